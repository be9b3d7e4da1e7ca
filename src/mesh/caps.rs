//! Caps: the triangles that close a surface on the faces of an open box.

use rayon::prelude::*;

use super::Mesh;
use super::sheets::Side;
use super::surface::sorted_sides;
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

    /// The edges at which caps of a box end, or go on in another of its faces.
    pub fn rim(&self, bounds: Bounds, tolerance: f64) -> Vec<[u32; 2]> {
        let faces: Vec<Option<usize>> = (0..self.triangles.len())
            .into_par_iter()
            .map(|triangle| self.face_of_cap(triangle, bounds, tolerance))
            .collect();
        let is_rim = |same: &[Side]| {
            same.windows(2).any(|pair| faces[pair[0].1 as usize] != faces[pair[1].1 as usize])
        };
        let sides = sorted_sides(&self.triangles);
        let edges = sides.chunk_by(|one, other| one.0 == other.0);
        edges.filter(|same| is_rim(same)).map(|same| same[0].0).collect()
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
