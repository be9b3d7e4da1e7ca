//! Fewer points on contours that run nearly straight.
//!
//! D. Douglas and T. Peucker, Algorithms for the reduction of the number of points required to
//! represent a digitized line or its caricature, Cartographica 10, 1973. Points where more than
//! two edges meet stay.

use glam::DVec2;

use super::trace::Contours;
use crate::label::Label;
use crate::section::Edge;

const NONE: u32 = u32::MAX;

impl Contours {
    /// The same within a distance, in pixels.
    pub fn simplified(&self, tolerance: f64) -> Self {
        let mut reduced = Self::default();
        let mut numbers = vec![NONE; self.points.len()];
        for (chain, [left, right]) in self.chains() {
            let kept = kept(
                &chain.iter().map(|&own| self.points[own as usize]).collect::<Vec<_>>(),
                tolerance,
            );
            let mut add = |own: usize| {
                let number = &mut numbers[chain[own] as usize];
                if *number == NONE {
                    *number = reduced.points.len() as u32;
                    reduced.points.push(self.points[chain[own] as usize]);
                }
                *number
            };
            let ends: Vec<u32> = kept.into_iter().map(&mut add).collect();
            let edges =
                ends.windows(2).map(|pair| Edge { start: pair[0], end: pair[1], left, right });
            reduced.edges.extend(edges);
        }
        reduced
    }

    /// The points along curves from one place where edges meet to the next, or around: then the
    /// last is the first. With the labels on their left and right.
    pub fn chains(&self) -> Vec<(Vec<u32>, [Label; 2])> {
        let mut around: Vec<Vec<u32>> = vec![Vec::new(); self.points.len()];
        for (number, edge) in (0u32..).zip(&self.edges) {
            for end in [edge.start, edge.end] {
                around[end as usize].push(number);
            }
        }
        let mut done = vec![false; self.edges.len()];
        let mut chains = Vec::new();
        let is_meeting = |point: u32| around[point as usize].len() != 2;
        // Those between meetings first: what is left are closed curves.
        let meetings = (0..self.edges.len()).flat_map(|number| {
            let edge = &self.edges[number];
            [edge.start, edge.end]
                .map(|end| (number, end))
                .into_iter()
                .filter(|&(_, end)| is_meeting(end))
        });
        let any = (0..self.edges.len()).map(|number| (number, self.edges[number].start));
        for (first, start) in meetings.chain(any) {
            if done[first] {
                continue;
            }
            let edge = &self.edges[first];
            let sides =
                if start == edge.start { [edge.left, edge.right] } else { [edge.right, edge.left] };
            let (mut chain, mut number) = (vec![start], first);
            while !std::mem::replace(&mut done[number], true) {
                let edge = &self.edges[number];
                let last = chain[chain.len() - 1];
                let next = if edge.start == last { edge.end } else { edge.start };
                chain.push(next);
                if is_meeting(next) {
                    break;
                }
                let both = &around[next as usize];
                number = if both[0] as usize == number { both[1] } else { both[0] } as usize;
            }
            chains.push((chain, sides));
        }
        chains
    }
}

/// Which points of a curve are kept; of a closed one, whose last is its first, four at least.
fn kept(points: &[DVec2], tolerance: f64) -> Vec<usize> {
    let last = points.len() - 1;
    let mut kept = vec![0, last];
    if points[0] == points[last] {
        // A third and a fourth of it, so that it keeps an area.
        kept.extend([last / 3, 2 * last / 3]);
        kept.sort_unstable();
        kept.dedup();
    }
    let mut open: Vec<[usize; 2]> = kept.windows(2).map(|pair| [pair[0], pair[1]]).collect();
    while let Some([from, to]) = open.pop() {
        let way = points[to] - points[from];
        let length = way.length_squared().max(f64::MIN_POSITIVE);
        let off = |own: usize| {
            let offset = points[own] - points[from];
            let along = (offset.dot(way) / length).clamp(0.0, 1.0);
            (offset - along * way).length()
        };
        let farthest = (from + 1..to).map(|own| (off(own), own));
        let farthest = farthest.max_by(|one, other| one.0.total_cmp(&other.0));
        if let Some((_, own)) = farthest.filter(|&(off, _)| off > tolerance) {
            kept.push(own);
            open.extend([[from, own], [own, to]]);
        }
    }
    kept.sort_unstable();
    kept
}
