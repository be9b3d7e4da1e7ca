//! Simplifying the curves where surfaces meet or end, in the network itself: a vertex becomes
//! part of the next one along its curve, and all surfaces there follow.
//!
//! ```text
//!  x───y───z            x───y───z
//!  │ ╲ │ ╱ │            │ ╲ │  ╱│
//!  u───v───w     ─►     u──╲┴─╱─w      the distance of v from u w is what it costs
//!  │ ╱ │ ╲ │            │   ╲╱  │
//! ```
//!
//! Nothing changes in how parts hang together if the link condition holds (Dey et al. 1999): only
//! the corners of triangles at the edge from u to v are next to both, and u and w are not next to
//! each other along a curve yet.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use glam::DVec3;

use super::deviation::to_segment;
use super::reduced::Reduced;
use super::sheets;
use crate::error::Result;
use crate::label::Label;
use crate::mesh::network::Ends;

/// The cosine of the angle that a triangle may turn by in a step.
const UPRIGHT: f64 = 0.5;
/// How much the length of the new edge counts against the distance from it: where a curve is
/// straight the shortest edges go first.
const SHORT: f64 = 1e-2;

impl Reduced {
    /// Makes curves simpler until this share of their vertices is left, or none can go.
    ///
    /// # Errors
    /// When an edge that is kept has a vertex that the mesh has not.
    pub fn reduce_curves(&mut self, share: f64) -> Result<()> {
        let curves = sheets::curves(&self.network()?);
        if curves.is_empty() {
            return Ok(());
        }
        let mut work = Work::new(self, &curves);
        work.run(share);
        let Work { is_there, into, .. } = work;
        let mut is_there = is_there.into_iter();
        let mut sides = is_there.clone();
        self.mesh.triangles.retain(|_| is_there.next().unwrap_or(true));
        self.mesh.sides.retain(|_| sides.next().unwrap_or(true));
        self.renumber(&into);
        Ok(())
    }

    /// Leaves out vertices that became part of others.
    fn renumber(&mut self, into: &[u32]) {
        let mut to = vec![0; into.len()];
        let mut vertices = Vec::new();
        for (vertex, &place) in self.mesh.vertices.iter().enumerate() {
            if into[vertex] as usize == vertex {
                to[vertex] = vertices.len() as u32;
                vertices.push(place);
            }
        }
        for vertex in 0..into.len() {
            let mut there = vertex;
            while into[there] as usize != there {
                there = into[there] as usize;
            }
            to[vertex] = to[there];
        }
        for corner in self.mesh.triangles.as_flattened_mut() {
            *corner = to[*corner as usize];
        }
        self.mesh.vertices = vertices;
        self.follow(&to, self.mesh.vertices.len());
    }
}

/// A network whose curves become simpler.
struct Work<'a> {
    reduced: &'a mut Reduced,
    /// For every triangle whether it is there.
    is_there: Vec<bool>,
    /// The triangles at every vertex, with some that are no more.
    around: Vec<Vec<u32>>,
    /// The next vertices along curves.
    along: Vec<Vec<u32>>,
    /// The vertices that edges stand for.
    passed: BTreeMap<Ends, Vec<u32>>,
    /// The vertex that each became part of; itself where it is there.
    into: Vec<u32>,
    /// Times that what is next to a vertex changed.
    changes: Vec<u32>,
}

impl<'a> Work<'a> {
    fn new(reduced: &'a mut Reduced, curves: &[Ends]) -> Self {
        let count = reduced.mesh.vertices.len();
        let mut around = vec![Vec::new(); count];
        for (triangle, corners) in reduced.mesh.triangles.iter().enumerate() {
            corners.iter().for_each(|&corner| around[corner as usize].push(triangle as u32));
        }
        let mut along = vec![Vec::new(); count];
        for &[one, other] in curves {
            along[one as usize].push(other);
            along[other as usize].push(one);
        }
        Self {
            is_there: vec![true; reduced.mesh.triangles.len()],
            around,
            along,
            passed: BTreeMap::new(),
            into: (0..count as u32).collect(),
            changes: vec![0; count],
            reduced,
        }
    }

    fn run(&mut self, share: f64) {
        let all: Vec<u32> =
            (0..self.into.len() as u32).filter(|&vertex| self.is_on_one_curve(vertex)).collect();
        let mut left = all.len() - (share * all.len() as f64) as usize;
        let mut queue: BinaryHeap<_> =
            all.into_iter().map(|vertex| Reverse(self.offer(vertex))).collect();
        while let (true, Some(Reverse((_, vertex, changes)))) = (left > 0, queue.pop()) {
            if self.changes[vertex as usize] != changes || !self.is_on_one_curve(vertex) {
                continue;
            }
            let ends = self.ends(vertex);
            if !self.remove(vertex) {
                continue;
            }
            left -= 1;
            for end in ends {
                self.changes[end as usize] += 1;
                if self.is_on_one_curve(end) {
                    queue.push(Reverse(self.offer(end)));
                }
            }
        }
    }

    /// Whether a vertex is in the course of a curve, with the same surfaces before and after it
    /// and no other that touches there.
    fn is_on_one_curve(&self, vertex: u32) -> bool {
        let &[one, other] = &self.along[vertex as usize][..] else { return false };
        let is_kept = |end: u32| self.reduced.kept.contains(&ends(vertex, end));
        one != other
            && is_kept(one) == is_kept(other)
            && self.sides_at(vertex, one) == self.sides_at(vertex, other)
            && self.is_one_fan(vertex)
    }

    /// What it costs to remove a vertex, to be sorted by, with its number and its changes so far.
    fn offer(&self, vertex: u32) -> (u64, u32, u32) {
        let [one, other] = self.ends(vertex).map(|end| self.place(end));
        let cost = self.distance(vertex) + SHORT * one.distance(other);
        // Of numbers that are not negative bits are in the order of values.
        (cost.to_bits(), vertex, self.changes[vertex as usize])
    }

    /// The largest distance from the edge that would pass by a vertex to all that were there.
    fn distance(&self, vertex: u32) -> f64 {
        let [one, other] = self.ends(vertex);
        let [from, to] = [one, other].map(|end| self.place(end));
        let before = [one, other].map(|end| self.passed.get(&ends(vertex, end)));
        let before = before.into_iter().flatten().flatten().copied();
        before
            .chain([vertex])
            .map(|passed| to_segment(self.place(passed), from, to))
            .fold(0.0, f64::max)
    }

    /// Makes a vertex part of the nearer of its neighbours on the curve, or else of the other;
    /// whether it can be.
    fn remove(&mut self, vertex: u32) -> bool {
        let [mut near, mut far] = self.ends(vertex);
        let Reduced { limits, reached, .. } = &*self.reduced;
        let so_far = [vertex, near, far].map(|own| reached[own as usize]);
        let distance = so_far.into_iter().fold(0.0, f64::max) + self.distance(vertex);
        if distance > limits[vertex as usize] {
            return false;
        }
        let length = |end: u32| self.place(vertex).distance(self.place(end));
        if length(far) < length(near) {
            (near, far) = (far, near);
        }
        for [to, beyond] in [[near, far], [far, near]] {
            if self.can_become(vertex, to, beyond) {
                self.join(vertex, to, beyond, distance);
                return true;
            }
        }
        false
    }

    fn can_become(&self, vertex: u32, to: u32, beyond: u32) -> bool {
        let (own, others) = (self.neighbours(vertex), self.neighbours(to));
        let common: BTreeSet<u32> = own.intersection(&others).copied().collect();
        let at_edge = |corners: &[u32; 3]| corners.contains(&to);
        let apexes: BTreeSet<u32> = (self.triangles(vertex).map(|(_, corners)| corners))
            .filter(at_edge)
            .flatten()
            .filter(|corner| ![vertex, to].contains(corner))
            .collect();
        if common != apexes || self.along[to as usize].contains(&beyond) {
            return false;
        }
        self.triangles(vertex).filter(|(_, corners)| !at_edge(corners)).all(|(_, corners)| {
            let after = corners.map(|corner| if corner == vertex { to } else { corner });
            let is_same = |other: &[u32; 3]| after.iter().all(|corner| other.contains(corner));
            !self.triangles(to).any(|(_, other)| is_same(&other)) && self.is_upright(corners, after)
        })
    }

    /// Whether a triangle does not turn too far.
    fn is_upright(&self, before: [u32; 3], after: [u32; 3]) -> bool {
        let [was, is] = [before, after].map(|corners| {
            let [a, b, c] = corners.map(|corner| self.place(corner));
            (b - a).cross(c - a)
        });
        was.dot(is) > UPRIGHT * was.length() * is.length()
    }

    fn join(&mut self, vertex: u32, to: u32, beyond: u32, distance: f64) {
        for triangle in std::mem::take(&mut self.around[vertex as usize]) {
            let corners = &mut self.reduced.mesh.triangles[triangle as usize];
            if corners.contains(&to) {
                self.is_there[triangle as usize] = false;
            } else {
                *corners = corners.map(|corner| if corner == vertex { to } else { corner });
                self.around[to as usize].push(triangle);
            }
        }
        let is_there = &self.is_there;
        self.around[to as usize].retain(|&triangle| is_there[triangle as usize]);
        for (end, next) in [(to, beyond), (beyond, to)] {
            let along = &mut self.along[end as usize];
            along.retain(|&other| other != vertex);
            along.push(next);
        }
        let mut passed = vec![vertex];
        for end in [to, beyond] {
            passed.extend(self.passed.remove(&ends(vertex, end)).unwrap_or_default());
            if self.reduced.kept.remove(&ends(vertex, end)) {
                self.reduced.kept.insert(ends(to, beyond));
            }
        }
        self.passed.insert(ends(to, beyond), passed);
        self.into[vertex as usize] = to;
        let [vertex, to] = [vertex, to].map(|own| own as usize);
        let Reduced { limits, reached, .. } = &mut *self.reduced;
        limits[to] = limits[to].min(limits[vertex]);
        // 0 would say that nothing became part of it.
        let least = f64::MIN_POSITIVE;
        reached[to] = reached[to].max(reached[vertex]).max(distance).max(least);
    }

    fn place(&self, vertex: u32) -> DVec3 {
        self.reduced.mesh.vertices[vertex as usize]
    }

    /// The next vertices of one on one curve.
    fn ends(&self, vertex: u32) -> [u32; 2] {
        let along = &self.along[vertex as usize];
        [along[0], along[1]]
    }

    /// The triangles at a vertex and their corners.
    fn triangles(&self, vertex: u32) -> impl Iterator<Item = (u32, [u32; 3])> {
        let there = self.around[vertex as usize].iter().copied();
        let there = there.filter(|&triangle| self.is_there[triangle as usize]);
        there.map(|triangle| (triangle, self.reduced.mesh.triangles[triangle as usize]))
    }

    fn neighbours(&self, vertex: u32) -> BTreeSet<u32> {
        let corners = self.triangles(vertex).flat_map(|(_, corners)| corners);
        corners.filter(|&corner| corner != vertex).collect()
    }

    /// The labels on both sides of the triangles at an edge, sorted.
    fn sides_at(&self, vertex: u32, end: u32) -> Vec<[Label; 2]> {
        let at_edge = self.triangles(vertex).filter(|(_, corners)| corners.contains(&end));
        let mut sides: Vec<_> =
            at_edge.map(|(triangle, _)| self.reduced.mesh.sides[triangle as usize]).collect();
        sides.sort_unstable();
        sides
    }

    /// Whether all triangles at a vertex hang together across edges that end there.
    fn is_one_fan(&self, vertex: u32) -> bool {
        let mut apart: Vec<[u32; 3]> = self.triangles(vertex).map(|(_, corners)| corners).collect();
        let mut reached: BTreeSet<u32> = apart.pop().into_iter().flatten().collect();
        reached.remove(&vertex);
        loop {
            let was = apart.len();
            apart.retain(|corners| {
                let is_next = corners.iter().any(|corner| reached.contains(corner));
                if is_next {
                    reached.extend(corners.iter().filter(|&&corner| corner != vertex));
                }
                !is_next
            });
            if apart.is_empty() || apart.len() == was {
                return apart.is_empty();
            }
        }
    }
}

fn ends(one: u32, other: u32) -> Ends {
    [one.min(other), one.max(other)]
}
