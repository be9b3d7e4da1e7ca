//! Edges around which a label comes up more than once.
//!
//! Where a surface almost touches itself, the tetrahedra of one label may meet
//! in an edge only, and its boundary then has four triangles there:
//!
//! ```text
//!      B                 B
//!   A  ×  A   becomes  A ─ A  with the upper two triangles at a new point in
//!      C                 C    the middle of the edge, the others as they were
//! ```
//!
//! The triangles that bound the sectors between two of the label are split at
//! a new point in the middle of the edge, which is theirs alone, as the dual
//! mesher's pinched faces are. The two sectors of the label are then connected
//! between that point and the old edge. Sectors between are taken before those
//! around them, until no label is left more than once.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;

use super::oracle::Oracle;
use super::seeds::{Seed, crossings};
use crate::label::Label;
use crate::mesh::Mesh;

/// How far the new point is moved into its sectors, relative to the edge.
const SHIFT: f64 = 0.02;

/// Splits the triangles of a mesh at the edges in `rings`: two ends, the
/// number of triangles, and the triangles in turn around the edge.
pub fn split(mesh: &mut Mesh, rings: &[u32]) {
    let mut splits = Splits { mesh, parts: HashMap::new() };
    for (edge, ring) in each(rings) {
        splits.split_edge(edge, ring);
    }
}

/// Points of the surface around such edges, in lattice units: with these,
/// most are no longer pinched.
pub fn seeds(mesh: &Mesh, rings: &[u32], oracle: &Oracle) -> Vec<Seed> {
    each(rings)
        .flat_map(|(_, ring)| ring)
        .flat_map(|&triangle| {
            let [a, b, c] = mesh.corners(triangle as usize);
            crossings((a + b + c) / 3.0, mesh.sides[triangle as usize], oracle)
        })
        .collect()
}

/// The edges with their triangles.
fn each(rings: &[u32]) -> impl Iterator<Item = ([u32; 2], &[u32])> {
    let mut rest = rings;
    std::iter::from_fn(move || {
        let [start, end, count, tail @ ..] = rest else { return None };
        let (ring, next) = tail.split_at_checked(*count as usize)?;
        rest = next;
        Some(([*start, *end], ring))
    })
}

struct Splits<'a> {
    mesh: &'a mut Mesh,
    /// What became of triangles that were split.
    parts: HashMap<u32, Vec<u32>>,
}

impl Splits<'_> {
    fn split_edge(&mut self, edge: [u32; 2], ring: &[u32]) {
        let mut ring: Vec<u32> =
            ring.iter().filter_map(|&triangle| self.current(triangle, edge)).collect();
        self.turn_counter_clockwise(edge, &mut ring);
        // The sector after each triangle.
        let mut sectors: Vec<Label> =
            ring.iter().map(|&triangle| self.label_after(triangle, edge)).collect();
        while let Some([from, to]) = innermost(&sectors) {
            let group: Vec<u32> = ring.drain(from + 1..=to).collect();
            sectors.drain(from + 1..=to);
            self.split_group(edge, &group);
        }
    }

    /// The triangle, or that part of it, which has the edge.
    fn current(&self, triangle: u32, edge: [u32; 2]) -> Option<u32> {
        let has_edge = |of: &u32| edge.iter().all(|end| self.corners(*of).contains(end));
        match self.parts.get(&triangle) {
            None => Some(triangle).filter(has_edge),
            Some(parts) => [triangle].iter().chain(parts).find(|part| has_edge(part)).copied(),
        }
    }

    fn corners(&self, triangle: u32) -> [u32; 3] {
        self.mesh.triangles[triangle as usize]
    }

    fn apex(&self, triangle: u32, edge: [u32; 2]) -> u32 {
        let corners = self.corners(triangle);
        corners.into_iter().find(|corner| !edge.contains(corner)).unwrap_or(corners[0])
    }

    /// The direction of a triangle as seen along the edge, unit length.
    fn direction(&self, triangle: u32, [start, end]: [u32; 2]) -> DVec3 {
        let point = |vertex: u32| self.mesh.vertices[vertex as usize];
        let axis = (point(end) - point(start)).normalize_or_zero();
        let apex = point(self.apex(triangle, [start, end])) - point(start);
        apex.reject_from_normalized(axis).normalize_or_zero()
    }

    /// The steps from one triangle to the next add up to one turn, or the
    /// ring runs the other way.
    fn turn_counter_clockwise(&self, edge: [u32; 2], ring: &mut [u32]) {
        let [start, end] = edge.map(|vertex| self.mesh.vertices[vertex as usize]);
        let directions: Vec<DVec3> =
            ring.iter().map(|&triangle| self.direction(triangle, edge)).collect();
        let turn: f64 = (0..ring.len())
            .map(|at| {
                let (one, next) = (directions[at], directions[(at + 1) % ring.len()]);
                let sine = one.cross(next).dot((end - start).normalize_or_zero());
                sine.atan2(one.dot(next)).rem_euclid(TAU)
            })
            .sum();
        if turn > 1.5 * TAU {
            ring.reverse();
        }
    }

    /// The label counter-clockwise of a triangle: its front when it passes
    /// the edge forward.
    fn label_after(&self, triangle: u32, [start, end]: [u32; 2]) -> Label {
        let corners = self.corners(triangle);
        let forward = (0..3).any(|at| [corners[at], corners[(at + 1) % 3]] == [start, end]);
        self.mesh.sides[triangle as usize][usize::from(forward)]
    }

    /// Splits neighbouring triangles at a point of their own.
    fn split_group(&mut self, edge: [u32; 2], group: &[u32]) {
        let [start, end] = edge.map(|vertex| self.mesh.vertices[vertex as usize]);
        let inward: DVec3 = group.iter().map(|&triangle| self.direction(triangle, edge)).sum();
        let shift = SHIFT * start.distance(end) * inward.normalize_or_zero();
        let middle = self.mesh.vertices.len() as u32;
        self.mesh.vertices.push(start.midpoint(end) + shift);
        for &triangle in group {
            let replaced = |from: u32| {
                self.corners(triangle).map(|corner| if corner == from { middle } else { corner })
            };
            let halves = [replaced(edge[1]), replaced(edge[0])];
            let part = self.mesh.triangles.len() as u32;
            self.mesh.triangles[triangle as usize] = halves[0];
            self.mesh.triangles.push(halves[1]);
            self.mesh.sides.push(self.mesh.sides[triangle as usize]);
            self.parts.entry(triangle).or_default().push(part);
        }
    }
}

/// Two places with one label, and no label twice between them.
fn innermost(sectors: &[Label]) -> Option<[usize; 2]> {
    for (to, label) in sectors.iter().enumerate() {
        if let Some(from) = sectors[..to].iter().rposition(|other| other == label) {
            return Some([from, to]);
        }
    }
    None
}
