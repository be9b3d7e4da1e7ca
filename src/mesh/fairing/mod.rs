//! Fairing: remeshing and smoothing a network while some of its edges stay
//! (Barequet and Vaxman §6), from coarse to fine.
//!
//! What holds: for every label the boundary stays closed, and vertices at the
//! ends of edges that stay are in the result bit by bit. Remeshing keeps the
//! borders of patches, smoothing moves vertices and nothing else. That surfaces
//! do not come to cross each other where they are close is not promised.

mod network;
mod patches;
mod umbrella;

use crate::error::{Error, Result};
use crate::grid::memory::available_memory;
use crate::mesh::Mesh;

use network::Network;

/// How a mesh is made fair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FairingOptions {
    /// How long edges are to be, in world units.
    pub edge_length: f64,
    /// Steps of smoothing on each level.
    pub steps: u32,
}

/// Edges on each level are so many times as long as on the last. What is smooth
/// takes few steps where edges are long.
const LEVELS: [f64; 3] = [4.0, 2.0, 1.0];
/// Bytes that a triangle takes while it is remeshed.
const TRIANGLE_BYTES: f64 = 1000.0;

/// A network with edges of about the wanted length, smooth but for some edges,
/// each given by its two vertices, that stay where they are. Those that are too
/// long are divided, as are curves where more than two surfaces meet.
///
/// The same for any number of threads.
///
/// # Errors
/// When the wanted length is not positive or needs more memory than there is,
/// when an edge has a vertex that the mesh has not, or when CGAL fails.
pub fn fair(mesh: &Mesh, fixed: &[[u32; 2]], options: &FairingOptions) -> Result<Mesh> {
    require_length(mesh, options.edge_length)?;
    let mut network = Network::new(mesh, fixed)?;
    let was_open = network.open_edges();
    for level in LEVELS {
        network.remesh(level * options.edge_length)?;
        network.smooth(options.steps);
    }
    let open = network.open_edges();
    if was_open == 0 && open > 0 {
        let what = format!("{open} edges came out open that were closed before");
        return Err(Error::Bug { stage: "fairing", what });
    }
    Ok(network.into_mesh())
}

/// Refuses lengths that are none, or that the result would not fit into memory
/// with.
fn require_length(mesh: &Mesh, length: f64) -> Result<()> {
    if !(length.is_finite() && length > 0.0) {
        let what = format!("edges cannot be {length} long: give a positive length");
        return Err(Error::Option(what));
    }
    let area = |triangle| {
        let [a, b, c] = mesh.corners(triangle);
        (b - a).cross(c - a).length() / 2.0
    };
    let area: f64 = (0..mesh.triangles.len()).map(area).sum();
    // Of an equilateral triangle; more there are where borders are fine.
    let triangles = area / (3f64.sqrt() / 4.0 * length * length);
    let (needed, available) = ((TRIANGLE_BYTES * triangles) as u64, available_memory());
    if needed > available {
        let what = format!("a mesh with edges of {length}");
        return Err(Error::Memory { what, needed, available, hint: "use longer edges".into() });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
