//! What comes to lie in the plane of a section cuts the corners of its contours: a
//! surface may only pass there.

use std::collections::{BTreeMap, BTreeSet, HashSet};

use rayon::prelude::*;

use super::guard::Sides;
use crate::mesh::network::{Kind, Network};
use crate::mesh::sheets::Side;
use crate::plane::Plane;

/// Less than this that comes to lie in a plane is rounding, relative to the size squared.
const FLAT: f64 = 1e-9;
/// More rounds of turning edges than any corner needs.
const TURNING: u32 = 8;

/// How much of every patch lies in which of the planes.
pub struct Flat {
    /// By patch and plane.
    areas: BTreeMap<(u32, usize), f64>,
}

impl Flat {
    pub fn of(network: &Network, planes: &[Plane]) -> Self {
        let Network { mesh, patches, .. } = network;
        let planes = Sides::all(planes, &mesh.vertices);
        let in_plane = |(number, plane): (usize, &Sides)| {
            let is_on: Vec<bool> = mesh.vertices.iter().map(|&at| plane.of(at) == 0.0).collect();
            let mut areas: BTreeMap<(u32, usize), f64> = BTreeMap::new();
            for (triangle, (corners, &patch)) in mesh.triangles.iter().zip(patches).enumerate() {
                if corners.iter().all(|&corner| is_on[corner as usize]) {
                    let [a, b, c] = mesh.corners(triangle);
                    let area = (b - a).cross(c - a).length() / 2.0;
                    *areas.entry((patch, number)).or_default() += area;
                }
            }
            areas
        };
        let areas = planes.par_iter().enumerate().map(in_plane);
        let areas = areas.reduce(BTreeMap::new, |mut all, mut own| {
            all.append(&mut own);
            all
        });
        Self { areas }
    }

    /// The patches of which more lies in a plane than did before.
    pub fn grown(&self, before: &Self, size: f64) -> BTreeSet<u32> {
        let is_grown = |&(key, area): &(&(u32, usize), &f64)| {
            area - before.areas.get(key).unwrap_or(&0.0) > FLAT * size * size
        };
        self.areas.iter().filter(is_grown).map(|(&(patch, _), _)| patch).collect()
    }
}

impl Network {
    /// Turns edges so that triangles in a plane with all their corners on its contours, of
    /// which remeshing makes some, become two that leave it. `on` says of every vertex which
    /// planes it stays on.
    pub fn turn_flat(&mut self, on: &[Vec<usize>]) {
        for _ in 0..TURNING {
            if !self.turn_flat_once(on) {
                return;
            }
        }
    }

    fn turn_flat_once(&mut self, on: &[Vec<usize>]) -> bool {
        let common = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|corner| &on[corner as usize]);
            a.iter().copied().find(|plane| b.contains(plane) && c.contains(plane))
        };
        let flat: Vec<Option<usize>> =
            self.mesh.triangles.iter().map(|&corners| common(corners)).collect();
        if flat.iter().all(Option::is_none) {
            return false;
        }
        let edges = self.edges();
        let inner: Vec<[Side; 2]> = edges
            .iter()
            .filter(|sides| self.kind(sides) == Kind::Surface)
            .map(|sides| [sides[0], sides[1]])
            .collect();
        let mut known: HashSet<[u32; 2]> = edges.iter().map(|sides| sides[0].0).collect();
        let mut is_turned = vec![false; flat.len()];
        let mut any = false;
        for [one, other] in inner {
            for [own, beside] in [[one, other], [other, one]] {
                let [triangle, next] = [own.1 as usize, beside.1 as usize];
                let Some(plane) = flat[triangle] else { continue };
                let corner = |side: Side, step: u8| {
                    self.mesh.triangles[side.1 as usize][usize::from((side.2 + step) % 3)]
                };
                let [from, to, top] = [0, 1, 2].map(|step| corner(own, step));
                let apex = corner(beside, 2);
                let ends = [top.min(apex), top.max(apex)];
                if on[apex as usize].contains(&plane)
                    || top == apex
                    || is_turned[triangle]
                    || is_turned[next]
                    || !known.insert(ends)
                {
                    continue;
                }
                (is_turned[triangle], is_turned[next], any) = (true, true, true);
                self.mesh.triangles[triangle] = [top, from, apex];
                self.mesh.triangles[next] = [apex, to, top];
            }
        }
        any
    }
}
