//! How a surface leans where sections were taken.
//!
//! A method that fills space cell by cell can go through every contour and still
//! lean the wrong way there: its surface then steps from section to section.
//! Distances hardly tell, and normals do.

use glam::DVec3;
use serde::Serialize;

use super::sampling::draw_on;
use crate::error::Result;
use crate::label::Label;
use crate::mesh::nearest::Nearest;
use crate::mesh::{Mesh, Surface};
use crate::plane::Plane;

/// Where is looked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NormalOptions {
    /// How far from a plane a point still counts, in world units: two or three
    /// voxels.
    pub reach: f64,
    /// Points drawn on the whole reference, of which those near planes count.
    pub samples: u32,
    /// What they are drawn from: the same points for the same seed.
    pub seed: u64,
}

impl NormalOptions {
    /// Points up to this far from a plane, as many drawn as
    /// [`compare`](super::compare) draws.
    pub fn within(reach: f64) -> Self {
        let super::Options { samples, seed, .. } = super::Options::default();
        Self { reach, samples, seed }
    }
}

/// How a mesh leans near planes, and how its reference does, in degrees. Means
/// over points of the reference, evenly drawn; what the mesh has there is its
/// nearest triangle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Leaning {
    /// How many points are near enough to a plane.
    pub points: usize,
    /// Between the normals of both, from 0 to 180.
    pub error: f64,
    /// Between the mesh and the nearest plane: 0 where it lies along the plane,
    /// 90 where it stands on it.
    pub steepness: f64,
    /// The same of the reference.
    pub true_steepness: f64,
}

/// How a mesh leans near planes, beside a reference in the same frame; `None`
/// when no drawn point of the reference is near enough to any plane. A network
/// of several materials counts as the union of them all, and the normal of a
/// place is its triangle's.
///
/// # Errors
/// When one of them has no surface around its materials.
pub fn leaning(
    mesh: &Mesh,
    reference: &Mesh,
    planes: &[Plane],
    options: &NormalOptions,
) -> Result<Option<Leaning>> {
    let [surface, reference] = [mesh, reference].map(|mesh| mesh.surface_of(Label::is_material));
    let nearest = Nearest::on_surface(&surface)?;
    let places: Vec<Place> = draw_on(&reference, options.samples.max(1), options.seed)
        .into_iter()
        .filter_map(|(triangle, point)| {
            let normal = normal(&reference, triangle);
            Some(Place { point, normal, across: across(planes, point, options.reach)? })
        })
        .collect();
    let points: Vec<DVec3> = places.iter().map(|place| place.point).collect();
    let triangles = nearest.triangles(&points)?;
    let normals = triangles.iter().map(|&triangle| normal(&surface, triangle as usize));
    Ok(mean(&places, normals))
}

/// How far a mesh's normals are off those of its reference, in degrees: means over points of the
/// reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct NormalErrors {
    /// Near planes, if any point is.
    pub at: Option<f64>,
    /// Everywhere else.
    pub away: Option<f64>,
}

/// How far a mesh's normals are off, at planes and away from them.
///
/// # Errors
/// As [`leaning`].
pub fn normal_errors(
    mesh: &Mesh,
    reference: &Mesh,
    planes: &[Plane],
    options: &NormalOptions,
) -> Result<NormalErrors> {
    let [surface, reference] = [mesh, reference].map(|mesh| mesh.surface_of(Label::is_material));
    let nearest = Nearest::on_surface(&surface)?;
    let drawn = draw_on(&reference, options.samples.max(1), options.seed);
    let points: Vec<DVec3> = drawn.iter().map(|(_, point)| *point).collect();
    let mut sums = [(0.0, 0usize); 2];
    for ((own, point), found) in drawn.iter().zip(nearest.triangles(&points)?) {
        let is_near = across(planes, *point, options.reach).is_some();
        let (sum, count) = &mut sums[usize::from(!is_near)];
        *sum += degrees(normal(&surface, found as usize), normal(&reference, *own));
        *count += 1;
    }
    let [at, away] = sums.map(|(sum, count)| (count > 0).then(|| sum / count as f64));
    Ok(NormalErrors { at, away })
}

/// A point of the reference near a plane.
struct Place {
    point: DVec3,
    /// Of the reference.
    normal: DVec3,
    /// The normal of the nearest plane.
    across: DVec3,
}

fn normal(surface: &Surface, triangle: usize) -> DVec3 {
    let [a, b, c] = surface.corners(triangle);
    (b - a).cross(c - a)
}

/// The normal of the nearest of the planes that are near enough.
fn across(planes: &[Plane], point: DVec3, reach: f64) -> Option<DVec3> {
    planes
        .iter()
        .map(|plane| (plane.distance(point).abs(), plane.normal))
        .filter(|(distance, _)| *distance <= reach)
        .min_by(|one, other| one.0.total_cmp(&other.0))
        .map(|(_, normal)| normal)
}

fn mean(places: &[Place], normals: impl Iterator<Item = DVec3>) -> Option<Leaning> {
    let mut sums = [0.0; 3];
    for (place, normal) in places.iter().zip(normals) {
        sums[0] += degrees(normal, place.normal);
        sums[1] += steepness(normal, place.across);
        sums[2] += steepness(place.normal, place.across);
    }
    let [error, steepness, true_steepness] = sums.map(|sum| sum / places.len() as f64);
    let points = places.len();
    (points > 0).then_some(Leaning { points, error, steepness, true_steepness })
}

/// Between two vectors of any length: from the tangent, since near 0 the cosine
/// says nothing.
fn degrees(one: DVec3, other: DVec3) -> f64 {
    one.cross(other).length().atan2(one.dot(other)).to_degrees()
}

/// Between two planes by their normals, whichever way these point.
fn steepness(one: DVec3, other: DVec3) -> f64 {
    let angle = degrees(one, other);
    angle.min(180.0 - angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::solid;

    /// A frustum from z = −1 to 1 whose square cross-section has half the side
    /// `half` at z = 0, and whose walls go inward by `lean` per height.
    fn frustum(half: f64, lean: f64) -> Mesh {
        let corner = |index: u32| {
            let [x, y, z] =
                [index & 1, index >> 1 & 1, index >> 2].map(|i| 2.0 * f64::from(i) - 1.0);
            DVec3::new(x * (half - lean * z), y * (half - lean * z), z)
        };
        let quads =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles: Vec<[u32; 3]> =
            quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let sides = vec![[Label(1), Label::OUTSIDE]; triangles.len()];
        Mesh { vertices: (0..8).map(corner).collect(), triangles, sides }
    }

    fn level(height: f64) -> Plane {
        Plane { normal: -2.0 * DVec3::Z, offset: -2.0 * height }
    }

    #[test]
    fn a_wall_that_should_be_a_slope() {
        // The slope rises by 4 on 3: atan(4/3) = 53.13°; a wall has 90°. Within
        // 0.01 of the middle they are no more than 0.0075 apart, and only there,
        // in the corners, a point of one side may be nearest to another one.
        let (wall, slope) = (frustum(1.0, 0.0), frustum(1.0, 0.75));
        let options = NormalOptions::within(0.01);
        let found = leaning(&wall, &slope, &[level(0.0)], &options).unwrap().unwrap();
        assert!((found.true_steepness - 53.13).abs() < 0.01, "{found:?}");
        assert!((found.steepness - 90.0).abs() < 0.5, "{found:?}");
        assert!((found.error - 36.87).abs() < 0.5, "{found:?}");
    }

    #[test]
    fn a_solid_leans_like_itself() {
        let slope = frustum(1.0, 0.5);
        let options = NormalOptions::within(0.1);
        let found = leaning(&slope, &slope, &[level(0.0), level(0.5)], &options).unwrap().unwrap();
        assert!(found.error < 1e-6 && found.steepness == found.true_steepness, "{found:?}");
    }

    #[test]
    fn errors_are_told_apart_by_where_they_are() {
        // A slope beside one that leans as much as it does: off by 2 · 36.87° or not at all.
        let (wall, slope) = (frustum(1.0, 0.0), frustum(1.0, 0.75));
        let options = NormalOptions::within(0.01);
        let same = normal_errors(&slope, &slope, &[level(0.0)], &options).unwrap();
        assert!(same.at.is_some_and(|at| at < 1e-6) && same.away.is_some_and(|away| away < 1e-6));
        let found = normal_errors(&wall, &slope, &[level(0.0)], &options).unwrap();
        assert!(found.at.is_some_and(|at| (at - 36.87).abs() < 0.5), "{found:?}");
        assert!(found.away.is_some_and(|away| away > 10.0 && away < 90.0), "{found:?}");
        let far = normal_errors(&wall, &slope, &[level(9.0)], &options).unwrap();
        assert_eq!(far.at, None);
    }

    #[test]
    fn the_nearest_plane_counts() {
        // The top lies along the one, and stands on the other.
        let across = Plane { normal: DVec3::X, offset: 0.0 };
        let cube = frustum(1.0, 0.0);
        let found =
            |planes: &[Plane]| leaning(&cube, &cube, planes, &NormalOptions::within(0.05)).unwrap();
        assert!(found(&[level(1.0)]).is_some_and(|found| found.true_steepness < 10.0));
        assert_eq!(found(&[across]).map(|found| found.true_steepness), Some(90.0));
        assert!(found(&[level(3.0)]).is_none());
    }

    #[test]
    fn meshes_of_a_ball_agree_with_each_other() {
        // Of two sizes, so on lattices that differ: the normals of flat triangles
        // are a few degrees off those of the sphere. At half its height a ball is
        // 60° steep.
        let ball = |nodes| solid(nodes, 1.0, |point| 0.8 - point.length());
        let options = NormalOptions::within(0.02);
        let found = leaning(&ball(61), &ball(101), &[level(0.4)], &options).unwrap().unwrap();
        assert!(found.points > 1000);
        assert!((found.true_steepness - 60.0).abs() < 0.5, "{found:?}");
        assert!((found.steepness - 60.0).abs() < 1.0, "{found:?}");
        assert!(found.error < 5.0, "{found:?}");
    }
}
