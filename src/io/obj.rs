//! Meshes as Wavefront OBJ: points and triangles in text, in groups.

use std::collections::BTreeMap;
use std::io::{Result, Write};

use super::mesh::About;
use crate::label::Label;
use crate::mesh::Mesh;

/// Writes a group of triangles for each pair of labels, called
/// `label_BACK_FRONT` with the labels' numbers, 0 for outside.
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
        writeln!(out, "g label_{}_{}", back.0, front.0)?;
        for triangle in triangles {
            // Vertices count from 1.
            let [a, b, c] = triangle.map(|vertex| u64::from(vertex) + 1);
            writeln!(out, "f {a} {b} {c}")?;
        }
    }
    Ok(())
}
