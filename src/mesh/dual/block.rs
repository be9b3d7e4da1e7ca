//! The interface in the cells of one leaf: its pieces, and a point for each.

use glam::{DVec3, IVec3};

use super::cell::{EDGE_CORNERS, FACE_CORNERS, FACE_EDGES, Links, Pieces};
use super::patch::{Leaves, Patch};
use crate::grid::leaf_grid::leaf_after;
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE};
use crate::label::Label;

/// A cell that the interface passes through.
#[derive(Clone)]
pub struct ActiveCell {
    /// The offset of its first node in the leaf.
    pub node: [usize; 3],
    /// The number of its first piece's point in the block.
    pub first: u32,
    /// The pieces.
    pub pieces: Pieces,
    /// The links in its faces.
    pub links: [Links; 6],
}

/// A lattice edge between nodes of different labels.
#[derive(Clone)]
pub struct CrossedEdge {
    /// The offset of its first node in the leaf.
    pub node: [usize; 3],
    /// Its direction.
    pub axis: usize,
    /// The labels of its two nodes.
    pub labels: [Label; 2],
}

/// A face whose two pairs of edges belong to one piece on at least this
/// cell's side.
#[derive(Clone)]
pub struct Pinch {
    /// The offset in the leaf of the cell whose low face it is.
    pub node: [usize; 3],
    /// The axis that it is perpendicular to.
    pub axis: usize,
    /// A point for each pair, where the surface crosses the face.
    pub points: [DVec3; 2],
}

/// Everything about the cells whose first nodes are in one leaf. Points are
/// in lattice units: node (i, j, k) is at (i, j, k).
#[derive(Clone)]
pub struct Block {
    /// The leaf.
    pub at: [i32; 3],
    /// In the order of their first nodes.
    pub cells: Vec<ActiveCell>,
    /// For every place in the leaf the index in `cells`, or `u16::MAX`.
    cell_at: Vec<u16>,
    /// The pieces' points: those of each cell in turn.
    pub points: Vec<DVec3>,
    /// In the order of (node, axis).
    pub pinches: Vec<Pinch>,
    /// In the order of (node, axis).
    pub edges: Vec<CrossedEdge>,
}

impl Block {
    /// `None` where nothing crosses the leaf's cells.
    pub fn new(leaves: &Leaves, at: [i32; 3]) -> Option<Self> {
        let patch = Patch::gather(leaves, at)?;
        let mut block = Self {
            at,
            cells: Vec::new(),
            cell_at: vec![u16::MAX; LEAF_NODES],
            points: Vec::new(),
            pinches: Vec::new(),
            edges: Vec::new(),
        };
        for place in 0..LEAF_NODES {
            let node = [place / 64, place / 8 % 8, place % 8];
            let labels = corner_nodes(node).map(|corner| patch.label(corner));
            if labels.iter().any(|&label| label != labels[0]) {
                block.add(&patch, node, &labels);
            }
        }
        (!block.cells.is_empty()).then_some(block)
    }

    /// The cell with this first node.
    pub fn cell(&self, node: [usize; 3]) -> Option<&ActiveCell> {
        let index = self.cell_at[(node[0] * LEAF_SIDE + node[1]) * LEAF_SIDE + node[2]];
        self.cells.get(usize::from(index))
    }

    /// For every point the first node of its cell.
    pub fn lows_of_points(&self) -> impl Iterator<Item = DVec3> {
        self.cells.iter().flat_map(|cell| {
            let low = self.world(DVec3::from_array(cell.node.map(|at| at as f64)));
            std::iter::repeat_n(low, usize::from(cell.pieces.count))
        })
    }

    fn add(&mut self, patch: &Patch, node: [usize; 3], labels: &[Label; 8]) {
        let links = std::array::from_fn(|face| face_links(patch, node, labels, face));
        let pieces = Pieces::of(labels, &links);
        let crossings = edge_crossings(patch, node, &pieces);
        self.add_edges(node, labels);
        self.add_pinches(node, &pieces, &links, &crossings);
        let place = (node[0] * LEAF_SIDE + node[1]) * LEAF_SIDE + node[2];
        self.cell_at[place] = self.cells.len() as u16;
        let first = self.points.len() as u32;
        for piece in 0..pieces.count {
            self.points.push(self.world(piece_point(patch, node, &pieces, piece, &crossings)));
        }
        self.cells.push(ActiveCell { node, first, pieces, links });
    }

    /// The same in a leaf `by` farther on.
    pub fn moved(&self, by: [i32; 3]) -> Self {
        let step = LEAF_SIDE as f64 * IVec3::from_array(by).as_dvec3();
        let mut moved = self.clone();
        moved.at = leaf_after(self.at, by);
        let pinched = moved.pinches.iter_mut().flat_map(|pinch| &mut pinch.points);
        moved.points.iter_mut().chain(pinched).for_each(|point| *point += step);
        moved
    }

    /// From the leaf's coordinates to the lattice's.
    fn world(&self, local: DVec3) -> DVec3 {
        let [x, y, z] = self.at.map(|at| f64::from(at) * LEAF_SIDE as f64);
        local + DVec3::new(x, y, z)
    }

    /// The three edges that start at the cell's first node.
    fn add_edges(&mut self, node: [usize; 3], labels: &[Label; 8]) {
        for axis in 0..3 {
            let [low, high] = EDGE_CORNERS[4 * axis].map(|corner| labels[corner]);
            if low != high {
                self.edges.push(CrossedEdge { node, axis, labels: [low, high] });
            }
        }
    }

    fn add_pinches(
        &mut self,
        node: [usize; 3],
        pieces: &Pieces,
        links: &[Links; 6],
        crossings: &[DVec3; 12],
    ) {
        for axis in 0..3 {
            let edges = FACE_EDGES[2 * axis];
            if let Some(pairs) = links[2 * axis].pairs()
                && is_pinched(pieces, edges)
            {
                let points =
                    pairs.map(|pair| self.world(mean(pair.map(|edge| crossings[edges[edge]]))));
                self.pinches.push(Pinch { node, axis, points });
            }
        }
    }
}

/// Whether both pairs of a face's edges belong to one piece: e0 and e2 are
/// never in the same pair.
pub fn is_pinched(pieces: &Pieces, face_edges: [usize; 4]) -> bool {
    pieces.of_edge[face_edges[0]] == pieces.of_edge[face_edges[2]]
}

/// The corners of a cell from its first node.
pub fn corner_nodes(node: [usize; 3]) -> [[usize; 3]; 8] {
    std::array::from_fn(|corner| {
        [node[0] + corner / 4, node[1] + corner / 2 % 2, node[2] + corner % 2]
    })
}

/// The links in a face of a cell with these labels at its corners.
pub fn face_links(patch: &Patch, node: [usize; 3], labels: &[Label; 8], face: usize) -> Links {
    let corners = FACE_CORNERS[face];
    Links::of(corners.map(|corner| labels[corner]), || {
        // The lead of the even corners' label over the odd corners' has a
        // saddle in the face; its value there, by bilinear interpolation, has
        // the sign of f0 f2 − f1 f3, as f0 + f2 − f1 − f3 is not negative.
        let (even, odd) = (labels[corners[0]], labels[corners[1]]);
        let nodes = corner_nodes(node);
        let [f0, f1, f2, f3] = corners.map(|corner| patch.lead(nodes[corner], even, odd));
        f0 * f2 - f1 * f3 > 0.0
    })
}

/// The mean of a piece's crossings. In cells at a face of an open box the edges
/// that lead out of it do not count, as long as the piece has others: these
/// say where the surface leaves the box.
fn piece_point(
    patch: &Patch,
    node: [usize; 3],
    pieces: &Pieces,
    piece: u8,
    crossings: &[DVec3; 12],
) -> DVec3 {
    let nodes = corner_nodes(node);
    let own = || (0..12).filter(|&edge| pieces.of_edge[edge] == piece);
    let within = |edge: &usize| {
        let [low, high] = EDGE_CORNERS[*edge].map(|corner| nodes[corner]);
        !patch.leaves_box(low, high)
    };
    let points = |edge| crossings[edge];
    if own().any(|edge| within(&edge)) {
        mean(own().filter(within).map(points))
    } else {
        mean(own().map(points))
    }
}

/// The point where the interface crosses each edge between different labels,
/// in the leaf's lattice units.
fn edge_crossings(patch: &Patch, node: [usize; 3], pieces: &Pieces) -> [DVec3; 12] {
    let nodes = corner_nodes(node);
    std::array::from_fn(|edge| {
        if pieces.of_edge[edge] == Pieces::NONE {
            return DVec3::ZERO;
        }
        let [low, high] = EDGE_CORNERS[edge].map(|corner| nodes[corner]);
        let mut point = DVec3::from_array(low.map(|at| at as f64));
        point[edge / 4] += patch.crossing(low, high);
        point
    })
}

fn mean(points: impl IntoIterator<Item = DVec3>) -> DVec3 {
    let (sum, count) = points
        .into_iter()
        .fold((DVec3::ZERO, 0.0), |(sum, count), point| (sum + point, count + 1.0));
    sum / count
}
