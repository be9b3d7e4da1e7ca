//! Curves that nearly touch are made to touch, so that no sliver is left between them.
//!
//! ```text
//!    a ── b ── c               a ─ b ─ c        points that near are one of them;
//!    d ─────── e       ⟶       └───┴───┘        edges are led through points that near,
//!    ═════ fixed ═════                          but a fixed edge draws the points onto itself
//! ```
//!
//! The tolerance is a distance in world units. Nothing that is farther apart is moved, and what
//! lies exactly on an edge is left to the subdivision. Points go to one that stays where it is,
//! so a chain of points that near is not drawn together. Afterwards no point is that near to
//! another or to an edge: snapping once more moves nothing.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};

use super::subdivision::{Curves, Segment};
use crate::plane::Plane;
use crate::segments::SegmentTree;

/// An edge that is led through a point may come near another one; each pass moves it by the
/// tolerance at most, and two are common.
const PASSES: usize = 8;

impl Curves {
    /// Makes what is nearer than the tolerance touch; says how many points that concerns.
    pub fn snap(&mut self, plane: &Plane, tolerance: f64) -> usize {
        let size =
            self.points.iter().fold(0.0_f64, |size, point| size.max(point.abs().max_element()));
        // Below that it is rounding of the coordinates themselves.
        if !tolerance.is_finite() || tolerance <= f64::EPSILON * size {
            return 0;
        }
        let mut moved = BTreeSet::new();
        for _ in 0..PASSES {
            let near = Near::new(self, plane, tolerance);
            if !self.join_points(&near, &mut moved) && !self.lead_edges(&near, &mut moved) {
                break;
            }
        }
        moved.len()
    }

    fn is_fixed(&self, curve: u32) -> bool {
        self.fixed.is_some_and(|first| curve >= first)
    }

    /// Replaces every point by the nearest that stays, if one is near enough: one of a fixed
    /// curve if it can be, else one that comes earlier. Says whether there were any.
    fn join_points(&mut self, near: &Near, moved: &mut BTreeSet<u32>) -> bool {
        let mut stays = vec![false; self.points.len()];
        let mut place: Vec<u32> = (0..self.points.len() as u32).collect();
        let (first, then): (Vec<u32>, Vec<u32>) =
            near.used().partition(|&point| near.fixed[point as usize]);
        for point in first.into_iter().chain(then) {
            let others = near.points(point).filter(|&(_, other)| stays[other as usize]);
            match others.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))) {
                Some((_, other)) => {
                    place[point as usize] = other;
                    moved.insert(point);
                }
                None => stays[point as usize] = true,
            }
        }
        let is_any = place.iter().zip(0..).any(|(&place, own)| place != own);
        if is_any {
            for Segment { start, end, curve } in std::mem::take(&mut self.segments) {
                self.segment(curve as usize, place[start as usize], place[end as usize]);
            }
        }
        is_any
    }

    /// Leads every edge through the points that are nearly on it; first, points that are nearly on
    /// a fixed edge are moved there, as exactly as doubles can. Says whether there were any.
    fn lead_edges(&mut self, near: &Near, moved: &mut BTreeSet<u32>) -> bool {
        let mut through: BTreeMap<[u32; 2], Vec<(f64, u32)>> = BTreeMap::new();
        let mut place: Vec<u32> = (0..self.points.len() as u32).collect();
        for point in near.used() {
            let on: Vec<(f64, usize)> = near.edges(point, &self.points).collect();
            if on.is_empty() {
                continue;
            }
            moved.insert(point);
            for &(part, edge) in &on {
                through.entry(near.pairs[edge]).or_default().push((part, point));
            }
            let fixed = on.iter().find(|&&(_, edge)| near.is_fixed_edge[edge]);
            if let Some(&(part, edge)) = fixed.filter(|_| !near.fixed[point as usize]) {
                let [start, end] = near.pairs[edge].map(|end| self.points[end as usize]);
                place[point as usize] = self.point(start + part * (end - start));
            }
        }
        if through.is_empty() {
            return false;
        }
        through.values_mut().for_each(|on| on.sort_by(|a, b| a.0.total_cmp(&b.0)));
        for Segment { start, end, curve } in std::mem::take(&mut self.segments) {
            let on = through.get(&[start.min(end), start.max(end)]).map_or(&[][..], Vec::as_slice);
            let mut chain: Vec<u32> = on.iter().map(|&(_, point)| point).collect();
            if start > end {
                chain.reverse();
            }
            chain.insert(0, start);
            chain.push(end);
            for pair in chain.windows(2) {
                let [from, to] = [pair[0], pair[1]].map(|point| place[point as usize]);
                self.segment(curve as usize, from, to);
            }
        }
        true
    }
}

/// Which edges are near to every point.
struct Near {
    tolerance: f64,
    /// The points in space, where distances are measured.
    places: Vec<DVec3>,
    /// The ends of every edge, the smaller number first.
    pairs: Vec<[u32; 2]>,
    /// Whether a fixed curve runs along the edge, or through the point.
    is_fixed_edge: Vec<bool>,
    fixed: Vec<bool>,
    /// The edges that near to a point, its own among them; none for points without edges.
    edges: Vec<Vec<u32>>,
}

impl Near {
    fn new(curves: &Curves, plane: &Plane, tolerance: f64) -> Self {
        let places: Vec<DVec3> = curves.points.iter().map(|&point| plane.lift(point)).collect();
        let shared = curves.shared();
        let pairs: Vec<[u32; 2]> = shared.keys().map(|&(start, end)| [start, end]).collect();
        let along = |segment: &u32| curves.is_fixed(curves.segments[*segment as usize].curve);
        let is_fixed_edge: Vec<bool> =
            shared.values().map(|segments| segments.iter().any(along)).collect();
        let ends = |pair: &[u32; 2]| pair.map(|end| places[end as usize]);
        let tree = SegmentTree::new(pairs.iter().map(ends).collect());
        let mut fixed = vec![false; places.len()];
        let mut edges = vec![Vec::new(); places.len()];
        for (pair, &is_fixed) in pairs.iter().zip(&is_fixed_edge) {
            for end in pair.map(|end| end as usize) {
                fixed[end] |= is_fixed;
                if edges[end].is_empty() {
                    edges[end] = tree.within(tolerance, places[end]);
                }
            }
        }
        Self { tolerance, places, pairs, is_fixed_edge, fixed, edges }
    }

    /// The points that edges end in.
    fn used(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.places.len() as u32).filter(|&point| !self.edges[point as usize].is_empty())
    }

    /// The other points that near, by their distance.
    fn points(&self, point: u32) -> impl Iterator<Item = (f64, u32)> + '_ {
        let own = self.places[point as usize];
        let ends = self.edges[point as usize].iter().flat_map(|&edge| self.pairs[edge as usize]);
        ends.filter(move |&end| end != point)
            .map(move |end| (own.distance(self.places[end as usize]), end))
            .filter(|&(distance, _)| distance <= self.tolerance)
    }

    /// The edges that a point is nearly on, but not exactly, and which part of their length it
    /// is from their beginning.
    fn edges<'a>(
        &'a self,
        point: u32,
        points: &'a [DVec2],
    ) -> impl Iterator<Item = (f64, usize)> + 'a {
        let other = move |&edge: &usize| !self.pairs[edge].contains(&point);
        self.edges[point as usize].iter().map(|&edge| edge as usize).filter(other).filter_map(
            move |edge| {
                let [start, end] = self.pairs[edge].map(|end| self.places[end as usize]);
                let along = end - start;
                let part =
                    (self.places[point as usize] - start).dot(along) / along.length_squared();
                let [a, b] = self.pairs[edge].map(|end| points[end as usize]);
                let is_between = part > 0.0 && part < 1.0;
                (is_between && !is_on(points[point as usize], [a, b])).then_some((part, edge))
            },
        )
    }
}

/// Whether a point is exactly on the line through two others.
fn is_on(point: DVec2, line: [DVec2; 2]) -> bool {
    let [start, end, own] = [line[0], line[1], point].map(|DVec2 { x, y }| Coord { x, y });
    orient2d(start, end, own) == 0.0
}
