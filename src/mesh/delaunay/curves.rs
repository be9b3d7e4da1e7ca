//! The curves of a network where three or more labels meet, and those where it
//! is bent sharply: around the caps of an open box.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;

use crate::label::Label;
use crate::mesh::Mesh;
use crate::plane::Bounds;

/// How often points are moved towards the middle of their neighbours, which
/// takes away the steps of the lattice.
const SMOOTHING: usize = 6;

/// The junction curves of a mesh, and of its caps when the box is open (every
/// face of the box counts as a label). Each from one point where several end to
/// the next, or closed: then the last point is the first. Together they have
/// every junction edge once.
pub fn curves(mesh: &Mesh, open: Option<Bounds>) -> Vec<Vec<DVec3>> {
    let mut graph = Graph::new(mesh, open);
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
    let at_box = |point: DVec3| open.is_some_and(|open| open.on_one_face(&[point], 0.0));
    chains.iter().map(|chain| smooth(chain, &mesh.vertices, at_box)).collect()
}

/// What is the same on both sides of an edge that is not on a curve: the labels,
/// and for a cap the box's face.
type Patch = ([Label; 2], Option<usize>);

/// Edges where more than two labels meet, and those of caps.
struct Graph {
    /// The neighbours of every vertex.
    links: BTreeMap<u32, Vec<u32>>,
    /// Vertices that a curve passes through: those with two neighbours.
    inner: BTreeSet<u32>,
}

impl Graph {
    fn new(mesh: &Mesh, open: Option<Bounds>) -> Self {
        let side = |start: u32, end: u32, patch| ([start.min(end), start.max(end)], patch);
        let mut edges: Vec<([u32; 2], Patch)> = (0..mesh.triangles.len())
            .flat_map(|triangle| {
                let face = open.and_then(|open| mesh.face_of_cap(triangle, open, 0.0));
                let (patch, [a, b, c]) = ((mesh.sides[triangle], face), mesh.triangles[triangle]);
                [side(a, b, patch), side(b, c, patch), side(c, a, patch)]
            })
            .collect();
        edges.par_sort_unstable();
        let mut links: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for around in edges.chunk_by(|one, other| one.0 == other.0) {
            if around.iter().any(|(_, patch)| *patch != around[0].1) {
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

/// Moves all points but the ends; those of a closed chain all. A chain on the
/// box has no such steps, and would only shrink.
fn smooth(chain: &[u32], vertices: &[DVec3], at_box: impl Fn(DVec3) -> bool) -> Vec<DVec3> {
    let mut points: Vec<DVec3> = chain.iter().map(|&at| vertices[at as usize]).collect();
    let last = points.len() - 1;
    let closed = chain[0] == chain[last];
    if points.iter().all(|&point| at_box(point)) {
        return points;
    }
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
