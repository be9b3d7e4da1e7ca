//! Distances from rows of nodes to a triangle.

use glam::{DVec3, Vec3};

use crate::grid::samples::LEAF_SIDE;

/// A triangle near a leaf, prepared in doubles, used in floats: coordinates
/// are voxels from the leaf's first node, so errors stay near 1e-6.
pub(super) struct Triangle {
    /// The corner with the smallest coordinates of its box.
    pub(super) min: Vec3,
    /// The corner with the largest coordinates of its box.
    pub(super) max: Vec3,
    corners: [Vec3; 3],
    edges: [Edge; 3],
    /// Of length one.
    normal: Vec3,
    /// What an inward distance must reach to be inside: 0, or infinity for
    /// a triangle without area.
    inside_from: f32,
}

struct Edge {
    along: Vec3,
    /// One over the square of its length, or 0.
    inverse_square: f32,
    /// In the triangle's plane, at right angles to the edge, pointing inward.
    inward: Vec3,
}

impl Triangle {
    pub(super) fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let cross = (b - a).cross(c - a);
        let normal = cross.normalize_or_zero();
        let edge = |start: DVec3, end: DVec3| {
            let along = end - start;
            let square = along.length_squared();
            Edge {
                along: along.as_vec3(),
                inverse_square: if square > 0.0 { (1.0 / square) as f32 } else { 0.0 },
                inward: normal.cross(along).normalize_or_zero().as_vec3(),
            }
        };
        Self {
            min: a.min(b).min(c).as_vec3(),
            max: a.max(b).max(c).as_vec3(),
            corners: corners.map(|corner| corner.as_vec3()),
            edges: [edge(a, b), edge(b, c), edge(c, a)],
            normal: normal.as_vec3(),
            inside_from: if normal == DVec3::ZERO { f32::INFINITY } else { 0.0 },
        }
    }

    /// How far a coordinate is from the triangle's box.
    pub(super) fn gap(&self, axis: usize, at: f32) -> f32 {
        (self.min[axis] - at).max(at - self.max[axis]).max(0.0)
    }

    /// Lowers the squared distances of the nodes (x, y, 0…7). No branches:
    /// the compiler makes vectors of the row.
    pub(super) fn lower_row(&self, [x, y]: [f32; 2], squares: &mut [f32; LEAF_SIDE]) {
        for (z, square) in squares.iter_mut().enumerate() {
            *square = smaller(*square, self.square(Vec3::new(x, y, z as f32)));
        }
    }

    /// The squared distance of a point: to the plane over the triangle's
    /// inside, else to the nearest edge.
    #[inline(always)]
    fn square(&self, point: Vec3) -> f32 {
        let mut to_edges = f32::INFINITY;
        let mut inward = f32::INFINITY;
        for (corner, edge) in self.corners.iter().zip(&self.edges) {
            let from = point - *corner;
            let along = from.dot(edge.along) * edge.inverse_square;
            let along = smaller(1.0, larger(0.0, along));
            to_edges = smaller(to_edges, (from - along * edge.along).length_squared());
            inward = smaller(inward, from.dot(edge.inward));
        }
        let height = (point - self.corners[0]).dot(self.normal);
        if inward >= self.inside_from { height * height } else { to_edges }
    }
}

/// `f32::min` without its care for NaN, which costs instructions.
#[inline(always)]
fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// `f32::max` likewise.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_plane_edges_and_corners() {
        let corners = [DVec3::ZERO, DVec3::new(4.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];
        let triangle = Triangle::new(corners);
        for (point, expected) in [
            (Vec3::new(1.0, 1.0, 2.5), 6.25),
            (Vec3::new(1.0, -2.0, 1.0), 5.0),
            (Vec3::new(-1.0, -2.0, 2.0), 9.0),
            (Vec3::new(3.0, 3.0, 0.0), 2.0),
            (Vec3::new(6.0, 0.0, -1.0), 5.0),
        ] {
            assert!((triangle.square(point) - expected).abs() < 1e-5, "{point}");
        }
    }

    #[test]
    fn triangles_without_area_are_segments_or_points() {
        let segment = Triangle::new([DVec3::ZERO, DVec3::X, 3.0 * DVec3::X]);
        assert_eq!(segment.square(Vec3::new(2.0, 2.0, 0.0)), 4.0);
        let point = Triangle::new([DVec3::ONE; 3]);
        assert_eq!(point.square(Vec3::new(1.0, 1.0, 4.0)), 9.0);
    }
}
