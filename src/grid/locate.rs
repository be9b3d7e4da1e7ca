//! Which cells of the complex the nodes of a leaf lie in.

use glam::DVec3;

use crate::complex::Complex;
use crate::label::Label;
use crate::plane::Bounds;

use super::invariant::node_offset;
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice};

/// In place of a cell for nodes that do not lie inside the box.
pub(super) const NO_CELL: u32 = u32::MAX;

/// The cells that divide a box.
pub trait Cells: Sync {
    /// The box.
    fn bounds(&self) -> Bounds;
    /// Whether materials may reach the box's faces.
    fn is_open(&self) -> bool;
    /// The cell of a point of the box.
    fn locate(&self, point: DVec3) -> u32;
    /// Finds the cells of points of a region.
    fn locator<'a>(&'a self, region: Bounds) -> Box<dyn Fn(DVec3) -> u32 + 'a>;
}

impl Cells for Complex {
    fn bounds(&self) -> Bounds {
        self.bounds()
    }

    fn is_open(&self) -> bool {
        self.border() != Label::OUTSIDE
    }

    fn locate(&self, point: DVec3) -> u32 {
        self.locate(point)
    }

    fn locator<'a>(&'a self, region: Bounds) -> Box<dyn Fn(DVec3) -> u32 + 'a> {
        let locator = self.locator(region);
        match locator.only_cell() {
            Some(cell) => Box::new(move |_| cell),
            None => Box::new(move |point| locator.locate(point)),
        }
    }
}

/// Where the field is asked for the values of a node: there, and in an open
/// box, for nodes that are not inside it, at the nearest node that is.
pub(super) fn place(cells: &dyn Cells, lattice: &Lattice, node: [i32; 3]) -> DVec3 {
    lattice.position(if cells.is_open() { lattice.nearest_inner(node) } else { node })
}

/// The cell that a node gets its values in, or [`NO_CELL`].
pub(super) fn node_cell(cells: &dyn Cells, lattice: &Lattice, node: [i32; 3]) -> u32 {
    let point = place(cells, lattice, node);
    if has_values(cells, point) { cells.locate(point) } else { NO_CELL }
}

/// The cells of a leaf's nodes.
pub(super) fn leaf_cells(cells: &dyn Cells, lattice: &Lattice, at: [i32; 3]) -> Vec<u32> {
    let node = |offset: [usize; 3]| {
        let node = std::array::from_fn(|axis| (at[axis] * LEAF_SIDE as i32) + offset[axis] as i32);
        place(cells, lattice, node)
    };
    let region = Bounds { min: node([0; 3]), max: node([LEAF_SIDE - 1; 3]) };
    let locate = cells.locator(region);
    let cell = |index| {
        let point = node(node_offset(index));
        if has_values(cells, point) { locate(point) } else { NO_CELL }
    };
    (0..LEAF_NODES).map(cell).collect()
}

/// Whether the field has values at a point: inside the box, and on its faces
/// when it is open.
fn has_values(cells: &dyn Cells, point: DVec3) -> bool {
    let bounds = cells.bounds();
    let reached = || point.cmpge(bounds.min).all() && point.cmple(bounds.max).all();
    if cells.is_open() { reached() } else { is_inside(bounds, point) }
}

/// Whether a point is inside a box, and not on its border.
pub(super) fn is_inside(bounds: Bounds, point: DVec3) -> bool {
    point.cmpgt(bounds.min).all() && point.cmplt(bounds.max).all()
}
