//! How deep nodes lie in what differs.

use rayon::prelude::*;

use crate::grid::labels::node_in_leaf;
use crate::grid::samples::{LEAF_NODES, Lattice};

/// In place of a leaf's first value where no node of it is in the set.
const EMPTY: usize = usize::MAX;

/// For each node of a set, given leaf by leaf, the distance to the nearest node
/// that is not in it, in world units. Nodes on the lattice's border and beyond
/// are not in it.
pub fn depths(lattice: &Lattice, nodes: &[[i32; 3]]) -> Vec<f32> {
    let mut squares = Squares::new(lattice, nodes);
    // The least of squares along z, then of those along y, then along x.
    for axis in [2, 1, 0] {
        let least: Vec<u32> =
            nodes.par_iter().map(|&node| squares.least_along(node, axis)).collect();
        for (&node, square) in nodes.iter().zip(least) {
            let place = squares.place(node);
            squares.values[place] = square;
        }
    }
    let depth = |&node: &[i32; 3]| {
        (lattice.voxel * f64::from(squares.values[squares.place(node)]).sqrt()) as f32
    };
    nodes.par_iter().map(depth).collect()
}

/// Squared distances in voxels, 0 for what is not in the set.
struct Squares<'a> {
    lattice: &'a Lattice,
    /// For every leaf where its values begin, or [`EMPTY`].
    starts: Vec<usize>,
    values: Vec<u32>,
}

impl<'a> Squares<'a> {
    /// Still infinite in the set.
    fn new(lattice: &'a Lattice, nodes: &[[i32; 3]]) -> Self {
        let mut squares = Self {
            lattice,
            starts: vec![EMPTY; lattice.leaf_count() as usize],
            values: Vec::new(),
        };
        for &node in nodes {
            let leaf = lattice.leaf_index(node_in_leaf(node).0);
            if squares.starts[leaf] == EMPTY {
                squares.starts[leaf] = squares.values.len();
                squares.values.resize(squares.values.len() + LEAF_NODES, 0);
            }
            let place = squares.place(node);
            squares.values[place] = u32::MAX;
        }
        squares
    }

    /// Where the value of a node in the set is.
    fn place(&self, node: [i32; 3]) -> usize {
        let (at, index) = node_in_leaf(node);
        self.starts[self.lattice.leaf_index(at)] + index
    }

    fn at(&self, node: [i32; 3]) -> u32 {
        if !self.lattice.is_inner(node) {
            return 0;
        }
        let (at, index) = node_in_leaf(node);
        match self.starts[self.lattice.leaf_index(at)] {
            EMPTY => 0,
            start => self.values[start + index],
        }
    }

    /// The least of step² + the square there, along an axis.
    fn least_along(&self, node: [i32; 3], axis: usize) -> u32 {
        let mut least = self.at(node);
        let mut step: u32 = 1;
        while step * step < least {
            for forward in [step as i32, -(step as i32)] {
                let mut other = node;
                other[axis] += forward;
                least = least.min(self.at(other).saturating_add(step * step));
            }
            step += 1;
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::grid::labels::leaf_nodes;

    #[test]
    fn depths_are_distances_to_the_nearest_node_outside() {
        let lattice = Lattice { origin: DVec3::ZERO, voxel: 0.5, dims: [24, 20, 22] };
        // A ball, and a bar that runs into the lattice's border.
        let within = |[x, y, z]: [i32; 3]| {
            let far = (x - 10).pow(2) + (y - 9).pow(2) + (z - 11).pow(2);
            lattice.is_inner([x, y, z]) && (far < 30 || ((3..6).contains(&y) && z < 7))
        };
        let all: Vec<[i32; 3]> = (0..lattice.leaf_count() as usize)
            .flat_map(|leaf| leaf_nodes(lattice.leaf_at(leaf)))
            .collect();
        let nodes: Vec<[i32; 3]> = all.iter().copied().filter(|&node| within(node)).collect();
        let apart = |one: [i32; 3], other: [i32; 3]| {
            (0..3).map(|axis| (one[axis] - other[axis]).pow(2)).sum::<i32>()
        };
        for (&node, depth) in nodes.iter().zip(depths(&lattice, &nodes)) {
            let outside = all.iter().filter(|&&other| !within(other));
            let nearest = outside.map(|&other| apart(node, other)).min().unwrap();
            assert_eq!(depth, (0.5 * f64::from(nearest).sqrt()) as f32, "{node:?}");
        }
        assert!(depths(&lattice, &[]).is_empty());
    }
}
