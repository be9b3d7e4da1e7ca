//! Meshes as Wavefront OBJ: points and polygons in text, in groups.

use std::borrow::Cow;
use std::collections::BTreeMap;
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
    let mut lines = text.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let mut line = Cow::Borrowed(line);
        while let Some(begin) = line.trim_end().strip_suffix('\\') {
            let (_, more) = lines.next().unwrap_or_default();
            line = Cow::Owned(format!("{begin} {more}"));
        }
        let at = |what| Error::input(path, format!("line {}", number + 1), what);
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

/// The vertex of `vertex/texture/normal`: counted from 1, or from the last one backwards.
fn corner(word: &str, count: usize) -> std::result::Result<u32, String> {
    let error = || format!("{:?} is no vertex: vertices count from 1", shortened(word));
    let number: i64 = word.split('/').next().and_then(|it| it.parse().ok()).ok_or_else(error)?;
    let index = if number < 0 { count as i64 + number } else { number - 1 };
    u32::try_from(index).map_err(|_| error())
}

/// Writes a group of triangles for each pair of labels, called `BACK__FRONT`
/// after the materials: `liver__outside`, `liver__vessel`.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> std::io::Result<()> {
    for line in about.lines() {
        writeln!(out, "# {line}")?;
    }
    for vertex in &mesh.vertices {
        writeln!(out, "v {} {} {}", vertex.x, vertex.y, vertex.z)?;
    }
    let mut groups: BTreeMap<[Label; 2], Vec<[u32; 3]>> = BTreeMap::new();
    for (triangle, sides) in mesh.triangles.iter().zip(&mesh.sides) {
        groups.entry(*sides).or_default().push(*triangle);
    }
    for ([back, front], triangles) in groups {
        let [back, front] = [back, front].map(|label| name(label, about.materials));
        writeln!(out, "g {back}__{front}")?;
        for triangle in triangles {
            // Vertices count from 1.
            let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
            writeln!(out, "f {a} {b} {c}")?;
        }
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
    fn groups_are_called_after_both_materials() {
        let material = |id, name: &str| Material { id, name: name.to_owned(), color: [0; 3] };
        let materials =
            [material(1, "left lung"), material(2, "left/lung"), material(3, "outside")];
        let pairs = [[1, 0], [1, 2], [3, 0], [4, 0]];
        let mesh = Mesh {
            triangles: vec![[0, 1, 2]; 4],
            sides: pairs.map(|pair| pair.map(Label)).to_vec(),
            ..Mesh::default()
        };
        let mut bytes = Vec::new();
        write(&mesh, &About { materials: &materials, ..About::default() }, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let groups: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("g ")).collect();
        let expected = [
            "left_lung_1__outside",
            "left_lung_1__left_lung_2",
            "outside_3__outside",
            "label_4__outside",
        ];
        assert_eq!(groups, expected);
    }
}
