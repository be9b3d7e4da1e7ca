//! What [`Samples`] promise, checked.

use crate::label::Label;

use super::leaf::Leaf;
use super::samples::{LEAF_NODES, LEAF_SIDE, LabelValues, Samples, Values};

/// The node of a leaf with these offsets.
pub fn node_index([x, y, z]: [usize; 3]) -> usize {
    (x * LEAF_SIDE + y) * LEAF_SIDE + z
}

/// The offsets of a leaf's node: the inverse of [`node_index`].
pub fn node_offset(node: usize) -> [usize; 3] {
    [node / (LEAF_SIDE * LEAF_SIDE), node / LEAF_SIDE % LEAF_SIDE, node % LEAF_SIDE]
}

/// A node of a leaf in the lattice.
pub fn node_of(leaf: [i32; 3], node: usize) -> [i32; 3] {
    let offset = node_offset(node);
    std::array::from_fn(|axis| leaf[axis] * LEAF_SIDE as i32 + offset[axis] as i32)
}

/// The leaf next to `at` along an axis, forward or backward.
pub fn neighbor(at: [i32; 3], axis: usize, forward: bool) -> [i32; 3] {
    let mut next = at;
    next[axis] += if forward { 1 } else { -1 };
    next
}

/// Whether a label other than `tile` occurs in the `depth` layers of nodes
/// that lie at a leaf's face.
pub fn differs_near_face(
    labels: &[Label],
    axis: usize,
    forward: bool,
    depth: usize,
    tile: Label,
) -> bool {
    (0..LEAF_NODES).any(|node| {
        let along = node_offset(node)[axis];
        let layer = if forward { LEAF_SIDE - 1 - along } else { along };
        layer < depth && labels[node] != tile
    })
}

/// See [`Samples::sanity_check`].
pub(super) fn check(samples: &Samples) -> Result<(), String> {
    let lattice = &samples.lattice;
    if samples.tiles.len() as u64 != lattice.leaf_count() {
        return Err(format!("{} tiles for {} leaves", samples.tiles.len(), lattice.leaf_count()));
    }
    if !samples.valued.is_sorted_by(|a, b| a < b) {
        return Err("leaves are not sorted, or not distinct".to_owned());
    }
    if !samples.fields.is_sorted_by(|a, b| a.label < b.label) {
        return Err("labels are not sorted, or not distinct".to_owned());
    }
    samples.fields.iter().try_for_each(|field| check_field(samples, field))?;
    samples.leaves().try_for_each(|leaf| check_leaf(samples, &leaf))?;
    (0..samples.tiles.len()).try_for_each(|index| check_tile(samples, lattice.leaf_at(index)))
}

fn check_field(samples: &Samples, LabelValues { label, grid }: &LabelValues) -> Result<(), String> {
    if *label == Label::UNKNOWN || grid.leaves().is_empty() {
        return Err(format!("label {label}, near {} leaves", grid.leaves().len()));
    }
    match grid.leaves().iter().find(|&&at| !samples.is_valued(at)) {
        Some(at) => Err(format!("label {label} has values in {at:?}, which is no such leaf")),
        None => Ok(()),
    }
}

fn check_leaf(samples: &Samples, leaf: &Leaf) -> Result<(), String> {
    let at = leaf.at;
    if !samples.lattice.has_leaf(at) {
        return Err(format!("leaf {at:?} is not in the lattice"));
    }
    for material in &leaf.materials {
        let may_be = |value: &f32| match samples.values {
            Values::Indicators => (-1.0..=1.0).contains(value),
            Values::Distances => value.is_finite(),
        };
        if !material.values.iter().all(may_be) {
            let label = material.label;
            return Err(format!("leaf {at:?}: label {label} has values that it cannot have"));
        }
    }
    let labels = leaf.labels();
    if samples.open.is_none() {
        check_outermost(samples, at, &labels)?;
    }
    for (axis, forward) in faces() {
        let next = neighbor(at, axis, forward);
        let closed = !samples.lattice.has_leaf(next)
            || samples.is_valued(next)
            || !differs_near_face(&labels, axis, forward, 1, samples.tile(next));
        if !closed {
            return Err(format!("a surface leaves the leaves from {at:?} to {next:?}"));
        }
    }
    Ok(())
}

fn check_outermost(samples: &Samples, at: [i32; 3], labels: &[Label]) -> Result<(), String> {
    let dims = samples.lattice.dims;
    for (node, &label) in labels.iter().enumerate() {
        let offset = node_offset(node);
        let outermost = (0..3).any(|axis| {
            let along = at[axis] * LEAF_SIDE as i32 + offset[axis] as i32;
            along == 0 || along >= dims[axis] - 1
        });
        if outermost && label != Label::OUTSIDE {
            return Err(format!("node {offset:?} of leaf {at:?} is outermost and {label}"));
        }
    }
    Ok(())
}

fn check_tile(samples: &Samples, at: [i32; 3]) -> Result<(), String> {
    if samples.is_valued(at) {
        return Ok(());
    }
    let label = samples.tile(at);
    for (axis, forward) in faces() {
        let next = neighbor(at, axis, forward);
        if !samples.lattice.has_leaf(next) {
            if label != Label::OUTSIDE {
                return Err(format!("tile {at:?} is outermost and {label}"));
            }
        } else if !samples.is_valued(next) && samples.tile(next) != label {
            return Err(format!("tiles {at:?} and {next:?} differ"));
        }
    }
    Ok(())
}

/// The six faces of a leaf: axis, and whether forward along it.
pub fn faces() -> impl Iterator<Item = (usize, bool)> {
    (0..3).flat_map(|axis| [(axis, false), (axis, true)])
}
