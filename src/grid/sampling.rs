//! Evaluates the field near the surface: from the contours and a coarse
//! lattice on, following changes of label from leaf to leaf.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::field::{Completion, Field};
use crate::label::Label;
use crate::progress::Progress;
use crate::section::Section;

use super::contour::{corners, pierced_voxels, segments};
use super::invariant::{differs_near_face, faces, neighbor, node_offset};
use super::leaf::{Leaf, LeafNodes, LeafOf, LeafValues, NewLeaf};
use super::locate::{Cells, NO_CELL, leaf_cells, node_cell, place};
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Samples};

mod batch;
mod kept;

use batch::Batch;
pub use kept::{Before, Kept};

/// Values that leaves evaluated at a time have at most, 32 MB, and as many as they count for at
/// least: a million points, some 50 MB with what belongs to them.
const BATCH_VALUES: usize = 1 << 23;
/// See [`BATCH_VALUES`].
const VALUES_OF_POINT: usize = 8;
/// Single points evaluated at a time.
const BATCH_POINTS: usize = 1 << 17;
/// Of more labels than this in a leaf only those are kept that may win near it: with
/// [`PART_OF_BEST`] of the largest share at some node. The others' values take up memory, and
/// make no difference to where the surface passes between two nodes.
const MANY_LABELS: usize = 4;
/// See [`MANY_LABELS`].
const PART_OF_BEST: f32 = 0.05;
/// The node of a leaf that stands for it on the coarse lattice, along every
/// axis.
const COARSE: i32 = SIDE / 2;
/// [`LEAF_SIDE`] for node indices.
const SIDE: i32 = LEAF_SIDE as i32;

/// How far the surface keeps from leaves without values, in nodes: one is enough
/// to close it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Margin(pub usize);

/// Samples, and what they cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    /// The samples, with what sampling again wants to know.
    pub kept: Kept,
    /// Points at which the field was evaluated; those in cells of one label
    /// alone are not counted.
    pub points: u64,
}

/// Leaves that the surface is known to pass.
#[derive(Debug, Clone, Default)]
pub struct Starts(Vec<[i32; 3]>);

impl Starts {
    /// Along the contours of sections, and across the unknown regions on which
    /// labels change.
    pub fn new(sections: &[Section], completion: &Completion, lattice: &Lattice) -> Self {
        let edges: Vec<[DVec3; 2]> = sections.iter().flat_map(segments).collect();
        let mut starts = Self::along(&edges, lattice);
        let changes = completion.changes();
        starts.0.extend(changes.flat_map(|corners| leaves_around(corners, lattice)));
        starts
    }

    /// The leaves of all nodes of the voxels that segments pass.
    pub fn along(segments: &[[DVec3; 2]], lattice: &Lattice) -> Self {
        let leaf = |node: [i32; 3]| node.map(|index| index / SIDE);
        let voxels = pierced_voxels(segments, lattice);
        let mut leaves: Vec<[i32; 3]> = voxels.into_iter().flat_map(corners).map(leaf).collect();
        leaves.sort_unstable();
        leaves.dedup();
        Self(leaves)
    }

    /// These leaves.
    pub fn leaves(self) -> Vec<[i32; 3]> {
        self.0
    }
}

/// Samples the field wherever its labels change on the lattice, as far as the
/// contours or a coarse lattice of one node a leaf show where.
///
/// # Errors
/// When the field cannot be evaluated.
pub fn sample(
    cells: &dyn Cells,
    field: &dyn Field,
    starts: &Starts,
    lattice: &Lattice,
    margin: Margin,
    progress: &dyn Progress,
) -> Result<Sampling> {
    let sampler = Sampler { cells, field, lattice: *lattice, margin, before: None, progress };
    sampler.run(starts.0.clone())
}

/// The same when some cells have changed since samples were taken on the same lattice: only
/// what lies in those is evaluated.
///
/// # Errors
/// When the field cannot be evaluated.
pub fn sample_again(
    cells: &dyn Cells,
    field: &dyn Field,
    starts: &Starts,
    before: Before,
    margin: Margin,
    progress: &dyn Progress,
) -> Result<Sampling> {
    let lattice = before.kept.samples.lattice;
    let sampler = Sampler { cells, field, lattice, margin, before: Some(before), progress };
    sampler.run(starts.0.clone())
}

/// The leaves in the box around a triangle.
fn leaves_around(corners: [DVec3; 3], lattice: &Lattice) -> Vec<[i32; 3]> {
    let local = corners.map(|corner| (corner - lattice.origin) / lattice.voxel);
    let leaf = |node: f64, axis: usize| {
        (node / f64::from(SIDE)).clamp(0.0, f64::from(lattice.leaf_dims()[axis] - 1)) as i32
    };
    let range = |axis: usize| {
        let along = local.map(|corner| corner[axis]);
        let [low, high] = [along.into_iter().reduce(f64::min), along.into_iter().reduce(f64::max)]
            .map(|end| leaf(end.unwrap_or(0.0), axis));
        low..=high
    };
    let mut leaves = Vec::new();
    for x in range(0) {
        for y in range(1) {
            leaves.extend(range(2).map(|z| [x, y, z]));
        }
    }
    leaves
}

struct Sampler<'a> {
    cells: &'a dyn Cells,
    field: &'a dyn Field,
    lattice: Lattice,
    margin: Margin,
    before: Option<Before<'a>>,
    progress: &'a dyn Progress,
}

/// What is known so far.
struct State {
    samples: Samples,
    /// For every leaf of the lattice whether it is evaluated or about to be.
    taken: Vec<bool>,
    /// The cells that the nodes of the leaves lie in.
    cells: HashMap<[i32; 3], Vec<u32>>,
    points: u64,
}

impl Sampler<'_> {
    fn run(&self, mut starts: Vec<[i32; 3]>) -> Result<Sampling> {
        self.progress.begin("sampling", 0);
        let (tiles, coarse, points) = self.coarse_labels()?;
        let taken = vec![false; tiles.len()];
        starts.extend(self.coarse_changes(&tiles));
        let open = self.cells.is_open().then(|| self.cells.bounds());
        let samples = Samples::new(self.lattice, tiles, open, self.field.values());
        let mut state = State { samples, taken, cells: HashMap::new(), points };
        let mut wave = self.take(starts, &mut state.taken);
        while !wave.is_empty() {
            let mut next = Vec::new();
            let mut waiting = &wave[..];
            while !waiting.is_empty() {
                let leaves;
                [leaves, waiting] = self.batch(waiting, &coarse);
                self.progress.go_on()?;
                next.extend(self.evaluate(leaves, &mut state)?);
                self.progress.advance(leaves.len() as u64);
            }
            wave = self.take(next, &mut state.taken);
        }
        let State { samples, mut cells, points, .. } = state;
        let cells = samples.valued.iter().map(|at| cells.remove(at).unwrap_or_default()).collect();
        Ok(Sampling { kept: Kept { samples, coarse, cells }, points })
    }

    /// The first of some leaves that are evaluated at a time, and the others; `coarse` are the
    /// cells of all leaves' middles, which have about as many labels as the leaves.
    fn batch<'l>(&self, leaves: &'l [[i32; 3]], coarse: &[u32]) -> [&'l [[i32; 3]]; 2] {
        let values = |at: &[i32; 3]| {
            let labels = match coarse[self.lattice.leaf_index(*at)] {
                NO_CELL => 0,
                cell => self.field.labels(cell).len(),
            };
            LEAF_NODES * labels.max(VALUES_OF_POINT)
        };
        let mut sum = 0;
        let fits = leaves.iter().take_while(|at| {
            sum += values(at);
            sum <= BATCH_VALUES
        });
        let (own, others) = leaves.split_at(fits.count().clamp(1, leaves.len()));
        [own, others]
    }

    /// Sorts leaves, drops those taken already, and takes the others.
    fn take(&self, mut leaves: Vec<[i32; 3]>, taken: &mut [bool]) -> Vec<[i32; 3]> {
        leaves.sort_unstable();
        leaves.dedup();
        leaves.retain(|&at| !std::mem::replace(&mut taken[self.lattice.leaf_index(at)], true));
        leaves
    }

    /// The label of one node of every leaf, its cell, and how many points that took.
    fn coarse_labels(&self) -> Result<(Vec<Label>, Vec<u32>, u64)> {
        let count = self.lattice.leaf_count() as usize;
        let known = |index| self.before.as_ref().and_then(|before| before.coarse(index));
        let (mut tiles, mut coarse) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut points = 0;
        for start in (0..count).step_by(BATCH_POINTS) {
            let indices = start..count.min(start + BATCH_POINTS);
            let node = |index| self.lattice.leaf_at(index).map(|at| at * SIDE + COARSE);
            let cell = |index| match known(index) {
                Some((cell, _)) => cell,
                None => node_cell(self.cells, &self.lattice, node(index)),
            };
            coarse.par_extend(indices.clone().into_par_iter().map(cell));
            let wanted = |index: usize| match known(index) {
                Some(_) => NO_CELL,
                None => coarse[index],
            };
            let cells = indices.clone().into_par_iter().map(wanted).collect();
            let position = |index| place(self.cells, &self.lattice, node(start + index));
            let batch = Batch::evaluate(self.field, cells, position)?;
            points += batch.points;
            let label = |index| match known(index) {
                Some((_, label)) => label,
                None => batch.label(index - start),
            };
            tiles.par_extend(indices.into_par_iter().map(label));
        }
        Ok((tiles, coarse, points))
    }

    /// Leaves with another coarse label than a neighbour's. Beyond the
    /// lattice all is outside.
    fn coarse_changes(&self, tiles: &[Label]) -> Vec<[i32; 3]> {
        let changes = |index: &usize| {
            let at = self.lattice.leaf_at(*index);
            faces().any(|(axis, forward)| {
                self.lattice.tile(tiles, neighbor(at, axis, forward)) != tiles[*index]
            })
        };
        let indices: Vec<usize> = (0..tiles.len()).into_par_iter().filter(changes).collect();
        indices.into_iter().map(|index| self.lattice.leaf_at(index)).collect()
    }

    /// Evaluates leaves and says which others the surface comes near to.
    fn evaluate(&self, wave: &[[i32; 3]], state: &mut State) -> Result<Vec<[i32; 3]>> {
        let leaves = self.reuse(wave, state);
        let cells: Vec<u32> = leaves
            .par_iter()
            .flat_map_iter(|&at| leaf_cells(self.cells, &self.lattice, at))
            .collect();
        state.cells.par_extend(leaves.par_iter().copied().zip(cells.par_chunks(LEAF_NODES).map(
            |cells| {
                let mut cells = cells.to_vec();
                cells.sort_unstable();
                cells.dedup();
                cells
            },
        )));
        let position = |node: usize| {
            let (at, offset) = (leaves[node / LEAF_NODES], node_offset(node % LEAF_NODES));
            let node = std::array::from_fn(|axis| at[axis] * SIDE + offset[axis] as i32);
            place(self.cells, &self.lattice, node)
        };
        let batch = Batch::evaluate(self.field, cells, position)?;
        state.points += batch.points;
        let leaf = |(index, &at): (usize, &[i32; 3])| collect_leaf(&batch, index, at);
        let found: Vec<NewLeaf> = leaves.par_iter().enumerate().map(leaf).collect();
        state.samples.add(found);
        let found = wave.par_iter().filter_map(|&at| state.samples.leaf(at));
        Ok(found.flat_map_iter(|leaf| self.nearby(&leaf, &state.samples.tiles)).collect())
    }

    /// Takes over the leaves that are as they were, and returns the others.
    fn reuse(&self, wave: &[[i32; 3]], state: &mut State) -> Vec<[i32; 3]> {
        let Some(before) = &self.before else { return wave.to_vec() };
        let (mut reused, mut others) = (Vec::new(), Vec::new());
        for &at in wave {
            match before.leaf(at) {
                Some((leaf, cells)) => {
                    state.cells.insert(at, cells.to_vec());
                    reused.push(leaf);
                }
                None => others.push(at),
            }
        }
        state.samples.add(reused);
        others
    }

    /// The neighbours of a leaf whose tile differs from a node near them.
    fn nearby(&self, leaf: &Leaf, tiles: &[Label]) -> Vec<[i32; 3]> {
        let labels = leaf.labels();
        faces()
            .filter_map(|(axis, forward)| {
                let next = neighbor(leaf.at, axis, forward);
                let tile = self.lattice.tile(tiles, next);
                let differs = differs_near_face(&labels, axis, forward, self.margin.0, tile);
                (self.lattice.has_leaf(next) && differs).then_some(next)
            })
            .collect()
    }
}

/// The leaf made of the batch's `index`-th 512 nodes.
fn collect_leaf(batch: &Batch, index: usize, at: [i32; 3]) -> NewLeaf {
    let nodes = index * LEAF_NODES..(index + 1) * LEAF_NODES;
    let mut labels = batch.labels(nodes.clone());
    let are_many = batch.are_indicators() && labels.len() > MANY_LABELS;
    if are_many && !labels.contains(&Label::OUTSIDE) {
        labels.insert(0, Label::OUTSIDE);
    }
    let absent = |label| LeafValues { label, values: Box::new([-1.0; LEAF_NODES]) };
    let mut materials: Vec<_> = labels.into_iter().map(absent).collect();
    for (node, id) in nodes.enumerate() {
        batch.values_at(id, &mut materials, node);
    }
    if are_many {
        keep_near_ones(&mut materials);
    } else if batch.are_indicators() {
        materials.retain(|own| own.values.iter().any(|&value| value > -1.0));
    }
    LeafOf { at, materials }
}

/// Of many labels those that have some part of the best one's share somewhere, and *outside*,
/// which then is not what the others leave.
fn keep_near_ones(materials: &mut Vec<LeafValues<Box<LeafNodes>>>) {
    let mut limits = [0.0f32; LEAF_NODES];
    for own in &*materials {
        let all = limits.iter_mut().zip(own.values.iter());
        all.for_each(|(limit, value)| *limit = limit.max(PART_OF_BEST * (value + 1.0)));
    }
    materials.retain(|own| {
        let mut values = own.values.iter().zip(&limits);
        own.label == Label::OUTSIDE || values.any(|(value, limit)| value + 1.0 > *limit)
    });
}

#[cfg(test)]
mod tests;
