//! Closed curves on a plane and the faces between them, exactly.

use std::collections::{BTreeMap, HashMap, VecDeque};

use glam::DVec2;

use super::draft::Draft;
use super::{Edge, Section};
use crate::error::{Error, Result};
use crate::ffi::partition::{self, Partition};
use crate::label::Label;

/// The stage that errors of the bridge name.
const STAGE: &str = "partition of a section";
/// Rounding a crossing can make new ones, ever fewer: two rounds are common.
const ROUNDS: usize = 12;
/// The face that reaches to infinity.
pub(super) const UNBOUNDED: usize = 0;

/// A directed piece of a curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    pub start: u32,
    pub end: u32,
    pub curve: u32,
}

/// Curves by their segments, over distinct points.
#[derive(Debug, Default)]
pub(super) struct Curves {
    pub(super) points: Vec<DVec2>,
    numbers: HashMap<[u64; 2], u32>,
    pub(super) segments: Vec<Segment>,
    /// The first of the curves that stay where they are: others are moved onto them.
    pub(super) fixed: Option<u32>,
}

impl Curves {
    /// The number of a point; equal points have the same.
    pub fn point(&mut self, point: DVec2) -> u32 {
        let point = point + 0.0; // no -0
        let next = self.points.len() as u32;
        let number = *self.numbers.entry([point.x.to_bits(), point.y.to_bits()]).or_insert(next);
        if number == next {
            self.points.push(point);
        }
        number
    }

    /// Adds a segment to a curve, unless it has no length.
    pub fn segment(&mut self, curve: usize, start: u32, end: u32) {
        if start != end {
            self.segments.push(Segment { start, end, curve: curve as u32 });
        }
    }

    /// Adds a closed polygon as a curve.
    pub fn polygon(&mut self, curve: usize, points: &[DVec2]) {
        let numbers: Vec<u32> = points.iter().map(|&point| self.point(point)).collect();
        for (i, &start) in numbers.iter().enumerate() {
            self.segment(curve, start, numbers[(i + 1) % numbers.len()]);
        }
    }

    /// Adds edges to the boundaries of the labels on either side: those labels' curves. Their ends
    /// are points by `numbers`.
    pub fn boundaries(
        &mut self,
        edges: &[Edge],
        numbers: &[u32],
        curve: impl Fn(Label) -> Option<usize>,
    ) {
        for edge in edges {
            let [start, end] = [edge.start, edge.end].map(|vertex| numbers[vertex as usize]);
            for (label, start, end) in [(edge.left, start, end), (edge.right, end, start)] {
                if let Some(curve) = curve(label) {
                    self.segment(curve, start, end);
                }
            }
        }
    }

    /// The exact subdivision of the plane by the curves, what nearly touches made to touch.
    /// Crossings are rounded to doubles; that moves edges, so it is repeated until
    /// the rounded edges meet in vertices alone.
    pub fn subdivide(mut self, draft: &mut Draft) -> Result<Subdivision> {
        for round in 0..ROUNDS {
            // What comes of rounding alone comes to rest.
            if round < ROUNDS / 2 {
                draft.findings.snapped += self.snap(&draft.plane, draft.findings.snapping);
            }
            let found = self.partition()?;
            if found.inputs.iter().all(|&input| input != u32::MAX) {
                return Ok(Subdivision::new(self, &found));
            }
            self = self.split(&found);
        }
        let crossing = self.partition()?.first_crossing().unwrap_or_default();
        Err(draft.error(format!(
            "edges near {} cross each other in ways that doubles cannot tell apart: \
             simplify the contours there",
            draft.place(crossing)
        )))
    }

    fn partition(&self) -> Result<Partition> {
        let points: Vec<f64> = self.points.iter().flat_map(|point| point.to_array()).collect();
        let shared = self.shared();
        let segments: Vec<u32> = shared.keys().flat_map(|&(start, end)| [start, end]).collect();
        let mut found = partition::partition(&points, &segments)
            .map_err(|exception| Error::library(STAGE, &exception))?;
        let along: Vec<&Vec<u32>> = shared.values().collect();
        found.share(&along);
        Ok(found)
    }

    /// The segments between two points, in either direction. Neighbouring loops
    /// share many; as overlapping curves they would cost exact comparisons.
    pub(super) fn shared(&self) -> BTreeMap<(u32, u32), Vec<u32>> {
        let mut shared: BTreeMap<(u32, u32), Vec<u32>> = BTreeMap::new();
        for (number, &Segment { start, end, .. }) in self.segments.iter().enumerate() {
            shared.entry((start.min(end), start.max(end))).or_default().push(number as u32);
        }
        shared
    }

    /// The same curves by the edges of their partition, crossings rounded.
    fn split(self, found: &Partition) -> Self {
        let segments = Vec::new();
        let mut curves =
            Self { points: self.points, numbers: self.numbers, segments, fixed: self.fixed };
        let numbers: Vec<u32> = (0..found.inputs.len())
            .map(|vertex| match found.inputs[vertex] {
                u32::MAX => curves.point(found.point(vertex)),
                input => input,
            })
            .collect();
        for edge in 0..found.cover_ends.len() {
            let [start, end] = found.ends(edge).map(|vertex| numbers[vertex]);
            for &cover in found.covers_of(edge) {
                let segment = self.segments[cover as usize];
                let (start, end) =
                    if curves.ascends(segment) { (start, end) } else { (end, start) };
                curves.segment(segment.curve as usize, start, end);
            }
        }
        curves
    }

    /// Whether a segment runs as the partition's edges do: from the smaller
    /// point by x, then y.
    fn ascends(&self, segment: Segment) -> bool {
        let [start, end] = [segment.start, segment.end].map(|point| self.points[point as usize]);
        (start.x, start.y) < (end.x, end.y)
    }
}

impl Partition {
    fn point(&self, vertex: usize) -> DVec2 {
        DVec2::new(self.points[2 * vertex], self.points[2 * vertex + 1])
    }

    fn first_crossing(&self) -> Option<DVec2> {
        let vertex = self.inputs.iter().position(|&input| input == u32::MAX)?;
        Some(self.point(vertex))
    }

    fn ends(&self, edge: usize) -> [usize; 2] {
        [self.edges[4 * edge] as usize, self.edges[4 * edge + 1] as usize]
    }

    /// Replaces every cover by the segments that share its points.
    fn share(&mut self, along: &[&Vec<u32>]) {
        let mut covers = Vec::with_capacity(self.covers.len());
        let mut ends = Vec::with_capacity(self.cover_ends.len());
        for edge in 0..self.cover_ends.len() {
            let segments = self.covers_of(edge).iter().flat_map(|&cover| along[cover as usize]);
            covers.extend(segments);
            ends.push(covers.len() as u32);
        }
        (self.covers, self.cover_ends) = (covers, ends);
    }

    fn covers_of(&self, edge: usize) -> &[u32] {
        &self.covers[part(&self.cover_ends, edge)]
    }
}

/// The range of part `i` of a flat list, by where the parts end.
fn part(ends: &[u32], i: usize) -> std::ops::Range<usize> {
    let start = if i == 0 { 0 } else { ends[i - 1] };
    start as usize..ends[i] as usize
}

/// A curve that runs along an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cover {
    pub curve: u32,
    /// Whether in the edge's direction.
    pub forward: bool,
}

/// An edge between two faces; it has a curve on it, maybe several.
#[derive(Debug)]
pub(super) struct Side {
    pub start: u32,
    pub end: u32,
    pub left: usize,
    pub right: usize,
    pub covers: Vec<Cover>,
}

/// A boundary of a face by its vertices; the face lies left of it.
#[derive(Debug)]
pub(super) struct Walk {
    pub face: usize,
    pub outer: bool,
    pub vertices: Vec<u32>,
}

/// How often curves wind around a face, counter-clockwise positive; sorted by
/// curve, without zeros.
pub(super) type Windings = Vec<(u32, i32)>;

/// Vertices, edges and faces, none of which cross.
#[derive(Debug)]
pub(super) struct Subdivision {
    /// The curves' points in their order, then rounded crossings.
    pub points: Vec<DVec2>,
    /// In the order of the curves' segments.
    pub edges: Vec<Side>,
    /// How many faces there are.
    pub faces: usize,
    /// The boundaries of all faces.
    pub walks: Vec<Walk>,
}

impl Subdivision {
    fn new(curves: Curves, found: &Partition) -> Self {
        let mut edges: Vec<(u32, Side)> =
            (0..found.cover_ends.len()).map(|edge| side(&curves, found, edge)).collect();
        edges.sort_by(|(first, a), (second, b)| {
            let [a, b] = [a, b].map(|side| curves.points[side.start as usize]);
            first.cmp(second).then(a.x.total_cmp(&b.x)).then(a.y.total_cmp(&b.y))
        });
        let edges = edges.into_iter().map(|(_, side)| side).collect();
        let walks = (0..found.walk_ends.len()).map(|walk| boundary(found, walk)).collect();
        Self { points: curves.points, edges, faces: found.faces as usize, walks }
    }

    /// How every curve winds around every face. Across an edge from right to
    /// left a curve along it winds once more, one against it once less.
    pub fn windings(&self) -> Vec<Windings> {
        let mut across = vec![Vec::new(); self.faces];
        for (number, edge) in self.edges.iter().enumerate() {
            across[edge.left].push((edge.right, number, -1));
            across[edge.right].push((edge.left, number, 1));
        }
        let mut found: Vec<Option<Windings>> = vec![None; self.faces];
        found[UNBOUNDED] = Some(Vec::new());
        let mut queue = VecDeque::from([UNBOUNDED]);
        while let Some(face) = queue.pop_front() {
            for &(neighbour, edge, sign) in &across[face] {
                if found[neighbour].is_none() {
                    let here = found[face].as_ref().cloned().unwrap_or_default();
                    found[neighbour] = Some(wound(here, &self.edges[edge].covers, sign));
                    queue.push_back(neighbour);
                }
            }
        }
        found.into_iter().map(Option::unwrap_or_default).collect()
    }

    /// The area of every face in kept coordinates; the unbounded one's is minus
    /// that of all others.
    pub fn areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.faces];
        let origin = self.points.first().copied().unwrap_or_default();
        for edge in &self.edges {
            let [start, end] = [edge.start, edge.end].map(|i| self.points[i as usize] - origin);
            let half = 0.5 * start.perp_dot(end);
            areas[edge.left] += half;
            areas[edge.right] -= half;
        }
        areas
    }

    /// The middle of a face's longest edge: a place to name it by.
    pub fn place(&self, face: usize) -> DVec2 {
        let ends = |edge: &Side| [edge.start, edge.end].map(|i| self.points[i as usize]);
        let length = |edge: &Side| ends(edge)[0].distance_squared(ends(edge)[1]);
        self.edges
            .iter()
            .filter(|edge| edge.left == face || edge.right == face)
            .max_by(|a, b| length(a).total_cmp(&length(b)))
            .map(|edge| ends(edge)[0].midpoint(ends(edge)[1]))
            .unwrap_or_default()
    }

    /// The section whose faces have these labels: only edges between differing
    /// labels stay, and the vertices they have.
    pub fn section(self, draft: &Draft, labels: &[Label]) -> Section {
        let mut edges: Vec<Edge> = self
            .edges
            .iter()
            .map(|edge| Edge {
                start: edge.start,
                end: edge.end,
                left: labels[edge.left],
                right: labels[edge.right],
            })
            .filter(|edge| edge.left != edge.right)
            .collect();
        let vertices = keep_used(&self.points, &mut edges);
        let (background, normals) = (labels[UNBOUNDED], Vec::new());
        let (name, plane) = (draft.name.to_owned(), draft.plane);
        Section { name, plane, vertices, edges, background, normals }
    }
}

/// The points that edges end in, in their order; the edges are renumbered.
pub(super) fn keep_used(points: &[DVec2], edges: &mut [Edge]) -> Vec<DVec2> {
    let mut numbers = vec![u32::MAX; points.len()];
    for edge in edges.iter() {
        numbers[edge.start as usize] = 0;
        numbers[edge.end as usize] = 0;
    }
    let mut vertices = Vec::new();
    for point in (0..points.len()).filter(|&point| numbers[point] == 0).collect::<Vec<_>>() {
        numbers[point] = vertices.len() as u32;
        vertices.push(points[point]);
    }
    for edge in edges {
        edge.start = numbers[edge.start as usize];
        edge.end = numbers[edge.end as usize];
    }
    vertices
}

/// An edge, directed as the first segment along it, and that segment.
fn side(curves: &Curves, found: &Partition, edge: usize) -> (u32, Side) {
    let mut segments = found.covers_of(edge).to_vec();
    segments.sort_unstable();
    let ascends = |&number: &u32| curves.ascends(curves.segments[number as usize]);
    let along = segments.first().is_none_or(ascends);
    let covers = segments
        .iter()
        .map(|number| Cover {
            curve: curves.segments[*number as usize].curve,
            forward: ascends(number) == along,
        })
        .collect();
    let [first, second] = found.ends(edge).map(|vertex| found.inputs[vertex]);
    let [left, right] = [2, 3].map(|field| found.edges[4 * edge + field] as usize);
    let side = if along {
        Side { start: first, end: second, left, right, covers }
    } else {
        Side { start: second, end: first, left: right, right: left, covers }
    };
    (segments.first().copied().unwrap_or(u32::MAX), side)
}

/// A walk by the vertices that its half-edges start from.
fn boundary(found: &Partition, walk: usize) -> Walk {
    let vertices = found.walks[part(&found.walk_ends, walk)]
        .iter()
        .map(|&halfedge| {
            let ends = found.ends(halfedge as usize / 2);
            found.inputs[ends[halfedge as usize % 2]]
        })
        .collect();
    Walk { face: found.walk_faces[walk] as usize, outer: found.walk_outer[walk], vertices }
}

/// Windings on the other side of an edge; `sign` is 1 when that is the left.
fn wound(mut windings: Windings, covers: &[Cover], sign: i32) -> Windings {
    for cover in covers {
        let step = if cover.forward { sign } else { -sign };
        match windings.binary_search_by_key(&cover.curve, |&(curve, _)| curve) {
            Ok(i) => windings[i].1 += step,
            Err(i) => windings.insert(i, (cover.curve, step)),
        }
    }
    windings.retain(|&(_, times)| times != 0);
    windings
}

/// How often a curve winds, given the windings of a face.
pub(super) fn times(windings: &Windings, curve: u32) -> i32 {
    windings.binary_search_by_key(&curve, |&(curve, _)| curve).map_or(0, |i| windings[i].1)
}
