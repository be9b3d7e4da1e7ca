//! Meshes as Wavefront OBJ: points and triangles in text, in groups.

use std::collections::BTreeMap;
use std::io::{Result, Write};

use super::mesh::About;
use crate::label::{Label, Material};
use crate::mesh::Mesh;

/// Writes a group of triangles for each pair of labels, called `BACK__FRONT`
/// after the materials: `liver__outside`, `liver__vessel`.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> Result<()> {
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
    use super::*;

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
