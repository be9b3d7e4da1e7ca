//! Triangle networks: every triangle knows the label on its two sides.

pub mod caps;
pub(crate) mod clusters;
pub mod cut;
pub mod decimation;
pub mod delaunay;
pub mod dual;
pub mod facts;
pub mod fairing;
pub mod nearest;
mod network;
pub mod patches;
mod pieces;
#[cfg(test)]
pub(crate) mod shapes;
mod sheets;
pub mod surface;

use glam::DVec3;

use crate::label::Label;
use crate::plane::Bounds;

pub use decimation::decimate;
pub use dual::dual;
pub use fairing::fair;

/// A network of triangles between labels. Junction curves are shared vertex
/// for vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// World units.
    pub vertices: Vec<DVec3>,
    /// Counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the labels `[back, front]`; the normal points from
    /// back to front. Between a material and outside, back is the material;
    /// between two materials, back is the smaller number.
    pub sides: Vec<[Label; 2]>,
}

/// The boundary of one label: closed, oriented outward, every edge with two
/// triangles and every vertex with one fan.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// World units.
    pub vertices: Vec<DVec3>,
    /// Counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The materials that occur, sorted.
    pub fn labels(&self) -> Vec<Label> {
        let mut labels = Vec::new();
        for label in self.sides.iter().flatten().filter(|label| label.is_material()) {
            if let Err(place) = labels.binary_search(label) {
                labels.insert(place, *label);
            }
        }
        labels
    }

    /// The smallest box around the vertices; `None` without any.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around(self.vertices.iter().copied())
    }

    /// The corners of a triangle in space.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }
}

impl Surface {
    /// The surface of a label as a mesh of its own, outside in front of it.
    pub fn into_mesh(self, label: Label) -> Mesh {
        let Self { vertices, triangles } = self;
        let sides = vec![[label, Label::OUTSIDE]; triangles.len()];
        Mesh { vertices, triangles, sides }
    }

    /// The corners of a triangle in space.
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    /// The sum of the triangles' areas, in square world units.
    pub fn area(&self) -> f64 {
        (0..self.triangles.len())
            .map(|triangle| self.corners(triangle))
            .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
            .sum()
    }

    /// For each vertex the mean of the normals of the triangles around it, weighted by their
    /// angles there: of length 1, and along z where they leave none.
    pub fn vertex_normals(&self) -> Vec<DVec3> {
        let mut sums = vec![DVec3::ZERO; self.vertices.len()];
        for (index, triangle) in self.triangles.iter().enumerate() {
            let corners = self.corners(index);
            let [a, b, c] = corners;
            let normal = (b - a).cross(c - a).normalize_or_zero();
            for at in 0..3 {
                let [one, other] = [1, 2].map(|step| corners[(at + step) % 3] - corners[at]);
                let angle = one.cross(other).length().atan2(one.dot(other));
                sums[triangle[at] as usize] += angle * normal;
            }
        }
        sums.into_iter().map(|sum| sum.normalize_or(DVec3::Z)).collect()
    }

    /// The enclosed volume by the divergence theorem, in cubic world units:
    /// positive when the surface is oriented outward.
    pub fn volume(&self) -> f64 {
        // Relative to a corner of the mesh: far from the origin the
        // tetrahedra would cancel digits away.
        let Some(&base) = self.vertices.first() else { return 0.0 };
        (0..self.triangles.len())
            .map(|triangle| self.corners(triangle).map(|corner| corner - base))
            .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
            .sum()
    }
}

/// Which way round two labels lie across a triangle: `[back, front]`, as
/// documented at [`Mesh::sides`].
pub fn back_and_front(one: Label, other: Label) -> [Label; 2] {
    let rank = |label: Label| (!label.is_material(), label);
    if rank(one) < rank(other) { [one, other] } else { [other, one] }
}
