//! The outlines of unknown regions as they are triangulated: chains of edges
//! beside one known label, simplified, and cut into pieces.
//!
//! Outlines can be as fine as contours or as pixels, and every vertex would be
//! a corner, though what is completed inside is smooth. A chain between two
//! fixed points is replaced by a coarser one that stays close to it. On the
//! strip between them the unknown region and the known one overlap or leave a
//! gap; both say the same there, because shares tend to the known label at the
//! outline. Fixed are the points where labels change along an outline and those
//! on lines where other planes cross.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use crate::complex::{Complex, FacetEdge};
use crate::field::places::{key, pieces, step};
use crate::label::Label;

/// How far simplified chains stray, as a part of the spacing: a voxel at 256
/// voxels and the default spacing.
const STRAY: f64 = 1.0 / 16.0;

/// Points and segments around the unknown regions of a plane.
#[derive(Default)]
pub(super) struct Outlines {
    /// World units, all on the plane.
    pub points: Vec<DVec3>,
    numbers: HashMap<[u64; 3], u32>,
    /// Pairs of points, unknown on the left.
    pub segments: Vec<[u32; 2]>,
    /// The face that each segment's unknown region lies on.
    pub faces: Vec<u32>,
    /// What is known to the right of a segment.
    pub labels: HashMap<[u32; 2], Label>,
    /// Points nearer to each other are one.
    step: f64,
}

/// The edges of one face beside unknown regions.
#[derive(Default)]
struct Rim {
    /// Edges to known regions on the same face, by their label.
    chains: BTreeMap<Label, Vec<[DVec3; 2]>>,
    /// Edges on the face's border.
    border: Vec<[DVec3; 2]>,
}

impl Outlines {
    /// Those of the unknown regions on some faces of a plane, in pieces of
    /// about `spacing` (world units) at most.
    pub fn new(complex: &Complex, faces: &[u32], spacing: f64) -> Self {
        let rims: Vec<(u32, Rim)> =
            faces.iter().map(|&face| (face, Rim::new(&complex.facets()[face].edges))).collect();
        let step = step(complex.bounds());
        let fixed = fixed(rims.iter().map(|(_, rim)| rim), step);
        let mut outlines = Self { step, ..Self::default() };
        for (face, rim) in &rims {
            for &[start, end] in &rim.border {
                outlines.add(*face, [start, end], None, spacing);
            }
            for (&label, edges) in &rim.chains {
                for chain in chains(edges, &fixed, step) {
                    for ends in simplified(&chain, STRAY * spacing).windows(2) {
                        outlines.add(*face, [ends[0], ends[1]], Some(label), spacing);
                    }
                }
            }
        }
        outlines
    }

    /// Adds a segment in equal pieces, the same ones from either end.
    fn add(&mut self, face: u32, [start, end]: [DVec3; 2], label: Option<Label>, spacing: f64) {
        for ends in pieces([start, end], spacing, self.step).windows(2) {
            let segment = [ends[0], ends[1]].map(|end| self.number(end));
            self.segments.push(segment);
            self.faces.push(face);
            if let Some(label) = label {
                self.labels.insert(segment, label);
            }
        }
    }

    fn number(&mut self, point: DVec3) -> u32 {
        let next = self.points.len() as u32;
        let number = *self.numbers.entry(key(point, self.step)).or_insert(next);
        if number == next {
            self.points.push(point);
        }
        number
    }
}

impl Rim {
    fn new(edges: &[FacetEdge]) -> Self {
        let mut rim = Self::default();
        for &FacetEdge { start, end, left, right } in edges.iter().filter(|e| e.start != e.end) {
            match (left, right) {
                (Label::UNKNOWN, None) => rim.border.push([start, end]),
                (Label::UNKNOWN, Some(label)) => {
                    rim.chains.entry(label).or_default().push([start, end]);
                }
                (label, Some(Label::UNKNOWN)) => {
                    rim.chains.entry(label).or_default().push([end, start]);
                }
                _ => {}
            }
        }
        rim
    }
}

/// The points at which chains end: all but those between two edges of one
/// chain.
fn fixed<'a>(rims: impl Iterator<Item = &'a Rim> + Clone, step: f64) -> HashMap<[u64; 3], bool> {
    let mut degrees: HashMap<[u64; 3], (u32, bool)> = HashMap::new();
    for rim in rims {
        let borders = rim.border.iter().map(|edge| (edge, true));
        let chains = rim.chains.values().flatten().map(|edge| (edge, false));
        for (edge, border) in borders.chain(chains) {
            for &point in edge {
                let (degree, on_border) = degrees.entry(key(point, step)).or_default();
                *degree += 1;
                *on_border |= border;
            }
        }
    }
    degrees.into_iter().map(|(point, (degree, border))| (point, degree != 2 || border)).collect()
}

/// Edges of one label in sequences between fixed points; where there is none,
/// closed.
fn chains(edges: &[[DVec3; 2]], fixed: &HashMap<[u64; 3], bool>, step: f64) -> Vec<Vec<DVec3>> {
    let key = |point: DVec3| key(point, step);
    let is_fixed = |point: DVec3| fixed.get(&key(point)).copied().unwrap_or(true);
    let mut leaving: HashMap<[u64; 3], usize> = HashMap::new();
    let mut arriving: HashMap<[u64; 3], usize> = HashMap::new();
    for (index, [start, end]) in edges.iter().enumerate() {
        leaving.insert(key(*start), index);
        arriving.insert(key(*end), index);
    }
    // Between two labels that alternate, a point that is not fixed is one where
    // the chain ends too.
    let ends = |point: DVec3| {
        is_fixed(point) || !leaving.contains_key(&key(point)) || !arriving.contains_key(&key(point))
    };
    let (open, mut closed): (Vec<usize>, Vec<usize>) =
        (0..edges.len()).partition(|&index| ends(edges[index][0]));
    // A closed one keeps its beginning: any point, but the same whatever the edges' order.
    closed.sort_by_key(|&index| key(edges[index][0]));
    let mut used = vec![false; edges.len()];
    let mut chains = Vec::new();
    for first in open.into_iter().chain(closed) {
        let mut chain = vec![edges[first][0]];
        let mut next = Some(first).filter(|&index| !used[index]);
        while let Some(index) = next {
            used[index] = true;
            let end = edges[index][1];
            chain.push(end);
            let free = !ends(end);
            next = leaving.get(&key(end)).copied().filter(|&index| free && !used[index]);
        }
        if chain.len() > 1 {
            chains.push(chain);
        }
    }
    chains
}

/// Douglas and Peucker's simplification: a subsequence from whose pieces no
/// point is farther than `stray`. A closed chain keeps its first point and the
/// one farthest from it.
fn simplified(chain: &[DVec3], stray: f64) -> Vec<DVec3> {
    let last = chain.len() - 1;
    let mut kept = vec![false; chain.len()];
    kept[0] = true;
    kept[last] = true;
    let mut spans = vec![(0, last)];
    while let Some((first, last)) = spans.pop() {
        let [start, end] = [chain[first], chain[last]];
        let off = |&index: &usize| off_segment(chain[index], start, end);
        let worst = (first + 1..last).max_by(|one, other| off(one).total_cmp(&off(other)));
        if let Some(worst) = worst.filter(|worst| start == end || off(worst) > stray) {
            kept[worst] = true;
            spans.extend([(first, worst), (worst, last)]);
        }
    }
    chain.iter().zip(kept).filter(|&(_, kept)| kept).map(|(&point, _)| point).collect()
}

fn off_segment(point: DVec3, start: DVec3, end: DVec3) -> f64 {
    let (d, to) = (end - start, point - start);
    let squared = d.length_squared();
    let along = if squared > 0.0 { (to.dot(d) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (to - along * d).length()
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1e-12;

    #[test]
    fn simplified_chains_stay_close() {
        let wave: Vec<DVec3> = (0..=200)
            .map(|i| DVec3::new(f64::from(i) * 0.01, (f64::from(i) * 0.05).sin(), 0.0))
            .collect();
        let coarse = simplified(&wave, 0.02);
        assert!(coarse.len() < 30, "{}", coarse.len());
        assert_eq!([coarse[0], coarse[coarse.len() - 1]], [wave[0], wave[200]]);
        for &point in &wave {
            let off = |ends: &[DVec3]| off_segment(point, ends[0], ends[1]);
            assert!(coarse.windows(2).map(off).fold(f64::INFINITY, f64::min) <= 0.02);
        }
    }

    /// A square around which two labels take turns: four chains, whose ends are
    /// where the label changes.
    #[test]
    fn chains_end_where_labels_change() {
        let corner = |i: u32| {
            DVec3::new(
                f64::from(u8::from(i % 4 == 1 || i % 4 == 2)),
                f64::from(u8::from(i % 4 > 1)),
                0.0,
            )
        };
        let edge = |i: u32, label: u32| FacetEdge {
            start: corner(i),
            end: corner(i + 1),
            left: Label::UNKNOWN,
            right: Some(Label(label)),
        };
        let rim = Rim::new(&[edge(0, 1), edge(1, 1), edge(2, 2), edge(3, 2)]);
        let fixed = fixed([&rim].into_iter(), STEP);
        for label in [1, 2] {
            let chains = chains(&rim.chains[&Label(label)], &fixed, STEP);
            assert_eq!(chains.iter().map(Vec::len).collect::<Vec<_>>(), [3]);
        }
        let whole = Rim::new(&[edge(0, 1), edge(1, 1), edge(2, 1), edge(3, 1)]);
        let chains =
            chains(&whole.chains[&Label(1)], &super::fixed([&whole].into_iter(), STEP), STEP);
        assert_eq!(chains.len(), 1);
        assert_eq!(chains[0].len(), 5);
        assert_eq!(simplified(&chains[0], 0.1).len(), 5);
    }

    #[test]
    fn pieces_are_the_same_from_either_end() {
        let [start, end] = [DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.7, -0.4, 0.9)];
        let mut outlines = Outlines { step: STEP, ..Outlines::default() };
        outlines.add(0, [start, end], None, 0.3);
        let points = outlines.points.len();
        // A length of 1.81 makes seven pieces.
        assert_eq!(points, 8);
        outlines.add(1, [end, start], Some(Label(1)), 0.3);
        assert_eq!(outlines.points.len(), points);
        assert_eq!(outlines.labels.len(), 7);
    }
}
