//! Fewer points on smooth borders: chains between junctions, simplified by
//! Douglas and Peucker's method.

use std::collections::BTreeMap;

use glam::DVec3;

use transect::section::Edge;

use super::contours::{Borders, Piece};

/// How far a simplified border may be from the original, in mm.
const TOLERANCE: f64 = 0.1;

/// The edges that remain; points that no edge needs remain unused.
pub fn simplified(borders: &Borders) -> Vec<Edge> {
    chains(borders).iter().flat_map(|chain| simplified_chain(&borders.points, chain)).collect()
}

/// Pieces in a row, each beginning where the one before it ends. All have the
/// same labels.
type Chain = Vec<Piece>;

/// Splits borders at their junctions.
fn chains(borders: &Borders) -> Vec<Chain> {
    let mut degree = vec![0u32; borders.points.len()];
    let mut next: BTreeMap<u32, Piece> = BTreeMap::new();
    for piece in &borders.pieces {
        degree[piece.start as usize] += 1;
        degree[piece.end as usize] += 1;
    }
    let is_inner = |point: u32| degree[point as usize] == 2;
    // An inner point has one piece that leaves it: both have the larger label
    // on their left.
    for piece in borders.pieces.iter().filter(|piece| is_inner(piece.start)) {
        next.insert(piece.start, *piece);
    }
    let mut found = Vec::new();
    for &first in borders.pieces.iter().filter(|piece| !is_inner(piece.start)) {
        found.push(follow(first, &mut next));
    }
    while let Some((_, first)) = next.pop_first() {
        found.push(follow(first, &mut next));
    }
    found
}

fn follow(first: Piece, next: &mut BTreeMap<u32, Piece>) -> Chain {
    let mut chain = vec![first];
    while let Some(piece) = chain.last().and_then(|last| next.remove(&last.end)) {
        chain.push(piece);
    }
    chain
}

fn simplified_chain(points: &[DVec3], chain: &Chain) -> Vec<Edge> {
    let along: Vec<u32> =
        chain.iter().map(|piece| piece.start).chain(chain.last().map(|piece| piece.end)).collect();
    let at = |i: usize| points[along[i] as usize];
    let last = along.len() - 1;
    // The farthest point always stays, and of a loop one on either side of it:
    // nothing collapses.
    let farthest = (0..=last)
        .max_by(|&a, &b| at(a).distance_squared(at(0)).total_cmp(&at(b).distance_squared(at(0))));
    let is_loop = along[0] == along[last];
    let middle = if is_loop { farthest.unwrap_or(0) } else { last / 2 };
    let mut kept = vec![0, last];
    if middle > 0 && middle < last {
        kept.push(middle);
        for range in [[0, middle], [middle, last]] {
            keep(points, &along, range, is_loop, &mut kept);
        }
    }
    kept.sort_unstable();
    let Piece { left, right, .. } = chain[0];
    kept.windows(2)
        .map(|ends| Edge { start: along[ends[0]], end: along[ends[1]], left, right })
        .collect()
}

/// Keeps the point between two others that is farthest from their chord, if it
/// is too far or has to be kept, and so on.
fn keep(
    points: &[DVec3],
    along: &[u32],
    [from, to]: [usize; 2],
    must: bool,
    kept: &mut Vec<usize>,
) {
    let at = |i: usize| points[along[i] as usize];
    let chord = at(to) - at(from);
    let off = |i: usize| {
        let arm = at(i) - at(from);
        let part = (arm.dot(chord) / chord.length_squared()).clamp(0.0, 1.0);
        (arm - part * chord).length()
    };
    let Some(worst) = (from + 1..to).max_by(|&a, &b| off(a).total_cmp(&off(b))) else { return };
    if must || off(worst) > TOLERANCE {
        kept.push(worst);
        keep(points, along, [from, worst], false, kept);
        keep(points, along, [worst, to], false, kept);
    }
}
