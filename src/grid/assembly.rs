//! The labels' fields become samples: leaves wherever the largest field changes.

use rayon::prelude::*;

use crate::label::Label;
use crate::plane::Bounds;

use super::invariant::{differs_near_face, faces, neighbor, node_of};
use super::leaf::{Leaf, LeafNodes, LeafOf, LeafValues};
use super::leaf_grid::{LeafGrid, LeafSet, NO_SLOT};
use super::samples::{LEAF_NODES, LEAF_SIDE, LabelValues, Lattice, Samples, Values};

/// A label whose field is lower than this all over a leaf, in voxels, is not kept
/// there: it is farther away than the leaf's nodes are from each other.
pub const FAR: f32 = -(LEAF_SIDE as f32);
/// What *outside* is in a leaf that it is not near to.
static FAR_LEAF: LeafNodes = [FAR; LEAF_NODES];
/// What is beyond a closed box.
const BEYOND: f32 = 1.0;

/// One label's field on a lattice: about the distance to its surface in voxels, positive where
/// the label is.
pub trait NodeField: Send + Sync {
    /// The label.
    fn label(&self) -> Label;
    /// The value of a node, roughly where no leaf is near.
    fn rough(&self, node: [i32; 3]) -> f32;
    /// Whether its surface, or what is near to it, may be in a leaf; by default where its value
    /// is no distance too far from the surface in the leaf's middle.
    fn may_be_in(&self, leaf: [i32; 3]) -> bool {
        self.rough(middle(leaf)) > FAR
    }
    /// Gives values to leaves, if they have none.
    fn ensure(&mut self, leaves: Vec<[i32; 3]>);
    /// The values that leaves were given.
    fn grid(&self) -> &LeafGrid;
    /// The same, to be changed.
    fn grid_mut(&mut self) -> &mut LeafGrid;
    /// The same alone.
    fn into_grid(self) -> LeafGrid;
    /// Whether the field has a value at a node, and not only the leaf that it is in.
    fn has(&self, node: [i32; 3]) -> bool;
}

/// The samples of some fields in a box, found from where leaves start on. They keep the values
/// where these are.
pub fn assemble<F: NodeField>(
    fields: Vec<F>,
    starts: Vec<[i32; 3]>,
    lattice: Lattice,
    open: Option<Bounds>,
) -> Samples {
    let tiles = tiles(&fields, &lattice);
    let taken = LeafSet::new(&LeafGrid::new([0; 3], lattice.dims));
    let mut assembly = Assembly { open, lattice, fields, tiles, taken };
    let mut wave = starts;
    wave.extend(assembly.changes_of_tiles());
    while !wave.is_empty() {
        wave.sort_unstable();
        wave.retain(|&leaf| assembly.taken.insert(leaf));
        assembly.take(&wave);
        wave = wave.par_iter().flat_map_iter(|&leaf| assembly.nearby(leaf)).collect();
    }
    assembly.into_samples()
}

/// The node that stands for a leaf.
pub fn middle(leaf: [i32; 3]) -> [i32; 3] {
    leaf.map(|along| along * LEAF_SIDE as i32 + LEAF_SIDE as i32 / 2)
}

/// The label of every leaf's middle.
fn tiles<F: NodeField>(fields: &[F], lattice: &Lattice) -> Vec<Label> {
    let label = |index: usize| {
        let node = middle(lattice.leaf_at(index));
        if !lattice.is_inner(node) {
            return Label::OUTSIDE;
        }
        let mut best = (Label::OUTSIDE, if fields.len() == 1 { 0.0 } else { f32::NEG_INFINITY });
        for field in fields {
            let value = field.rough(node);
            if value > best.1 {
                best = (field.label(), value);
            }
        }
        best.0
    };
    (0..lattice.leaf_count() as usize).into_par_iter().map(label).collect()
}

/// Samples in the making.
struct Assembly<F> {
    open: Option<Bounds>,
    lattice: Lattice,
    fields: Vec<F>,
    tiles: Vec<Label>,
    /// The leaves with values.
    taken: LeafSet,
}

impl<F: NodeField> Assembly<F> {
    /// Gives leaves the values of all labels that are near.
    fn take(&mut self, leaves: &[[i32; 3]]) {
        for field in &mut self.fields {
            let near: Vec<[i32; 3]> =
                leaves.par_iter().copied().filter(|&leaf| field.may_be_in(leaf)).collect();
            field.ensure(near);
            let is_open = self.open.is_some();
            leaves.iter().for_each(|&leaf| settle(field, &self.lattice, is_open, leaf));
        }
    }

    fn tile(&self, at: [i32; 3]) -> Label {
        self.lattice.tile(&self.tiles, at)
    }

    /// Leaves whose tile is not that of all neighbours.
    fn changes_of_tiles(&self) -> Vec<[i32; 3]> {
        let changes = |index: &usize| {
            let at = self.lattice.leaf_at(*index);
            faces()
                .any(|(axis, forward)| self.tile(neighbor(at, axis, forward)) != self.tiles[*index])
        };
        let indices: Vec<usize> = (0..self.tiles.len()).into_par_iter().filter(changes).collect();
        indices.into_iter().map(|index| self.lattice.leaf_at(index)).collect()
    }

    /// The neighbours that a change of label in a leaf leads into.
    fn nearby(&self, at: [i32; 3]) -> Vec<[i32; 3]> {
        let labels = self.leaf(at).labels();
        let near = |(axis, forward)| {
            let next = neighbor(at, axis, forward);
            let differs = differs_near_face(&labels, axis, forward, 1, self.tile(next));
            (self.lattice.has_leaf(next) && differs).then_some(next)
        };
        faces().filter_map(near).collect()
    }

    /// A leaf as it will be in the samples.
    fn leaf(&self, at: [i32; 3]) -> Leaf<'_> {
        let several = self.fields.len() > 1;
        let near = self.fields.iter().filter_map(|field| in_leaf(field, at, several));
        LeafOf { at, materials: near.collect() }
    }

    /// The fields' own values, less what the samples do not need.
    fn into_samples(self) -> Samples {
        let Self { open, lattice, fields, tiles, taken } = self;
        let (valued, several) = (taken.sorted(), fields.len() > 1);
        let own = |field: F| {
            let label = field.label();
            let mut grid = field.into_grid();
            grid.retain(|leaf, values| taken.has(leaf) && is_near(label, values, several));
            if label == Label::OUTSIDE {
                let added = grid.add(valued.iter().copied());
                grid.values_mut()[added.start * LEAF_NODES..].fill(FAR);
            }
            grid.shrink_to_fit();
            (!grid.leaves().is_empty()).then_some(LabelValues { label, grid })
        };
        let fields = fields.into_par_iter().filter_map(own).collect();
        Samples { lattice, valued, fields, tiles, open, values: Values::Distances }
    }
}

/// A field's values in a leaf, where it is near.
fn in_leaf<F: NodeField>(field: &F, at: [i32; 3], several: bool) -> Option<LeafValues<&LeafNodes>> {
    let label = field.label();
    let values = match field.grid().get(at) {
        None if label == Label::OUTSIDE => &FAR_LEAF,
        values => values?,
    };
    is_near(label, values, several).then_some(LeafValues { label, values })
}

/// Whether a label, one of several or not, is kept in a leaf where it has these values.
fn is_near(label: Label, values: &LeafNodes, several: bool) -> bool {
    !several || label == Label::OUTSIDE || values.iter().any(|&value| value > FAR)
}

/// Gives those nodes of a leaf, if it is there, that are not inside the box the values
/// that samples have there.
fn settle<F: NodeField>(field: &mut F, lattice: &Lattice, is_open: bool, leaf: [i32; 3]) {
    let slot = field.grid().slot(leaf);
    let is_inner = |node: usize| lattice.is_inner(node_of(leaf, node));
    if slot == NO_SLOT || is_inner(0) && is_inner(LEAF_NODES - 1) {
        return;
    }
    for node in 0..LEAF_NODES {
        let at = node_of(leaf, node);
        if !lattice.is_inner(at) {
            let own = field.grid().leaf(slot)[node];
            field.grid_mut().leaf_mut(slot)[node] = value_beyond(field, lattice, is_open, at, own);
        }
    }
}

/// The value of a node that is not inside the box: beyond an open one that of the
/// nearest node inside, beyond a closed one something outside.
fn value_beyond<F: NodeField>(
    field: &F,
    lattice: &Lattice,
    is_open: bool,
    node: [i32; 3],
    own: f32,
) -> f32 {
    if is_open {
        return field.grid().value(lattice.nearest_inner(node)).unwrap_or(own);
    }
    match (field.label() == Label::OUTSIDE, field.has(node)) {
        (true, true) => own.max(BEYOND),
        (false, true) => own.min(-BEYOND / 16.0),
        (true, false) => BEYOND,
        (false, false) => -BEYOND,
    }
}
