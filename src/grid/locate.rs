//! Which cells of the arrangement the nodes of a leaf lie in.

use glam::DVec3;

use crate::arrangement::Arrangement;
use crate::plane::Bounds;

use super::invariant::node_index;
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice};

/// In place of a cell for nodes that do not lie inside the box.
pub(super) const NO_CELL: u32 = u32::MAX;

/// The convex cells that divide a box.
pub(super) trait Cells: Sync {
    /// The box.
    fn bounds(&self) -> Bounds;
    /// The cell of a point inside the box.
    fn locate(&self, point: DVec3) -> u32;
}

impl Cells for Arrangement {
    fn bounds(&self) -> Bounds {
        self.bounds()
    }

    fn locate(&self, point: DVec3) -> u32 {
        self.locate(point)
    }
}

/// The cell of a node, or [`NO_CELL`].
pub(super) fn node_cell(cells: &dyn Cells, lattice: &Lattice, node: [i32; 3]) -> u32 {
    let point = lattice.position(node);
    let bounds = cells.bounds();
    let inside = point.cmpgt(bounds.min).all() && point.cmplt(bounds.max).all();
    if inside { cells.locate(point) } else { NO_CELL }
}

/// The cells of a leaf's nodes. Cells are convex: where the corners of a
/// block of nodes lie in one cell, the whole block does.
pub(super) fn leaf_cells(cells: &dyn Cells, lattice: &Lattice, at: [i32; 3]) -> Vec<u32> {
    let mut found = vec![NO_CELL; LEAF_NODES];
    let leaf = Blocks { cells, lattice, first: at.map(|at| at * LEAF_SIDE as i32) };
    leaf.fill([0; 3], LEAF_SIDE, &mut found);
    found
}

struct Blocks<'a> {
    cells: &'a dyn Cells,
    lattice: &'a Lattice,
    first: [i32; 3],
}

impl Blocks<'_> {
    fn fill(&self, start: [usize; 3], side: usize, found: &mut [u32]) {
        let corners: [[usize; 3]; 8] = std::array::from_fn(|corner| {
            std::array::from_fn(|axis| start[axis] + (corner >> axis & 1) * (side - 1))
        });
        let cells = corners.map(|corner| self.cell(corner));
        if side == 2 {
            for (corner, cell) in corners.into_iter().zip(cells) {
                found[node_index(corner)] = cell;
            }
        } else if cells[0] != NO_CELL && cells.iter().all(|&cell| cell == cells[0]) {
            for node in 0..side * side * side {
                let offset = [node / (side * side), node / side % side, node % side];
                found[node_index(std::array::from_fn(|axis| start[axis] + offset[axis]))] =
                    cells[0];
            }
        } else {
            for corner in 0..8 {
                let half: [usize; 3] =
                    std::array::from_fn(|axis| start[axis] + (corner >> axis & 1) * (side / 2));
                self.fill(half, side / 2, found);
            }
        }
    }

    fn cell(&self, offset: [usize; 3]) -> u32 {
        let node = std::array::from_fn(|axis| self.first[axis] + offset[axis] as i32);
        node_cell(self.cells, self.lattice, node)
    }
}
