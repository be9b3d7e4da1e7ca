//! Meshes as binary STL: loose triangles in single precision.

use std::io::{Error, Result, Write};

use super::mesh::About;
use crate::mesh::Mesh;

/// Length of the header, which must not begin with "solid".
const HEADER: usize = 80;

/// Writes all triangles, without their labels: a closed surface when the mesh
/// has one material, the whole network when it has several.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> Result<()> {
    let Ok(count) = u32::try_from(mesh.triangles.len()) else {
        return Err(Error::other("STL cannot count this many triangles: write another kind"));
    };
    let mut header = about.lines().join("; ").into_bytes();
    header.resize(HEADER, b' ');
    out.write_all(&header)?;
    out.write_all(&count.to_le_bytes())?;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        for vector in [normal, a, b, c] {
            for number in vector.as_vec3().to_array() {
                out.write_all(&number.to_le_bytes())?;
            }
        }
        out.write_all(&[0; 2])?;
    }
    Ok(())
}
