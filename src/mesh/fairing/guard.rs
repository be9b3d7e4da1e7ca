//! What a surface must not come to while it is made fair: it must not cross itself or
//! another, pass through a section other than at a contour, or shrink to nothing.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::facts::crossings;
use crate::mesh::network::Network;
use crate::mesh::sheets::Side;
use crate::mesh::surface::sorted_sides;
use crate::plane::Plane;
use crate::sets::Sets;

/// Times that what is wrong is taken back, each time with one more ring of neighbours,
/// before everything is.
const ROUNDS: usize = 6;
/// A piece that comes to have less than this part of its volume, or more than its inverse,
/// is not made fair.
const SHRUNK: f64 = 0.5;
/// So near to a plane is on it, relative to the size.
const ON: f64 = 1e-12;

impl Network {
    /// The pairs of triangles that cross each other.
    ///
    /// # Errors
    /// When CGAL fails.
    pub fn crossings(&self) -> Result<Vec<[u32; 2]>> {
        crossings(&self.mesh.vertices, &self.mesh.triangles, &[])
    }

    /// The patches that triangles belong to.
    pub fn patches_of(&self, pairs: &[[u32; 2]]) -> BTreeSet<u32> {
        pairs.as_flattened().iter().map(|&triangle| self.patches[triangle as usize]).collect()
    }

    /// Puts vertices that moved wrongly back to where they were, with what is around them.
    ///
    /// # Errors
    /// When CGAL fails.
    pub fn settle(&mut self, before: &[DVec3], planes: &[Plane]) -> Result<()> {
        let mut neighbours: Option<Vec<Vec<u32>>> = None;
        // What is put back can only cross what it did not cross a moment ago.
        let mut asked: Vec<u32> = Vec::new();
        for round in 0..ROUNDS {
            let Mesh { vertices, triangles, .. } = &self.mesh;
            let mut wrong = if round == 0 { self.beyond(before, planes) } else { BTreeSet::new() };
            for triangle in crossings(vertices, triangles, &asked)?.as_flattened() {
                wrong.extend(triangles[*triangle as usize]);
            }
            wrong.retain(|&vertex| self.has_moved(vertex, before));
            if wrong.is_empty() {
                return Ok(());
            }
            for _ in 0..round {
                let neighbours = neighbours.get_or_insert_with(|| self.neighbours());
                let around = wrong.iter().flat_map(|&vertex| &neighbours[vertex as usize]);
                let around: Vec<u32> = around.copied().collect();
                wrong.extend(around);
            }
            for &vertex in &wrong {
                self.mesh.vertices[vertex as usize] = before[vertex as usize];
            }
            let is_touched =
                |triangle: &[u32; 3]| triangle.iter().any(|vertex| wrong.contains(vertex));
            let touched = self.mesh.triangles.iter().enumerate();
            asked = touched.filter(|(_, own)| is_touched(own)).map(|(own, _)| own as u32).collect();
        }
        self.mesh.vertices = before.to_vec();
        Ok(())
    }

    fn has_moved(&self, vertex: u32, before: &[DVec3]) -> bool {
        self.mesh.vertices[vertex as usize] != before[vertex as usize]
    }

    /// The vertices that are on another side of a plane than they were. One that was on it,
    /// because a triangle with all corners on one contour was divided, may leave it to the
    /// side on which its patches are.
    fn beyond(&self, before: &[DVec3], planes: &[Plane]) -> BTreeSet<u32> {
        let planes = Sides::all(planes, before);
        let wrong = planes.par_iter().map(|plane| self.beyond_one(before, plane));
        wrong.reduce(BTreeSet::new, |mut all, mut own| {
            all.append(&mut own);
            all
        })
    }

    fn beyond_one(&self, before: &[DVec3], plane: &Sides) -> BTreeSet<u32> {
        let was: Vec<f64> = before.iter().map(|&place| plane.of(place)).collect();
        let is: Vec<f64> = self.mesh.vertices.iter().map(|&place| plane.of(place)).collect();
        let corners = || self.patches.iter().zip(&self.mesh.triangles);
        // Of each patch whether anything is behind the plane and in front of it.
        let mut sides: HashMap<u32, [bool; 2]> = HashMap::new();
        for (&patch, triangle) in corners() {
            let sides = sides.entry(patch).or_default();
            for side in triangle.map(|corner| was[corner as usize]) {
                sides[0] |= side < 0.0;
                sides[1] |= side > 0.0;
            }
        }
        let mut wrong = BTreeSet::new();
        for (patch, triangle) in corners() {
            let other = |to: f64| sides[patch][usize::from(to < 0.0)];
            wrong.extend(triangle.iter().filter(|&&corner| {
                let (from, to) = (was[corner as usize], is[corner as usize]);
                from != to && (from != 0.0 || other(to))
            }));
        }
        wrong
    }

    fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::new(); self.mesh.vertices.len()];
        for &[a, b, c] in &self.mesh.triangles {
            for [one, other] in [[a, b], [b, c], [c, a]] {
                neighbours[one as usize].push(other);
                neighbours[other as usize].push(one);
            }
        }
        neighbours
    }
}

/// On which side of a plane points are.
pub struct Sides {
    /// Of length one.
    normal: DVec3,
    offset: f64,
    /// Nearer than this is on it.
    near: f64,
}

impl Sides {
    /// For points of a size.
    pub fn all(planes: &[Plane], points: &[DVec3]) -> Vec<Self> {
        let largest = points.iter().fold(0.0, |size: f64, at| size.max(at.abs().max_element()));
        let of = |plane: &Plane| {
            let length = plane.normal.length();
            let (normal, offset) = (plane.normal / length, plane.offset / length);
            Self { normal, offset, near: ON * largest }
        };
        planes.iter().map(of).collect()
    }

    pub fn of(&self, point: DVec3) -> f64 {
        let distance = self.normal.dot(point) - self.offset;
        if distance.abs() <= self.near { 0.0 } else { distance.signum() }
    }
}

/// The edges in planes at which a surface passes from one side to the other: contours, and
/// where another section contradicts the plane's. Moved along the plane they would be seen
/// in the section.
pub fn passing(mesh: &Mesh, planes: &[Plane]) -> Vec<[u32; 2]> {
    let planes = Sides::all(planes, &mesh.vertices);
    let place = |vertex: u32| mesh.vertices[vertex as usize];
    let passes = |around: &[Side]| {
        let ends = around[0].0;
        planes.iter().any(|plane| {
            let beside = |way: f64| {
                around.iter().any(|side| {
                    let corners = mesh.triangles[side.1 as usize];
                    corners.into_iter().any(|corner| plane.of(place(corner)) == way)
                })
            };
            ends.into_iter().all(|end| plane.of(place(end)) == 0.0) && beside(1.0) && beside(-1.0)
        })
    };
    let sides = sorted_sides(&mesh.triangles);
    let edges: Vec<&[Side]> = sides.chunk_by(|one, other| one.0 == other.0).collect();
    edges.into_par_iter().filter(|around| passes(around)).map(|around| around[0].0).collect()
}

/// The pieces of all labels, by the patches around them.
pub struct Solids {
    /// For each label and patch the piece that it bounds.
    pieces: BTreeMap<(Label, u32), u32>,
    /// What every piece encloses.
    volumes: Vec<f64>,
}

impl Solids {
    pub fn new(network: &Network) -> Self {
        let mut numbers: BTreeMap<(Label, u32), u32> = BTreeMap::new();
        for (sides, &patch) in network.mesh.sides.iter().zip(&network.patches) {
            for &label in sides.iter().filter(|label| label.is_material()) {
                let next = numbers.len() as u32;
                numbers.entry((label, patch)).or_insert(next);
            }
        }
        let mut sets = Sets::new(numbers.len());
        for around in network.edges().iter() {
            let mut first: BTreeMap<Label, u32> = BTreeMap::new();
            for side in around {
                let (triangle, patch) = (side.1 as usize, network.patches[side.1 as usize]);
                for label in network.mesh.sides[triangle] {
                    let Some(&own) = numbers.get(&(label, patch)) else { continue };
                    sets.join(own, *first.entry(label).or_insert(own));
                }
            }
        }
        let pieces = numbers.into_iter().map(|(key, number)| (key, sets.root(number))).collect();
        let mut solids = Self { pieces, volumes: Vec::new() };
        solids.volumes = solids.volumes_in(&network.mesh, &network.patches);
        solids
    }

    fn volumes_in(&self, mesh: &Mesh, patches: &[u32]) -> Vec<f64> {
        let count = self.pieces.values().max().map_or(0, |&last| last as usize + 1);
        let mut volumes = vec![0.0; count];
        let base = mesh.vertices.first().copied().unwrap_or_default();
        for (triangle, (sides, patch)) in mesh.sides.iter().zip(patches).enumerate() {
            let [a, b, c] = mesh.corners(triangle);
            let volume = (a - base).dot((b - a).cross(c - a)) / 6.0;
            for (label, way) in [(sides[0], 1.0), (sides[1], -1.0)] {
                if let Some(&piece) = self.pieces.get(&(label, *patch)) {
                    volumes[piece as usize] += way * volume;
                }
            }
        }
        volumes
    }

    /// The patches around pieces whose volume changed too much.
    pub fn spoiled(&self, network: &Network) -> BTreeSet<u32> {
        let volumes = self.volumes_in(&network.mesh, &network.patches);
        let is_spoiled = |piece: u32| {
            let [was, is] = [&self.volumes, &volumes].map(|all| all[piece as usize]);
            was != 0.0 && !(is / was > SHRUNK && is / was < 1.0 / SHRUNK)
        };
        let spoiled = self.pieces.iter().filter(|&(_, &piece)| is_spoiled(piece));
        spoiled.map(|(&(_, patch), _)| patch).collect()
    }
}
