//! The field in f64, straight from the equations: what the other backends are
//! measured against.

use glam::{DVec2, DVec3};

use super::boundaries::{self, Boundaries};
use super::ramps::NEEDLE;
use super::{Field, Queries, bug};
use crate::complex::Facet;
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
    triangles: Vec<Triangle>,
}

/// An edge, with indices into the cell's labels on its two sides; `None` where
/// there is nothing known.
struct Edge {
    start: DVec2,
    end: DVec2,
    left: Option<usize>,
    right: Option<usize>,
}

/// A piece of an unknown region: its corners, counter-clockwise, and there the
/// shares of the cell's labels.
struct Triangle {
    corners: [DVec2; 3],
    shares: [Vec<f64>; 3],
}

impl Reference {
    /// The field inside some boundaries.
    ///
    /// # Errors
    /// As [`field::new`](super::new).
    pub fn new(boundaries: &Boundaries) -> Result<Self> {
        let boundary = |cell| Boundary::new(&boundaries.boundary(cell));
        let cells = (0..boundaries.count()).map(boundary).collect::<Result<_>>()?;
        Ok(Self { cells, clearance: boundaries.clearance() })
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
        let edges = |face: &Face| face.edges.len() + 3 * face.triangles.len();
        boundary.faces.iter().map(edges).sum::<usize>() as u64
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
    fn new(source: &boundaries::Boundary) -> Result<Self> {
        let faces = source.facets().map(|(index, face)| Face::new(source, index, face));
        Ok(Self { labels: source.labels.to_vec(), faces: faces.collect::<Result<_>>()? })
    }

    /// W_l for every label l.
    fn weights(&self, x: DVec3, clearance: f64) -> Vec<f64> {
        let mut weights = vec![0.0; self.labels.len()];
        for face in &self.faces {
            let gamma = face.plane.distance(x).abs().max(clearance);
            let foot = face.flatten(x);
            for edge in &face.edges {
                let share = edge_sum(edge.start - foot, edge.end - foot, gamma) / (2.0 * gamma);
                for (label, share) in [(edge.left, share), (edge.right, -share)] {
                    if let Some(label) = label {
                        weights[label] += share;
                    }
                }
            }
            for triangle in &face.triangles {
                triangle.add_weights(foot, gamma, &mut weights);
            }
        }
        weights
    }
}

impl Face {
    fn new(boundary: &boundaries::Boundary, index: u32, source: &Facet) -> Result<Self> {
        let plane = boundary.complex.planes()[source.plane];
        let origin = source.edges.first().map_or(DVec3::ZERO, |edge| edge.start);
        let (edges, triangles) = (Vec::new(), Vec::new());
        let mut face = Self { plane, origin, tangents: plane.tangents(), edges, triangles };
        let known = |label: Option<Label>| match label.filter(|&label| label != Label::UNKNOWN) {
            Some(label) => slot(boundary.labels, label).map(Some),
            None => Ok(None),
        };
        for edge in &source.edges {
            let edge = Edge {
                start: face.flatten(edge.start),
                end: face.flatten(edge.end),
                left: known(Some(edge.left))?,
                right: known(edge.right)?,
            };
            face.edges.push(edge);
        }
        let slots = boundary.completion.slots(boundary.labels);
        for corners in boundary.triangles(index).filter(|corners| !is_needle(corners)) {
            let shares = corners.map(|(corner, _)| {
                slots.iter().map(|&slot| boundary.completion.share(corner, slot)).collect()
            });
            let corners = corners.map(|(_, point)| face.flatten(point));
            face.triangles.push(Triangle { corners, shares });
        }
        Ok(face)
    }

    /// A point's foot in the face's frame.
    fn flatten(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(self.tangents[0].dot(offset), self.tangents[1].dot(offset))
    }
}

impl Triangle {
    fn add_weights(&self, foot: DVec2, gamma: f64, weights: &mut [f64]) {
        let corners = self.corners.map(|corner| (corner - foot).extend(gamma));
        for (weight, shares) in corner_weights(corners).into_iter().zip(&self.shares) {
            for (sum, share) in weights.iter_mut().zip(shares) {
                *sum += weight * share;
            }
        }
    }
}

/// Whether a triangle is nothing but rounding.
fn is_needle(corners: &[(u32, DVec3); 3]) -> bool {
    let [a, b, c] = corners.map(|(_, point)| point);
    let sides = [b - a, c - b, a - c];
    let longest = sides.iter().map(|side| side.length_squared()).fold(0.0, f64::max);
    sides[0].cross(sides[1]).length() <= NEEDLE * longest
}

/// Ju et al.'s weights of the corners v_i of a triangle as seen from the origin
/// (Bermano, Appendix A): m·n_i / (n_i·v_i), with n_i the unit normal of the
/// plane through the origin and the other two corners, θ_i the angle between
/// these, and m = Σ θ_i n_i / 2. The corners are counter-clockwise in a plane
/// above the origin.
fn corner_weights(corners: [DVec3; 3]) -> [f64; 3] {
    let mut normals = [DVec3::ZERO; 3];
    let mut mean = DVec3::ZERO;
    for i in 0..3 {
        let (next, last) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
        let cross = next.cross(last);
        normals[i] = cross.normalize_or_zero();
        mean += 0.5 * cross.length().atan2(next.dot(last)) * normals[i];
    }
    std::array::from_fn(|i| {
        let height = normals[i].dot(corners[i]);
        if height == 0.0 { 0.0 } else { mean.dot(normals[i]) / height }
    })
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
    use crate::random::Random;

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
    fn integrate(corners: [DVec2; 3], gamma: f64, depth: u32, rule: &[(f64, f64)]) -> f64 {
        integrate_with(corners, gamma, depth, rule, &|_| 1.0)
    }

    /// The same with a density.
    fn integrate_with(
        [a, b, c]: [DVec2; 3],
        gamma: f64,
        depth: u32,
        rule: &[(f64, f64)],
        density: &dyn Fn(DVec2) -> f64,
    ) -> f64 {
        if depth > 0 {
            let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            let quarters = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
            let part = |&quarter| integrate_with(quarter, gamma, depth - 1, rule, density);
            return quarters.iter().map(part).sum();
        }
        let doubled_area = (b - a).perp_dot(c - a);
        let mut sum = 0.0;
        for &(s, weight_s) in rule {
            for &(t, weight_t) in rule {
                // The unit square onto the triangle; the Jacobian is s.
                let y = a + s * (b - a) + s * t * (c - b);
                let kernel = gamma / (y.length_squared() + gamma * gamma).powi(2);
                sum += weight_s * weight_t * s * kernel * density(y);
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
        let mut random = Random::new(20);
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

    /// Ju et al.'s weights are the integrals of the barycentric coordinates.
    #[test]
    fn corner_weights_are_integrals() {
        let rule = gauss(16);
        let corners = [(-0.3, 0.2), (1.1, -0.4), (0.6, 0.9)].map(DVec2::from);
        let gamma = 0.4;
        let doubled_area = (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]);
        let weights = corner_weights(corners.map(|corner| corner.extend(gamma)));
        for (i, found) in weights.into_iter().enumerate() {
            let share = |y: DVec2| {
                let [next, last] = [corners[(i + 1) % 3], corners[(i + 2) % 3]];
                (next - y).perp_dot(last - y) / doubled_area
            };
            let expected = integrate_with(corners, gamma, 3, &rule, &share);
            assert!((found / expected - 1.0).abs() < 1e-10, "{found} {expected}");
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
