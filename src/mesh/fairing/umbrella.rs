//! Smoothing: the flow p −= ¼ U²(p) of Kobbelt et al. (1998), where the
//! *umbrella* U(p) is the mean of a vertex's neighbours less itself. The
//! eigenvalues of U² lie between 0 and 4, so the flow is stable, and the finest
//! ripple goes first. It bends surfaces as little as it can through what stays,
//! across which they have no crease.
//!
//! A vertex on a curve where surfaces meet has only its neighbours along the
//! curve; where such curves end or meet it stays, and where a mesh is open.

use glam::DVec3;
use rayon::prelude::*;

use crate::mesh::Mesh;
use crate::mesh::network::{Kind, Network};

/// One over the largest eigenvalue of U².
const RATE: f64 = 0.25;

/// The cosine of the angle that a triangle may turn by in a step.
const UPRIGHT: f64 = 0.5;

/// Times that triangles are looked at again when others' vertices were left.
const ROUNDS: u32 = 1;

/// More than two curves.
const MANY: u32 = 3;

/// Who pulls at every vertex.
struct Umbrellas {
    /// Where a vertex's neighbours end in `neighbours`.
    ends: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Network {
    /// So many steps of smoothing; what is pinned stays where it is.
    pub fn smooth(&mut self, steps: u32) {
        let umbrellas = Umbrellas::new(self);
        for _ in 0..steps {
            let first = umbrellas.of(&self.mesh.vertices);
            let second = umbrellas.of(&first);
            let mut next = self.mesh.vertices.clone();
            next.par_iter_mut().enumerate().for_each(|(vertex, place)| {
                if !self.pinned[vertex] {
                    *place -= RATE * second[vertex];
                }
            });
            self.take_back(&mut next);
            self.mesh.vertices = next;
        }
    }

    /// Leaves the vertices of triangles that would turn over where they are.
    fn take_back(&self, next: &mut [DVec3]) {
        let Mesh { vertices, triangles, .. } = &self.mesh;
        for _ in 0..ROUNDS {
            let turns_over = |triangle: &&[u32; 3]| {
                let [was, is] = [&vertices[..], &next[..]].map(|places| {
                    let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
                    (b - a).cross(c - a)
                });
                was.dot(is) < UPRIGHT * was.length() * is.length()
            };
            let moved = |triangle: &&[u32; 3]| {
                triangle.iter().any(|&vertex| next[vertex as usize] != vertices[vertex as usize])
            };
            let turned: Vec<[u32; 3]> = triangles
                .par_iter()
                .filter(|triangle| turns_over(triangle) && moved(triangle))
                .copied()
                .collect();
            if turned.is_empty() {
                return;
            }
            for &vertex in turned.as_flattened() {
                next[vertex as usize] = vertices[vertex as usize];
            }
        }
    }
}

impl Umbrellas {
    fn new(network: &Network) -> Self {
        let edges = network.edges();
        let mut curves = vec![0u32; network.mesh.vertices.len()];
        for sides in edges.iter().filter(|sides| network.kind(sides) == Kind::Curve) {
            // Where the mesh is open it ends there: as good as many curves.
            let weight = if sides.len() == 1 { MANY } else { 1 };
            sides[0].0.iter().for_each(|&end| curves[end as usize] += weight);
        }
        let mut pairs: Vec<[u32; 2]> = Vec::new();
        for sides in edges.iter() {
            let [one, other] = sides[0].0;
            let is_curve = network.kind(sides) == Kind::Curve;
            // Off all curves every neighbour pulls, on one those along it.
            let pulled = |vertex: u32| match curves[vertex as usize] {
                0 => true,
                2 => is_curve,
                _ => false,
            };
            pairs.extend(pulled(one).then_some([one, other]));
            pairs.extend(pulled(other).then_some([other, one]));
        }
        pairs.par_sort_unstable();
        let vertices = 0..network.mesh.vertices.len() as u32;
        let ends = vertices.map(|vertex| pairs.partition_point(|pair| pair[0] <= vertex)).collect();
        Self { ends, neighbours: pairs.into_iter().map(|[_, neighbour]| neighbour).collect() }
    }

    fn neighbours(&self, vertex: usize) -> &[u32] {
        let start = if vertex == 0 { 0 } else { self.ends[vertex - 1] };
        &self.neighbours[start..self.ends[vertex]]
    }

    /// U of values at the vertices; 0 where nothing pulls.
    fn of(&self, values: &[DVec3]) -> Vec<DVec3> {
        let umbrella = |vertex: usize| {
            let neighbours = self.neighbours(vertex);
            if neighbours.is_empty() {
                return DVec3::ZERO;
            }
            let sum: DVec3 = neighbours.iter().map(|&neighbour| values[neighbour as usize]).sum();
            sum / neighbours.len() as f64 - values[vertex]
        };
        (0..values.len()).into_par_iter().map(umbrella).collect()
    }
}
