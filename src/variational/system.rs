//! The linear system of one label on one level: the unknown nodes, the energy's
//! stencil and the samples that bear on them, as flat arrays for any backend.
//!
//! With voxels of length 1, and directions d of weights w_d (`metric`), Σ‖Hess f‖² is
//!
//! ```text
//! Σ_d w_d² Σ (δdd f)²  +  2 Σ_{d < e} w_d w_e Σ (δd δe f)²
//! ```
//!
//! with δdd f = f(x − d) − 2 f(x) + f(x + d) at nodes and δd δe f at the
//! parallelograms between the nodes x, x + d, x + e and x + d + e. Half its gradient is
//! what L = Σ_d w_d δdd makes of L f; with the three axes for directions, all of them
//! with a weight of 1, it is the stencil 42, −12 (6 neighbours), +2 (12 across an edge),
//! +1 (6 at distance two). At a natural boundary only differences between nodes that
//! exist are summed up.
//!
//! A sample is a point with a weight w and a target t, and adds w (f − t)² with f
//! interpolated trilinearly from the eight nodes around it. [`Anchors`] do the same
//! at nodes.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::grid::leaf_grid::{LeafGrid, NO_SLOT, around, leaf_of, node_below};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE};

use super::metric::Direction;

/// [`LEAF_SIDE`] for node indices.
pub const SIDE: i32 = LEAF_SIDE as i32;
/// Nodes that the stencil reaches beyond a leaf.
pub const REACH: usize = 2;
/// Nodes along each axis of a *patch*: a leaf with what its stencil reaches.
pub const PATCH: usize = LEAF_SIDE + 2 * REACH;
/// Nodes of a patch.
pub const PATCH_NODES: usize = PATCH * PATCH * PATCH;
/// From the first corner of a cell to all eight, in a patch.
pub const CORNERS: [usize; 8] = [
    0,
    1,
    PATCH,
    PATCH + 1,
    PATCH * PATCH,
    PATCH * PATCH + 1,
    PATCH * PATCH + PATCH,
    PATCH * PATCH + PATCH + 1,
];

/// A point that bears on nodes of a leaf.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sample {
    /// Where in the cell it lies, from 0 to 1 along each axis.
    pub place: [f32; 3],
    /// The cell's first node in the leaf's patch.
    pub node: u32,
    /// w.
    pub weight: f32,
    /// t.
    pub target: f32,
}

/// What draws single nodes: each adds w (f − t)².
#[derive(Debug, Clone, PartialEq)]
pub struct Anchors {
    /// w, leaf by leaf [`LEAF_NODES`] of them; 0 where nothing draws.
    pub weights: Vec<f32>,
    /// t, in voxels.
    pub targets: Vec<f32>,
}

impl Anchors {
    /// The weights and targets in a leaf.
    pub fn of(&self, leaf: usize) -> [&[f32; LEAF_NODES]; 2] {
        [&self.weights, &self.targets].map(|values| &values.as_chunks().0[leaf])
    }
}

/// A point in the lattice with a weight and a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pull {
    /// In nodes.
    pub at: [f64; 3],
    /// w.
    pub weight: f32,
    /// t, in voxels.
    pub target: f32,
}

/// The nodes that exist where the boundary is natural: from the first up to,
/// without, the last along each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Domain {
    /// The first node.
    pub low: [i32; 3],
    /// One beyond the last node.
    pub high: [i32; 3],
}

impl Domain {
    /// Whether a node exists.
    pub fn has(&self, node: [i32; 3]) -> bool {
        (0..3).all(|axis| (self.low[axis]..self.high[axis]).contains(&node[axis]))
    }
}

/// The system. Nodes that are not free, and all other leaves, are as they are.
#[derive(Debug, Clone)]
pub struct System {
    /// Leaves with unknown nodes.
    pub leaves: Vec<[i32; 3]>,
    /// For each the 27 around it by index, x slowest, or [`NO_SLOT`].
    pub neighbours: Vec<[u32; 27]>,
    /// For each one bit a node: whether it is free.
    pub free: Vec<[u64; 8]>,
    /// Where the boundary is natural.
    pub domain: Option<Domain>,
    /// In which second differences are taken.
    pub directions: Vec<Direction>,
    /// The samples, leaf by leaf; one at a leaf's border is with several.
    pub samples: Vec<Sample>,
    /// For each leaf where its samples begin, and the end.
    pub starts: Vec<u32>,
    /// What draws single nodes, if anything.
    pub anchors: Option<Anchors>,
    /// What holds every free node where solving begins: λ (f − start)² is added for each, 0 on
    /// levels that are solved to the end.
    pub hold: f32,
}

impl System {
    /// Of the leaves with unknown nodes, sorted, those of which `is_free` says
    /// yes, and all pulls.
    pub fn new(
        leaves: Vec<[i32; 3]>,
        is_free: impl Fn([i32; 3]) -> bool + Sync,
        domain: Option<Domain>,
        pulls: &[Pull],
        directions: &[Direction],
    ) -> Self {
        let index = Index::new(&leaves);
        let neighbours = leaves
            .par_iter()
            .map(|&leaf| {
                let mut own = [NO_SLOT; 27];
                around(leaf).zip(&mut own).for_each(|(leaf, own)| *own = index.of(leaf));
                own
            })
            .collect();
        let free = leaves.par_iter().map(|&leaf| free_nodes(leaf, &is_free)).collect();
        let (samples, starts) = sorted_samples(leaves.len(), &index, pulls);
        let directions = directions.to_vec();
        Self {
            leaves,
            neighbours,
            free,
            domain,
            directions,
            samples,
            starts,
            anchors: None,
            hold: 0.0,
        }
    }

    /// How many unknowns there are.
    pub fn unknowns(&self) -> u64 {
        self.free.iter().flatten().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Whether a node of a leaf is free.
    pub fn is_free(&self, leaf: usize, node: usize) -> bool {
        self.free[leaf][node / 64] >> (node % 64) & 1 == 1
    }

    /// The samples that bear on a leaf.
    pub fn samples_of(&self, leaf: usize) -> &[Sample] {
        &self.samples[self.starts[leaf] as usize..self.starts[leaf + 1] as usize]
    }

    /// Whether the stencil of some node of a leaf reaches beyond the domain.
    pub fn domain_near(&self, leaf: [i32; 3]) -> Option<Domain> {
        self.domain.filter(|domain| {
            (0..3).any(|axis| {
                let low = leaf[axis] * SIDE;
                low - (REACH as i32) < domain.low[axis]
                    || low + SIDE + REACH as i32 > domain.high[axis]
            })
        })
    }
}

/// Where leaves are in a sorted list.
struct Index {
    grid: LeafGrid,
}

impl Index {
    fn new(leaves: &[[i32; 3]]) -> Self {
        let low = fold(leaves, i32::min);
        let high = fold(leaves, i32::max);
        let (low, high) = (low.map(|at| at * SIDE), high.map(|at| at * SIDE + SIDE));
        Self { grid: LeafGrid::indexed(low, high, leaves) }
    }

    fn of(&self, leaf: [i32; 3]) -> u32 {
        self.grid.slot(leaf)
    }

    /// The leaves that a pull bears on: those of its cell's corners, each once.
    fn around(&self, pull: &Pull) -> [u32; 8] {
        let low = node_below(pull.at);
        let [low, high] = [leaf_of(low), leaf_of(low.map(|along| along + 1))];
        std::array::from_fn(|corner| {
            let step = [corner >> 2, corner >> 1 & 1, corner & 1];
            let repeats = (0..3).any(|axis| step[axis] == 1 && high[axis] == low[axis]);
            let leaf = std::array::from_fn(|axis| [low, high][step[axis]][axis]);
            if repeats { NO_SLOT } else { self.of(leaf) }
        })
    }
}

fn fold(leaves: &[[i32; 3]], choose: impl Fn(i32, i32) -> i32) -> [i32; 3] {
    let first = leaves.first().copied().unwrap_or_default();
    leaves
        .iter()
        .fold(first, |one, other| std::array::from_fn(|axis| choose(one[axis], other[axis])))
}

fn free_nodes(leaf: [i32; 3], is_free: &impl Fn([i32; 3]) -> bool) -> [u64; 8] {
    let mut bits = [0; 8];
    for node in 0..LEAF_NODES {
        let offset = [node / 64, node / 8 % 8, node % 8];
        let at = std::array::from_fn(|axis| leaf[axis] * SIDE + offset[axis] as i32);
        bits[node / 64] |= u64::from(is_free(at)) << (node % 64);
    }
    bits
}

/// Every pull with each leaf that it bears on, in the order of the leaves, and
/// where each leaf's begin.
fn sorted_samples(leaves: usize, index: &Index, pulls: &[Pull]) -> (Vec<Sample>, Vec<u32>) {
    let slots: Vec<[u32; 8]> = pulls.par_iter().map(|pull| index.around(pull)).collect();
    let mut starts = vec![0u32; leaves + 1];
    for &slot in slots.as_flattened().iter().filter(|&&slot| slot != NO_SLOT) {
        starts[slot as usize + 1] += 1;
    }
    for leaf in 0..leaves {
        starts[leaf + 1] += starts[leaf];
    }
    let mut next = starts.clone();
    let mut order = vec![(0u32, 0u32); starts[leaves] as usize];
    for (pull, slots) in slots.iter().enumerate() {
        for &slot in slots.iter().filter(|&&slot| slot != NO_SLOT) {
            let place = &mut next[slot as usize];
            order[*place as usize] = (pull as u32, slot);
            *place += 1;
        }
    }
    let sample = |&(pull, slot): &(u32, u32)| {
        Sample::new(&pulls[pull as usize], index.grid.leaves()[slot as usize])
    };
    (order.par_iter().map(sample).collect(), starts)
}

impl Sample {
    fn new(pull: &Pull, leaf: [i32; 3]) -> Self {
        let low = node_below(pull.at);
        let place = std::array::from_fn(|axis| (pull.at[axis] - f64::from(low[axis])) as f32);
        let [x, y, z] =
            std::array::from_fn(|axis| (low[axis] - leaf[axis] * SIDE + REACH as i32) as usize);
        let node = ((x * PATCH + y) * PATCH + z) as u32;
        Self { place, node, weight: pull.weight, target: pull.target }
    }

    /// The weights of the cell's eight corners, in the order of [`CORNERS`].
    #[inline(always)]
    pub fn shares(&self) -> [f32; 8] {
        let [x, y, z] = self.place.map(|high| [1.0 - high, high]);
        std::array::from_fn(|corner| x[corner >> 2] * y[corner >> 1 & 1] * z[corner & 1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_at_a_border_bears_on_all_leaves_around() {
        let leaves = vec![[0, 0, 0], [0, 0, 1], [1, 0, 0]];
        let pull = |at| Pull { at, weight: 2.0, target: 1.0 };
        let pulls = [pull([3.25, 4.5, 7.5]), pull([1.0, 1.0, 1.0]), pull([7.5, 0.0, 7.0])];
        let system = System::new(leaves, |_| true, None, &pulls, &[]);
        // The second one's cell is within the first leaf; the third one's reaches all.
        assert_eq!(system.starts, [0, 3, 5, 6]);
        let [first, ..] = system.samples_of(1) else { panic!() };
        // Its cell begins at (3, 4, 7): in the patch of leaf (0, 0, 1), which begins at
        // (−2, −2, 6), that is (5, 6, 1).
        assert_eq!(first.node as usize, (5 * 12 + 6) * 12 + 1);
        let shares = first.shares();
        assert_eq!(shares[0], 0.75 * 0.5 * 0.5);
        assert_eq!(shares[7], 0.25 * 0.5 * 0.5);
        assert_eq!(system.unknowns(), 3 * 512);
        assert_eq!(system.neighbours[0][14], 1);
        assert_eq!(system.neighbours[0][22], 2);
        assert_eq!(system.neighbours[0][4], NO_SLOT);
    }
}
