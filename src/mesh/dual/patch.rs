//! The nodes that the cells of one leaf touch: the leaf and the first layer
//! of the leaves after it.

use rayon::prelude::*;

use crate::grid::invariant::node_index;
use crate::grid::leaf::Leaf;
use crate::grid::samples::{LEAF_SIDE, Lattice, Samples, Values};
use crate::label::Label;

/// Nodes of a patch along each axis.
const SIDE: usize = LEAF_SIDE + 1;

/// Sampled leaves with their nodes' labels, found by place.
pub struct Leaves<'a> {
    samples: &'a Samples,
    leaves: Vec<Leaf<'a>>,
    labels: Vec<Vec<Label>>,
    /// For each leaf of the lattice its index in `leaves`.
    index: Vec<u32>,
}

/// The index of a leaf without values.
const TILE: u32 = u32::MAX;

impl<'a> Leaves<'a> {
    /// Those of samples.
    pub fn new(samples: &'a Samples) -> Self {
        let own: Vec<Leaf> = samples.par_leaves().collect();
        let labels = own.par_iter().map(Leaf::labels).collect();
        let count = samples.lattice.leaf_count() as usize;
        let mut leaves = Self { samples, leaves: own, labels, index: vec![TILE; count] };
        for (number, &at) in samples.valued.iter().enumerate() {
            if let Some(place) = leaves.place(at) {
                leaves.index[place] = number as u32;
            }
        }
        leaves
    }

    /// The number of a leaf in `index` and `tiles`; `None` off the lattice.
    pub fn place(&self, at: [i32; 3]) -> Option<usize> {
        let lattice = &self.samples.lattice;
        lattice.has_leaf(at).then(|| lattice.leaf_index(at))
    }

    /// The leaf's coordinates, from its number.
    pub fn at(&self, place: usize) -> [i32; 3] {
        self.samples.lattice.leaf_at(place)
    }

    /// How many leaves the lattice has.
    pub fn count(&self) -> usize {
        self.index.len()
    }

    /// Leaves along each axis.
    pub fn dims(&self) -> [i32; 3] {
        self.samples.lattice.leaf_dims()
    }

    /// For each leaf of the lattice whether other samples say the same there; nothing where
    /// they are on another lattice.
    pub fn same_in(&self, other: &Samples) -> Vec<bool> {
        let own = self.samples;
        if (own.lattice, own.open, own.values) != (other.lattice, other.open, other.values) {
            return Vec::new();
        }
        let is_same = |place: usize| match (self.index[place], other.leaf(self.at(place))) {
            (TILE, None) => own.tiles[place] == other.tiles[place],
            (TILE, Some(_)) | (_, None) => false,
            (number, Some(leaf)) => self.leaves[number as usize] == leaf,
        };
        (0..self.count()).into_par_iter().map(is_same).collect()
    }

    /// Whether all that the cells of a leaf touch is the same.
    pub fn is_patch_same(&self, at: [i32; 3], same: &[bool]) -> bool {
        // Off the lattice all is outside.
        !same.is_empty()
            && patch_leaves(at).all(|leaf| self.place(leaf).is_none_or(|place| same[place]))
    }

    /// The label of a node, by what the samples say.
    pub fn label(&self, node: [i32; 3]) -> Label {
        match self.source(node.map(|along| along.div_euclid(LEAF_SIDE as i32))) {
            Source::Tile(label) => label,
            Source::Leaf(_, labels) => {
                labels[node_index(node.map(|along| along.rem_euclid(LEAF_SIDE as i32) as usize))]
            }
        }
    }

    fn source(&self, at: [i32; 3]) -> Source<'_> {
        match self.place(at).map(|place| self.index[place]) {
            None | Some(TILE) => Source::Tile(self.samples.tile(at)),
            Some(number) => {
                let number = number as usize;
                Source::Leaf(&self.leaves[number], &self.labels[number])
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Source<'a> {
    Leaf(&'a Leaf<'a>, &'a [Label]),
    Tile(Label),
}

/// A leaf and the seven after it.
fn patch_leaves(at: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..8).map(move |corner| [at[0] + corner / 4, at[1] + corner / 2 % 2, at[2] + corner % 2])
}

/// The 9 × 9 × 9 nodes from a leaf's first on.
pub struct Patch<'a> {
    lattice: &'a Lattice,
    values: Values,
    open: bool,
    at: [i32; 3],
    sources: [Source<'a>; 8],
    labels: Vec<Label>,
}

impl<'a> Patch<'a> {
    /// `None` where all nodes are in tiles of one label.
    pub fn gather(leaves: &'a Leaves<'a>, at: [i32; 3]) -> Option<Self> {
        let mut around = patch_leaves(at);
        let sources: [Source; 8] =
            std::array::from_fn(|_| leaves.source(around.next().unwrap_or(at)));
        if let Source::Tile(first) = sources[0]
            && sources.iter().all(|source| matches!(source, Source::Tile(label) if *label == first))
        {
            return None;
        }
        let (lattice, open) = (&leaves.samples.lattice, leaves.samples.open.is_some());
        let labels = vec![Label::OUTSIDE; SIDE * SIDE * SIDE];
        let values = leaves.samples.values;
        let mut patch = Self { lattice, values, open, at, sources, labels };
        for x in 0..SIDE {
            for y in 0..SIDE {
                for z in 0..SIDE {
                    let node = [x, y, z];
                    // What lies on the lattice's border or beyond is outside,
                    // so that every surface closes.
                    if patch.is_inner(node) {
                        patch.labels[index(node)] = patch.sampled_label(node);
                    }
                }
            }
        }
        Some(patch)
    }

    /// The patch with the samples' labels beyond an open box, too: as if
    /// materials went on there.
    pub fn extended(mut self) -> Self {
        for node in (0..self.labels.len()).filter(|_| self.open) {
            let place = [node / SIDE / SIDE, node / SIDE % SIDE, node % SIDE];
            self.labels[node] = self.sampled_label(place);
        }
        self
    }

    /// Whether the edge between two nodes leads out of an open box: the
    /// polygon around it is a cap.
    pub fn leaves_box(&self, low: [usize; 3], high: [usize; 3]) -> bool {
        self.open && !(self.is_inner(low) && self.is_inner(high))
    }

    fn is_inner(&self, node: [usize; 3]) -> bool {
        let global = |axis: usize| self.at[axis] * LEAF_SIDE as i32 + node[axis] as i32;
        self.lattice.is_inner(std::array::from_fn(global))
    }

    /// A node's label.
    pub fn label(&self, node: [usize; 3]) -> Label {
        self.labels[index(node)]
    }

    /// How far the label `one` leads over `other` at a node, in [−1, 1].
    pub fn lead(&self, node: [usize; 3], one: Label, other: Label) -> f64 {
        let (source, inner) = self.locate(node);
        match source {
            Source::Leaf(leaf, _) => leaf.share(inner, one) - leaf.share(inner, other),
            Source::Tile(label) if label == one => 1.0,
            Source::Tile(label) if label == other => -1.0,
            Source::Tile(_) => 0.0,
        }
    }

    /// Where the interface crosses the edge between two neighbouring nodes of
    /// different labels: the fraction of the way from the first.
    ///
    /// Next to a section plane the mean-value indicator is s/√(s² + γ²), with
    /// s the distance to the contour and γ that to the plane. Interpolating it
    /// as it is would put every crossing near the middle, in stairs;
    /// d/√(1 − d²) = s/γ is linear in s.
    pub fn crossing(&self, low: [usize; 3], high: [usize; 3]) -> f64 {
        /// Keeps points off the nodes, where triangles would degenerate.
        const MARGIN: f64 = 0.01;
        let (one, other) = (self.label(low), self.label(high));
        let before = self.values.straightened(self.lead(low, one, other)).max(0.0);
        let after = self.values.straightened(self.lead(high, other, one)).max(0.0);
        let fraction = if before + after > 0.0 { before / (before + after) } else { 0.5 };
        fraction.clamp(MARGIN, 1.0 - MARGIN)
    }

    fn sampled_label(&self, node: [usize; 3]) -> Label {
        match self.locate(node) {
            (Source::Leaf(_, labels), inner) => labels[inner],
            (Source::Tile(label), _) => label,
        }
    }

    /// The leaf that a node is in, and its index there.
    fn locate(&self, node: [usize; 3]) -> (Source<'a>, usize) {
        let [x, y, z] = node.map(|at| at / LEAF_SIDE);
        (self.sources[4 * x + 2 * y + z], node_index(node.map(|at| at % LEAF_SIDE)))
    }
}

fn index(node: [usize; 3]) -> usize {
    (node[0] * SIDE + node[1]) * SIDE + node[2]
}
