//! A network with edges that must stay, and what it takes to refine it.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::Mesh;
use super::sheets::{Side, starts_at};
use super::surface::sorted_sides;
use crate::error::{Error, Result};
use crate::sets::Sets;

/// The ends of an edge, the smaller number first.
pub type Ends = [u32; 2];

/// More rounds than any edge needs.
const UNTYING: u32 = 8;

/// A mesh in the making.
#[derive(Clone)]
pub struct Network {
    pub mesh: Mesh,
    /// For every triangle the patch that it belongs to from the beginning on.
    pub patches: Vec<u32>,
    /// Edges that stay where they are.
    fixed: BTreeSet<Ends>,
    /// For every vertex whether it stays where it is.
    pub pinned: Vec<bool>,
}

/// The edges of a network.
pub struct Edges {
    /// Those of all triangles, the same ones together.
    sides: Vec<Side>,
}

/// What meets at an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Two triangles between the same two labels: a smooth surface.
    Surface,
    /// The same, and it must stay.
    Fixed,
    /// Anything else: a curve where surfaces meet or end.
    Curve,
}

impl From<Mesh> for Network {
    /// A mesh without edges that stay.
    fn from(mesh: Mesh) -> Self {
        let pinned = vec![false; mesh.vertices.len()];
        let patches = vec![0; mesh.triangles.len()];
        Self { mesh, patches, fixed: BTreeSet::new(), pinned }
    }
}

impl Network {
    /// A mesh with edges that stay.
    ///
    /// # Errors
    /// Where an edge has a vertex that the mesh has not.
    pub fn new(mesh: &Mesh, fixed: &[[u32; 2]]) -> Result<Self> {
        let mut pinned = vec![false; mesh.vertices.len()];
        for &end in fixed.as_flattened() {
            let Some(pinned) = pinned.get_mut(end as usize) else {
                return Err(Error::Mesh(format!(
                    "has {} vertices, but an edge to be kept ends in number {end}",
                    mesh.vertices.len()
                )));
            };
            *pinned = true;
        }
        let fixed = fixed.iter().map(|&[one, other]| [one.min(other), one.max(other)]).collect();
        let mut network = Self { mesh: mesh.clone(), patches: Vec::new(), fixed, pinned };
        network.patches = network.number_patches();
        Ok(network)
    }

    /// For every triangle the number of its patch: what hangs together across smooth
    /// surface.
    fn number_patches(&self) -> Vec<u32> {
        let count = self.mesh.triangles.len();
        let mut patches = Sets::new(count);
        for sides in self.edges().iter() {
            if let ([one, other], Kind::Surface) = (sides, self.kind(sides)) {
                patches.join(one.1, other.1);
            }
        }
        patches.roots()
    }

    /// Keeps all of some patches where it is.
    pub fn pin(&mut self, patches: &BTreeSet<u32>) {
        for (triangle, patch) in self.mesh.triangles.iter().zip(&self.patches) {
            if patches.contains(patch) {
                triangle.iter().for_each(|&vertex| self.pinned[vertex as usize] = true);
            }
        }
    }

    pub fn edges(&self) -> Edges {
        Edges { sides: sorted_sides(&self.mesh.triangles) }
    }

    /// What meets at an edge, given its triangles' sides.
    pub fn kind(&self, sides: &[Side]) -> Kind {
        let labels = |side: &Side| self.mesh.sides[side.1 as usize];
        let start = |side: &Side| starts_at(&self.mesh.triangles, side);
        match sides {
            [one, other] if labels(one) == labels(other) && start(one) != start(other) => {
                if self.fixed.contains(&one.0) { Kind::Fixed } else { Kind::Surface }
            }
            _ => Kind::Curve,
        }
    }

    /// Adds a vertex.
    pub fn add(&mut self, place: DVec3, pinned: bool) -> u32 {
        self.mesh.vertices.push(place);
        self.pinned.push(pinned);
        self.mesh.vertices.len() as u32 - 1
    }

    fn place(&self, vertex: u32) -> DVec3 {
        self.mesh.vertices[vertex as usize]
    }

    /// The distance between the ends of an edge.
    pub fn length(&self, [start, end]: Ends) -> f64 {
        self.place(start).distance(self.place(end))
    }

    /// Divides edges into so many equal parts, all triangles at them alike.
    pub fn divide(&mut self, parts: &BTreeMap<Ends, u32>) {
        let points: BTreeMap<Ends, Vec<u32>> =
            parts.iter().map(|(&ends, &parts)| (ends, self.divide_edge(ends, parts))).collect();
        let along = |from: u32, to: u32| -> Vec<u32> {
            let mut points = points.get(&[from.min(to), from.max(to)]).cloned().unwrap_or_default();
            if from > to {
                points.reverse();
            }
            points
        };
        let triangles = std::mem::take(&mut self.mesh.triangles);
        let sides = std::mem::take(&mut self.mesh.sides);
        let patches = std::mem::take(&mut self.patches);
        for ((&[a, b, c], sides), patch) in triangles.iter().zip(sides).zip(patches) {
            let pieces = self.pieces([(a, along(a, b)), (b, along(b, c)), (c, along(c, a))]);
            self.mesh.sides.extend(pieces.iter().map(|_| sides));
            self.patches.extend(pieces.iter().map(|_| patch));
            self.mesh.triangles.extend(pieces);
        }
    }

    /// New vertices along an edge, in its direction.
    fn divide_edge(&mut self, ends: Ends, parts: u32) -> Vec<u32> {
        let [start, end] = ends.map(|end| self.place(end));
        let is_fixed = self.fixed.remove(&ends);
        let place = |part: u32| start.lerp(end, f64::from(part) / f64::from(parts));
        let is_pinned = is_fixed || ends.iter().all(|&end| self.pinned[end as usize]);
        let points: Vec<u32> = (1..parts).map(|part| self.add(place(part), is_pinned)).collect();
        if is_fixed {
            let chain: Vec<u32> = [&ends[..1], &points[..], &ends[1..]].concat();
            self.fixed
                .extend(chain.windows(2).map(|pair| [pair[0].min(pair[1]), pair[0].max(pair[1])]));
        }
        points
    }

    /// The triangles that a triangle becomes with points along its sides, each
    /// side given by its first corner and these. With points on one side they
    /// all meet in the corner opposite to it, otherwise in the middle.
    fn pieces(&mut self, sides: [(u32, Vec<u32>); 3]) -> Vec<[u32; 3]> {
        let corners = [0, 1, 2].map(|side: usize| sides[side].0);
        let divided: Vec<usize> = (0..3).filter(|&side| !sides[side].1.is_empty()).collect();
        let apex = match divided[..] {
            [] => return vec![corners],
            [side] => corners[(side + 2) % 3],
            _ => {
                let middle = corners.iter().map(|&corner| self.place(corner)).sum::<DVec3>() / 3.0;
                self.add(middle, false)
            }
        };
        let around: Vec<u32> =
            sides.iter().flat_map(|(corner, points)| [&[*corner], &points[..]].concat()).collect();
        (0..around.len())
            .map(|at| [around[at], around[(at + 1) % around.len()], apex])
            .filter(|[start, end, _]| *start != apex && *end != apex)
            .collect()
    }

    /// Divides edges that two sheets of one label share with both their ends.
    pub fn untie(&mut self) {
        for _ in 0..UNTYING {
            let tied = self.mesh.tied_edges();
            if tied.is_empty() {
                return;
            }
            self.divide(&tied.into_iter().map(|ends| (ends, 2)).collect());
        }
    }

    /// The mesh with the vertices that triangles have, in their order.
    pub fn into_mesh(self) -> Mesh {
        let Mesh { vertices, mut triangles, sides } = self.mesh;
        let mut numbers = vec![u32::MAX; vertices.len()];
        triangles.as_flattened().iter().for_each(|&vertex| numbers[vertex as usize] = 0);
        let used = |vertex: &usize| numbers[*vertex] == 0;
        let kept: Vec<usize> = (0..vertices.len()).filter(used).collect();
        kept.iter().enumerate().for_each(|(number, &vertex)| numbers[vertex] = number as u32);
        for vertex in triangles.as_flattened_mut() {
            *vertex = numbers[*vertex as usize];
        }
        Mesh {
            vertices: kept.into_iter().map(|vertex| vertices[vertex]).collect(),
            triangles,
            sides,
        }
    }
}

impl Edges {
    /// Every edge by its triangles' sides, in the order of the vertices.
    pub fn iter(&self) -> impl Iterator<Item = &[Side]> {
        self.sides.chunk_by(|one, other| one.0 == other.0)
    }
}
