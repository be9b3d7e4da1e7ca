//! What nodes of a lattice hold, as volumes: values in leaves near the surface.

use rayon::prelude::*;

use super::evidence::Evidence;
use super::labels::{LabelGrid, leaf_nodes, node_in_leaf};
use super::leaf::Leaf;
use super::samples::{LEAF_NODES, Samples};
use crate::label::Label;
use crate::section::Section;

/// Values at the nodes of a lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct Volume<T> {
    /// What all leaves have that are not named.
    pub background: T,
    /// Leaves with a value for each node.
    pub leaves: Vec<[i32; 3]>,
    /// Their values, in the order of [`LeafNodes`](super::leaf::LeafNodes).
    pub values: Vec<T>,
    /// Leaves of one value.
    pub tiles: Vec<[i32; 3]>,
    /// Their values.
    pub tile_values: Vec<T>,
}

impl<T> Volume<T> {
    /// In leaves alone.
    fn in_leaves(background: T, leaves: Vec<[i32; 3]>, values: Vec<T>) -> Self {
        Self { background, leaves, values, tiles: Vec::new(), tile_values: Vec::new() }
    }
}

/// A label's indicator: from −1 far outside to 1 far inside.
pub fn indicator(samples: &Samples, label: Label) -> Volume<f32> {
    let own = samples.fields.iter().find(|field| field.label == label);
    let (leaves, values) =
        own.map_or_else(Default::default, |own| (own.grid.leaves(), own.grid.values()));
    let values = values.par_iter().map(|&value| samples.values.indicator(value)).collect();
    let all = (0..samples.tiles.len()).filter(|&tile| samples.tiles[tile] == label);
    let all = all.map(|tile| samples.lattice.leaf_at(tile));
    let tiles: Vec<[i32; 3]> = all.filter(|&at| !samples.is_valued(at)).collect();
    let tile_values = vec![1.0; tiles.len()];
    Volume { background: -1.0, leaves: leaves.to_vec(), values, tiles, tile_values }
}

/// How far the nearest known part of a section is, in world units, near the surface.
pub fn evidence(samples: &Samples, sections: &[Section]) -> Volume<f32> {
    let evidence = Evidence::new(sections);
    near_surface(samples, 0.0, |leaf| evidence.in_leaf(&samples.lattice, leaf.at))
}

/// How far the label at a node leads over the second. Away from the surface one label has
/// everything.
pub fn margin(samples: &Samples) -> Volume<f32> {
    let margin = |margin: f32| 2.0 * samples.values.indicator(margin / 2.0);
    near_surface(samples, 2.0, |leaf| leaf.margins().into_iter().map(margin).collect())
}

fn near_surface(
    samples: &Samples,
    background: f32,
    values: impl Fn(&Leaf) -> Vec<f32> + Sync,
) -> Volume<f32> {
    let values = samples.par_leaves().map(|leaf| values(&leaf)).collect::<Vec<_>>().concat();
    Volume::in_leaves(background, samples.valued.clone(), values)
}

/// The material at every node. Beyond an open box nothing is, though values lead there.
pub fn labels(grid: &LabelGrid) -> Volume<Label> {
    let mut volume = Volume::in_leaves(Label::OUTSIDE, Vec::new(), Vec::new());
    for leaf in 0..grid.lattice.leaf_count() as usize {
        let at = grid.lattice.leaf_at(leaf);
        match grid.tile(leaf) {
            Some(label) if label.is_material() => {
                volume.tiles.push(at);
                volume.tile_values.push(label);
            }
            Some(_) => {}
            None => {
                volume.leaves.push(at);
                volume.values.extend(leaf_nodes(at).zip(grid.leaf(leaf)).map(|(node, label)| {
                    let beyond = grid.is_open && !grid.lattice.is_inner(node);
                    if beyond { Label::OUTSIDE } else { label }
                }));
            }
        }
    }
    volume
}

/// Values at some nodes, which come leaf by leaf, and 0 at all others.
pub fn at_nodes(nodes: &[[i32; 3]], values: &[f32]) -> Volume<f32> {
    let mut volume = Volume::in_leaves(0.0, Vec::new(), Vec::new());
    for (&node, &value) in nodes.iter().zip(values) {
        let (at, index) = node_in_leaf(node);
        if volume.leaves.last() != Some(&at) {
            volume.leaves.push(at);
            volume.values.resize(volume.values.len() + LEAF_NODES, 0.0);
        }
        let first = volume.values.len() - LEAF_NODES;
        volume.values[first + index] = value;
    }
    volume
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_at_nodes_are_where_their_nodes_are() {
        let volume = at_nodes(&[[1, 0, 2], [7, 7, 7], [8, 0, 0]], &[0.5, 1.5, 2.5]);
        assert_eq!(volume.leaves, [[0; 3], [1, 0, 0]]);
        assert_eq!([66, 511, 512].map(|at| volume.values[at]), [0.5, 1.5, 2.5]);
        assert_eq!(volume.values.iter().filter(|&&value| value != 0.0).count(), 3);
    }
}
