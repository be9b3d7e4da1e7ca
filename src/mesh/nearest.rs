//! Distances from points to triangles.

use glam::DVec3;
use rayon::prelude::*;

use super::{Mesh, Surface};
use crate::error::{Error, Result};
use crate::ffi::measure;
use crate::label::Label;

/// Triangles arranged so that the nearest to a point is found fast.
pub struct Nearest {
    tree: measure::OwnedTree,
}

impl Nearest {
    /// Of a surface; one without area is an error.
    pub fn on_surface(surface: &Surface) -> Result<Self> {
        Self::new(&surface.vertices, surface.triangles.as_flattened())
    }

    /// Of all triangles of a network; one without area is an error.
    pub fn on_mesh(mesh: &Mesh) -> Result<Self> {
        Self::new(&mesh.vertices, mesh.triangles.as_flattened())
    }

    /// Of all triangles with `label` on either side; `None` without any.
    pub fn on_border(mesh: &Mesh, label: Label) -> Result<Option<Self>> {
        let corners: Vec<u32> = (mesh.triangles.iter().zip(&mesh.sides))
            .filter(|(_, sides)| sides.contains(&label))
            .flat_map(|(triangle, _)| *triangle)
            .collect();
        if corners.is_empty() {
            return Ok(None);
        }
        Self::new(&mesh.vertices, &corners).map(Some)
    }

    /// Of triangles, three corners each; without area they are an error.
    pub(crate) fn new(vertices: &[DVec3], corners: &[u32]) -> Result<Self> {
        let tree = measure::new_tree(&flat(vertices), corners)
            .map_err(|exception| Error::library("distance", &exception))?;
        Ok(Self { tree })
    }

    /// For each point the distance to the nearest triangle, in world units.
    pub fn distances(&self, points: &[DVec3]) -> Result<Vec<f64>> {
        self.asked(points, measure::distances)
    }

    /// For each point the number of the nearest triangle (of several, one of
    /// them), among those that the tree was made of, in their order.
    pub fn triangles(&self, points: &[DVec3]) -> Result<Vec<u32>> {
        self.asked(points, measure::nearest_triangles)
    }

    /// The answers for all points, asked in batches.
    fn asked<T: Copy + Send>(
        &self,
        points: &[DVec3],
        ask: fn(&measure::Tree, &[f64]) -> std::result::Result<Vec<T>, cxx::Exception>,
    ) -> Result<Vec<T>> {
        const BATCH: usize = 1024;
        let batches: Vec<Vec<T>> = points
            .par_chunks(BATCH)
            .map(|batch| ask(&self.tree, &flat(batch)))
            .collect::<std::result::Result<_, _>>()
            .map_err(|exception| Error::library("distance", &exception))?;
        Ok(batches.concat())
    }
}

/// Coordinates by threes, as they cross the bridge.
pub(crate) fn flat(points: &[DVec3]) -> Vec<f64> {
    points.iter().flat_map(|point| point.to_array()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::solid;

    #[test]
    fn distances_to_a_ball_are_those_to_its_sphere() {
        let ball = solid(41, 1.0, |point| 0.7 - point.length());
        let nearest = Nearest::on_border(&ball, Label(1)).unwrap().unwrap();
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(0.0, -2.0, 0.0), DVec3::splat(0.1)];
        for (point, distance) in points.iter().zip(nearest.distances(&points).unwrap()) {
            assert!((distance - (point.length() - 0.7).abs()).abs() < 3e-3, "{point} {distance}");
        }
        assert!(Nearest::on_border(&ball, Label(2)).unwrap().is_none());
    }

    #[test]
    fn the_nearest_triangle_keeps_its_number() {
        // The floor's two halves, with a triangle without area before them.
        let vertices = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let vertices = vertices.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
        let surface = Surface { vertices, triangles: vec![[0, 1, 1], [0, 1, 2], [0, 2, 3]] };
        let nearest = Nearest::on_surface(&surface).unwrap();
        let points = [[0.9, 0.2, 1.0], [0.1, 0.7, -3.0], [5.0, 0.5, 0.0]].map(DVec3::from);
        assert_eq!(nearest.triangles(&points).unwrap(), [1, 2, 1]);
    }

    #[test]
    fn a_surface_without_area_is_an_error() {
        let surface = Surface { vertices: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]] };
        assert!(Nearest::on_surface(&surface).is_err());
    }
}
