//! Files of meshes, by the ending of their name.

use std::collections::HashMap;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::vtk::{self, DataSet};
use super::{glb, obj, off, ply, stl, threemf, vtm};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::section::Sections;
use crate::sides::Sides;

/// The kinds of files that meshes are read from.
pub const MESH_KINDS: &str = ".ply, .obj, .stl, .off";

/// A kind of mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshKind {
    /// Stanford polygons, binary: keeps everything.
    Ply,
    /// Wavefront: an object for each label; colours are in a file beside it.
    Obj,
    /// Stereolithography, binary: single precision, no labels.
    Stl,
    /// Object file format: no labels.
    Off,
    /// VTK's polygons, for ParaView: keeps everything; written only.
    Vtp,
    /// VTK's unstructured grid, the same; written only.
    Vtu,
    /// VTK's multiblock data set, a block for each label in a file of its own; written only.
    Vtm,
    /// Binary glTF, single precision: a node for each label; written only.
    Glb,
    /// For printers: an object for each label; written only.
    Threemf,
}

impl MeshKind {
    /// From the ending of a file's name, in either case.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "obj" => Some(Self::Obj),
            "stl" => Some(Self::Stl),
            "off" => Some(Self::Off),
            "vtp" => Some(Self::Vtp),
            "vtu" => Some(Self::Vtu),
            "vtm" => Some(Self::Vtm),
            "glb" => Some(Self::Glb),
            "3mf" => Some(Self::Threemf),
            _ => None,
        }
    }

    /// Whether it says which triangles are of which label.
    pub fn knows_labels(self) -> bool {
        !matches!(self, Self::Stl | Self::Off)
    }

    /// The files beside one of this kind that belong to it, with what they hold.
    pub fn beside(self, path: &Path, materials: &[Material]) -> Vec<(PathBuf, Beside)> {
        let block = |label: Label| (vtm::block(path, label), Beside::Block(label));
        match self {
            Self::Obj => vec![(path.with_extension(obj::MATERIALS), Beside::Materials)],
            Self::Vtm => materials.iter().map(|material| block(Label(material.id))).collect(),
            _ => Vec::new(),
        }
    }
}

/// What a file holds that belongs to another one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beside {
    /// The colours of the materials of an `.obj`.
    Materials,
    /// The surface of a label in a `.vtm`.
    Block(Label),
}

impl Beside {
    /// Writes it, for the mesh that the other file is written from.
    ///
    /// # Errors
    /// As [`write_mesh`].
    pub fn write(self, mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
        match self {
            Self::Materials => obj::write_materials(mesh, about, out),
            Self::Block(label) => {
                let own = [about.material(label)];
                let part = mesh.surface(label).into_mesh(label);
                write_mesh(MeshKind::Vtp, &part, &About { materials: &own, ..*about }, out)
            }
        }
    }
}

/// What files say about a mesh besides its triangles.
#[derive(Debug, Clone, Copy, Default)]
pub struct About<'a> {
    /// Names and colours.
    pub materials: &'a [Material],
    /// The unit of length; empty when unknown.
    pub units: &'a str,
    /// The frame of the coordinates; empty when unknown.
    pub frame: &'a str,
    /// Which way is up, and where the front is.
    pub sides: Sides,
    /// The file's own name less its ending, after which files beside it are called; empty where
    /// there are none.
    pub stem: &'a str,
}

impl<'a> From<&'a Sections> for About<'a> {
    fn from(sections: &'a Sections) -> Self {
        Self {
            materials: &sections.materials,
            units: &sections.units,
            frame: &sections.frame,
            sides: Sides::of(sections),
            stem: "",
        }
    }
}

impl About<'_> {
    /// A line for each thing known, to be put into a comment.
    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines = vec!["made by transect".to_owned()];
        // First of all, for STL cuts them short, and Slicer looks for it.
        match self.space() {
            Some(space) => lines.push(format!("SPACE={space}")),
            None if self.frame.is_empty() => (),
            None => lines.push(format!("frame {}", self.frame)),
        }
        if !self.units.is_empty() {
            lines.push(format!("units {}", self.units));
        }
        let names = self.materials.iter();
        lines.extend(names.map(|material| format!("label {} {}", material.id, material.name)));
        for line in &mut lines {
            *line = line.replace(char::is_control, " ");
        }
        lines
    }

    /// The frame by the name that programs for medical images look for, if it is one of theirs.
    pub(super) fn space(&self) -> Option<&'static str> {
        let frame = self.frame.trim();
        ["LPS", "RAS"].into_iter().find(|known| known.eq_ignore_ascii_case(frame))
    }

    /// The colour of a label.
    pub(super) fn color(&self, label: Label) -> [u8; 3] {
        self.known(label).map_or_else(|| Material::numbered(label).color, |known| known.color)
    }

    /// The name and colour of a label.
    pub(super) fn material(&self, label: Label) -> Material {
        self.known(label).cloned().unwrap_or_else(|| Material::numbered(label))
    }

    fn known(&self, label: Label) -> Option<&Material> {
        self.materials.iter().find(|material| material.id == label.0)
    }
}

/// Writes a mesh. Of a network of several labels PLY, VTP, VTU, STL and OFF have all triangles,
/// those between materials, too, and the first three say which is which. The others have the
/// closed surface of each label; what [`MeshKind::beside`] names belongs to it.
///
/// # Errors
/// What the writer says, and where a number does not fit into the format.
pub fn write_mesh(
    kind: MeshKind,
    mesh: &Mesh,
    about: &About,
    out: &mut dyn Write,
) -> std::io::Result<()> {
    let mut out = BufWriter::new(out);
    match kind {
        MeshKind::Ply => ply::write(mesh, about, &mut out),
        MeshKind::Obj => obj::write(mesh, about, &mut out),
        MeshKind::Stl => stl::write(mesh, about, &mut out),
        MeshKind::Off => off::write(mesh, about, &mut out),
        MeshKind::Vtp => vtk::write(DataSet::PolyData, mesh, about, &mut out),
        MeshKind::Vtu => vtk::write(DataSet::UnstructuredGrid, mesh, about, &mut out),
        MeshKind::Vtm => vtm::write(about, &mut out),
        MeshKind::Glb => glb::write(mesh, about, &mut out),
        MeshKind::Threemf => threemf::write(mesh, about, &mut out),
    }?;
    out.flush()
}

/// Reads a mesh. Triangles without labels lie between label 1 behind them and
/// outside in front. Polygons become fans of triangles. But for PLY, points
/// in the same place become one.
///
/// # Errors
/// Where the file cannot be read, is empty, damaged, or has no triangle.
pub fn read_mesh(path: &Path) -> Result<Mesh> {
    let kind = readable(path)?;
    parse(kind, &super::read_bytes(path)?, path)
}

/// The kind of a file that meshes are read from.
pub(super) fn readable(path: &Path) -> Result<MeshKind> {
    match MeshKind::of(path) {
        Some(MeshKind::Vtp | MeshKind::Vtu | MeshKind::Vtm | MeshKind::Glb | MeshKind::Threemf) => {
            let what = format!("this kind is written, not read: meshes are read from {MESH_KINDS}");
            Err(Error::file(path, what))
        }
        Some(kind) => Ok(kind),
        None => {
            let what = format!("this kind of file is not known: meshes are read from {MESH_KINDS}");
            Err(Error::file(path, what))
        }
    }
}

/// The mesh in the bytes of a file.
pub(super) fn parse(kind: MeshKind, bytes: &[u8], path: &Path) -> Result<Mesh> {
    let text = super::without_mark(bytes);
    let mesh = match kind {
        MeshKind::Ply => ply::read(text, path)?,
        MeshKind::Stl => stl::read(bytes, path)?.mesh(path)?,
        MeshKind::Obj => obj::united(obj::read(&String::from_utf8_lossy(text), path)?.mesh(path)?),
        _ => off::read(&String::from_utf8_lossy(text), path)?.mesh(path)?,
    };
    if mesh.triangles.is_empty() {
        return Err(Error::file(path, "there is no triangle in it: export it again"));
    }
    let is_bad = |vertex: &&u32| !mesh.vertices[**vertex as usize].is_finite();
    if let Some(vertex) = mesh.triangles.iter().flatten().find(is_bad) {
        let what = "a coordinate is not a finite number: correct it, or export the file again";
        return Err(Error::input(path, format!("vertex {vertex}"), what));
    }
    Ok(without_unused(mesh))
}

/// A mesh of the vertices that triangles have: others are no part of the surface.
fn without_unused(mut mesh: Mesh) -> Mesh {
    let mut numbers = vec![u32::MAX; mesh.vertices.len()];
    for &vertex in mesh.triangles.iter().flatten() {
        numbers[vertex as usize] = 0;
    }
    let mut vertices = Vec::with_capacity(numbers.len());
    for (number, &vertex) in numbers.iter_mut().zip(&mesh.vertices) {
        if *number == 0 {
            *number = vertices.len() as u32;
            vertices.push(vertex);
        }
    }
    for vertex in mesh.triangles.iter_mut().flatten() {
        *vertex = numbers[*vertex as usize];
    }
    Mesh { vertices, ..mesh }
}

/// Polygons as most kinds of files have them, without labels.
#[derive(Debug, Default)]
pub(super) struct Soup {
    pub points: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Soup {
    /// Adds a polygon as a fan of triangles.
    pub fn polygon(&mut self, corners: &[u32]) {
        for pair in corners.get(1..).unwrap_or_default().windows(2) {
            self.triangles.push([corners[0], pair[0], pair[1]]);
        }
    }

    /// As a mesh; points in the same place become one.
    pub fn mesh(self, path: &Path) -> Result<Mesh> {
        let count = self.points.len();
        let missing = |&&corner: &&u32| corner as usize >= count;
        if let Some(corner) = self.triangles.iter().flatten().find(missing) {
            let what = format!(
                "a face names vertex {corner} (from 0), and there are {count}: the file is cut off \
                 or damaged, export it again"
            );
            return Err(Error::file(path, what));
        }
        let (vertices, number) = welded(self.points.into_iter());
        let corners = |triangle: [u32; 3]| triangle.map(|corner| number[corner as usize]);
        let triangles: Vec<[u32; 3]> = self.triangles.into_iter().map(corners).collect();
        let sides = vec![[Label(1), Label::OUTSIDE]; triangles.len()];
        Ok(Mesh { vertices, triangles, sides })
    }
}

/// Points without doubles, and for every point its number among them.
pub(super) fn welded(points: impl Iterator<Item = DVec3>) -> (Vec<DVec3>, Vec<u32>) {
    let mut vertices = Vec::new();
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let number = points
        .map(|point| {
            // Adding zero makes one zero of the two.
            let key = (point + DVec3::ZERO).to_array().map(f64::to_bits);
            *numbers.entry(key).or_insert_with(|| {
                vertices.push(point);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    (vertices, number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::samples::Lattice;
    use crate::mesh::dual;
    use crate::mesh::shapes::{samples, solid};
    use crate::progress::Silent;

    /// Writes and reads.
    fn round_trip(mesh: &Mesh, name: &str) -> Mesh {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        let materials = [Material::numbered(Label(1))];
        let about = About { materials: &materials, units: "mm", frame: "LPS", ..About::default() };
        let mut bytes = Vec::new();
        write_mesh(MeshKind::of(&path).unwrap(), mesh, &about, &mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        read_mesh(&path).unwrap()
    }

    fn ball() -> Mesh {
        solid(21, 1.0, |point| 0.7 - (point - 0.013).length())
    }

    #[test]
    fn ply_obj_and_off_keep_every_digit() {
        let ball = ball();
        for name in ["ball.ply", "ball.OFF"] {
            assert_eq!(round_trip(&ball, name), ball, "{name}");
        }
        // The vertices of a label have an order of their own.
        let own = ball.surface(Label(1)).into_mesh(Label(1));
        assert_eq!(round_trip(&ball, "ball.obj"), own);
    }

    #[test]
    fn ply_keeps_labels() {
        let lattice = Lattice { origin: DVec3::new(-3.0, 2.0, 1.0), voxel: 0.5, dims: [10; 3] };
        let samples =
            samples(lattice, |[x, _, _]| if x < 5 { vec![0.8, -1.0] } else { vec![-1.0, 0.4] });
        let mesh = dual(&samples, &Silent).unwrap();
        assert_eq!(mesh.labels(), [Label(1), Label(2)]);
        assert_eq!(round_trip(&mesh, "two.ply"), mesh);
    }

    #[test]
    fn stl_keeps_single_precision() {
        let ball = ball();
        let single = round_trip(&ball, "ball.stl");
        assert_eq!(single.triangles.len(), ball.triangles.len());
        assert_eq!(single.vertices.len(), ball.vertices.len());
        for triangle in 0..ball.triangles.len() {
            let rounded = ball.corners(triangle).map(|corner| corner.as_vec3().as_dvec3());
            assert_eq!(single.corners(triangle), rounded);
        }
    }

    #[test]
    fn vertices_without_a_face_are_no_part_of_a_mesh() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.off");
        std::fs::write(&path, "OFF\n4 1 0\n9 9 9\n0 0 0\n1 0 0\n0 1 0\n3 1 2 3\n").unwrap();
        let mesh = read_mesh(&path).unwrap();
        assert_eq!((mesh.vertices.len(), &mesh.triangles[..]), (3, &[[0, 1, 2]][..]));
        assert_eq!(mesh.bounds().unwrap().max, DVec3::new(1.0, 1.0, 0.0));
    }

    #[test]
    fn a_mark_at_the_beginning_and_ends_of_lines_change_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let solid = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
                     vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";
        let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                   property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                   end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        for (name, text) in [
            ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 \\\n0\nl 1 2\np 1\nf 1 2 3\n"),
            ("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
            ("a.ply", ply),
            ("a.stl", solid),
            ("b.stl", &solid.to_uppercase()),
        ] {
            let path = folder.path().join(name);
            for text in [format!("\u{feff}{text}"), text.replace('\n', "\r\n")] {
                std::fs::write(&path, &text).unwrap();
                let mesh = read_mesh(&path).unwrap();
                let expected = [DVec3::ZERO, DVec3::X, DVec3::Y];
                assert_eq!(
                    (&mesh.vertices[..], &mesh.triangles[..]),
                    (&expected[..], &[[0, 1, 2]][..]),
                    "{text}"
                );
            }
        }
    }

    #[test]
    fn what_is_no_mesh_is_an_error_that_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let bad = |name: &str, content: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).unwrap();
            read_mesh(&path).unwrap_err().to_string()
        };
        assert!(bad("a.xyz", "1").contains("kind"));
        for name in ["a.vtp", "a.glb", "a.3mf", "a.vtm"] {
            assert!(bad(name, "1").contains("not read"));
        }
        assert!(bad("a.off", "").contains("empty"));
        assert!(bad("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n").contains("b.off"));
        assert!(bad("c.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n").contains("c.off"));
        assert!(bad("d.obj", "v 0 0 0\n").contains("no triangle"));
        assert!(bad("e.stl", "solid x\n facet normal 0 0 1\n").contains("e.stl"));
        assert!(bad("f.ply", "ply\nformat ascii 1.0\n").contains("header"));
        let missing = read_mesh(&folder.path().join("missing.stl")).unwrap_err().to_string();
        assert!(missing.contains("no such file"));
    }
}
