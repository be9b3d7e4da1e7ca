//! What a surface is like: closed, how large, of which genus.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::nearest::flat;
use super::{Mesh, Surface};
use crate::error::{Error, Result};
use crate::ffi::measure::{self, Component};

/// What CGAL's Polygon_mesh_processing says about a surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Facts {
    /// Whether every edge has exactly two triangles, which pass it in
    /// opposite directions.
    pub closed: bool,
    /// Whether the surface is closed and its inside lies behind its triangles
    /// everywhere: every piece that encloses a negative volume is a cavity in
    /// the box of one that encloses a larger positive one, or so thin that its
    /// vertices' rounding can turn it inside out.
    pub outward: bool,
    /// Cubic world units; what cavities enclose is not counted.
    pub volume: f64,
    /// Square world units.
    pub area: f64,
    /// Connected pieces, cavities included.
    pub components: usize,
    /// Pieces that enclose a cavity.
    pub cavities: usize,
    /// Handles of all pieces together: for each 1 − (V − E + F) / 2. Of no
    /// meaning for a surface that is not closed.
    pub genus: i64,
    /// Triangles of the surface.
    pub triangles: usize,
    /// Pairs of triangles that intersect other than in a corner or an edge that
    /// both have at the same place, when that was asked for.
    pub self_intersections: Option<u64>,
}

impl Surface {
    /// Measures the surface. Counting self-intersections takes some seconds
    /// for a million triangles.
    pub fn facts(&self, self_intersections: bool) -> Result<Facts> {
        let error = |exception| Error::library("measure", &exception);
        let points = flat(&self.vertices);
        let corners = self.triangles.as_flattened();
        let facts = measure::measure(&points, corners).map_err(error)?;
        let pieces = &facts.components;
        let count = || Ok(crossings(&self.vertices, &self.triangles, &[])?.len() as u64);
        let intersections = self_intersections.then(count);
        Ok(Facts {
            closed: facts.closed,
            outward: facts.closed && pieces.iter().all(|piece| faces_outward(piece, pieces)),
            volume: pieces.iter().map(|piece| piece.volume).sum(),
            area: facts.area,
            components: pieces.len(),
            cavities: pieces.iter().filter(|piece| piece.volume < 0.0).count(),
            genus: pieces.iter().map(|piece| 1 - piece.euler / 2).sum(),
            triangles: self.triangles.len(),
            self_intersections: intersections.transpose()?,
        })
    }
}

impl Mesh {
    /// Whether every label's surface is closed and has its inside behind it.
    ///
    /// # Errors
    /// When CGAL fails.
    pub fn faces_outward(&self) -> Result<bool> {
        let labels = self.labels();
        let outward = labels.par_iter().map(|&label| Ok(self.surface(label).facts(false)?.outward));
        Ok(outward.collect::<Result<Vec<bool>>>()?.into_iter().all(|outward| outward))
    }
}

/// The pairs of triangles that intersect other than in a corner or an edge that both
/// have at the same place: those with a triangle that is asked for, if any is. Decided
/// exactly.
///
/// # Errors
/// When a triangle has a vertex that is not there.
pub fn crossings(
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    asked: &[u32],
) -> Result<Vec<[u32; 2]>> {
    let found = measure::crossings(&flat(vertices), triangles.as_flattened(), asked)
        .map_err(|exception| Error::library("measure", &exception))?;
    Ok(found.as_chunks().0.to_vec())
}

fn faces_outward(piece: &Component, pieces: &[Component]) -> bool {
    let within = |outer: &Component| {
        (0..3).all(|axis| outer.min[axis] <= piece.min[axis] && piece.max[axis] <= outer.max[axis])
    };
    piece.volume >= -piece.rounding
        || pieces.iter().any(|outer| outer.volume > -piece.volume && within(outer))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::{DVec2, DVec3};

    use super::*;
    use crate::label::Label;
    use crate::mesh::shapes::solid;

    fn facts(distance: impl Fn(DVec3) -> f64) -> Facts {
        solid(61, 1.0, distance).surface(Label(1)).facts(true).unwrap()
    }

    #[test]
    fn a_ball() {
        let facts = facts(|point| 0.8 - point.length());
        assert!(facts.closed && facts.outward);
        assert_eq!((facts.components, facts.cavities, facts.genus), (1, 0, 0));
        assert_eq!(facts.self_intersections, Some(0));
        assert!((facts.volume / (4.0 / 3.0 * PI * 0.8f64.powi(3)) - 1.0).abs() < 3e-3);
        assert!((facts.area / (4.0 * PI * 0.64) - 1.0).abs() < 3e-3);
    }

    #[test]
    fn a_torus_has_a_handle() {
        let (major, minor) = (0.6, 0.25);
        let facts =
            facts(|point| minor - DVec2::new(point.truncate().length() - major, point.z).length());
        assert!(facts.closed && facts.outward);
        assert_eq!((facts.components, facts.genus), (1, 1));
        assert!((facts.volume / (2.0 * PI * PI * major * minor * minor) - 1.0).abs() < 1e-2);
        assert!((facts.area / (4.0 * PI * PI * major * minor) - 1.0).abs() < 1e-2);
    }

    #[test]
    fn a_shell_has_a_cavity() {
        let facts = facts(|point| 0.2 - (point.length() - 0.6).abs());
        assert!(facts.closed && facts.outward);
        assert_eq!((facts.components, facts.cavities, facts.genus), (2, 1, 0));
        let exact = 4.0 / 3.0 * PI * (0.8f64.powi(3) - 0.4f64.powi(3));
        assert!((facts.volume / exact - 1.0).abs() < 3e-3);
    }

    #[test]
    fn two_balls_that_touch_are_closed() {
        let balls = |point: DVec3| {
            let [left, right] = [-0.4, 0.4].map(|x| 0.4 - (point - DVec3::X * x).length());
            left.max(right)
        };
        let facts = facts(balls);
        assert!(facts.closed && facts.outward);
        assert_eq!(facts.genus, 0);
        assert!((facts.volume / (8.0 / 3.0 * PI * 0.4f64.powi(3)) - 1.0).abs() < 1e-2);
    }

    #[test]
    fn a_surface_turned_inside_out_does_not_face_outward() {
        let mut surface = solid(31, 1.0, |point| 0.8 - point.length()).surface(Label(1));
        surface.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        let facts = surface.facts(false).unwrap();
        assert!(facts.closed && !facts.outward);
    }

    #[test]
    fn what_is_thinner_than_rounding_has_no_inside() {
        let with = |height: f64| {
            let apex = DVec3::new(0.3, 0.3, 1.0 + height);
            let base = [DVec3::ZERO, DVec3::X, DVec3::Y].map(|corner| corner + DVec3::Z);
            tetrahedron([apex, base[0], base[1], base[2]]).facts(false).unwrap()
        };
        let (up, down) = (with(1e-3), with(-1e-3));
        assert!(up.outward != down.outward, "{up:?}, {down:?}");
        assert!(with(f64::EPSILON).outward && with(-f64::EPSILON).outward);
    }

    #[test]
    fn a_hole_and_a_doubled_triangle_are_not_closed() {
        let mut surface = solid(31, 1.0, |point| 0.8 - point.length()).surface(Label(1));
        let last = surface.triangles.pop().unwrap();
        assert!(!surface.facts(false).unwrap().closed);
        surface.triangles.extend([last, last]);
        assert!(!surface.facts(false).unwrap().closed);
    }

    /// The tetrahedron of an origin and three points around it, outward if they
    /// turn counter-clockwise as seen from the far side.
    fn tetrahedron(corners: [DVec3; 4]) -> Surface {
        let triangles = vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]];
        Surface { vertices: corners.to_vec(), triangles }
    }

    /// Both, with vertices of their own.
    fn self_intersections(one: &Surface, other: &Surface) -> Option<u64> {
        let first = one.vertices.len() as u32;
        let moved = other.triangles.iter().map(|triangle| triangle.map(|corner| corner + first));
        let surface = Surface {
            vertices: [&one.vertices[..], &other.vertices].concat(),
            triangles: one.triangles.iter().copied().chain(moved).collect(),
        };
        let facts = surface.facts(true).unwrap();
        assert!(facts.closed && facts.outward);
        facts.self_intersections
    }

    const UNIT: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];

    #[test]
    fn crossing_triangles_are_counted() {
        // Two tetrahedra: one has its tip in the other. The slanted face of the
        // first meets the three other faces of the second.
        let tip = UNIT.map(|corner| corner + 0.1);
        assert_eq!(self_intersections(&tetrahedron(UNIT), &tetrahedron(tip)), Some(3));
    }

    /// Rounding may put all corners of a triangle into one point.
    #[test]
    fn a_triangle_in_one_point_crosses_what_the_point_is_on() {
        for (height, count) in [(0.0, 1), (0.5, 0)] {
            let point = DVec3::new(0.25, 0.25, height);
            let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y, point, point, point];
            let found = crossings(&vertices, &[[0, 1, 2], [3, 4, 5]], &[]).unwrap();
            assert_eq!(found.len(), count, "{height}");
        }
    }

    #[test]
    fn sheets_that_touch_in_common_corners_do_not_intersect() {
        let unit = tetrahedron(UNIT);
        // The origin alone.
        let opposite = tetrahedron([DVec3::ZERO, -DVec3::Y, -DVec3::X, -DVec3::Z]);
        assert_eq!(self_intersections(&unit, &opposite), Some(0));
        // The edge from the origin to X; two faces of one lie in the planes of
        // two of the other, on the other side of that edge.
        let beside = tetrahedron([DVec3::ZERO, DVec3::X, -DVec3::Y, -DVec3::Z]);
        assert_eq!(self_intersections(&unit, &beside), Some(0));
    }

    #[test]
    fn sheets_with_common_corners_may_intersect_elsewhere() {
        let unit = tetrahedron(UNIT);
        // From the origin through the middle of the slanted face: its tip leaves
        // through that face, crossed by the three sides of the other.
        let spike = [[0.9, 1.0, 1.0], [1.0, 0.9, 1.0], [1.0, 1.0, 0.9]].map(DVec3::from);
        let spike = tetrahedron([DVec3::ZERO, spike[0], spike[1], spike[2]]);
        assert_eq!(self_intersections(&unit, &spike), Some(3));
        // A common edge, and faces that lie on each other: in z = 0 and in y = 0.
        let inner = tetrahedron([DVec3::ZERO, DVec3::X, 0.5 * DVec3::Y, 0.5 * DVec3::Z]);
        assert!(self_intersections(&unit, &inner) >= Some(2));
        // The very same triangles.
        assert!(self_intersections(&unit, &unit) >= Some(4));
        // A corner in the middle of the other's slanted face.
        let centre = DVec3::splat(1.0 / 4.0).with_z(0.5);
        let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| centre + axis);
        let resting = tetrahedron([centre, x, y, z]);
        assert_eq!(self_intersections(&unit, &resting), Some(3));
    }
}
