//! Files of solids, whether meshes or volumes of labels, with what they say about them.

use std::path::Path;

use super::mesh::{MESH_KINDS, MeshKind, parse, readable};
use super::volume::{VOLUME_KINDS, is_volume, read_volume};
use super::{images, nrrd, read_bytes};
use crate::compare::{Content, Shape};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::volume::LayeredVolume;

/// Comments are looked for in so many bytes at the beginning of a mesh.
const COMMENTS: usize = 1 << 16;
/// The header of binary STL.
const STL_HEADER: usize = 80;

/// Reads a mesh, or a volume of labels with all its layers; what comments say of unit, frame and
/// labels counts.
///
/// # Errors
/// Where the file cannot be read, is damaged, or holds no material.
pub fn read_shape(path: &Path) -> Result<Shape> {
    if is_volume(path) {
        return read_voxels(path);
    }
    if MeshKind::of(path).is_none() {
        let what = format!(
            "this kind of file is not known: solids are read from meshes ({MESH_KINDS}) and \
             volumes of labels ({VOLUME_KINDS})"
        );
        return Err(Error::file(path, what));
    }
    let kind = readable(path)?;
    let bytes = read_bytes(path)?;
    let mesh = parse(kind, &bytes, path)?;
    let shape = Comments::of(kind, &bytes).shape(kind, mesh);
    if shape.labels().is_empty() {
        return Err(Error::file(
            path,
            "no triangle of it has a material on a side: export it again",
        ));
    }
    Ok(shape)
}

fn read_voxels(path: &Path) -> Result<Shape> {
    let layers = match images::is_layered(path) {
        true => nrrd::read_layers(&read_bytes(path)?, path)?,
        false => vec![read_volume(path)?],
    };
    if layers.iter().all(|layer| layer.bounds().is_none()) {
        let what = "all of its voxels are 0, which is outside: export the labels";
        return Err(Error::file(path, what));
    }
    let (units, frame) = (layers[0].units.clone(), layers[0].frame.clone());
    let materials = layers.iter().flat_map(|layer| layer.materials.clone()).collect();
    let content = LayeredVolume::new(layers).map_err(|what| Error::file(path, what))?;
    Ok(Shape { content: Content::Voxels(content), materials, units, frame })
}

/// What comments of a mesh say, as we write them, and Slicer the frame.
#[derive(Debug, Default, PartialEq)]
struct Comments {
    units: String,
    frame: String,
    materials: Vec<Material>,
}

impl Comments {
    fn of(kind: MeshKind, bytes: &[u8]) -> Self {
        let mut found = Self::default();
        if kind == MeshKind::Stl {
            // What reaches its end may be cut off.
            let header = String::from_utf8_lossy(&bytes[..bytes.len().min(STL_HEADER)]);
            let (whole, _) = header.rsplit_once([' ', ';', '\n']).unwrap_or_default();
            whole.split([';', '\n']).for_each(|comment| found.hear(comment));
            return found;
        }
        let start = String::from_utf8_lossy(&bytes[..bytes.len().min(COMMENTS)]);
        for line in start.lines().take_while(|line| line.trim() != "end_header") {
            let comment = line.strip_prefix('#').or_else(|| line.strip_prefix("comment "));
            comment.into_iter().for_each(|comment| found.hear(comment));
        }
        found
    }

    fn hear(&mut self, comment: &str) {
        let comment = comment.trim();
        if let Some(frame) = comment.strip_prefix("SPACE=").or(comment.strip_prefix("frame ")) {
            frame.trim().clone_into(&mut self.frame);
        } else if let Some(units) = comment.strip_prefix("units ") {
            units.trim().clone_into(&mut self.units);
        } else if let Some(label) = comment.strip_prefix("label ") {
            let (number, name) = label.split_once(' ').unwrap_or((label, ""));
            if let Some(label) = number.parse().ok().map(Label).filter(|own| own.is_material()) {
                let name = name.to_owned();
                self.materials.push(Material { name, ..Material::numbered(label) });
            }
        }
    }

    /// A mesh with what they say. In kinds that are read without labels all is one: that label, if
    /// they tell of one alone.
    fn shape(self, kind: MeshKind, mut mesh: Mesh) -> Shape {
        let Self { units, frame, mut materials } = self;
        if kind != MeshKind::Ply {
            match materials[..] {
                [Material { id, .. }] => mesh.sides.fill([Label(id), Label::OUTSIDE]),
                _ => materials.clear(),
            }
        }
        Shape { content: Content::Mesh(mesh), materials, units, frame }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::mesh::{About, write_mesh};
    use crate::mesh::shapes::solid;

    #[test]
    fn comments_of_our_meshes_are_heard() {
        let ball = solid(9, 1.0, |point| 0.7 - point.length());
        let folder = tempfile::tempdir().expect("a folder");
        let material =
            |id, name: &str| Material { name: name.to_owned(), ..Material::numbered(Label(id)) };
        let (one, two) = (vec![material(3, "liver")], vec![material(1, "a"), material(2, "b")]);
        for (name, materials, label, called) in [
            ("a.ply", &two, 1, Some("a")),
            ("a.obj", &one, 3, Some("liver")),
            ("a.off", &one, 3, Some("liver")),
            ("a.stl", &one, 3, Some("liver")),
            ("b.obj", &two, 1, None),
        ] {
            let path = folder.path().join(name);
            let about = About { materials, units: "cm", frame: "RAS", ..About::default() };
            let mut bytes = Vec::new();
            let kind = MeshKind::of(&path).expect("a kind");
            write_mesh(kind, &ball, &about, &mut bytes).expect("bytes");
            std::fs::write(&path, bytes).expect("a file");
            let shape = read_shape(&path).expect("a shape");
            assert_eq!((shape.units.as_str(), shape.frame.as_str()), ("cm", "RAS"), "{name}");
            assert_eq!(shape.labels(), [Label(label)], "{name}");
            assert_eq!(shape.name(Label(label)), called, "{name}");
        }
    }

    #[test]
    fn what_is_no_solid_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |name: &str, content: &str| {
            let path = folder.path().join(name);
            std::fs::write(&path, content).expect("a file");
            read_shape(&path).expect_err("it is none").to_string()
        };
        let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: ascii\n\n";
        assert!(refused("a.nrrd", &format!("{header}0 0\n")).contains("all of its voxels are 0"));
        assert!(refused("a.xyz", "1").contains("volumes of labels (.nrrd"));
        assert!(refused("a.glb", "1").contains("not read"));
        let flat = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
                    property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                    property int label_back\nproperty int label_front\nend_header\n0 0 0\n1 0 0\n\
                    0 1 0\n3 0 1 2 0 0\n";
        assert!(refused("a.ply", flat).contains("material"), "{}", refused("a.ply", flat));
    }
}
