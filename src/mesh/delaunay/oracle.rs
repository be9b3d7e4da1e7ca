//! Which label is at a point: the surface that refinement samples.
//!
//! Let d_l be the signed distance to the boundary of label l in the dual mesh,
//! negative in l. It is computed at the nodes of all lattice cells that the
//! interface passes through and interpolated trilinearly in them; the label
//! of a point is the one with the smallest. The sign at a node is that of the
//! node's label, so this surface crosses the same lattice edges as the dual
//! mesh, and lies in the same cells; within them it is smoother than the
//! indicator, whose slope changes with every section plane.
//!
//! A node between two of other labels is in something one voxel thick, which
//! the dual mesh may squeeze to nothing; there |d_l| is at least [`THIN`], so
//! that what is left of it can be sampled.
//!
//! What is connected across a face is as in the dual mesh (`saddles`).
//!
//! An open box is cut out of what would be there without it: the dual mesh has
//! no caps, and nodes beyond the box have the labels and distances of the
//! nearest ones inside, as in the samples.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use super::saddles::Factors;
use crate::grid::distance::distances;
use crate::grid::leaf_grid::LeafGrid;
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Samples};
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::dual::block::corner_nodes;
use crate::mesh::dual::patch::{Leaves, Patch};
use crate::plane::Bounds;

/// The least distance to the surface of a node in something thin, in voxels.
const THIN: f32 = 0.25;
/// How far distances are known, in voxels: to what passes through a cell, its
/// corners have no longer ones.
const REACH: f64 = 1.75;

/// The label of every point. Nothing in it changes once it is made.
pub struct Oracle {
    /// Leaves along each axis.
    dims: [i32; 3],
    blocks: Vec<Block>,
    /// Everything beyond is outside; in lattice units.
    open: Option<Bounds>,
}

/// The cells that start in one leaf.
enum Block {
    Uniform(Label),
    Mixed(Cells),
}

struct Cells {
    /// Of each cell's first node: the label throughout a cell without parts.
    labels: Vec<Label>,
    /// Cell i has `parts[first[i]..first[i + 1]]`, by label.
    first: Vec<u32>,
    parts: Vec<Part>,
}

/// Signed distances to one label's boundary, in voxels, at a cell's corners:
/// corner `4 x + 2 y + z` has the offset (x, y, z).
struct Part {
    label: Label,
    distances: [f32; 8],
}

impl Oracle {
    /// The oracle of samples and of the dual mesh made from them, without caps.
    pub fn new(samples: &Samples, dual: &Mesh) -> Self {
        let leaves = Leaves::new(samples);
        let borders = Borders::new(samples, &leaves, dual);
        let factors = Factors::new(&leaves, &borders);
        let blocks = (0..leaves.count())
            .into_par_iter()
            .map(|place| match Patch::gather(&leaves, leaves.at(place)) {
                None => Block::Uniform(samples.tiles[place]),
                Some(patch) => Block::Mixed(Cells::new(
                    &patch.extended(),
                    leaves.at(place),
                    &borders,
                    &factors,
                )),
            })
            .collect();
        let Lattice { origin, voxel, .. } = samples.lattice;
        let open = samples.open.map(|Bounds { min, max }| Bounds {
            min: (min - origin) / voxel,
            max: (max - origin) / voxel,
        });
        Self { dims: leaves.dims(), blocks, open }
    }

    /// The label at a point in lattice units; off the lattice and beyond an open
    /// box it is outside.
    pub fn label_at(&self, point: [f64; 3]) -> Label {
        if self.open.is_some_and(|open| !open.contains(DVec3::from_array(point))) {
            return Label::OUTSIDE;
        }
        if point.iter().any(|&coordinate| coordinate.is_nan() || coordinate < 0.0) {
            return Label::OUTSIDE;
        }
        // Truncation is the floor, and no call to a library.
        let cell = point.map(|coordinate| coordinate as usize);
        let at = cell.map(|node| node / LEAF_SIDE);
        if (0..3).any(|axis| at[axis] >= self.dims[axis] as usize) {
            return Label::OUTSIDE;
        }
        let [_, y, z] = self.dims.map(|side| side as usize);
        let place = (at[0] * y + at[1]) * z + at[2];
        match &self.blocks[place] {
            Block::Uniform(label) => *label,
            Block::Mixed(cells) => {
                let node = cell.map(|node| node % LEAF_SIDE);
                let fraction = std::array::from_fn(|axis| point[axis] - cell[axis] as f64);
                cells.label_at(node, fraction)
            }
        }
    }
}

impl Cells {
    fn new(patch: &Patch, at: [i32; 3], borders: &Borders, factors: &Factors) -> Self {
        let mut cells = Self { labels: vec![], first: vec![0], parts: vec![] };
        for cell in 0..LEAF_NODES {
            let corners = corners(cell);
            for label in cell_labels(patch, cell) {
                let distances = corners.map(|corner| {
                    let sign = if patch.label(corner) == label { -1.0 } else { 1.0 };
                    sign * borders.distance(label, at, corner) * factors.at(global(at, corner))
                });
                cells.parts.push(Part { label, distances });
            }
            cells.labels.push(patch.label(corners[0]));
            cells.first.push(cells.parts.len() as u32);
        }
        cells
    }

    /// The label in the cell that starts at a node of the leaf, at fractions
    /// of its sides.
    fn label_at(&self, node: [usize; 3], fraction: [f64; 3]) -> Label {
        let cell = (node[0] * LEAF_SIDE + node[1]) * LEAF_SIDE + node[2];
        let parts = &self.parts[self.first[cell] as usize..self.first[cell + 1] as usize];
        let nearest = parts
            .iter()
            .map(|part| (part.label, part.at(fraction)))
            .reduce(|best, next| if next.1 < best.1 { next } else { best });
        nearest.map_or(self.labels[cell], |(label, _)| label)
    }
}

impl Part {
    fn at(&self, [x, y, z]: [f64; 3]) -> f64 {
        let d = self.distances.map(f64::from);
        let along_z = |corner: usize| d[corner] + z * (d[corner + 1] - d[corner]);
        let along_y = |corner: usize| {
            let (low, high) = (along_z(corner), along_z(corner + 2));
            low + y * (high - low)
        };
        let (low, high) = (along_y(0), along_y(4));
        low + x * (high - low)
    }
}

/// A node of a leaf, on the lattice.
pub fn global(at: [i32; 3], node: [usize; 3]) -> [i32; 3] {
    std::array::from_fn(|axis| at[axis] * LEAF_SIDE as i32 + node[axis] as i32)
}

/// The nodes of a cell, as offsets in its leaf.
fn corners(cell: usize) -> [[usize; 3]; 8] {
    corner_nodes([cell / 64, cell / 8 % 8, cell % 8])
}

/// The labels at a cell's nodes, sorted; none where there is only one.
fn cell_labels(patch: &Patch, cell: usize) -> Vec<Label> {
    let labels = corners(cell).map(|corner| patch.label(corner));
    if labels.iter().all(|&label| label == labels[0]) {
        return Vec::new();
    }
    let mut labels = labels.to_vec();
    labels.sort_unstable();
    labels.dedup();
    labels
}

/// Distances to the boundary of every label in the dual mesh.
pub struct Borders<'a> {
    samples: &'a Samples,
    leaves: &'a Leaves<'a>,
    of: BTreeMap<Label, LeafGrid>,
}

impl<'a> Borders<'a> {
    fn new(samples: &'a Samples, leaves: &'a Leaves, dual: &Mesh) -> Self {
        let mut labels = dual.labels();
        labels.push(Label::OUTSIDE);
        let band = |label| {
            let triangles = dual.triangles_around(|side| side == label);
            distances(&samples.lattice, &dual.vertices, &triangles, REACH)
        };
        let of = labels.into_iter().map(|label| (label, band(label))).collect();
        Self { samples, leaves, of }
    }

    /// The distance, in voxels, of a node to the boundary of a label, up to
    /// [`REACH`].
    pub fn distance(&self, label: Label, at: [i32; 3], node: [usize; 3]) -> f32 {
        let mut node = global(at, node);
        if self.samples.open.is_some() {
            node = self.samples.lattice.nearest_inner(node);
        }
        let found = self.of.get(&label).and_then(|band| band.value(node));
        let least = if self.is_thin(node) { THIN } else { 0.0 };
        found.unwrap_or(REACH as f32).max(least)
    }

    /// Whether a node lies between two of other labels.
    fn is_thin(&self, node: [i32; 3]) -> bool {
        let label = self.leaves.label(node);
        (0..3).any(|axis| {
            [-1, 1].into_iter().all(|step| {
                let mut next = node;
                next[axis] += step;
                self.leaves.label(next) != label
            })
        })
    }
}
