//! Fairing: remeshing and smoothing a network while some of its edges stay
//! (Barequet and Vaxman §6), from coarse to fine.
//!
//! What holds: for every label the boundary stays closed, and vertices at the
//! ends of edges that stay are in the result bit by bit. No triangles come to cross each
//! other that did not before, no vertex passes through a plane, and no solid shrinks to
//! nothing: what would is taken back, vertex by vertex or patch by patch. A surface that
//! passes a plane, as it may where a section is partial, can move along it.

mod flat;
mod guard;
mod patches;
mod umbrella;

use std::collections::BTreeSet;

use crate::error::{Error, Remedy, Result};
use crate::grid::memory::require_bytes;
use crate::mesh::Mesh;
use crate::mesh::network::Network;
use crate::plane::Plane;
use crate::progress::Progress;

use flat::Flat;
use guard::{Sides, Solids};

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
const LEVELS: [f64; 2] = [2.0, 1.0];
/// Steps after which it is looked whether all is well.
const BETWEEN_LOOKS: u32 = 100;
/// Times that it is begun again with patches that stay as they are.
const TRIES: u32 = 4;
/// Bytes that a triangle takes while it is remeshed.
const TRIANGLE_BYTES: f64 = 1000.0;

/// A fair network.
#[derive(Debug, Clone, PartialEq)]
pub struct Fair {
    /// The network.
    pub mesh: Mesh,
    /// Patches of surface, between edges that stay and curves where surfaces meet.
    pub patches: usize,
    /// How many of these were left as they were.
    pub left: usize,
}

/// A network with edges of about the wanted length, smooth but for some edges that stay
/// where they are: those given by their two vertices, and those in one of the planes at which
/// a surface passes it. Those that are too long are divided, as are curves where more than two
/// surfaces meet. No vertex moves through one of the planes.
///
/// The same for any number of threads.
///
/// # Errors
/// When the wanted length is not positive or needs more memory than there is,
/// when an edge has a vertex that the mesh has not, when cancelled, or when CGAL fails.
pub fn fair(
    mesh: &Mesh,
    fixed: &[[u32; 2]],
    planes: &[Plane],
    options: &FairingOptions,
    progress: &dyn Progress,
) -> Result<Fair> {
    require_length(mesh, options.edge_length)?;
    let network = Network::new(mesh, &[fixed, &guard::passing(mesh, planes)].concat())?;
    let patches = network.patches.iter().collect::<BTreeSet<_>>().len();
    let solids = Solids::new(&network);
    let was_sound = mesh.faces_outward()?;
    let crossings = network.crossings()?.len();
    let flat = Flat::of(&network, planes);
    let size = mesh.bounds().map_or(0.0, |bounds| bounds.diagonal());
    let mut left = BTreeSet::new();
    for _ in 0..TRIES {
        progress.begin("fairing", LEVELS.len() as u64 * u64::from(options.steps));
        let made = smoothed(network.clone(), &solids, planes, &left, options, progress)?;
        let mut spoiled = solids.spoiled(&made);
        spoiled.extend(Flat::of(&made, planes).grown(&flat, size));
        let found = made.crossings()?;
        if found.len() > crossings {
            spoiled.extend(made.patches_of(&found));
        }
        if spoiled.is_subset(&left) && found.len() <= crossings {
            let mesh = made.into_mesh();
            if was_sound && !mesh.faces_outward()? {
                break;
            }
            return Ok(Fair { mesh, patches, left: left.len() });
        }
        left.extend(spoiled);
    }
    Ok(Fair { mesh: mesh.clone(), patches, left: patches })
}

/// A network made fair but for some patches; not to the end when others are spoiled.
fn smoothed(
    mut network: Network,
    solids: &Solids,
    planes: &[Plane],
    left: &BTreeSet<u32>,
    options: &FairingOptions,
    progress: &dyn Progress,
) -> Result<Network> {
    network.pin(left);
    for level in LEVELS {
        let sides = Sides::all(planes, &network.mesh.vertices);
        network.remesh(level * options.edge_length, left, &sides)?;
        let mut steps = options.steps;
        while steps > 0 {
            progress.go_on()?;
            let (before, taken) = (network.mesh.vertices.clone(), steps.min(BETWEEN_LOOKS));
            network.smooth(taken);
            network.settle(&before, planes)?;
            progress.advance(taken.into());
            steps -= taken;
        }
        if !solids.spoiled(&network).is_subset(left) {
            return Ok(network);
        }
    }
    network.untie();
    Ok(network)
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
    let needed = (TRIANGLE_BYTES * triangles) as u64;
    require_bytes(needed, Remedy::LongerEdges, || format!("a mesh with edges of {length}"))
}

#[cfg(test)]
mod tests;
