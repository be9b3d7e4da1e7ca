//! The cut of a mesh by a plane: a planar graph with a label on either side
//! of each edge, as sections are.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use super::Mesh;
use crate::label::Label;
use crate::plane::Plane;
use crate::section::Edge;

/// What a mesh looks like on a plane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Cut {
    /// World units, on the plane to rounding.
    pub points: Vec<DVec3>,
    /// Labels as seen with the plane's normal pointing at the viewer. From
    /// [`Mesh::cut`] no two with the same ends.
    pub edges: Vec<Edge>,
}

/// A point of a cut by the mesh edge that it is on, or by a vertex twice.
type Name = [u32; 2];

impl Mesh {
    /// Cuts the mesh. Vertices on the plane count as above it, so that every
    /// triangle is cut along a segment or not at all.
    pub fn cut(&self, plane: &Plane) -> Cut {
        let Cut { points, edges } = self.segments(plane);
        Cut { points, edges: without_doubles(edges) }
    }

    /// The same with an edge for each triangle that is cut, its back on the left.
    pub fn segments(&self, plane: &Plane) -> Cut {
        let above: Vec<f64> =
            self.vertices.par_iter().map(|&vertex| plane.distance(vertex)).collect();
        let segments: Vec<([Name; 2], [Label; 2])> = self
            .triangles
            .par_iter()
            .zip(&self.sides)
            .filter_map(|(&triangle, &sides)| Some((segment(triangle, &above)?, sides)))
            .filter(|([start, end], _)| start != end)
            .collect();
        let mut numbers = HashMap::new();
        let mut cut = Cut::default();
        for (names, [left, right]) in segments {
            let [start, end] = names.map(|name| {
                *numbers.entry(name).or_insert_with(|| {
                    cut.points.push(self.point_between(name, &above));
                    cut.points.len() as u32 - 1
                })
            });
            cut.edges.push(Edge { start, end, left, right });
        }
        cut
    }

    fn point_between(&self, [one, other]: Name, above: &[f64]) -> DVec3 {
        let (from, to) = (self.vertices[one as usize], self.vertices[other as usize]);
        if one == other {
            return from;
        }
        let (before, after) = (above[one as usize], above[other as usize]);
        from.lerp(to, before / (before - after))
    }
}

/// Where a triangle crosses the plane, from start to end with the triangle's
/// back on the left: the lone corner's outgoing side first when it is above.
fn segment(triangle: [u32; 3], above: &[f64]) -> Option<[Name; 2]> {
    let is_above = triangle.map(|vertex| above[vertex as usize] >= 0.0);
    let lone = (0..3).find(|&corner| {
        is_above[corner] != is_above[(corner + 1) % 3]
            && is_above[corner] != is_above[(corner + 2) % 3]
    })?;
    let name = |corner: usize| {
        let (apex, other) = (triangle[lone], triangle[corner % 3]);
        let (high, low) = if is_above[lone] { (apex, other) } else { (other, apex) };
        if above[high as usize] == 0.0 { [high, high] } else { [high.min(low), high.max(low)] }
    };
    let (first, second) = (name(lone + 1), name(lone + 2));
    Some(if is_above[lone] { [first, second] } else { [second, first] })
}

/// Where the mesh only touches the plane along an edge, segments come in
/// opposite pairs: what remains of them is the difference between the label
/// on the far left and that on the far right, if there is one.
fn without_doubles(mut edges: Vec<Edge>) -> Vec<Edge> {
    for edge in edges.iter_mut().filter(|edge| edge.start > edge.end) {
        *edge = Edge { start: edge.end, end: edge.start, left: edge.right, right: edge.left };
    }
    edges.sort_by_key(|edge| (edge.start, edge.end, edge.left, edge.right));
    edges
        .chunk_by(|one, other| (one.start, one.end) == (other.start, other.end))
        .filter_map(|same| {
            let mut rights: Vec<Label> = same.iter().map(|edge| edge.right).collect();
            let mut lefts: Vec<Label> = same.iter().map(|edge| edge.left).collect();
            lefts.retain(|left| match rights.iter().position(|right| right == left) {
                Some(place) => {
                    rights.remove(place);
                    false
                }
                None => true,
            });
            let (left, right) = (*lefts.first()?, *rights.first()?);
            Some(Edge { left, right, ..same[0] })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::solid;

    /// Twice the area of the material, about the normal.
    fn doubled_area(cut: &Cut, normal: DVec3) -> f64 {
        let edge = |edge: &Edge| {
            let (start, end) = (cut.points[edge.start as usize], cut.points[edge.end as usize]);
            let sign = if edge.left.is_material() { 1.0 } else { -1.0 };
            sign * start.cross(end).dot(normal)
        };
        cut.edges.iter().map(edge).sum()
    }

    #[test]
    fn a_ball_is_cut_in_a_disc_with_the_inside_left() {
        let ball = solid(41, 1.0, |point| 0.7 - point.length());
        for normal in [DVec3::Z, DVec3::new(-1.0, 2.0, 0.5).normalize()] {
            let cut = ball.cut(&Plane { normal: 3.0 * normal, offset: 0.9 });
            let exact = std::f64::consts::PI * (0.49 - 0.09);
            let area = doubled_area(&cut, normal) / 2.0;
            assert!((area / exact - 1.0).abs() < 5e-3, "{area} for {exact}");
            assert!(cut.edges.iter().all(|edge| [edge.left, edge.right] != [edge.right; 2]));
            let off = cut.points.iter().map(|&point| (point.dot(normal) - 0.3).abs());
            assert!(off.fold(0.0, f64::max) < 1e-15);
        }
    }

    #[test]
    fn a_plane_along_a_face_sees_each_edge_once() {
        // A unit cube: its bottom is on the plane and counts as above.
        let vertices = (0..8u32)
            .map(|corner| {
                DVec3::from_array([corner >> 2, corner >> 1 & 1, corner & 1].map(f64::from))
            })
            .collect();
        let quads =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let sides = vec![[Label(1), Label::OUTSIDE]; triangles.len()];
        let cube = Mesh { vertices, triangles, sides };
        assert!((cube.surface(Label(1)).volume() - 1.0).abs() < 1e-15);
        let plane = |offset: f64| Plane { normal: DVec3::Z, offset };
        assert!(cube.cut(&plane(0.0)).edges.is_empty());
        let top = cube.cut(&plane(1.0));
        assert_eq!(doubled_area(&top, DVec3::Z), 2.0);
        assert_eq!(top.edges.len(), 4);
        assert_eq!(doubled_area(&cube.cut(&plane(0.5)), DVec3::Z), 2.0);
    }
}
