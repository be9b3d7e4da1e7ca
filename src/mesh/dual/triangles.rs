//! Polygons to triangles.

use glam::DVec3;
use rayon::prelude::*;

use super::polygon::Polygons;
use crate::mesh::Mesh;

/// Quadrilaterals by the better diagonal, larger polygons as a fan around a
/// new point in their middle.
pub fn triangulate(points: Vec<DVec3>, polygons: &[Polygons]) -> Mesh {
    let mut mesh = Mesh { vertices: points, ..Mesh::default() };
    let mut centres = Vec::new();
    let first_centre = mesh.vertices.len() as u32;
    let split: Vec<Vec<[[u32; 3]; 2]>> = polygons
        .par_iter()
        .map(|polygons| {
            polygons.quads.iter().map(|(corners, _)| halves(*corners, &mesh.vertices)).collect()
        })
        .collect();
    for (polygons, quads) in polygons.iter().zip(split) {
        for (pair, (_, sides)) in quads.into_iter().zip(&polygons.quads) {
            mesh.triangles.extend(pair);
            mesh.sides.extend([*sides; 2]);
        }
        for (corners, sides) in &polygons.large {
            let centre = first_centre + centres.len() as u32;
            let sum: DVec3 = corners.iter().map(|&corner| mesh.vertices[corner as usize]).sum();
            centres.push(sum / corners.len() as f64);
            for (place, &corner) in corners.iter().enumerate() {
                mesh.triangles.push([corner, corners[(place + 1) % corners.len()], centre]);
                mesh.sides.push(*sides);
            }
        }
    }
    mesh.vertices.extend(centres);
    mesh
}

/// Splits a quadrilateral by the diagonal whose worse triangle is better.
fn halves([a, b, c, d]: [u32; 4], points: &[DVec3]) -> [[u32; 3]; 2] {
    let worse = |pair: [[u32; 3]; 2]| {
        let [one, other] = pair.map(|triangle| quality(triangle.map(|at| points[at as usize])));
        one.min(other)
    };
    let (across_ac, across_bd) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
    if worse(across_ac) >= worse(across_bd) { across_ac } else { across_bd }
}

/// 1 for an equilateral triangle, 0 for a degenerate one: the area over the
/// sum of the squared sides, normalised.
fn quality([a, b, c]: [DVec3; 3]) -> f64 {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let squares = ab.length_squared() + ac.length_squared() + bc.length_squared();
    2.0 * 3f64.sqrt() * ab.cross(ac).length() / squares.max(f64::MIN_POSITIVE)
}
