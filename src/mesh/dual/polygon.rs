//! The polygon around every lattice edge between different labels.
//!
//! Seen from the end of the edge, with the edge's axis d pointing at the
//! viewer, its four cells and the faces between them are (u to the right, v
//! up, the edge in the middle):
//!
//! ```text
//!   cell 1 │ cell 0        cell 0 starts at the edge's first node n,
//!   ───────┼───────        cell 1 at n − u, cell 2 at n − u − v,
//!   cell 2 │ cell 3        cell 3 at n − v
//! ```

use std::sync::Arc;

use glam::DVec3;

use super::block::{ActiveCell, Block, CrossedEdge, is_pinched};
use super::cell::FACE_EDGES;
use crate::grid::samples::LEAF_SIDE;
use crate::label::Label;
use crate::mesh::back_and_front;

/// Blocks with the numbers of their points in the mesh.
pub struct Blocks<'a> {
    /// In the order of their places.
    pub blocks: &'a [Arc<Block>],
    /// For every leaf of the lattice the index in `blocks`, or `u32::MAX`.
    pub block_at: &'a [u32],
    /// Leaves along each axis.
    pub dims: [i32; 3],
    /// For each block the number of its first point.
    pub first_point: Vec<u32>,
    /// For each block the number of its first pinch's first point.
    pub first_pinch: Vec<u32>,
}

/// The faces of a block's cells that are pinched from both sides.
#[derive(Default)]
pub struct Pinched {
    /// The cell whose low face it is, by its offset in the leaf, and the axis
    /// that the face is perpendicular to; sorted.
    keys: Vec<([usize; 3], usize)>,
    /// Two for each.
    pub points: Vec<DVec3>,
}

/// A closed chain of points with the labels behind and in front of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Polygons {
    /// Those with four corners: the pieces' points in cells 0 to 3, or in the
    /// opposite order, counter-clockwise as seen from the front.
    pub quads: Vec<([u32; 4], [Label; 2])>,
    /// Those with points on faces, too.
    pub large: Vec<(Vec<u32>, [Label; 2])>,
}

/// A cell by its block and its first node's offset in the leaf.
type Place<'a> = (usize, &'a Block, [usize; 3]);

impl<'a> Blocks<'a> {
    /// The block and offset of the cell that starts at a node `back` steps
    /// before `node`.
    fn cell_before(&self, block: usize, node: [usize; 3], back: [usize; 3]) -> Option<Place<'a>> {
        let mut at = self.blocks[block].at;
        let mut inner = node;
        for axis in 0..3 {
            if back[axis] > inner[axis] {
                inner[axis] += LEAF_SIDE;
                at[axis] -= 1;
            }
            inner[axis] -= back[axis];
        }
        let inside = at.iter().zip(self.dims).all(|(&at, side)| (0..side).contains(&at));
        let place = ((at[0] * self.dims[1] + at[1]) * self.dims[2] + at[2]) as usize;
        let found = *self.block_at.get(place).filter(|_| inside)? as usize;
        self.blocks.get(found).map(|owner| (found, &**owner, inner))
    }

    /// Which of a block's pinches are pinched from the other side as well:
    /// there, the two pairs of polygons would share one mesh edge.
    pub fn pinched(&self, block: usize) -> Pinched {
        let mut pinched = Pinched::default();
        for pinch in &self.blocks[block].pinches {
            let mut back = [0; 3];
            back[pinch.axis] = 1;
            let before = self
                .cell_before(block, pinch.node, back)
                .and_then(|(_, owner, inner)| owner.cell(inner));
            if before.is_some_and(|cell| is_pinched(&cell.pieces, FACE_EDGES[2 * pinch.axis + 1])) {
                pinched.keys.push((pinch.node, pinch.axis));
                pinched.points.extend(pinch.points);
            }
        }
        pinched
    }

    /// The polygons around the edges that start in a block; `None` when a
    /// cell at an edge is missing, which never is (all four contain both of
    /// the edge's labels).
    pub fn polygons(&self, block: usize, pinched: &[Pinched]) -> Option<Polygons> {
        let mut polygons = Polygons::default();
        for edge in &self.blocks[block].edges {
            let (corners, extra) = self.around(block, edge, pinched)?;
            let [low, high] = edge.labels;
            let sides = back_and_front(low, high);
            // Counter-clockwise seen from the edge's end: that is from the
            // front when the end is in the front label.
            let forward = sides == [low, high];
            if extra.iter().all(Option::is_none) {
                let [a, b, c, d] = corners;
                polygons.quads.push((if forward { [a, b, c, d] } else { [a, d, c, b] }, sides));
            } else {
                let mut chain: Vec<u32> = corners
                    .iter()
                    .zip(extra)
                    .flat_map(|(&corner, extra)| [Some(corner), extra])
                    .flatten()
                    .collect();
                if !forward {
                    chain.reverse();
                }
                polygons.large.push((chain, sides));
            }
        }
        Some(polygons)
    }

    /// The points in cells 0 to 3 around an edge, and for each the point on
    /// the face to the next cell, if it is pinched.
    fn around(
        &self,
        block: usize,
        edge: &CrossedEdge,
        pinched: &[Pinched],
    ) -> Option<([u32; 4], [Option<u32>; 4])> {
        let (u, v) = ((edge.axis + 1) % 3, (edge.axis + 2) % 3);
        let mut quarters = [None; 4];
        // Steps back along u and v, in the sketch's order.
        for (quarter, [i, j]) in quarters.iter_mut().zip([[0, 0], [1, 0], [1, 1], [0, 1]]) {
            let mut back = [0; 3];
            (back[u], back[v]) = (i, j);
            let (owner, in_block, inner) = self.cell_before(block, edge.node, back)?;
            let cell = in_block.cell(inner)?;
            *quarter = Some(Quarter { owner, cell, edge: 4 * edge.axis + 2 * i + j });
        }
        let [Some(zero), Some(one), Some(two), Some(three)] = quarters else { return None };
        // A face belongs to the cell whose low face it is.
        Some((
            [zero, one, two, three].map(|quarter| self.point(quarter)),
            [(zero, u), (one, v), (three, u), (zero, v)]
                .map(|(quarter, axis)| self.point_on_low_face(quarter, axis, pinched)),
        ))
    }

    fn point(&self, Quarter { owner, cell, edge }: Quarter) -> u32 {
        self.first_point[owner] + cell.first + u32::from(cell.pieces.of_edge[edge])
    }

    fn point_on_low_face(&self, quarter: Quarter, axis: usize, pinched: &[Pinched]) -> Option<u32> {
        let Quarter { owner, cell, edge } = quarter;
        let found = pinched[owner].keys.binary_search(&(cell.node, axis)).ok()?;
        let face = 2 * axis;
        let place = FACE_EDGES[face].iter().position(|&candidate| candidate == edge)?;
        Some(self.first_pinch[owner] + (2 * found + cell.links[face].pair(place)) as u32)
    }
}

/// One of the four cells around a lattice edge.
#[derive(Clone, Copy)]
struct Quarter<'a> {
    /// Its block.
    owner: usize,
    cell: &'a ActiveCell,
    /// The lattice edge's number in this cell.
    edge: usize,
}
