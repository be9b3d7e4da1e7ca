//! Bi-Laplacian smoothing of the indicators (Bermano §4.6): the indicator
//! jumps at the contours, which draws the surface orthogonal to the sections
//! and makes ripples; a few steps of f −= rate · Δ²f, with the nodes around
//! the contours fixed, take them away.

use cxx::UniquePtr;
use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::ffi::grid as ffi;
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::Section;

use super::contour::{corners, pierced_voxels, segments};
use super::invariant::{differs_near_face, faces, neighbor, node_index, node_offset};
use super::locate::is_inside;
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Leaf, LeafValues, Samples, Values};
use super::sampling::Margin;

/// The largest eigenvalue of Δ² on a lattice with six neighbours is 12²; a
/// step of its inverse is stable and takes the finest ripple away at once.
const RATE: f32 = 1.0 / 144.0;
/// Shares below this are nothing: rounding leaves them behind.
const NOTHING: f32 = 1e-6;

/// How far the surface should keep from leaves without values when it will be
/// smoothed.
pub const SMOOTHING_MARGIN: Margin = Margin(3);

/// The indicators in OpenVDB trees, one for each material.
pub struct Grid {
    trees: UniquePtr<ffi::Grid>,
    /// Sorted.
    materials: Vec<Label>,
    /// Where there are values, sorted.
    region: Vec<[i32; 3]>,
    lattice: Lattice,
    tiles: Vec<Label>,
    open: Option<Bounds>,
}

impl Grid {
    /// Moves samples into trees. Nodes around the contours will stay as they
    /// are, and those that are not inside the box unless it is open.
    ///
    /// # Errors
    /// When OpenVDB fails.
    pub fn from_samples(samples: Samples, sections: &[Section], bounds: Bounds) -> Result<Self> {
        let materials = samples.materials();
        let region: Vec<[i32; 3]> = samples.leaves.iter().map(|leaf| leaf.at).collect();
        let closed = samples.open.is_none().then_some(bounds);
        let fixed = fixed_nodes(&samples.lattice, &region, sections, closed);
        let mut trees = ffi::new_grid(&flat(&region), &fixed).map_err(library)?;
        let Samples { lattice, leaves, tiles, open, .. } = samples;
        for &label in &materials {
            let own = leaves.iter().filter_map(|leaf| {
                let values = leaf.materials.iter().find(|own| own.label == label)?;
                Some((leaf.at, &values.values))
            });
            let (at, values): (Vec<_>, Vec<_>) = own.unzip();
            let values: Vec<f32> = values.into_iter().flatten().copied().collect();
            ffi::add_material(trees.pin_mut(), &flat(&at), &values).map_err(library)?;
        }
        Ok(Self { trees, materials, region, lattice, tiles, open })
    }

    /// Smooths.
    ///
    /// # Errors
    /// When OpenVDB fails.
    pub fn smooth(&mut self, steps: u32) -> Result<()> {
        ffi::smooth(self.trees.pin_mut(), steps, RATE).map_err(library)
    }

    /// Moves the samples out of the trees.
    ///
    /// # Errors
    /// When OpenVDB fails.
    pub fn into_samples(mut self) -> Result<Samples> {
        let mut leaves: Vec<Leaf> =
            self.region.iter().map(|&at| Leaf { at, materials: Vec::new() }).collect();
        for (index, &label) in self.materials.iter().enumerate() {
            let taken = ffi::take_material(self.trees.pin_mut(), index).map_err(library)?;
            for (at, values) in taken.at.chunks_exact(3).zip(taken.values.chunks_exact(LEAF_NODES))
            {
                let values: Vec<f32> = values.iter().map(|value| value.clamp(-1.0, 1.0)).collect();
                let present = values.iter().any(|&value| value > -1.0 + NOTHING);
                let found = self.region.binary_search(&[at[0], at[1], at[2]]);
                if let (true, Ok(leaf)) = (present, found) {
                    leaves[leaf].materials.push(LeafValues { label, values });
                }
            }
        }
        let Self { lattice, tiles, open, .. } = self;
        let mut samples = Samples { lattice, leaves, tiles, open, values: Values::Indicators };
        close(&mut samples);
        Ok(samples)
    }
}

/// Smooths samples; see [`Grid`].
///
/// # Errors
/// When OpenVDB fails.
pub fn smoothed(
    samples: Samples,
    sections: &[Section],
    bounds: Bounds,
    steps: u32,
) -> Result<Samples> {
    if steps == 0 {
        return Ok(samples);
    }
    let mut grid = Grid::from_samples(samples, sections, bounds)?;
    grid.smooth(steps)?;
    grid.into_samples()
}

/// Gives values to the tiles that a smoothed surface has come up to, so that
/// it does not end there. Their other neighbours then have the same label or
/// values: the invariant of [`Samples`] holds again after one pass.
fn close(samples: &mut Samples) {
    let reached = |leaf: &Leaf| {
        let labels = leaf.labels();
        let near = |(axis, forward)| {
            let next = neighbor(leaf.at, axis, forward);
            if !samples.lattice.has_leaf(next) || samples.leaf(next).is_some() {
                return None;
            }
            let tile = samples.tiles[samples.lattice.leaf_index(next)];
            differs_near_face(&labels, axis, forward, 1, tile).then_some((next, tile))
        };
        faces().filter_map(near).collect::<Vec<_>>()
    };
    let mut reached: Vec<([i32; 3], Label)> =
        samples.leaves.par_iter().flat_map_iter(reached).collect();
    reached.sort_unstable();
    reached.dedup();
    samples.leaves.extend(reached.into_iter().map(|(at, tile)| constant_leaf(at, tile)));
    samples.leaves.sort_unstable_by_key(|leaf| leaf.at);
}

fn constant_leaf(at: [i32; 3], label: Label) -> Leaf {
    let mut materials = Vec::new();
    if label.is_material() {
        materials.push(LeafValues { label, values: vec![1.0; LEAF_NODES] });
    }
    Leaf { at, materials }
}

/// One bit for every node of every leaf: whether it stays as it is. In a
/// closed box these are also the nodes that are not inside. In an open one
/// they are smoothed with the others, so that nothing pulls at the surface
/// where it leaves the box.
fn fixed_nodes(
    lattice: &Lattice,
    region: &[[i32; 3]],
    sections: &[Section],
    closed: Option<Bounds>,
) -> Vec<u64> {
    let side = LEAF_SIDE as i32;
    let mut fixed = vec![0; region.len() * LEAF_NODES / 64];
    fixed.par_chunks_mut(LEAF_NODES / 64).zip(region).for_each(|(words, at)| {
        for node in 0..LEAF_NODES {
            let offset = node_offset(node);
            let node_at = std::array::from_fn(|axis| at[axis] * side + offset[axis] as i32);
            let outside = |bounds| !is_inside(bounds, lattice.position(node_at));
            words[node / 64] |= u64::from(closed.is_some_and(outside)) << (node % 64);
        }
    });
    let edges: Vec<[DVec3; 2]> = sections.iter().flat_map(segments).collect();
    for node in pierced_voxels(&edges, lattice).into_iter().flat_map(corners) {
        if let Ok(leaf) = region.binary_search(&node.map(|index| index / side)) {
            let bit = node_index(node.map(|index| (index % side) as usize));
            fixed[leaf * LEAF_NODES / 64 + bit / 64] |= 1 << (bit % 64);
        }
    }
    fixed
}

fn flat(leaves: &[[i32; 3]]) -> Vec<i32> {
    leaves.iter().flatten().copied().collect()
}

fn library(exception: cxx::Exception) -> Error {
    Error::library("smoothing", &exception)
}

#[cfg(test)]
mod tests;
