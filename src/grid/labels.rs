//! The label of every node of a lattice, for whoever looks at many of them.

use rayon::prelude::*;

use crate::label::Label;

use super::invariant::{node_index, node_offset};
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Samples};

/// In place of a leaf's first value where all of it has one label.
const TILE: usize = usize::MAX;

/// The labels at all nodes of a lattice.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelGrid {
    /// Where the nodes are.
    pub lattice: Lattice,
    /// Whether the box is open: then nodes beyond it have the labels of the
    /// nearest nodes inside.
    pub is_open: bool,
    /// For every leaf where its labels begin in `values`, or [`TILE`].
    starts: Vec<usize>,
    tiles: Vec<Label>,
    values: Vec<Label>,
}

impl LabelGrid {
    /// Of samples.
    pub fn new(samples: &Samples) -> Self {
        let mut starts = vec![TILE; samples.tiles.len()];
        for (index, &at) in samples.valued.iter().enumerate() {
            starts[samples.lattice.leaf_index(at)] = index * LEAF_NODES;
        }
        let values = samples.par_leaves().flat_map_iter(|leaf| leaf.labels()).collect();
        let (lattice, is_open) = (samples.lattice, samples.open.is_some());
        Self { lattice, is_open, starts, tiles: samples.tiles.clone(), values }
    }

    /// The label of all nodes of a leaf, where they have one.
    pub fn tile(&self, leaf: usize) -> Option<Label> {
        (self.starts[leaf] == TILE).then(|| self.tiles[leaf])
    }

    /// The labels of a leaf's nodes, in the order of
    /// [`LeafNodes`](super::leaf::LeafNodes).
    pub fn leaf(&self, leaf: usize) -> Vec<Label> {
        match self.starts[leaf] {
            TILE => vec![self.tiles[leaf]; LEAF_NODES],
            start => self.values[start..start + LEAF_NODES].to_vec(),
        }
    }

    /// The label of a node of the lattice.
    pub fn at(&self, node: [i32; 3]) -> Label {
        let (at, index) = node_in_leaf(node);
        let leaf = self.lattice.leaf_index(at);
        match self.starts[leaf] {
            TILE => self.tiles[leaf],
            start => self.values[start + index],
        }
    }
}

/// The leaf of a node of the lattice, and which of its nodes it is.
pub fn node_in_leaf(node: [i32; 3]) -> ([i32; 3], usize) {
    let side = LEAF_SIDE as i32;
    (node.map(|index| index / side), node_index(node.map(|index| (index % side) as usize)))
}

/// The nodes of a leaf in the lattice, in their order.
pub fn leaf_nodes(at: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..LEAF_NODES).map(move |node| {
        let offset = node_offset(node);
        std::array::from_fn(|axis| at[axis] * LEAF_SIDE as i32 + offset[axis] as i32)
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::mesh::shapes::samples;

    #[test]
    fn labels_are_those_of_the_samples() {
        let lattice = Lattice { origin: DVec3::ZERO, voxel: 1.0, dims: [20, 9, 11] };
        let inside = |[x, y, z]: [i32; 3]| x > 3 && x < 12 && y > 1 && y < 7 && z > 2 && z < 9;
        let samples = samples(lattice, |node| if inside(node) { vec![0.5] } else { vec![-0.5] });
        let grid = LabelGrid::new(&samples);
        let mut materials = 0;
        for index in 0..samples.tiles.len() {
            let nodes = leaf_nodes(lattice.leaf_at(index));
            for (node, label) in nodes.zip(grid.leaf(index)) {
                assert_eq!(label == Label(1), inside(node), "{node:?}");
                assert_eq!(grid.at(node), label);
                materials += usize::from(label.is_material());
            }
        }
        assert_eq!(materials, 8 * 5 * 6);
    }
}
