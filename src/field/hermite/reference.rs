//! The field in f64, straight from the equations: what the backends are measured against.

use std::collections::BTreeMap;

use glam::DVec3;

use super::Options;
use super::nodes::{Node, Nodes};
use crate::error::Result;
use crate::field::places::{key, step};
use crate::field::{Boundaries, Field, Queries};
use crate::grid::samples::Values;
use crate::label::Label;

/// The scalar f64 backend.
pub struct Reference {
    cells: Vec<Cell>,
    is_single: bool,
    unit: f64,
}

/// A closed surface of triangles, and what is said at its corners.
struct Cell {
    labels: Vec<Label>,
    points: Vec<DVec3>,
    /// Seen from inside they turn one way all.
    triangles: Vec<[u32; 3]>,
    /// For every point a node for every label.
    nodes: Vec<Node>,
    /// How much every point counts.
    densities: Vec<f64>,
    clearance: f64,
}

impl Reference {
    /// The field inside some boundaries, with what is said at nodes.
    pub fn new(boundaries: &Boundaries, nodes: &Nodes, options: &Options, unit: f64) -> Self {
        let cell = |cell| Cell::new(boundaries, nodes, cell, options.density);
        let cells = (0..boundaries.count() as u32).map(cell).collect();
        Self { cells, is_single: boundaries.materials().len() == 1, unit }
    }
}

impl Field for Reference {
    fn labels(&self, cell: u32) -> &[Label] {
        &self.cells[cell as usize].labels
    }

    fn edges(&self, cell: u32) -> u64 {
        3 * self.cells[cell as usize].triangles.len() as u64
    }

    fn name(&self) -> String {
        "reference (f64, scalar)".to_owned()
    }

    fn values(&self) -> Values {
        Values::Distances
    }

    fn is_single(&self) -> bool {
        self.is_single
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        queries.check(self.cells.len())?;
        let mut values = Vec::new();
        for run in &queries.runs {
            for &x in &queries.points[run.points.clone()] {
                let own = self.cells[run.cell as usize].values(x);
                values.extend(own.into_iter().map(|value| (value / self.unit) as f32));
            }
        }
        Ok(values)
    }
}

impl Cell {
    fn new(boundaries: &Boundaries, all: &Nodes, cell: u32, density: bool) -> Self {
        let complex = boundaries.complex();
        let labels = boundaries.labels(cell).to_vec();
        let (points, triangles, nodes, densities) = Default::default();
        let clearance = boundaries.clearance();
        let mut own = Self { labels, points, triangles, nodes, densities, clearance };
        let mut places: BTreeMap<[u64; 3], Vec<u32>> = BTreeMap::new();
        let (step, alike) = (step(complex.bounds()), 1e-6 * complex.bounds().diagonal());
        for &facet in complex.cells().get(cell).map_or(&[][..], |cell| &cell.facets) {
            let said = all.on(facet);
            let mut numbers = Vec::new();
            for (point, &at) in said.mesh.points.iter().enumerate() {
                let here: Vec<Node> =
                    own.labels.iter().map(|&label| said.at(point, label)).collect();
                let same = |&&number: &&u32| {
                    let known = &own.nodes[number as usize * here.len()..][..here.len()];
                    known.iter().zip(&here).all(|(a, b)| (a.value - b.value).abs() <= alike)
                };
                let known = places.entry(key(at, step)).or_default();
                numbers.push(match known.iter().find(same) {
                    Some(&number) => number,
                    None => {
                        known.push(own.points.len() as u32);
                        own.points.push(at);
                        own.nodes.extend(here);
                        own.points.len() as u32 - 1
                    }
                });
            }
            // Facets' triangles turn about their planes' normals.
            let is_front = complex.facets()[facet].cells[0] == Some(cell);
            own.triangles.extend(said.mesh.triangles.iter().map(|corners| {
                let [a, b, c] = corners.map(|corner| numbers[corner as usize]);
                if is_front { [a, b, c] } else { [c, b, a] }
            }));
        }
        own.densities = vec![1.0; own.points.len()];
        if density {
            own.densities =
                areas(&own.points, &own.triangles).into_iter().map(|a| 1.0 / a).collect();
        }
        own
    }

    fn values(&self, x: DVec3) -> Vec<f64> {
        let coordinates = coordinates(&self.points, &self.triangles, x, self.clearance);
        let parts: Vec<f64> =
            coordinates.iter().zip(&self.densities).map(|(&t, d)| d * lifted(t)).collect();
        let total: f64 = parts.iter().sum();
        let count = self.labels.len();
        let value = |slot: usize| {
            let tangents = self.points.iter().enumerate().map(|(point, at)| {
                let Node { value, gradient } = self.nodes[point * count + slot];
                parts[point] * (value + gradient.dot(x - at))
            });
            tangents.sum::<f64>() / total
        };
        (0..count).map(value).collect()
    }
}

/// g(t) = 3 t² − 2 t³.
fn lifted(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

/// A third of the area of the triangles around each point.
fn areas(points: &[DVec3], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut areas = vec![0.0; points.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let area = 0.5 * (b - a).cross(c - a).length();
        corners.iter().for_each(|&corner| areas[corner as usize] += area / 3.0);
    }
    areas
}

/// The mean-value coordinates of x inside a closed surface of triangles (Ju et al. 2005): for
/// each triangle m · n_i / (n_i · (v_i − x)), with n_i the normal of the plane through x and the
/// other two corners, θ_i the angle between these, and m = Σ θ_i n_i / 2. Nearer to a triangle's
/// plane than the clearance counts as that far.
fn coordinates(points: &[DVec3], triangles: &[[u32; 3]], x: DVec3, clearance: f64) -> Vec<f64> {
    let mut weights = vec![0.0; points.len()];
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let normal = (b - a).cross(c - a).normalize();
        let height = (a - x).dot(normal).abs().max(clearance);
        let foot = x + normal * (a - x).dot(normal);
        let around = [a, b, c].map(|corner| corner - foot - height * normal);
        let mut mean = DVec3::ZERO;
        let normals: [DVec3; 3] = std::array::from_fn(|i| {
            let (next, last) = (around[(i + 1) % 3], around[(i + 2) % 3]);
            let cross = next.cross(last);
            mean += 0.5 * cross.length().atan2(next.dot(last)) * cross.normalize_or_zero();
            cross.normalize_or_zero()
        });
        for i in 0..3 {
            let height = normals[i].dot(around[i]);
            if height != 0.0 {
                weights[corners[i] as usize] += mean.dot(normals[i]) / height;
            }
        }
    }
    let total: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / total).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f = x² + 2 y² − z² + x y + 0.3 z with its gradient.
    fn quadratic(p: DVec3) -> Node {
        let value = p.x * p.x + 2.0 * p.y * p.y - p.z * p.z + p.x * p.y + 0.3 * p.z;
        let gradient = DVec3::new(2.0 * p.x + p.y, 4.0 * p.y + p.x, 0.3 - 2.0 * p.z);
        Node { value, gradient }
    }

    /// The cube [−1, 1]³, every face in k × k squares, these cut by the diagonal that on whole
    /// faces passes through (−1, −1, −1) or (1, 1, 1).
    fn cube(k: u32, node: impl Fn(DVec3) -> Node) -> Cell {
        let (mut points, mut triangles) = (Vec::<DVec3>::new(), Vec::new());
        let mut number = |at: DVec3| {
            let known = points.iter().position(|&known| known.distance(at) < 1e-12);
            known.unwrap_or_else(|| {
                points.push(at);
                points.len() - 1
            }) as u32
        };
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let at = |u: u32, v: u32| {
                    let mut at = DVec3::ZERO;
                    at[axis] = side;
                    let along = |step: u32| 2.0 * f64::from(step) / f64::from(k) - 1.0;
                    (at[(axis + 1) % 3], at[(axis + 2) % 3]) = (along(u), along(v));
                    at
                };
                for (u, v) in (0..k).flat_map(|u| (0..k).map(move |v| (u, v))) {
                    let [a, b] = [number(at(u, v)), number(at(u + 1, v))];
                    let [c, d] = [number(at(u + 1, v + 1)), number(at(u, v + 1))];
                    let both = [[a, b, c], [a, c, d]];
                    let turned = both.map(|[a, b, c]| [c, b, a]);
                    triangles.extend(if side < 0.0 { both } else { turned });
                }
            }
        }
        let nodes = points.iter().map(|&at| node(at)).collect();
        let densities = vec![1.0; points.len()];
        let labels = vec![Label(1)];
        Cell { labels, points, triangles, nodes, densities, clearance: 1e-12 }
    }

    fn at([x, y, z]: [f64; 3]) -> DVec3 {
        DVec3::new(x, y, z)
    }

    #[test]
    fn on_a_cube_values_are_those_of_the_specification() {
        let cube = cube(1, quadratic);
        for (x, mean, hermite) in [
            ([0.0, 0.0, 0.0], 2.149283447980, -2.303305169426),
            ([0.3, -0.2, 0.5], 2.294170604758, -2.549455287536),
            ([0.9, 0.1, -0.4], 2.002304575522, -0.630336722123),
            ([-0.5, 0.5, -0.5], 1.682491782227, -1.051965937267),
        ] {
            let x = at(x);
            let coordinates = coordinates(&cube.points, &cube.triangles, x, 0.0);
            let plain: f64 = coordinates.iter().zip(&cube.nodes).map(|(l, n)| l * n.value).sum();
            assert!((plain - mean).abs() < 1e-10, "{plain} {mean}");
            let found = cube.values(x)[0];
            assert!((found - hermite).abs() < 1e-10, "{found} {hermite}");
        }
        // On a face its own triangle alone counts.
        let found = cube.values(at([1.0, 0.2, 0.3]))[0];
        assert!((found - 0.357342583).abs() < 1e-8, "{found}");
        for (point, share) in
            cube.points.iter().zip(coordinates(&cube.points, &cube.triangles, DVec3::ZERO, 0.0))
        {
            let is_end = point.x == point.y && point.y == point.z;
            let expected = if is_end { 0.180981292993 } else { 0.106339569002 };
            assert!((share - expected).abs() < 1e-11, "{point} {share}");
        }
    }

    #[test]
    fn finer_triangles_come_nearer() {
        let x = at([0.3, -0.2, 0.5]);
        for (k, expected) in
            [(1, -2.549455), (2, -0.666188), (4, -0.363344), (8, -0.249773), (16, -0.222802)]
        {
            let found = cube(k, quadratic).values(x)[0];
            assert!((found - expected).abs() < 1e-6, "{k}: {found} {expected}");
        }
    }

    #[test]
    fn what_is_linear_stays_as_it_is() {
        let slope = DVec3::new(0.3, -1.7, 0.9);
        let linear = |at: DVec3| Node { value: 0.2 + slope.dot(at), gradient: slope };
        let cube = cube(3, linear);
        for x in [[0.1, 0.2, -0.3], [0.99, -0.5, 0.7], [1.0, 0.1, 0.1], [1.0, 1.0, 1.0]] {
            let (found, expected) = (cube.values(at(x))[0], linear(at(x)).value);
            assert!((found - expected).abs() < 1e-14, "{x:?}: {found} {expected}");
        }
    }

    /// How much the slope across the wall between two boxes changes there, cut into k × k: the
    /// largest of some places, by differences.
    fn jump(k: u32) -> f64 {
        let value = |at: DVec3| {
            let value = (1.3 * at.x).sin() + at.x * at.y - (0.7 * at.z).cos() * at.y;
            let gradient = DVec3::new(
                1.3 * (1.3 * at.x).cos() + at.y,
                at.x - (0.7 * at.z).cos(),
                0.7 * (0.7 * at.z).sin() * at.y,
            );
            Node { value, gradient }
        };
        let move_by = |by: f64| move |at: DVec3| value(at + by * DVec3::X);
        let [left, right] = [cube(k, move_by(-1.0)), cube(k, move_by(1.0))];
        let h = 1e-5;
        let place = |u: f64, v: f64| {
            let on = |side: f64| DVec3::new(side, u, v);
            let inward = |cell: &Cell, side: f64| {
                let step = side * h * DVec3::X;
                (cell.values(on(side) - 2.0 * step)[0] - cell.values(on(side) - step)[0]) / -h
            };
            (inward(&left, 1.0) + inward(&right, -1.0)).abs()
        };
        [(0.11, 0.23), (-0.37, 0.61), (0.53, -0.43)]
            .into_iter()
            .map(|(u, v)| place(u, v))
            .fold(0.0, f64::max)
    }

    #[test]
    fn across_walls_slopes_agree_ever_better() {
        let jumps = [2, 4, 8].map(jump);
        assert!(
            jumps[0] < 0.2 && jumps[1] < 0.6 * jumps[0] && jumps[2] < 0.6 * jumps[1],
            "{jumps:?}"
        );
    }
}
