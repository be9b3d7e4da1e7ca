//! The curves of a network where three or more labels meet.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;

use crate::label::Label;
use crate::mesh::Mesh;

/// How often points are moved towards the middle of their neighbours, which
/// takes away the steps of the lattice.
const SMOOTHING: usize = 6;

/// The junction curves of a mesh, each from one point where several end to
/// the next, or closed: then the last point is the first. Together they have
/// every junction edge once.
pub fn curves(mesh: &Mesh) -> Vec<Vec<DVec3>> {
    let mut graph = Graph::new(mesh);
    let vertices: Vec<u32> = graph.links.keys().copied().collect();
    let (inner, ends): (Vec<u32>, Vec<u32>) =
        vertices.iter().partition(|&vertex| graph.inner.contains(vertex));
    let mut chains = Vec::new();
    // What no chain from an end has taken is closed.
    for start in ends.into_iter().chain(inner) {
        while let Some(next) = graph.take_edge(start) {
            chains.push(graph.take_chain(start, next));
        }
    }
    chains.iter().map(|chain| smooth(chain, &mesh.vertices)).collect()
}

/// Edges where more than two labels meet.
struct Graph {
    /// The neighbours of every vertex.
    links: BTreeMap<u32, Vec<u32>>,
    /// Vertices that a curve passes through: those with two neighbours.
    inner: BTreeSet<u32>,
}

impl Graph {
    fn new(mesh: &Mesh) -> Self {
        let side = |start: u32, end: u32, sides| ([start.min(end), start.max(end)], sides);
        let mut edges: Vec<([u32; 2], [Label; 2])> = (mesh.triangles.iter().zip(&mesh.sides))
            .flat_map(|(&[a, b, c], &sides)| {
                [side(a, b, sides), side(b, c, sides), side(c, a, sides)]
            })
            .collect();
        edges.par_sort_unstable();
        let mut links: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for around in edges.chunk_by(|one, other| one.0 == other.0) {
            if around.iter().any(|(_, sides)| *sides != around[0].1) {
                let [start, end] = around[0].0;
                links.entry(start).or_default().push(end);
                links.entry(end).or_default().push(start);
            }
        }
        let passed = links.iter().filter(|(_, next)| next.len() == 2);
        let inner = passed.map(|(&vertex, _)| vertex).collect();
        Self { links, inner }
    }

    /// From an edge on, up to an end or back to the start.
    fn take_chain(&mut self, start: u32, next: u32) -> Vec<u32> {
        let mut chain = vec![start, next];
        let mut last = next;
        while self.inner.contains(&last) {
            let Some(next) = self.take_edge(last) else { break };
            chain.push(next);
            last = next;
        }
        chain
    }

    /// Removes an edge at a vertex and says where it leads.
    fn take_edge(&mut self, from: u32) -> Option<u32> {
        let next = self.links.get_mut(&from)?.pop()?;
        if let Some(back) = self.links.get_mut(&next)
            && let Some(place) = back.iter().position(|&vertex| vertex == from)
        {
            back.remove(place);
        }
        Some(next)
    }
}

/// Moves all points but the ends; those of a closed chain all.
fn smooth(chain: &[u32], vertices: &[DVec3]) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = chain.iter().map(|&at| vertices[at as usize]).collect();
    let last = points.len() - 1;
    let closed = chain[0] == chain[last];
    for _ in 0..SMOOTHING {
        let old = points.clone();
        for at in 1..last {
            points[at] = 0.5 * old[at] + 0.25 * (old[at - 1] + old[at + 1]);
        }
        if closed {
            points[0] = 0.5 * old[0] + 0.25 * (old[last - 1] + old[1]);
            points[last] = points[0];
        }
    }
    points
}
