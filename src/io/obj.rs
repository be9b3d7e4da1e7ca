//! Meshes as Wavefront OBJ: points and polygons in text, an object for each label.

use std::borrow::Cow;
use std::io::Write;
use std::path::Path;

use super::mesh::{About, Soup};
use super::text::{point, shortened};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::mesh::Mesh;

/// Reads vertices and faces; all else (lines, points, groups, materials, curves) is no part of
/// the surface. A line that ends with a backslash goes on on the next one.
pub(super) fn read(text: &str, path: &Path) -> Result<Soup> {
    let mut soup = Soup::default();
    for (number, line) in statements(text) {
        let at = |what| Error::input(path, format!("line {number}"), what);
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => soup.points.push(point(&mut words).map_err(at)?),
            Some("f") => {
                let count = soup.points.len();
                let corners = words.map(|word| corner(word, count));
                let corners = corners.collect::<std::result::Result<Vec<_>, _>>();
                soup.polygon(&corners.map_err(at)?);
            }
            _ => (),
        }
    }
    Ok(soup)
}

/// The lines of a text by their numbers, from 1; those that go on are one.
pub(super) fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut line = Cow::Borrowed(line);
        while let Some(end) = line.trim_end().strip_suffix('\\').map(str::len) {
            // In place, for there may be very many.
            let (whole, (_, more)) = (line.to_mut(), lines.next().unwrap_or_default());
            whole.truncate(end);
            whole.push(' ');
            whole.push_str(more);
        }
        Some((number + 1, line))
    })
}

/// The vertex of `vertex/texture/normal`: counted from 1, or from the last one backwards.
pub(super) fn corner(word: &str, count: usize) -> std::result::Result<u32, String> {
    let error = || format!("{:?} is no vertex: vertices count from 1", shortened(word));
    let number: i64 = word.split('/').next().and_then(|it| it.parse().ok()).ok_or_else(error)?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    u32::try_from(index).map_err(|_| error())
}

/// Objects as one. Where two touch, triangles lie on each other and face opposite ways: these are
/// no part of the surface around both.
pub(super) fn united(mut mesh: Mesh) -> Mesh {
    // By their corners from the least, then by the way round.
    let mut order: Vec<([u32; 3], bool, usize)> = Vec::with_capacity(mesh.triangles.len());
    for (index, &triangle) in mesh.triangles.iter().enumerate() {
        let mut corners = triangle;
        corners.sort_unstable();
        let least = triangle.iter().position(|&corner| corner == corners[0]).unwrap_or_default();
        order.push((corners, triangle[(least + 1) % 3] != corners[1], index));
    }
    order.sort_unstable();
    let mut stays = vec![true; order.len()];
    for same in order.chunk_by(|one, other| one.0 == other.0) {
        let turned = same.iter().filter(|triangle| triangle.1).count();
        let pairs = turned.min(same.len() - turned);
        for &(_, _, index) in same[..pairs].iter().chain(&same[same.len() - pairs..]) {
            stays[index] = false;
        }
    }
    let mut staying = stays.iter();
    mesh.triangles.retain(|_| staying.next() == Some(&true));
    let mut staying = stays.iter();
    mesh.sides.retain(|_| staying.next() == Some(&true));
    mesh
}

/// Writes an object for each label, called after its material, with the closed surface of the
/// label; the material's colour is in the file that [`write_materials`] writes.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
    for line in about.lines() {
        writeln!(out, "# {line}")?;
    }
    if !about.stem.is_empty() {
        writeln!(out, "mtllib {}.{MATERIALS}", about.stem)?;
    }
    // Vertices count from 1, through all objects.
    let mut first = 1;
    for label in mesh.labels() {
        let surface = mesh.surface(label);
        let name = name(label, about.materials);
        writeln!(out, "o {name}")?;
        for vertex in &surface.vertices {
            writeln!(out, "v {} {} {}", vertex.x, vertex.y, vertex.z)?;
        }
        writeln!(out, "usemtl {name}")?;
        for triangle in surface.triangles {
            let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + first);
            writeln!(out, "f {a} {b} {c}")?;
        }
        first += surface.vertices.len() as u64;
    }
    Ok(())
}

/// What the name of the file with the materials ends in.
pub const MATERIALS: &str = "mtl";

/// Writes the materials' colours, in sRGB as most programs take them.
pub fn write_materials(mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
    writeln!(out, "# made by transect")?;
    for label in mesh.labels() {
        let [r, g, b] = about.color(label).map(|channel| f64::from(channel) / 255.0);
        writeln!(out, "newmtl {}", name(label, about.materials))?;
        writeln!(out, "Ka 0 0 0\nKd {r:.6} {g:.6} {b:.6}\nKs 0 0 0\nd 1\nillum 1")?;
    }
    Ok(())
}

/// One word for a label; with its number if two materials would have the same.
fn name(label: Label, materials: &[Material]) -> String {
    if !label.is_material() {
        return label.to_string();
    }
    let own = materials.iter().find(|material| material.id == label.0);
    let word = own.map_or_else(|| Material::numbered(label).word(), Material::word);
    let taken = |other: &Material| other.id != label.0 && other.word() == word;
    if materials.iter().any(taken) || word == Label::OUTSIDE.to_string() {
        format!("{word}_{}", label.0)
    } else {
        word
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::io::bodies::tests::two_tetrahedra;

    #[test]
    fn what_is_no_face_is_passed_over_and_lines_go_on() {
        let text = "# \u{e9}\nmtllib a.mtl\nv 0 0 0 0.5 0.5 0.5\nv 1 0 \\\n 0\nv 1 1 0\nv 0 1 0\n\
                    l 1 2\np 1\ns off\nf 1/1/1 2//2 \\\n3 \\\n-1\nf -4 -3 -2\n";
        let soup = read(text, Path::new("a.obj")).unwrap();
        assert_eq!(soup.points[1], DVec3::X);
        assert_eq!(soup.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2]]);
        let error = |text: &str| read(text, Path::new("a.obj")).unwrap_err().to_string();
        assert!(error("v 0 0 0\nf 0 1 1").contains("line 2: \"0\" is no vertex"));
        assert!(error("v 0 0 0\nf 1 1 -2").contains("line 2: \"-2\""));
        assert!(error("\nv 0 1e \\").contains("line 2: \"1e\""));
        assert!(error("v 0 0 \\").contains("line 1: a vertex has fewer"));
    }

    #[test]
    fn objects_and_materials_are_called_after_labels() {
        let material = |id, name: &str| Material { id, name: name.to_owned(), color: [51, 0, 255] };
        let materials =
            [material(1, "left lung"), material(2, "left/lung"), material(3, "outside")];
        let pairs = [[1, 0], [1, 2], [3, 0], [4, 0]];
        let mesh = Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2]; 4],
            sides: pairs.map(|pair| pair.map(Label)).to_vec(),
        };
        let about = About { materials: &materials, stem: "a", ..About::default() };
        let written = |write: fn(&Mesh, &About, &mut dyn Write) -> std::io::Result<()>| {
            let mut bytes = Vec::new();
            write(&mesh, &about, &mut bytes).unwrap();
            String::from_utf8(bytes).unwrap()
        };
        let names = |text: &str, word: &str| -> Vec<String> {
            text.lines().filter_map(|line| line.strip_prefix(word)).map(str::to_owned).collect()
        };
        let expected = ["left_lung_1", "left_lung_2", "outside_3", "label_4"];
        let objects = written(write);
        assert_eq!(names(&objects, "o "), expected);
        assert_eq!(names(&objects, "usemtl "), expected);
        assert_eq!(names(&objects, "mtllib "), ["a.mtl"]);
        let materials = written(write_materials);
        assert_eq!(names(&materials, "newmtl "), expected);
        assert_eq!(names(&materials, "Kd ")[0], "0.200000 0.000000 1.000000");
    }

    #[test]
    fn a_wall_between_labels_is_of_both_objects_and_of_none_when_they_are_read() {
        let mut bytes = Vec::new();
        write(&two_tetrahedra(), &About::default(), &mut bytes).unwrap();
        let soup = read(&String::from_utf8(bytes).unwrap(), Path::new("a.obj")).unwrap();
        assert_eq!((soup.points.len(), soup.triangles.len()), (8, 8));
        let mesh = united(soup.mesh(Path::new("a.obj")).unwrap());
        assert_eq!((mesh.vertices.len(), mesh.triangles.len(), mesh.sides.len()), (5, 6, 6));
        let surface = mesh.surface(Label(1));
        assert!(surface.first_gap().is_none());
        assert!((surface.volume() - 2.0 / 6.0).abs() < 1e-15);
        // What is there twice, facing the same way, is no wall.
        let twice = Mesh { triangles: [&mesh.triangles[..]; 2].concat(), ..mesh.clone() };
        let sides = [&mesh.sides[..]; 2].concat();
        assert_eq!(united(Mesh { sides, ..twice }).triangles.len(), 12);
    }
}
