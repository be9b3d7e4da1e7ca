//! Meshes as OFF: points and triangles in text.

use std::io::{Result, Write};

use super::mesh::About;
use crate::mesh::Mesh;

/// Writes all triangles, without their labels.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "OFF")?;
    for line in about.lines() {
        writeln!(out, "# {line}")?;
    }
    writeln!(out, "{} {} 0", mesh.vertices.len(), mesh.triangles.len())?;
    for vertex in &mesh.vertices {
        writeln!(out, "{} {} {}", vertex.x, vertex.y, vertex.z)?;
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(out, "3 {a} {b} {c}")?;
    }
    Ok(())
}
