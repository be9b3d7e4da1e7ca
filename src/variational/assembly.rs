//! The labels' fields become samples: leaves wherever the largest field changes.

use rayon::prelude::*;

use crate::grid::invariant::{differs_near_face, faces, neighbor, node_offset};
use crate::grid::leaf_grid::{LeafSet, NO_SLOT};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Leaf, LeafValues, Samples, Values};
use crate::label::Label;

use super::label_field::{LabelField, Scene};

/// A label whose field is lower than this all over a leaf, in voxels, is not kept
/// there: it is farther away than the leaf's nodes are from each other.
const FAR: f32 = -(LEAF_SIDE as f32);
/// What is beyond a closed box.
const BEYOND: f32 = 1.0;

/// The samples of some fields.
pub fn assemble(mut fields: Vec<LabelField>, scene: &Scene) -> Samples {
    let lattice = scene.space.lattices[scene.space.lattices.len() - 1];
    let tiles = tiles(&fields, &lattice);
    let mut assembly = Assembly { lattice, tiles, leaves: Vec::new() };
    let Some(first) = fields.first().and_then(|field| field.levels.last()) else {
        return assembly.into_samples(scene);
    };
    let mut taken = LeafSet::new(&first.grid);
    let bands = fields.iter().flat_map(|field| field.band.iter().copied());
    let mut wave: Vec<[i32; 3]> = bands.chain(assembly.changes_of_tiles()).collect();
    while !wave.is_empty() {
        wave.sort_unstable();
        wave.retain(|&leaf| lattice.has_leaf(leaf) && taken.insert(leaf));
        for field in &mut fields {
            let near: Vec<[i32; 3]> =
                wave.iter().copied().filter(|&leaf| field.rough(middle(leaf)) > FAR).collect();
            field.ensure(near);
        }
        let start = assembly.leaves.len();
        let leaf = |&at: &[i32; 3]| collect_leaf(&fields, scene, at);
        assembly.leaves.par_extend(wave.par_iter().map(leaf));
        wave = assembly.nearby(start);
    }
    assembly.into_samples(scene)
}

/// The node that stands for a leaf.
fn middle(leaf: [i32; 3]) -> [i32; 3] {
    leaf.map(|along| along * LEAF_SIDE as i32 + LEAF_SIDE as i32 / 2)
}

/// The label of every leaf's middle.
fn tiles(fields: &[LabelField], lattice: &Lattice) -> Vec<Label> {
    let label = |index: usize| {
        let node = middle(lattice.leaf_at(index));
        if !lattice.is_inner(node) {
            return Label::OUTSIDE;
        }
        let mut best = (Label::OUTSIDE, if fields.len() == 1 { 0.0 } else { f32::NEG_INFINITY });
        for field in fields {
            let value = field.rough(node);
            if value > best.1 {
                best = (field.label, value);
            }
        }
        best.0
    };
    (0..lattice.leaf_count() as usize).into_par_iter().map(label).collect()
}

/// Samples in the making.
struct Assembly {
    lattice: Lattice,
    tiles: Vec<Label>,
    leaves: Vec<Leaf>,
}

impl Assembly {
    fn tile(&self, at: [i32; 3]) -> Label {
        let has = self.lattice.has_leaf(at);
        if has { self.tiles[self.lattice.leaf_index(at)] } else { Label::OUTSIDE }
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

    /// The neighbours, of leaves from `start` on, that a change of label leads into.
    fn nearby(&self, start: usize) -> Vec<[i32; 3]> {
        let next = |leaf: &Leaf| {
            let labels = leaf.labels();
            let near = |(axis, forward)| {
                let next = neighbor(leaf.at, axis, forward);
                let differs = differs_near_face(&labels, axis, forward, 1, self.tile(next));
                (self.lattice.has_leaf(next) && differs).then_some(next)
            };
            faces().filter_map(near).collect::<Vec<_>>()
        };
        self.leaves[start..].par_iter().flat_map_iter(next).collect()
    }

    fn into_samples(mut self, scene: &Scene) -> Samples {
        self.leaves.par_sort_unstable_by_key(|leaf| leaf.at);
        let Self { lattice, tiles, leaves } = self;
        let open = scene.is_open.then_some(scene.space.bounds);
        Samples { lattice, leaves, tiles, open, values: Values::Distances }
    }
}

/// A leaf with the fields of all labels that are near.
fn collect_leaf(fields: &[LabelField], scene: &Scene, at: [i32; 3]) -> Leaf {
    let several = fields.len() > 1;
    let mut materials = Vec::new();
    for field in fields {
        let Some(level) = field.levels.last() else { continue };
        let slot = level.grid.slot(at);
        let is_outside = field.label == Label::OUTSIDE;
        let values = match slot {
            NO_SLOT if is_outside => vec![FAR; LEAF_NODES],
            NO_SLOT => continue,
            _ => (0..LEAF_NODES).map(|node| node_value(field, scene, at, node)).collect(),
        };
        let is_near = !several || is_outside || values.iter().any(|&value| value > FAR);
        if is_near {
            materials.push(LeafValues { label: field.label, values });
        }
    }
    Leaf { at, materials }
}

/// The value of a leaf's node: beyond an open box that of the nearest node inside,
/// beyond a closed one something outside.
fn node_value(field: &LabelField, scene: &Scene, at: [i32; 3], node: usize) -> f32 {
    let Some(level) = field.levels.last() else { return FAR };
    let offset = node_offset(node);
    let place: [i32; 3] =
        std::array::from_fn(|axis| at[axis] * LEAF_SIDE as i32 + offset[axis] as i32);
    let own = level.grid.leaf(level.grid.slot(at))[node];
    if level.lattice.is_inner(place) {
        return own;
    }
    if scene.is_open {
        return level.grid.value(level.lattice.nearest_inner(place)).unwrap_or(own);
    }
    match (field.label == Label::OUTSIDE, level.has(place)) {
        (true, true) => own.max(BEYOND),
        (false, true) => own.min(-BEYOND / 16.0),
        (true, false) => BEYOND,
        (false, false) => -BEYOND,
    }
}
