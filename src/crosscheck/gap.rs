//! How far surfaces are from each other, and where the most.

use glam::DVec3;
use serde::Serialize;

use crate::compare::draw;
use crate::error::Result;
use crate::mesh::nearest::Nearest;
use crate::mesh::{Mesh, Surface};

/// Points drawn on a surface for the mean.
const DRAWN: u32 = 100_000;

/// A surface that distances are taken from and to.
pub struct Measured {
    surface: Surface,
    nearest: Nearest,
    drawn: Vec<DVec3>,
}

/// From one surface to another and back, in voxels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Gap {
    /// The larger of the two largest distances.
    pub hausdorff: f64,
    /// The mean of the two mean distances.
    pub mean: f64,
    /// From the first to the second.
    pub there: OneWay,
    /// From the second to the first.
    pub back: OneWay,
}

/// From one surface to another, in voxels.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OneWay {
    /// The largest distance, of vertices and drawn points.
    pub max: f64,
    /// The mean over the surface.
    pub mean: f64,
    /// The point that is farthest off.
    pub at: [f64; 3],
}

impl Measured {
    /// All triangles of a network; `None` without any.
    ///
    /// # Errors
    /// Where they have no area.
    pub fn network(mesh: &Mesh) -> Result<Option<Self>> {
        let Mesh { vertices, triangles, .. } = mesh.clone();
        Self::new(Surface { vertices, triangles })
    }

    /// A surface; `None` without triangles.
    ///
    /// # Errors
    /// Where it has no area.
    pub fn new(surface: Surface) -> Result<Option<Self>> {
        if surface.triangles.is_empty() {
            return Ok(None);
        }
        let nearest = Nearest::on_surface(&surface)?;
        let drawn = draw(&surface, DRAWN, 0);
        Ok(Some(Self { surface, nearest, drawn }))
    }

    /// The distances of points to the surface, in world units.
    ///
    /// # Errors
    /// When the search fails.
    pub fn distances(&self, points: &[DVec3]) -> Result<Vec<f64>> {
        self.nearest.distances(points)
    }

    /// `vertices` are the distances of the own vertices to the other surface.
    fn one_way(&self, other: &Self, vertices: &[f64], voxel: f64) -> Result<OneWay> {
        let drawn = other.distances(&self.drawn)?;
        let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
        let points = self.surface.vertices.iter().chain(&self.drawn);
        let mut farthest = (0.0, DVec3::ZERO);
        for (&point, &distance) in points.zip(vertices.iter().chain(&drawn)) {
            if distance >= farthest.0 {
                farthest = (distance, point);
            }
        }
        Ok(OneWay { max: farthest.0 / voxel, mean: mean / voxel, at: farthest.1.to_array() })
    }
}

/// How far two surfaces are from each other, and each vertex of the first from
/// the second, in world units.
///
/// # Errors
/// When the search fails.
pub fn gap(one: &Measured, other: &Measured, voxel: f64) -> Result<(Gap, Vec<f64>)> {
    let vertices = other.distances(&one.surface.vertices)?;
    let there = one.one_way(other, &vertices, voxel)?;
    let back = other.one_way(one, &one.distances(&other.surface.vertices)?, voxel)?;
    let (hausdorff, mean) = (there.max.max(back.max), 0.5 * (there.mean + back.mean));
    Ok((Gap { hausdorff, mean, there, back }, vertices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::solid;

    #[test]
    fn a_ball_and_a_shifted_one() {
        let ball = |shift: f64| {
            let mesh = solid(41, 1.0, |point| 0.5 - (point - shift * DVec3::X).length());
            Measured::network(&mesh).unwrap().unwrap()
        };
        let (one, other) = (ball(-0.1), ball(0.2));
        let (found, vertices) = gap(&one, &other, 0.05).unwrap();
        // The poles on either side are 0.3 = 6 voxels apart, on the x axis.
        assert!((found.hausdorff - 6.0).abs() < 0.05, "{found:?}");
        for [_, y, z] in [found.there.at, found.back.at] {
            assert!(y.abs() < 0.05 && z.abs() < 0.05, "{found:?}");
        }
        assert!(found.mean > 1.0 && found.mean < 6.0);
        let farthest = vertices.into_iter().fold(0.0, f64::max);
        assert!((farthest - 0.3).abs() < 2.5e-3, "{farthest}");
        assert!(gap(&one, &one, 0.05).unwrap().0.hausdorff < 1e-9);
        assert!(Measured::network(&Mesh::default()).unwrap().is_none());
    }
}
