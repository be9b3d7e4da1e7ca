//! From a formula to a closed mesh: sampled near the surface, and meshed by the
//! library.

use rayon::prelude::*;

use transect::error::{Error, Result};
use transect::grid::lattice::Resolution;
use transect::grid::leaf::{LeafOf, LeafValues, NewLeaf};
use transect::grid::samples::{LEAF_SIDE, Lattice, Samples, Values};
use transect::label::Label;
use transect::mesh::{Mesh, dual};
use transect::progress::Silent;

use super::{STEEPEST, Solid};

/// The label of all solids.
const INSIDE: Label = Label(1);
/// Distances in voxels that become the values −1 and 1.
const BAND: f64 = 3.0;

/// The solid's mesh, on a lattice with so many voxels on the longest side.
///
/// # Errors
/// When the samples break their promises: the solid's own distance is then no
/// bound for how far its surface is.
pub fn mesh(solid: &Solid, voxels: u32) -> Result<Mesh> {
    let samples = samples(solid, voxels)?;
    samples.sanity_check().map_err(|what| Error::Bug { stage: "solids", what })?;
    dual(&samples, &Silent)
}

/// The one place that makes samples. Leaves that are surely on one side of the
/// surface become tiles. The lattice reaches some voxels farther than the solid's
/// box, which the surface may touch.
fn samples(solid: &Solid, voxels: u32) -> Result<Samples> {
    let voxel = solid.bounds.size().max_element() / f64::from(voxels);
    let bounds = solid.bounds.grown(BAND * voxel);
    let lattice = Lattice::new(bounds, Resolution::VoxelSize(voxel))?;
    let made: Vec<(Label, Option<NewLeaf>)> = (0..lattice.leaf_count() as usize)
        .into_par_iter()
        .map(|index| leaf(solid, &lattice, lattice.leaf_at(index)))
        .collect();
    let tiles = made.iter().map(|(tile, _)| *tile).collect();
    let mut samples = Samples::new(lattice, tiles, None, Values::Indicators);
    samples.add(made.into_iter().filter_map(|(_, leaf)| leaf));
    Ok(samples)
}

/// What a leaf is all over, or its values where the surface may pass.
fn leaf(solid: &Solid, lattice: &Lattice, at: [i32; 3]) -> (Label, Option<NewLeaf>) {
    let half = (LEAF_SIDE - 1) as f64 / 2.0;
    let first = lattice.position(at.map(|at| at * LEAF_SIDE as i32));
    let middle = solid.distance(first + half * lattice.voxel);
    let farthest = half * 3f64.sqrt() * lattice.voxel;
    let mut leaf = LeafOf { at, materials: Vec::new() };
    if middle.abs() > STEEPEST * farthest {
        return (if middle < 0.0 { INSIDE } else { Label::OUTSIDE }, None);
    }
    let value = |node: usize| {
        let inward = -solid.distance(lattice.position(leaf.node(node))) / (BAND * lattice.voxel);
        inward.clamp(-1.0, 1.0) as f32
    };
    let values = Box::new(std::array::from_fn(value));
    leaf.materials = vec![LeafValues { label: INSIDE, values }];
    (Label::OUTSIDE, Some(leaf))
}
