//! Caps: the triangles that close a surface on the faces of an open box.

use rayon::prelude::*;

use super::Mesh;
use crate::label::Label;
use crate::plane::Bounds;

/// How far from the box's faces caps may lie, in voxels: rounding only.
pub const CAP_TOLERANCE: f64 = 1e-3;

impl Mesh {
    /// Whether a triangle is a cap of a box: outside is in front of it, and its
    /// corners lie on or beyond one face, up to `tolerance` world units.
    pub fn is_cap(&self, triangle: usize, bounds: Bounds, tolerance: f64) -> bool {
        self.face_of_cap(triangle, bounds, tolerance).is_some()
    }

    /// The face of a box that a triangle is a cap in, as
    /// [`Bounds::common_face`] numbers them.
    pub fn face_of_cap(&self, triangle: usize, bounds: Bounds, tolerance: f64) -> Option<usize> {
        let outside = self.sides[triangle][1] == Label::OUTSIDE;
        let face = || bounds.common_face(&self.corners(triangle), tolerance);
        outside.then(face).flatten()
    }

    /// The mesh without its caps and without the vertices that only these
    /// have: open where a material leaves the box.
    pub fn without_caps(&self, bounds: Bounds, tolerance: f64) -> Self {
        let kept: Vec<usize> = (0..self.triangles.len())
            .into_par_iter()
            .filter(|&triangle| !self.is_cap(triangle, bounds, tolerance))
            .collect();
        let triangles: Vec<[u32; 3]> = kept.iter().map(|&kept| self.triangles[kept]).collect();
        let sides = kept.iter().map(|&kept| self.sides[kept]).collect();
        let mut number = vec![u32::MAX; self.vertices.len()];
        triangles.iter().flatten().for_each(|&vertex| number[vertex as usize] = 0);
        let mut vertices = Vec::new();
        for (number, &vertex) in number.iter_mut().zip(&self.vertices) {
            if *number == 0 {
                *number = vertices.len() as u32;
                vertices.push(vertex);
            }
        }
        let renamed = |triangle: [u32; 3]| triangle.map(|vertex| number[vertex as usize]);
        Self { vertices, triangles: triangles.into_iter().map(renamed).collect(), sides }
    }
}
