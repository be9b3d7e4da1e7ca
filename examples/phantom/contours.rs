//! The borders of labels on a plane: marching triangles.
//!
//! A lattice of triangles is laid over the plane. A triangle with two labels
//! is crossed by one piece of border, one with three holds a junction:
//!
//! ```text
//!       a               a
//!      / \             / \
//!     P---Q           P   Q
//!    /     \         /  J  \        J is joined to P, Q and R
//!   b-------b       b---R---c
//! ```
//!
//! Every crossing lies on a lattice edge and is found once by bisection, so
//! pieces meet exactly and never cross.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use transect::label::Label;
use transect::plane::Plane;

/// The lattice's spacing, in mm.
const SPACING: f64 = 2.0;
/// Lattice edges from the middle to a border, beyond which all is outside.
const REACH: i32 = 84;
/// Halvings of a lattice edge: to 2⁻³⁰ of it.
const HALVINGS: u32 = 30;

/// Borders between labels.
#[derive(Debug, Default)]
pub struct Borders {
    /// On the plane.
    pub points: Vec<DVec3>,
    /// Pieces from start to end with the larger label on their left and the
    /// smaller one on their right, about the normal.
    pub pieces: Vec<Piece>,
}

/// A piece of border.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// Index of a point.
    pub start: u32,
    /// Index of a point.
    pub end: u32,
    /// The larger label.
    pub left: Label,
    /// The smaller label.
    pub right: Label,
}

/// A node of the lattice.
type Node = (i32, i32);

/// Finds the borders between the labels on a plane.
pub fn borders(plane: &Plane, label_at: &dyn Fn(DVec3) -> Label) -> Borders {
    let mut march = March::new(plane, label_at);
    for i in -REACH..REACH {
        for j in -REACH..REACH {
            let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
            march.triangle([a, b, c]);
            march.triangle([a, c, d]);
        }
    }
    march.borders
}

struct March<'a> {
    label_at: &'a dyn Fn(DVec3) -> Label,
    origin: DVec3,
    /// Unit vectors, counter-clockwise about the normal.
    axes: [DVec3; 2],
    labels: BTreeMap<Node, Label>,
    crossings: BTreeMap<(Node, Node), u32>,
    borders: Borders,
}

impl<'a> March<'a> {
    fn new(plane: &Plane, label_at: &'a dyn Fn(DVec3) -> Label) -> Self {
        let mut march = Self {
            label_at,
            origin: plane.normal * (plane.offset / plane.normal.length_squared()),
            axes: plane.tangents(),
            labels: BTreeMap::new(),
            crossings: BTreeMap::new(),
            borders: Borders::default(),
        };
        for node in (-REACH..=REACH).flat_map(|i| (-REACH..=REACH).map(move |j| (i, j))) {
            let label = label_at(march.space(position(node)));
            march.labels.insert(node, label);
        }
        march
    }

    fn space(&self, place: DVec2) -> DVec3 {
        self.origin + self.axes[0] * place.x + self.axes[1] * place.y
    }

    /// Adds the borders within a counter-clockwise triangle.
    fn triangle(&mut self, nodes: [Node; 3]) {
        let labels = nodes.map(|node| self.labels[&node]);
        let differs = |i: usize| labels[i] != labels[(i + 1) % 3];
        match (0..3).filter(|&i| differs(i)).count() {
            0 => {}
            2 => {
                // The corner whose label occurs once: both its edges differ.
                let lone = (0..3).find(|&i| differs(i) && differs((i + 2) % 3)).unwrap_or(0);
                let [next, last] = [(lone + 1) % 3, (lone + 2) % 3];
                let start = self.crossing(nodes[lone], nodes[next]);
                let end = self.crossing(nodes[lone], nodes[last]);
                self.add(start, end, labels[lone], labels[next]);
            }
            _ => {
                let junction = self.junction(nodes.map(position), labels);
                for i in 0..3 {
                    let next = (i + 1) % 3;
                    let end = self.crossing(nodes[i], nodes[next]);
                    self.add(junction, end, labels[next], labels[i]);
                }
            }
        }
    }

    fn add(&mut self, start: u32, end: u32, left: Label, right: Label) {
        self.borders.pieces.push(if left > right {
            Piece { start, end, left, right }
        } else {
            Piece { start: end, end: start, left: right, right: left }
        });
    }

    /// Where the label changes between two nodes.
    fn crossing(&mut self, one: Node, other: Node) -> u32 {
        let key = (one.min(other), one.max(other));
        if let Some(&known) = self.crossings.get(&key) {
            return known;
        }
        let (mut near, mut far) = (position(key.0), position(key.1));
        for _ in 0..HALVINGS {
            let middle = (near + far) / 2.0;
            if (self.label_at)(self.space(middle)) == self.labels[&key.0] {
                near = middle;
            } else {
                far = middle;
            }
        }
        let point = self.point((near + far) / 2.0);
        self.crossings.insert(key, point);
        point
    }

    /// Where three labels meet: of the four triangles that a triangle with
    /// three labels is split into, one has three again (Sperner's lemma), as
    /// long as its sides have no others.
    fn junction(&mut self, mut corners: [DVec2; 3], mut labels: [Label; 3]) -> u32 {
        for _ in 0..HALVINGS {
            let middles = [0, 1, 2].map(|i| (corners[i] + corners[(i + 1) % 3]) / 2.0);
            let between = middles.map(|middle| (self.label_at)(self.space(middle)));
            let [a, b, c] = [0, 1, 2].map(|i| (corners[i], labels[i]));
            let [ab, bc, ca] = [0, 1, 2].map(|i| (middles[i], between[i]));
            let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            let Some(part) = parts.iter().find(|part| has_three(part.map(|corner| corner.1)))
            else {
                break;
            };
            corners = part.map(|corner| corner.0);
            labels = part.map(|corner| corner.1);
        }
        let [a, b, c] = corners;
        self.point((a + b + c) / 3.0)
    }

    fn point(&mut self, place: DVec2) -> u32 {
        let point = self.space(place);
        self.borders.points.push(point);
        self.borders.points.len() as u32 - 1
    }
}

fn has_three([a, b, c]: [Label; 3]) -> bool {
    a != b && b != c && c != a
}

fn position((i, j): Node) -> DVec2 {
    DVec2::new(f64::from(i), f64::from(j)) * SPACING
}
