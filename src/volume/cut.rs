//! The cut of a volume of labels by a plane.
//!
//! Every voxel's label has a share of the points around its centre (trilinear
//! weights), and a point has the label with the largest share. So a border
//! between two labels runs between voxels, not along their faces. The plane is
//! sampled on a lattice of equilateral triangles, half a voxel long:
//!
//! ```text
//!   row 1    3───────4───────5         two labels in a triangle: one segment
//!           ╱ ╲     ╱ ╲     ╱          three: three segments that meet inside
//!   row 0  0───────1───────2
//! ```
//!
//! On triangles, unlike squares, nothing is ambiguous, and contours close and
//! never cross: a triangle's segments lie within it and end where its
//! neighbours' do. What a triangle does not see is smaller than half a voxel.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::LabelVolume;
use crate::label::Label;
use crate::mesh::cut::Cut;
use crate::plane::{Bounds, Plane};
use crate::section::Edge;

/// A row has at most so many nodes, and there are at most so many rows;
/// voxels far thinner than their volume is large are sampled less finely.
const LARGEST: f64 = 16384.0;

/// The nodes are moved by this part of their distance, so that voxels'
/// centres and the middles between them, where shares are equal, are rarely
/// hit.
const SHIFT: DVec2 = DVec2::new(0.311, 0.173);

/// Crossings keep this part of an edge away from its ends, and junctions as
/// much from the sides of their triangle, so that no two points coincide.
const CLEARANCE: f64 = 0.01;

impl LabelVolume {
    /// Cuts the volume; far away the plane is outside.
    pub fn cut(&self, plane: &Plane) -> Cut {
        match Lattice::new(self, plane) {
            Some(lattice) => Tracer::new(self, lattice).trace(),
            None => Cut::default(),
        }
    }
}

/// Nodes on a plane. Odd rows are half a step ahead.
struct Lattice {
    /// Of node 0 in row 0, in the world.
    origin: DVec3,
    /// From node to node, and from row to row.
    steps: [DVec3; 2],
    /// Nodes in a row, and rows.
    size: [usize; 2],
}

impl Lattice {
    /// Nodes over the part of a plane on which not all is outside, and around
    /// it; `None` when there is none.
    fn new(volume: &LabelVolume, plane: &Plane) -> Option<Self> {
        // Beyond the centres of the next voxels all shares are outside's.
        let corners = volume.corners(1.0)?;
        let [u, v] = plane.tangents();
        let polygon = crossings(&corners, plane);
        let base = *polygon.first()?;
        let flat = polygon.iter().map(|&point| point - base);
        let bounds = Bounds::around(flat.map(|at| DVec3::new(u.dot(at), v.dot(at), 0.0)))?;
        let side = (volume.spacing() / 2.0).max(bounds.size().max_element() / LARGEST);
        let steps = [u * side, v * side * (0.75f64).sqrt()];
        // A triangle to spare on every side, for the shift and the odd rows.
        let first = bounds.min - 2.0 * side + side * SHIFT.extend(0.0);
        let count = |length: f64, step: DVec3| (length / step.length()).ceil() as usize + 5;
        let size = [count(bounds.size().x, steps[0]), count(bounds.size().y, steps[1])];
        Some(Self { origin: base + u * first.x + v * first.y, steps, size })
    }

    fn point(&self, [column, row]: [usize; 2]) -> DVec3 {
        let ahead = column as f64 + 0.5 * (row % 2) as f64;
        self.origin + self.steps[0] * ahead + self.steps[1] * row as f64
    }

    /// The triangles between a row and the next, counter-clockwise about the
    /// plane's normal.
    fn triangles(&self, row: usize) -> impl Iterator<Item = [[usize; 2]; 3]> {
        (0..self.size[0] - 1).flat_map(move |column| {
            let [a, b] = [column, column + 1].map(|column| [column, row]);
            let [c, d] = [column, column + 1].map(|column| [column, row + 1]);
            if row.is_multiple_of(2) { [[a, b, c], [b, d, c]] } else { [[a, b, d], [a, d, c]] }
        })
    }
}

/// Where a plane meets the edges of a box.
fn crossings(corners: &[DVec3; 8], plane: &Plane) -> Vec<DVec3> {
    let above = corners.map(|corner| plane.distance(corner));
    let edges = (0..8).flat_map(|corner| (0..3).map(move |axis| (corner, corner | 1 << axis)));
    edges
        .filter(|&(from, to)| from != to && (above[from] >= 0.0) != (above[to] >= 0.0))
        .map(|(from, to)| corners[from].lerp(corners[to], above[from] / (above[from] - above[to])))
        .collect()
}

/// A node with its label.
#[derive(Clone, Copy)]
struct Node {
    at: [usize; 2],
    label: u32,
}

/// Contours in the making.
struct Tracer<'a> {
    volume: &'a LabelVolume,
    lattice: Lattice,
    /// The crossing between two nodes, the one that comes first named first.
    crossings: HashMap<[[usize; 2]; 2], u32>,
    cut: Cut,
}

impl<'a> Tracer<'a> {
    fn new(volume: &'a LabelVolume, lattice: Lattice) -> Self {
        Self { volume, lattice, crossings: HashMap::new(), cut: Cut::default() }
    }

    fn trace(mut self) -> Cut {
        let mut labels = self.row(0);
        for row in 0..self.lattice.size[1] - 1 {
            let next = self.row(row + 1);
            let node = |at: [usize; 2]| {
                let label = if at[1] == row { labels[at[0]] } else { next[at[0]] };
                Node { at, label }
            };
            let triangles: Vec<[Node; 3]> = (self.lattice.triangles(row))
                .map(|nodes| nodes.map(node))
                .filter(|[a, b, c]| a.label != b.label || b.label != c.label)
                .collect();
            triangles.into_iter().for_each(|nodes| self.triangle(nodes));
            labels = next;
        }
        self.cut
    }

    fn row(&self, row: usize) -> Vec<u32> {
        (0..self.lattice.size[0])
            .map(|column| self.volume.winner(self.indices([column, row])))
            .collect()
    }

    /// A node in voxels.
    fn indices(&self, at: [usize; 2]) -> DVec3 {
        self.volume.inverse * (self.lattice.point(at) - self.volume.placement.origin)
    }

    fn triangle(&mut self, nodes: [Node; 3]) {
        let alone = (0..3).find(|&i| nodes[(i + 1) % 3].label == nodes[(i + 2) % 3].label);
        if let Some(i) = alone {
            let [own, next, last] = [nodes[i], nodes[(i + 1) % 3], nodes[(i + 2) % 3]];
            let [start, end] = [self.crossing(own, next), self.crossing(last, own)];
            self.edge([start, end], [own, next]);
            return;
        }
        let junction = self.junction(nodes);
        for i in 0..3 {
            let sides = [nodes[i], nodes[(i + 1) % 3]];
            let start = self.crossing(sides[0], sides[1]);
            self.edge([start, junction], sides);
        }
    }

    fn edge(&mut self, [start, end]: [u32; 2], [left, right]: [Node; 2]) {
        let [left, right] = [left, right].map(|node| Label(node.label));
        self.cut.edges.push(Edge { start, end, left, right });
    }

    /// Where the shares of the two nodes' labels are equal between them.
    fn crossing(&mut self, one: Node, other: Node) -> u32 {
        let [from, to] = if [one.at[1], one.at[0]] < [other.at[1], other.at[0]] {
            [one, other]
        } else {
            [other, one]
        };
        if let Some(&known) = self.crossings.get(&[from.at, to.at]) {
            return known;
        }
        let lead = |node: Node| {
            let at = self.indices(node.at);
            self.volume.share(at, from.label) - self.volume.share(at, to.label)
        };
        let [before, after] = [lead(from), lead(to)];
        let part = if before > after { before / (before - after) } else { 0.5 };
        let part = part.clamp(CLEARANCE, 1.0 - CLEARANCE);
        let [start, end] = [from, to].map(|node| self.lattice.point(node.at));
        let number = self.add(start.lerp(end, part));
        self.crossings.insert([from.at, to.at], number);
        number
    }

    /// Where the shares of three labels, taken as linear on the triangle, are
    /// equal; in its middle if that is not inside.
    fn junction(&mut self, nodes: [Node; 3]) -> u32 {
        let at = nodes.map(|node| self.indices(node.at));
        let shares = nodes.map(|own| DVec3::from(at.map(|at| self.volume.share(at, own.label))));
        // Barycentric weights w with w·(s₀ − s₁) = w·(s₀ − s₂) = 0.
        let weights = (shares[0] - shares[1]).cross(shares[0] - shares[2]);
        let weights = weights / weights.element_sum();
        let inside = weights.is_finite() && weights.min_element() > CLEARANCE;
        let weights = if inside { weights } else { DVec3::splat(1.0 / 3.0) };
        let [a, b, c] = nodes.map(|node| self.lattice.point(node.at));
        self.add(a * weights.x + b * weights.y + c * weights.z)
    }

    fn add(&mut self, point: DVec3) -> u32 {
        self.cut.points.push(point);
        self.cut.points.len() as u32 - 1
    }
}
