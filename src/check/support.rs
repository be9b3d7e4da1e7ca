//! Where the surface rests on little: its parts that are farthest from what
//! sections know.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::grid::evidence::Evidence;

use crate::mesh::Mesh;
use crate::section::Section;

/// The share of the surface's area that counts as poorly supported.
const SHARE: f64 = 0.05;
/// How many parts are listed.
const PARTS: usize = 8;
/// Triangles that are looked up together: neighbours in a mesh are near each
/// other, as a rule.
const TOGETHER: usize = 64;

/// The twentieth of the surface that is farthest from known parts of sections.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Support {
    /// How far from known parts it begins, in world units.
    pub threshold: f64,
    /// Its largest connected parts, at most eight; none where sections leave no
    /// room of a voxel.
    pub parts: Vec<Part>,
}

/// A connected part of the surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// In square world units.
    pub area: f64,
    /// Its centre of gravity.
    pub at: [f64; 3],
    /// Its greatest distance from known parts of sections, in world units.
    pub distance: f64,
    /// The materials that it bounds.
    pub labels: Vec<u32>,
}

/// Measures a mesh; `voxel` in world units.
pub fn support(mesh: &Mesh, sections: &[Section], voxel: f64) -> Support {
    let triangles = measured(mesh, &Evidence::new(sections));
    let (threshold, weak) = farthest(&triangles);
    if threshold <= voxel {
        return Support { threshold, parts: Vec::new() };
    }
    let mut parts = connected_parts(mesh, &triangles, &weak);
    parts.sort_by(|one, other| other.area.total_cmp(&one.area));
    parts.truncate(PARTS);
    Support { threshold, parts }
}

/// A triangle's area, centre and distance from known parts.
#[derive(Clone, Copy)]
struct Measured {
    area: f64,
    center: DVec3,
    distance: f64,
}

fn measured(mesh: &Mesh, evidence: &Evidence) -> Vec<Measured> {
    let numbers: Vec<usize> = (0..mesh.triangles.len()).collect();
    let together = |numbers: &[usize]| {
        let centers: Vec<DVec3> = numbers
            .iter()
            .map(|&triangle| mesh.corners(triangle).into_iter().sum::<DVec3>() / 3.0)
            .collect();
        let middle = centers.iter().sum::<DVec3>() / centers.len() as f64;
        let radius = centers.iter().map(|center| center.distance(middle)).fold(0.0, f64::max);
        let near = evidence.near(middle, radius);
        let measure = |(&triangle, center): (&usize, DVec3)| {
            let [a, b, c] = mesh.corners(triangle);
            let distance = near.distance(center).unwrap_or(0.0);
            Measured { area: (b - a).cross(c - a).length() / 2.0, center, distance }
        };
        numbers.iter().zip(centers).map(measure).collect::<Vec<_>>()
    };
    numbers.par_chunks(TOGETHER).flat_map_iter(together).collect()
}

/// The farthest triangles that together have [`SHARE`] of the area, and how far
/// the nearest of them is.
fn farthest(triangles: &[Measured]) -> (f64, Vec<u32>) {
    let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
    let distance = |triangle: u32| triangles[triangle as usize].distance;
    order.par_sort_by(|&one, &other| distance(other).total_cmp(&distance(one)));
    let mut left = SHARE * triangles.iter().map(|triangle| triangle.area).sum::<f64>();
    let enough = order.iter().position(|&triangle| {
        left -= triangles[triangle as usize].area;
        left <= 0.0
    });
    order.truncate(enough.map_or(0, |last| last + 1));
    (order.last().map_or(0.0, |&last| distance(last)), order)
}

/// Triangles that share a vertex belong to one part.
fn connected_parts(mesh: &Mesh, triangles: &[Measured], weak: &[u32]) -> Vec<Part> {
    let mut roots = Roots { parent: (0..mesh.vertices.len() as u32).collect() };
    for &triangle in weak {
        let [a, b, c] = mesh.triangles[triangle as usize];
        roots.join(a, b);
        roots.join(b, c);
    }
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    for &triangle in weak {
        let Measured { area, center, distance } = triangles[triangle as usize];
        let root = roots.root(mesh.triangles[triangle as usize][0]);
        let nothing = Part { area: 0.0, at: [0.0; 3], distance: 0.0, labels: Vec::new() };
        let part = parts.entry(root).or_insert(nothing);
        part.area += area;
        part.at = (DVec3::from(part.at) + area * center).to_array();
        part.distance = part.distance.max(distance);
        let sides = mesh.sides[triangle as usize];
        part.labels.extend(sides.iter().filter(|side| side.is_material()).map(|side| side.0));
        part.labels.sort_unstable();
        part.labels.dedup();
    }
    let centred = |mut part: Part| {
        part.at = part.at.map(|sum| sum / part.area.max(f64::MIN_POSITIVE));
        part
    };
    parts.into_values().map(centred).collect()
}

/// A union-find structure over vertices.
struct Roots {
    parent: Vec<u32>,
}

impl Roots {
    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.parent[vertex as usize] != vertex {
            let above = self.parent[vertex as usize];
            self.parent[vertex as usize] = self.parent[above as usize];
            vertex = above;
        }
        vertex
    }

    /// The smaller vertex becomes the root.
    fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        self.parent[one.max(other) as usize] = one.min(other);
    }
}
