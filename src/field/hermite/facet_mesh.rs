//! Facets cut into triangles: the constrained Delaunay triangulation of the regions on them,
//! refined.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::complex::{Complex, Facet};
use crate::error::{Error, Result};
use crate::ffi::triangulation as ffi;
use crate::field::places::{PlaneFrame, key, pieces, step};
use crate::label::Label;

/// A triangle whose height is less than this part of its longest side is left out: what it weighs
/// is nothing, and single precision would make it more.
const NEEDLE: f64 = 1e-3;

/// A facet's triangles.
#[derive(Debug, Default)]
pub struct FacetMesh {
    /// World units.
    pub points: Vec<DVec3>,
    /// Counter-clockwise about the plane's normal.
    pub triangles: Vec<[u32; 3]>,
    /// The labels of the regions around every point, sorted, *unknown* among them.
    pub around: Vec<Vec<Label>>,
}

/// Borders of regions as they are triangulated.
struct Borders {
    points: Vec<DVec3>,
    numbers: HashMap<[u64; 3], u32>,
    segments: Vec<u32>,
    /// Of every segment its region: the number of its label.
    regions: Vec<u32>,
    step: f64,
}

impl FacetMesh {
    /// With edges of about `spacing`, in world units.
    ///
    /// # Errors
    /// CGAL's exceptions.
    pub fn new(complex: &Complex, facet: &Facet, spacing: f64) -> Result<Self> {
        let frame = PlaneFrame::new(complex.planes()[facet.plane], complex.bounds());
        let mut borders = Borders::new(step(complex.bounds()));
        for edge in &facet.edges {
            let sides = [Some(edge.left), edge.right].into_iter().flatten();
            let regions = sides.filter_map(|label| facet.labels.binary_search(&label).ok());
            borders.add([edge.start, edge.end], regions, spacing);
        }
        let flat: Vec<f64> =
            borders.points.iter().flat_map(|&point| frame.flatten(point).to_array()).collect();
        let made = ffi::triangulate(&flat, &borders.segments, &borders.regions, spacing)
            .map_err(|exception| Error::library("field", &exception))?;
        let flat = made.points.chunks_exact(2).map(DVec2::from_slice);
        let points: Vec<DVec3> = flat
            .zip(&made.inputs)
            .map(|(flat, &input)| match borders.points.get(input as usize) {
                Some(&point) => point,
                None => frame.lift(flat),
            })
            .collect();
        let mut mesh = Self { around: vec![Vec::new(); points.len()], points, triangles: vec![] };
        let corners = made.triangles.chunks_exact(3).map(|three| [three[0], three[1], three[2]]);
        for (corners, &region) in corners.zip(&made.regions) {
            mesh.add(corners, facet.labels[region as usize]);
        }
        mesh.around.iter_mut().for_each(|labels| labels.sort());
        Ok(mesh)
    }

    fn add(&mut self, corners: [u32; 3], label: Label) {
        let [a, b, c] = corners.map(|corner| self.points[corner as usize]);
        let sides = [b - a, c - b, a - c];
        let longest = sides.iter().map(|side| side.length_squared()).fold(0.0, f64::max);
        if sides[0].cross(sides[1]).length() > NEEDLE * longest {
            self.triangles.push(corners);
        }
        for corner in corners {
            let around = &mut self.around[corner as usize];
            if !around.contains(&label) {
                around.push(label);
            }
        }
    }
}

impl Borders {
    fn new(step: f64) -> Self {
        let (points, numbers, segments, regions) = Default::default();
        Self { points, numbers, segments, regions, step }
    }

    /// Adds an edge of some regions in equal pieces, the same ones from either end.
    fn add(
        &mut self,
        ends: [DVec3; 2],
        regions: impl Iterator<Item = usize> + Clone,
        spacing: f64,
    ) {
        for ends in pieces(ends, spacing, self.step).windows(2) {
            let segment = [ends[0], ends[1]].map(|end| self.number(end));
            for region in regions.clone().filter(|_| segment[0] != segment[1]) {
                self.segments.extend(segment);
                self.regions.push(region as u32);
            }
        }
    }

    fn number(&mut self, point: DVec3) -> u32 {
        let next = self.points.len() as u32;
        let number = *self.numbers.entry(key(point, self.step)).or_insert(next);
        if number == next {
            self.points.push(point);
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::fixture::busy_stack;
    use crate::random::Random;

    fn area(mesh: &FacetMesh, normal: DVec3) -> f64 {
        let of_triangle = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| mesh.points[corner as usize]);
            0.5 * (b - a).cross(c - a).dot(normal)
        };
        mesh.triangles.iter().map(of_triangle).sum()
    }

    /// Discs with rings in them: all of a facet is covered, once, and where labels meet points
    /// know both.
    #[test]
    fn triangles_cover_a_facet() {
        let mut random = Random::new(50);
        let stack = busy_stack(&mut random, 5, 20);
        let complex = stack.complex();
        for (number, facet) in complex.facets().iter() {
            let mesh = FacetMesh::new(&complex, facet, 0.2 * stack.scale).unwrap();
            let normal = complex.planes()[facet.plane].unit_normal();
            let side = |along: f64| along * stack.scale;
            let expected = if number < 3 { side(2.0) * side(2.0) } else { side(2.0) * side(1.0) };
            let found = area(&mesh, normal);
            assert!((found / expected - 1.0).abs() < 1e-3, "{number}: {found}, not {expected}");
            let meets = mesh.around.iter().filter(|labels| labels.len() == 2).count();
            assert!(if number < 3 { meets >= 8 * 20 } else { meets == 0 }, "{number}: {meets}");
            assert!(mesh.around.iter().all(|labels| (1..=2).contains(&labels.len())));
        }
    }
}
