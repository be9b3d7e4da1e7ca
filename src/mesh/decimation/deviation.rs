//! How far triangles are from a surface, with certainty.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::mesh::Mesh;
use crate::mesh::nearest::Nearest;

/// Times that a triangle is divided into four before it is taken to be too far.
const DIVISIONS: u32 = 6;

/// A triangle, or a part of it.
type Part = (u32, [DVec3; 3]);

/// The triangles of a mesh that come farther than `bound` from another one, or may.
///
/// The distance from a convex set is a convex function: a triangle is as near to another one as
/// the farthest of its corners. Where that does not suffice it is divided, until nothing is
/// doubtful or its edges are shorter than `dense`; then the distance of its middle counts.
///
/// # Errors
/// When CGAL fails.
pub fn beyond(
    mesh: &Mesh,
    (other, nearest): (&Mesh, &Nearest),
    bound: f64,
    dense: f64,
) -> Result<Vec<u32>> {
    let mut parts: Vec<Part> =
        (0..mesh.triangles.len()).map(|own| (own as u32, mesh.corners(own))).collect();
    let mut found = Vec::new();
    for division in 0..=DIVISIONS {
        let middles: Vec<DVec3> = parts.par_iter().map(|(_, corners)| middle(corners)).collect();
        let triangles = nearest.triangles(&middles)?;
        let judged: Vec<Verdict> = (parts.par_iter().zip(&middles).zip(triangles))
            .map(|((part, &middle), triangle)| {
                judge(part, middle, &other.corners(triangle as usize), bound, dense)
            })
            .collect();
        let is_last = division == DIVISIONS;
        let mut next = Vec::new();
        for ((own, corners), verdict) in parts.into_iter().zip(judged) {
            match verdict {
                Verdict::Near => {}
                Verdict::Doubtful if !is_last => next.extend(quarters(own, corners)),
                Verdict::Doubtful | Verdict::Far => found.push(own),
            }
        }
        parts = next;
    }
    found.sort_unstable();
    found.dedup();
    Ok(found)
}

#[derive(Clone, Copy)]
enum Verdict {
    Near,
    Far,
    Doubtful,
}

fn judge(part: &Part, middle: DVec3, nearest: &[DVec3; 3], bound: f64, dense: f64) -> Verdict {
    let corners = &part.1;
    if corners.iter().all(|&corner| distance(corner, nearest) <= bound) {
        return Verdict::Near;
    }
    let far = distance(middle, nearest);
    let reach = corners.iter().map(|corner| corner.distance(middle)).fold(0.0, f64::max);
    let [a, b, c] = *corners;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    match far <= bound {
        false => Verdict::Far,
        true if far + reach <= bound || longest < dense => Verdict::Near,
        true => Verdict::Doubtful,
    }
}

fn middle([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

fn quarters(own: u32, [a, b, c]: [DVec3; 3]) -> [Part; 4] {
    let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].map(|corners| (own, corners))
}

/// The distance from a point to a triangle.
fn distance(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let is_within = |from: DVec3, to: DVec3| normal.dot((to - from).cross(point - from)) >= 0.0;
    if normal != DVec3::ZERO && is_within(a, b) && is_within(b, c) && is_within(c, a) {
        return (point - a).dot(normal).abs() / normal.length();
    }
    let sides = [(a, b), (b, c), (c, a)];
    sides.map(|(from, to)| to_segment(point, from, to)).into_iter().fold(f64::INFINITY, f64::min)
}

/// The distance from a point to a line segment.
pub fn to_segment(point: DVec3, from: DVec3, to: DVec3) -> f64 {
    let (along, out) = (to - from, point - from);
    let length = along.length_squared();
    let part = if length > 0.0 { (out.dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (out - part * along).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_as_far_as_from_the_nearest_corner_edge_or_inside() {
        let triangle = [DVec3::ZERO, 2.0 * DVec3::X, 2.0 * DVec3::Y];
        let cases = [
            ([0.5, 0.5, -3.0], 3.0),
            ([1.0, -1.0, 0.0], 1.0),
            ([-3.0, -4.0, 0.0], 5.0),
            ([2.0, 2.0, 0.0], 2f64.sqrt()),
            ([5.0, 0.0, 4.0], 5.0),
        ];
        for (point, expected) in cases {
            assert!((distance(DVec3::from(point), &triangle) - expected).abs() < 1e-15);
        }
        // Without an area.
        let flat = [DVec3::ZERO, DVec3::X, 3.0 * DVec3::X];
        assert_eq!(distance(DVec3::new(2.0, 1.0, 0.0), &flat), 1.0);
    }
}
