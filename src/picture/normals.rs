//! Smooth normals that keep creases.

use glam::Vec3;
use rayon::prelude::*;

use super::scene::Facet;

/// The cosine of the angle between facets beyond which an edge stays sharp.
const CREASE: f32 = 0.6;

/// For each corner of each facet the mean normal of the facets around its
/// vertex that show the same material and lie on the same side of any crease,
/// weighted by their angles there.
pub fn corner_normals(points: &[Vec3], facets: &[Facet]) -> Vec<[Vec3; 3]> {
    let around = Incidence::new(points.len(), facets);
    let flat: Vec<Flat> = facets.par_iter().map(|facet| Flat::new(points, facet)).collect();
    let smooth = |number: usize, vertex: u32| {
        let (own, normal) = (&facets[number], flat[number].normal);
        let sum: Vec3 = around
            .of(vertex)
            .iter()
            .map(|&corner| (corner as usize / 3, corner as usize % 3))
            .filter(|&(other, _)| flat[other].normal.dot(normal) > CREASE)
            .filter(|&(other, _)| facets[other].material == own.material)
            .map(|(other, corner)| flat[other].normal * flat[other].angles[corner])
            .sum();
        sum.normalize_or(normal)
    };
    (0..facets.len())
        .into_par_iter()
        .map(|number| facets[number].corners.map(|vertex| smooth(number, vertex)))
        .collect()
}

/// A facet's own normal, and its angles.
struct Flat {
    normal: Vec3,
    angles: [f32; 3],
}

impl Flat {
    fn new(points: &[Vec3], facet: &Facet) -> Self {
        let corners = facet.corners.map(|vertex| points[vertex as usize]);
        let arms =
            |i: usize| (corners[(i + 1) % 3] - corners[i], corners[(i + 2) % 3] - corners[i]);
        let (u, v) = arms(0);
        let cross = u.cross(v);
        let area = cross.length();
        let angles = [0, 1, 2].map(|i| area.atan2(arms(i).0.dot(arms(i).1)));
        Self { normal: cross.normalize_or_zero(), angles }
    }
}

/// The facets around each vertex.
struct Incidence {
    /// Where each vertex's corners begin in `corners`; one more than vertices.
    starts: Vec<u32>,
    /// Three times a facet plus the corner's number in it.
    corners: Vec<u32>,
}

impl Incidence {
    fn new(vertices: usize, facets: &[Facet]) -> Self {
        let mut starts = vec![0u32; vertices + 1];
        for vertex in facets.iter().flat_map(|facet| facet.corners) {
            starts[vertex as usize + 1] += 1;
        }
        for vertex in 0..vertices {
            starts[vertex + 1] += starts[vertex];
        }
        let mut next = starts.clone();
        let mut corners = vec![0u32; facets.len() * 3];
        for (number, vertex) in facets.iter().flat_map(|facet| facet.corners).enumerate() {
            let slot = &mut next[vertex as usize];
            corners[*slot as usize] = number as u32;
            *slot += 1;
        }
        Self { starts, corners }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|i| self.starts[vertex as usize + i] as usize);
        &self.corners[start..end]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles that share the edge from the origin along y, the second
    /// one bent upward by an angle.
    fn hinge(angle: f32) -> Vec<[Vec3; 3]> {
        let bent = Vec3::new(angle.cos(), 0.0, angle.sin());
        let points = [Vec3::ZERO, Vec3::Y, Vec3::NEG_X, bent];
        let facets = [[0, 1, 2], [0, 3, 1]].map(|corners| Facet { corners, material: 0 });
        corner_normals(&points, &facets)
    }

    #[test]
    fn a_gentle_bend_is_smooth() {
        let normals = hinge(0.5);
        // Halfway between (0, 0, 1) and (−sin ½, 0, cos ½).
        let expected = Vec3::new(-(0.25f32.sin()), 0.0, 0.25f32.cos());
        assert!(normals[0][0].distance(expected) < 1e-5, "{}", normals[0][0]);
        assert!(normals[1][0].distance(expected) < 1e-5);
        assert_eq!(normals[0][2], Vec3::Z);
    }

    #[test]
    fn a_sharp_edge_stays_sharp() {
        let normals = hinge(1.5);
        assert!(normals[0].iter().all(|&normal| normal == Vec3::Z));
    }
}
