//! Points of the surface that refinement starts from, spread out over every
//! connected piece of it: what no point lies on, it would never see.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::oracle::Oracle;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::plane::Bounds;

/// A small piece has points at most this part of its size apart.
const PART: f64 = 0.25;
/// How far along the normal the surface is looked for, in voxels.
const REACH: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// Halvings of that way.
const HALVINGS: usize = 30;

/// A point between two labels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seed {
    /// In the mesh's units.
    pub point: DVec3,
    /// The labels on the two sides.
    pub sides: [Label; 2],
}

/// Vertices of a mesh in lattice units, no two of one piece nearer than
/// `spacing` (less on small pieces), moved to the oracle's surface.
pub fn seeds(mesh: &Mesh, oracle: &Oracle, spacing: f64) -> Vec<Seed> {
    let spacings = spacings(mesh, spacing);
    let normals = normals(mesh);
    let found: Vec<Option<Seed>> = (mesh.vertices.par_iter().zip(&normals))
        .map(|(&point, &(normal, sides))| on_surface(point, normal, sides?, oracle))
        .collect();
    let mut taken: HashMap<(IVec3, u32), Vec<DVec3>> = HashMap::new();
    let mut seeds = Vec::new();
    for (seed, &(piece, spacing)) in found.into_iter().zip(&spacings) {
        let Some(seed) = seed else { continue };
        let bin = (seed.point / spacing).floor().as_ivec3();
        let near = |bin: IVec3| taken.get(&(bin, piece)).into_iter().flatten();
        let is_near =
            around(bin).flat_map(near).any(|other| other.distance(seed.point) < spacing);
        if !is_near {
            taken.entry((bin, piece)).or_default().push(seed.point);
            seeds.push(seed);
        }
    }
    seeds
}

/// A bin and its neighbours.
fn around(bin: IVec3) -> impl Iterator<Item = IVec3> {
    (0..27).map(move |step| bin + IVec3::new(step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1))
}

/// For every vertex the number of its piece and the spacing there.
fn spacings(mesh: &Mesh, spacing: f64) -> Vec<(u32, f64)> {
    let mut parent: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &[a, b, c] in &mesh.triangles {
        for other in [b, c] {
            let (one, other) = (root(&mut parent, a), root(&mut parent, other));
            parent[one.max(other) as usize] = one.min(other);
        }
    }
    let roots: Vec<u32> =
        (0..mesh.vertices.len() as u32).map(|vertex| root(&mut parent, vertex)).collect();
    let mut boxes: HashMap<u32, Bounds> = HashMap::new();
    for (&root, &point) in roots.iter().zip(&mesh.vertices) {
        let whole = boxes.entry(root).or_insert(Bounds { min: point, max: point });
        *whole = Bounds { min: whole.min.min(point), max: whole.max.max(point) };
    }
    let least = f64::MIN_POSITIVE.sqrt();
    let own = |root: u32| (PART * boxes[&root].size().max_element()).clamp(least, spacing);
    roots.iter().map(|&root| (root, own(root))).collect()
}

fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        let above = parent[vertex as usize];
        parent[vertex as usize] = parent[above as usize];
        vertex = above;
    }
    vertex
}

/// For every vertex the sum of its triangles' normals, and their labels where
/// all have the same.
fn normals(mesh: &Mesh) -> Vec<(DVec3, Option<[Label; 2]>)> {
    let mut around = vec![(DVec3::ZERO, None, false); mesh.vertices.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        for &corner in corners {
            let (normal, sides, junction) = &mut around[corner as usize];
            *normal += (b - a).cross(c - a);
            let own = mesh.sides[triangle];
            *junction |= *sides.get_or_insert(own) != own;
        }
    }
    around
        .into_iter()
        .map(|(normal, sides, junction)| (normal, sides.filter(|_| !junction)))
        .collect()
}

/// Where the labels change from back to front on the normal through a point.
fn on_surface(
    point: DVec3,
    normal: DVec3,
    sides: [Label; 2],
    oracle: &Oracle,
) -> Option<Seed> {
    let normal = normal.normalize_or_zero();
    let label = |along: f64| oracle.label_at((point + along * normal).to_array());
    let reach = REACH.into_iter().find(|&reach| [label(-reach), label(reach)] == sides)?;
    let (mut low, mut high) = (-reach, reach);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if label(middle) == sides[0] { low = middle } else { high = middle }
    }
    Some(Seed { point: point + 0.5 * (low + high) * normal, sides })
}
