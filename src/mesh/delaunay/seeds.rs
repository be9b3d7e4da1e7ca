//! Points of the surface that refinement starts from, spread out over every
//! connected piece of it: what no point lies on, it would never see.

use std::collections::HashMap;

use glam::{DVec3, IVec3};

use super::oracle::Oracle;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::dual::cell::EDGE_CORNERS;
use crate::plane::Bounds;
use crate::sets::Sets;

/// Pieces up to this size, in voxels, have points on all lattice edges that
/// they cross.
const SMALL: f64 = 4.0;
/// Halvings of a lattice edge.
const HALVINGS: usize = 20;

/// A point between two labels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seed {
    /// In lattice units.
    pub point: DVec3,
    /// The labels on the two sides.
    pub sides: [Label; 2],
}

impl Seed {
    /// The same for the same point.
    pub fn key(&self) -> [u64; 3] {
        self.point.to_array().map(f64::to_bits)
    }
}

/// Points where lattice edges cross the oracle's surface, near vertices of
/// the dual mesh (in lattice units). No two of one piece are nearer than the
/// largest triangles may be there: `size`, or less where the surface bends, so
/// that they are nowhere further than `distance` from it. As many as can be are
/// taken here, since every other one costs a step of refinement.
pub fn seeds(dual: &Mesh, oracle: &Oracle, size: f64, distance: f64) -> Vec<Seed> {
    let sides = sides(dual);
    let bend = curvatures(dual);
    let mut taken: HashMap<(IVec3, u32), Vec<DVec3>> = HashMap::new();
    let mut seeds = Vec::new();
    for (vertex, (piece, length)) in pieces(dual).into_iter().enumerate() {
        let (point, Some(sides)) = (dual.vertices[vertex], sides[vertex]) else { continue };
        if length <= SMALL {
            seeds.extend(crossings(point, sides, oracle));
            continue;
        }
        // A triangle whose corners are r from its centre is κ r² / 2 from a
        // surface of curvature κ. Twice that distance is let pass, since single
        // edges bend more than the surface does: so the fewest vertices are
        // needed in the end.
        let spacing = (4.0 * distance / bend[vertex]).sqrt().min(size);
        let bin = (point / size).floor().as_ivec3();
        let near = |bin: IVec3| taken.get(&(bin, piece)).into_iter().flatten();
        if !around(bin).flat_map(near).any(|other| other.distance(point) < spacing) {
            taken.entry((bin, piece)).or_default().push(point);
            let distance = |seed: &Seed| seed.point.distance_squared(point);
            let nearest = crossings(point, sides, oracle)
                .min_by(|one, other| distance(one).total_cmp(&distance(other)));
            seeds.extend(nearest);
        }
    }
    seeds
}

/// Points where lattice edges cross the oracle's surface near some of the
/// dual mesh's vertices.
pub fn near(dual: &Mesh, oracle: &Oracle, vertices: &[usize]) -> Vec<Seed> {
    let sides = sides(dual);
    let of_vertex = |&vertex: &usize| {
        let sides = sides[vertex]?;
        Some(crossings(dual.vertices[vertex], sides, oracle))
    };
    vertices.iter().filter_map(of_vertex).flatten().collect()
}

/// Where the edges of a point's lattice cell lead from one label to another.
pub fn crossings(point: DVec3, sides: [Label; 2], oracle: &Oracle) -> impl Iterator<Item = Seed> {
    let cell = point.floor();
    EDGE_CORNERS.into_iter().filter_map(move |edge| {
        let mut ends = edge.map(|corner| {
            let offset = [corner / 4, corner / 2 % 2, corner % 2].map(|step| step as f64);
            cell + DVec3::from_array(offset)
        });
        let label = |point: DVec3| oracle.label_at(point.to_array());
        let labels = ends.map(label);
        if labels != sides && labels != [sides[1], sides[0]] {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = ends[0].midpoint(ends[1]);
            ends[usize::from(label(middle) != labels[0])] = middle;
        }
        Some(Seed { point: ends[0].midpoint(ends[1]), sides })
    })
}

/// The curvature of a mesh at every vertex: by how much its edges leave the
/// plane across the mean normal, as a root mean square.
fn curvatures(mesh: &Mesh) -> Vec<f64> {
    let mut normals = vec![DVec3::ZERO; mesh.vertices.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        corners.iter().for_each(|&corner| normals[corner as usize] += (b - a).cross(c - a));
    }
    let mut sums = vec![(0.0, 0.0); mesh.vertices.len()];
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let along = mesh.vertices[to as usize] - mesh.vertices[from as usize];
            let length = along.length_squared();
            if length == 0.0 {
                continue;
            }
            for vertex in [from, to] {
                let normal = normals[vertex as usize].normalize_or_zero();
                let sum: &mut (f64, f64) = &mut sums[vertex as usize];
                *sum = (sum.0 + (2.0 * normal.dot(along) / length).powi(2), sum.1 + 1.0);
            }
        }
    }
    sums.into_iter().map(|(sum, count)| f64::sqrt(sum / f64::max(count, 1.0))).collect()
}

/// A bin and its neighbours.
fn around(bin: IVec3) -> impl Iterator<Item = IVec3> {
    (0..27).map(move |step| bin + IVec3::new(step / 9 - 1, step / 3 % 3 - 1, step % 3 - 1))
}

/// For every vertex the number of its piece and the piece's longest side.
fn pieces(mesh: &Mesh) -> Vec<(u32, f64)> {
    let mut sets = Sets::new(mesh.vertices.len());
    for &[a, b, c] in &mesh.triangles {
        sets.join(a, b);
        sets.join(a, c);
    }
    let roots = sets.roots();
    let mut boxes: HashMap<u32, Bounds> = HashMap::new();
    for (&root, &point) in roots.iter().zip(&mesh.vertices) {
        let whole = boxes.entry(root).or_insert(Bounds { min: point, max: point });
        *whole = Bounds { min: whole.min.min(point), max: whole.max.max(point) };
    }
    roots.iter().map(|&root| (root, boxes[&root].size().max_element())).collect()
}

/// For every vertex the labels of its triangles, where all have the same.
fn sides(mesh: &Mesh) -> Vec<Option<[Label; 2]>> {
    let mut around = vec![(None, false); mesh.vertices.len()];
    for (corners, &own) in mesh.triangles.iter().zip(&mesh.sides) {
        for &corner in corners {
            let (sides, junction) = &mut around[corner as usize];
            *junction |= *sides.get_or_insert(own) != own;
        }
    }
    around.into_iter().map(|(sides, junction)| sides.filter(|_| !junction)).collect()
}
