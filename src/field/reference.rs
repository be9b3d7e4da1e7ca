//! The field in f64, straight from the equations: what the other backends are
//! measured against.

use glam::{DVec2, DVec3};

use super::{Field, Queries, bug, checked_clearance};
use crate::arrangement::{Arrangement, Cell};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Plane;

/// The scalar f64 backend.
pub struct Reference {
    cells: Vec<Boundary>,
    clearance: f64,
}

/// What x sees around it in a cell.
struct Boundary {
    labels: Vec<Label>,
    faces: Vec<Face>,
}

/// A face in its plane's frame, with its first vertex as the origin.
struct Face {
    plane: Plane,
    origin: DVec3,
    tangents: [DVec3; 2],
    edges: Vec<Edge>,
}

/// An edge, with indices into the cell's labels on its two sides.
struct Edge {
    start: DVec2,
    end: DVec2,
    left: usize,
    right: Option<usize>,
}

impl Reference {
    /// The field of an arrangement, with |γ| no less than `clearance` (world
    /// units).
    ///
    /// # Errors
    /// As [`field::new`](super::new).
    pub fn new(arrangement: &Arrangement, clearance: f64) -> Result<Self> {
        let clearance = checked_clearance(arrangement, clearance)?;
        let boundary = |cell| Boundary::new(arrangement, cell);
        let cells = arrangement.cells().iter().map(boundary).collect::<Result<_>>()?;
        Ok(Self { cells, clearance })
    }

    /// One value per label of the cell, in f64.
    pub fn indicator(&self, cell: u32, x: DVec3) -> Vec<f64> {
        let boundary = &self.cells[cell as usize];
        if boundary.labels.len() == 1 {
            return vec![1.0];
        }
        let weights = boundary.weights(x, self.clearance);
        let total: f64 = weights.iter().sum();
        weights.iter().map(|weight| (2.0 * weight - total) / total).collect()
    }
}

impl Field for Reference {
    fn labels(&self, cell: u32) -> &[Label] {
        &self.cells[cell as usize].labels
    }

    fn edges(&self, cell: u32) -> u64 {
        let boundary = &self.cells[cell as usize];
        if boundary.labels.len() == 1 {
            return 0;
        }
        boundary.faces.iter().map(|face| face.edges.len() as u64).sum()
    }

    fn name(&self) -> String {
        "reference (f64, scalar)".to_owned()
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        queries.check(self.cells.len())?;
        let mut values = Vec::new();
        for run in &queries.runs {
            for &x in &queries.points[run.points.clone()] {
                values.extend(self.indicator(run.cell, x).iter().map(|&f| f as f32));
            }
        }
        Ok(values)
    }
}

impl Boundary {
    fn new(arrangement: &Arrangement, cell: &Cell) -> Result<Self> {
        let faces = cell
            .faces
            .iter()
            .map(|&face| Face::new(arrangement, face, &cell.labels))
            .collect::<Result<_>>()?;
        Ok(Self { labels: cell.labels.clone(), faces })
    }

    /// W_l for every label l.
    fn weights(&self, x: DVec3, clearance: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.labels.len()];
        for face in &self.faces {
            let gamma = face.plane.distance(x).abs().max(clearance);
            let foot = face.flatten(x);
            for edge in &face.edges {
                let share = edge_sum(edge.start - foot, edge.end - foot, gamma) / (2.0 * gamma);
                weights[edge.left] += share;
                if let Some(right) = edge.right {
                    weights[right] -= share;
                }
            }
        }
        weights
    }
}

impl Face {
    fn new(arrangement: &Arrangement, index: u32, labels: &[Label]) -> Result<Self> {
        let source = &arrangement.faces()[index as usize];
        let plane = arrangement.planes()[source.plane as usize];
        let origin = source.edges.first().map_or(DVec3::ZERO, |edge| edge.start);
        let mut face = Self { plane, origin, tangents: plane.tangents(), edges: Vec::new() };
        for edge in &source.edges {
            let edge = Edge {
                start: face.flatten(edge.start),
                end: face.flatten(edge.end),
                left: slot(labels, edge.left)?,
                right: edge.right.map(|label| slot(labels, label)).transpose()?,
            };
            face.edges.push(edge);
        }
        Ok(face)
    }

    /// A point's foot in the face's frame.
    fn flatten(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(self.tangents[0].dot(offset), self.tangents[1].dot(offset))
    }
}

/// Where a label stands among a cell's.
pub(super) fn slot(labels: &[Label], label: Label) -> Result<usize> {
    labels
        .binary_search(&label)
        .map_err(|_| bug(format!("label {label} is on a cell's face but not among its labels")))
}

/// θ · cross(p, q) / c.
fn edge_sum(p: DVec2, q: DVec2, gamma: f64) -> f64 {
    let d = q - p;
    let cross = p.perp_dot(d);
    let c = (cross * cross + gamma * gamma * d.length_squared()).sqrt();
    if c == 0.0 {
        return 0.0; // an edge without length
    }
    c.atan2(p.dot(q) + gamma * gamma) * cross / c
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::fixture::Random;

    /// Nodes and weights of Gauss–Legendre quadrature on [0, 1], by Newton's
    /// method on the Legendre polynomial.
    fn gauss(count: usize) -> Vec<(f64, f64)> {
        (0..count)
            .map(|i| {
                let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
                let mut slope = 1.0;
                for _ in 0..50 {
                    let (mut last, mut value) = (1.0, x);
                    for n in 2..=count {
                        let n = n as f64;
                        (last, value) =
                            (value, ((2.0 * n - 1.0) * x * value - (n - 1.0) * last) / n);
                    }
                    slope = count as f64 * (x * value - last) / (x * x - 1.0);
                    x -= value / slope;
                }
                ((x + 1.0) / 2.0, 1.0 / ((1.0 - x * x) * slope * slope))
            })
            .collect()
    }

    /// ∬ γ / (‖y‖² + γ²)² dA over a triangle cut into 4^depth.
    fn integrate([a, b, c]: [DVec2; 3], gamma: f64, depth: u32, rule: &[(f64, f64)]) -> f64 {
        if depth > 0 {
            let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            return quarters.iter().map(|&t| integrate(t, gamma, depth - 1, rule)).sum();
        }
        let doubled_area = (b - a).perp_dot(c - a);
        let mut sum = 0.0;
        for &(s, weight_s) in rule {
            for &(t, weight_t) in rule {
                // The unit square onto the triangle; the Jacobian is s.
                let y = a + s * (b - a) + s * t * (c - b);
                sum +=
                    weight_s * weight_t * s * gamma / (y.length_squared() + gamma * gamma).powi(2);
            }
        }
        sum * doubled_area
    }

    /// A star about `centre`, not convex, counter-clockwise.
    fn star(centre: DVec2, random: &mut Random) -> Vec<DVec2> {
        (0..9)
            .map(|i| std::f64::consts::TAU * f64::from(i) / 9.0)
            .map(|angle| centre + (0.3 + random.unit()) * DVec2::from_angle(angle))
            .collect()
    }

    fn sides(corners: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
        corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
    }

    /// The closed form is the integral.
    #[test]
    fn closed_form_is_the_integral() {
        let rule = gauss(16);
        let mut random = Random(20);
        for centre in [DVec2::ZERO, DVec2::new(0.7, -0.2), DVec2::new(-3.0, 1.0)] {
            for gamma in [0.2, 0.5, 2.0] {
                let star = star(centre, &mut random);
                let closed: f64 =
                    sides(&star).map(|(p, q)| edge_sum(p, q, gamma) / (2.0 * gamma)).sum();
                let integral: f64 =
                    sides(&star).map(|(p, q)| integrate([centre, p, q], gamma, 3, &rule)).sum();
                let error = (closed - integral).abs() / integral;
                assert!(error < 1e-9, "centre {centre}, γ {gamma}: {error:e}");
            }
        }
    }

    /// A plane seen from above is a hemisphere: ∬ γ / r⁴ dA = π / γ.
    #[test]
    fn a_whole_plane_weighs_pi_over_gamma() {
        let gamma = 0.25;
        let square = [(-1e7, -1e7), (1e7, -1e7), (1e7, 1e7), (-1e7, 1e7)].map(DVec2::from);
        let found: f64 = sides(&square).map(|(p, q)| edge_sum(p, q, gamma) / (2.0 * gamma)).sum();
        assert!((found * gamma / std::f64::consts::PI - 1.0).abs() < 1e-12);
    }

    /// An edge turned round changes its sign, and one without length is none.
    #[test]
    fn edges_are_directed() {
        let (p, q) = (DVec2::new(0.3, 0.1), DVec2::new(-0.5, 0.8));
        assert!((edge_sum(p, q, 0.1) + edge_sum(q, p, 0.1)).abs() < 1e-15);
        assert_eq!(edge_sum(p, p, 0.1), 0.0);
    }
}
