//! The unknown regions of one plane: their triangulation, and what is known
//! around them.

use glam::{DVec2, DVec3};

use super::outline::Outlines;
use crate::complex::{Complex, FacetEdge};
use crate::error::{Error, Result};
use crate::ffi::triangulation::{self as ffi, Triangulation};
use crate::field::places::PlaneFrame;
use crate::label::Label;
use crate::sets::components;

/// How far the middle of a piece may lie off the line that it is a piece of,
/// relative to the size of the box: rounding only.
const ON_LINE: f64 = 1e-10;

/// The triangulated unknown regions of a plane.
#[derive(Debug, Default)]
pub(super) struct UnknownPlane {
    /// World units.
    pub points: Vec<DVec3>,
    /// A face of the complex, and three points on it, counter-clockwise
    /// about the plane's normal.
    pub triangles: Vec<(u32, [u32; 3])>,
    /// For each point its connected region.
    regions: Vec<u32>,
    /// Where known regions of the plane begin, unknown on the left.
    borders: Vec<Border>,
    /// The points in the plane's frame.
    flat: Vec<DVec2>,
}

/// An edge between an unknown region and a known one.
#[derive(Debug, Clone, Copy)]
struct Border {
    start: u32,
    end: u32,
    /// Beyond it.
    label: Label,
    /// The region on this side.
    region: u32,
}

/// The edge of a known region on its face's border, the region on the right,
/// in the plane's frame: beyond the line there may be an unknown one.
struct Known {
    start: DVec2,
    end: DVec2,
    label: Label,
}

/// Triangles, each with an edge that no other one has, on whose left it lies.
type Rim = Vec<(usize, [u32; 2])>;

impl UnknownPlane {
    /// Triangulates the unknown regions on some faces of a plane, with edges
    /// of about `spacing` (world units).
    pub fn new(complex: &Complex, faces: &[u32], spacing: f64) -> Result<Self> {
        let outlines = Outlines::new(complex, faces, spacing);
        if outlines.points.is_empty() {
            return Ok(Self::default());
        }
        let plane = complex.planes()[complex.facets()[faces[0]].plane];
        let frame = PlaneFrame::new(plane, complex.bounds());
        let flat: Vec<f64> =
            outlines.points.iter().flat_map(|&point| frame.flatten(point).to_array()).collect();
        let segments = outlines.segments.as_flattened();
        let made = ffi::triangulate(&flat, segments, &outlines.faces, spacing)
            .map_err(|exception| Error::library("completion", &exception))?;
        let known = faces
            .iter()
            .flat_map(|&index| complex.facets()[index].edges.iter())
            .filter_map(|edge| Known::beside(edge, &frame))
            .collect::<Vec<_>>();
        let reach = ON_LINE * complex.bounds().diagonal();
        Ok(Self::assemble(&outlines, &frame, &made, &known, reach))
    }

    fn assemble(
        outlines: &Outlines,
        frame: &PlaneFrame,
        made: &Triangulation,
        known: &[Known],
        reach: f64,
    ) -> Self {
        let flat: Vec<DVec2> = made.points.chunks_exact(2).map(DVec2::from_slice).collect();
        let given = |(&input, flat): (&u32, &DVec2)| {
            let point = outlines.points.get(input as usize);
            point.copied().unwrap_or_else(|| frame.lift(*flat))
        };
        let points = made.inputs.iter().zip(&flat).map(given).collect();
        let corners = made.triangles.chunks_exact(3).map(|three| [three[0], three[1], three[2]]);
        let triangles: Vec<(u32, [u32; 3])> = made.regions.iter().copied().zip(corners).collect();
        let (parts, rim) = connected(&triangles);
        let mut regions = vec![0; flat.len()];
        for ((_, corners), &part) in triangles.iter().zip(&parts) {
            corners.iter().for_each(|&corner| regions[corner as usize] = part);
        }
        let border = |&(triangle, [start, end]): &(usize, [u32; 2])| {
            let segment = [start, end].map(|point| made.inputs[point as usize]);
            let own = outlines.labels.get(&segment).copied();
            let [p, q] = [start, end].map(|point| flat[point as usize]);
            let label = own.or_else(|| beyond(known, p.midpoint(q), q - p, reach))?;
            Some(Border { start, end, label, region: parts[triangle] })
        };
        let borders = rim.iter().filter_map(border).collect();
        Self { points, triangles, regions, borders, flat }
    }

    /// For every point on a border to known regions the share that each label
    /// has there: of equal borders in every direction the mean. `None` for
    /// the others.
    pub fn fixed(&self, labels: &[Label]) -> Vec<Option<Vec<f32>>> {
        let mut shares: Vec<Option<Vec<f32>>> = vec![None; self.points.len()];
        for border in &self.borders {
            let Ok(slot) = labels.binary_search(&border.label) else { continue };
            for point in [border.start, border.end] {
                shares[point as usize].get_or_insert_with(|| vec![0.0; labels.len()])[slot] += 1.0;
            }
        }
        for shares in shares.iter_mut().flatten() {
            let total: f32 = shares.iter().sum();
            shares.iter_mut().for_each(|share| *share /= total);
        }
        shares
    }

    /// The weights of the labels around a point's region: the integral of
    /// 1/ρ over the directions within the plane in which the region's border
    /// is seen (the mean-value interpolant in two dimensions), in 1/world
    /// units. Borders seen from behind, across something known, do not count.
    pub fn weights(&self, point: u32, labels: &[Label]) -> Vec<f64> {
        let mut weights = vec![0.0; labels.len()];
        let (x, region) = (self.flat[point as usize], self.regions[point as usize]);
        for border in self.borders.iter().filter(|border| border.region == region) {
            let Ok(slot) = labels.binary_search(&border.label) else { continue };
            let [p, q] = [border.start, border.end].map(|end| self.flat[end as usize] - x);
            weights[slot] += seen(p, q);
        }
        weights
    }
}

/// ∫ dφ / ρ(φ) over an edge that has the origin on its left, 0 for others:
/// with h the distance to its line and φ measured from the foot,
/// ∫ cos φ / h dφ = (sin β − sin α) / h. With both ends on one side of the foot,
/// a and b from it, the difference is h² (1/p² − 1/q²) / (sin α + sin β), where
/// p² and q² differ by b² − a²: then no digits cancel, and what is seen edge on
/// has no weight rather than any.
fn seen(p: DVec2, q: DVec2) -> f64 {
    let d = q - p;
    let cross = p.perp_dot(d);
    if cross <= 0.0 {
        return 0.0;
    }
    let length = d.length();
    let [a, b] = [p, q].map(|end| end.dot(d) / length);
    let [sine_a, sine_b] = [a / p.length(), b / q.length()];
    if a * b <= 0.0 {
        return (sine_b - sine_a) * length / cross;
    }
    cross * (a + b) / (p.length_squared() * q.length_squared() * (sine_a + sine_b))
}

impl Known {
    /// A known region's edge on its face's border, turned round.
    fn beside(edge: &FacetEdge, frame: &PlaneFrame) -> Option<Self> {
        let border = edge.right.is_none() && edge.left != Label::UNKNOWN;
        let [start, end] = [edge.end, edge.start].map(|point| frame.flatten(point));
        border.then_some(Self { start, end, label: edge.left })
    }

    /// The squared distance of a point.
    fn distance_squared(&self, point: DVec2) -> f64 {
        let (d, to) = (self.end - self.start, point - self.start);
        let along = (to.dot(d) / d.length_squared()).clamp(0.0, 1.0);
        (to - along * d).length_squared()
    }
}

/// What is known beyond a face's border, at a point on it, to the right.
fn beyond(known: &[Known], point: DVec2, along: DVec2, reach: f64) -> Option<Label> {
    known
        .iter()
        .filter(|edge| (edge.end - edge.start).dot(along) > 0.0)
        .map(|edge| (edge.distance_squared(point), edge.label))
        .filter(|(distance, _)| *distance <= reach * reach)
        .min_by(|one, other| one.0.total_cmp(&other.0))
        .map(|(_, label)| label)
}

/// For every triangle its connected part, and the edges that only one
/// triangle has, with that triangle on the left.
fn connected(triangles: &[(u32, [u32; 3])]) -> (Vec<u32>, Rim) {
    let mut edges: Vec<([u32; 2], usize, [u32; 2])> = Vec::with_capacity(3 * triangles.len());
    for (index, (_, [a, b, c])) in triangles.iter().enumerate() {
        for (start, end) in [(*a, *b), (*b, *c), (*c, *a)] {
            edges.push(([start.min(end), start.max(end)], index, [start, end]));
        }
    }
    edges.sort_unstable();
    let pairs = edges.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    let parts =
        components(triangles.len() as u32, pairs.map(|pair| [pair[0].1 as u32, pair[1].1 as u32]));
    let alone = |edge: &[([u32; 2], usize, [u32; 2])]| match edge {
        [(_, triangle, ends)] => Some((*triangle, *ends)),
        _ => None,
    };
    let rim = edges.chunk_by(|one, other| one.0 == other.0).filter_map(alone).collect();
    (parts, rim)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn an_edge_is_seen_in_front_and_not_from_behind() {
        let [left, right] = [-1.0, 1.0].map(|x| DVec2::new(x, -1.0));
        // From −45° to 45° at a distance of 1: 2 sin 45°.
        assert!((seen(left, right) - 2f64.sqrt()).abs() < 1e-15);
        assert_eq!(seen(right, left), 0.0);
        // In parts, the second of which has both ends on one side of the foot.
        let middle = DVec2::new(0.3, -1.0);
        assert!((seen(left, middle) + seen(middle, right) - 2f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn an_edge_seen_edge_on_weighs_nothing() {
        for step in 0..1000 {
            let direction = DVec2::from_angle(f64::from(step) / 1000.0 * 2.0 * PI);
            // Rounded, these are on a line with the origin or just beside it.
            for [p, q] in [[0.7, 1.9], [-1.9, -0.7]].map(|ends| ends.map(|at| at * direction)) {
                let weight = seen(p, q);
                assert!((0.0..1e-15).contains(&weight), "{weight}");
            }
        }
    }
}
