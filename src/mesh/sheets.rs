//! The sheets of a surface at edges where it touches itself.
//!
//! Where bodies touch along an edge, more than two triangles of a surface meet there. They
//! belong together in pairs with the inside between them: each pair is a sheet.

use std::collections::HashMap;

use glam::DVec3;

use super::Mesh;
use crate::sets::Sets;

/// An edge of a triangle: its vertices in ascending order, then the triangle
/// and which of its corners the edge starts at.
pub(super) type Side = ([u32; 2], u32, u8);

/// The edges of a surface.
pub(super) struct Sheets<'a> {
    /// Which corners of triangles are the same vertex: sets of `3 * triangle + corner`. Two
    /// corners at one vertex of the network are joined across an edge of a sheet.
    pub corners: Sets,
    /// The edges where sheets touch, by pairs of triangles' sides: one for each sheet.
    /// Triangles that cannot all be paired join nothing: they stay visible as a border.
    pub touching: Vec<Vec<[&'a Side; 2]>>,
}

impl<'a> Sheets<'a> {
    /// `sides` are those of all triangles, sorted.
    pub fn new(mesh: &Mesh, triangles: &[[u32; 3]], sides: &'a [Side]) -> Self {
        let mut corners = Sets::new(3 * triangles.len());
        let mut crowded = Vec::new();
        for around in sides.chunk_by(|one, other| one.0 == other.0) {
            match around {
                [one, other] if is_balanced(triangles, around) => {
                    join_ends(&mut corners, one, other);
                }
                [_] | [_, _] => {}
                _ => crowded.push(around),
            }
        }
        let touching = Crowded::new(mesh, triangles, crowded, &mut corners).paired();
        for [one, other] in touching.iter().flatten() {
            join_ends(&mut corners, one, other);
        }
        Self { corners, touching }
    }
}

/// Edges with more than two triangles.
///
/// Around a vertex, triangles that follow each other across other edges are a *fan*. Where
/// every fan from one crowded edge leads to the same next one, the sheets of the one go on
/// as those of the other, and are paired alike. Their angles may say otherwise: of what is
/// as thin as rounding errors they are accidental, and not the same for both halves of a
/// divided edge.
struct Crowded<'a, 'm> {
    mesh: &'m Mesh,
    triangles: &'m [[u32; 3]],
    edges: Vec<&'a [Side]>,
    /// For every side of every edge the fans at its ends, in the order of the edge's.
    fans: Vec<Vec<[u32; 2]>>,
    /// The edges and their sides at which a fan begins or ends.
    at_fan: HashMap<u32, Vec<[usize; 2]>>,
}

impl<'a, 'm> Crowded<'a, 'm> {
    /// `corners` are joined across all other edges.
    fn new(
        mesh: &'m Mesh,
        triangles: &'m [[u32; 3]],
        edges: Vec<&'a [Side]>,
        corners: &mut Sets,
    ) -> Self {
        let mut fans_of = |side| corners_of(triangles, side).map(|corner| corners.root(corner));
        let fans: Vec<Vec<_>> =
            edges.iter().map(|around| around.iter().map(&mut fans_of).collect()).collect();
        let mut at_fan: HashMap<u32, Vec<[usize; 2]>> = HashMap::new();
        for (edge, sides) in fans.iter().enumerate() {
            for (side, ends) in sides.iter().enumerate() {
                for &fan in ends {
                    at_fan.entry(fan).or_default().push([edge, side]);
                }
            }
        }
        Self { mesh, triangles, edges, fans, at_fan }
    }

    /// The pairs of each edge. The longest edges say best how sheets lie.
    fn paired(&self) -> Vec<Vec<[&'a Side; 2]>> {
        let length = |edge: usize| {
            let [start, end] = self.edges[edge][0].0.map(|end| self.mesh.vertices[end as usize]);
            start.distance(end)
        };
        let mut order: Vec<usize> = (0..self.edges.len()).collect();
        order.sort_by(|&one, &other| length(other).total_cmp(&length(one)).then(one.cmp(&other)));
        let mut pairs: Vec<Option<Vec<[usize; 2]>>> = vec![None; self.edges.len()];
        for first in order {
            if pairs[first].is_some() {
                continue;
            }
            pairs[first] = Some(wedges(self.mesh, self.triangles, self.edges[first]));
            let mut reached = vec![first];
            while let Some(edge) = reached.pop() {
                for (next, beyond) in [0, 1].into_iter().filter_map(|end| self.next(edge, end)) {
                    if pairs[next].is_none() {
                        let own = pairs[edge].iter().flatten();
                        pairs[next] = Some(own.map(|pair| pair.map(|side| beyond[side])).collect());
                        reached.push(next);
                    }
                }
            }
        }
        let sides = |(edge, pairs): (usize, Option<Vec<[usize; 2]>>)| {
            let pairs = pairs.into_iter().flatten();
            pairs.map(|pair| pair.map(|side| &self.edges[edge][side])).collect()
        };
        pairs.into_iter().enumerate().map(sides).collect()
    }

    /// The edge that all fans lead to from one end of an edge, and for each of its sides the
    /// one there.
    fn next(&self, edge: usize, end: usize) -> Option<(usize, Vec<usize>)> {
        let across = |side: usize| match self.at_fan[&self.fans[edge][side][end]][..] {
            [one, other] => Some(if one == [edge, side] { other } else { one }),
            _ => None,
        };
        let beyond: Vec<[usize; 2]> =
            (0..self.fans[edge].len()).map(across).collect::<Option<_>>()?;
        let next = beyond[0][0];
        let is_same = next != edge
            && self.fans[next].len() == beyond.len()
            && beyond.iter().all(|&[other, _]| other == next);
        is_same.then(|| (next, beyond.into_iter().map(|[_, side]| side).collect()))
    }
}

/// Whether as many triangles pass an edge one way as the other.
fn is_balanced(triangles: &[[u32; 3]], around: &[Side]) -> bool {
    2 * around.iter().filter(|side| runs_along(triangles, side)).count() == around.len()
}

fn runs_along(triangles: &[[u32; 3]], side: &Side) -> bool {
    starts_at(triangles, side) == side.0[0]
}

/// The pairs of triangles at an edge with the inside between them, as positions in `around`.
fn wedges(mesh: &Mesh, triangles: &[[u32; 3]], around: &[Side]) -> Vec<[usize; 2]> {
    if !is_balanced(triangles, around) {
        return Vec::new();
    }
    // Around the edge, counter-clockwise as seen against it, the inside is behind a
    // triangle that runs along the edge and ahead of one that runs against it.
    let angles: Vec<f64> = around.iter().map(|side| angle(mesh, triangles, side)).collect();
    let mut left: Vec<usize> = (0..around.len()).collect();
    left.sort_by(|&one, &other| angles[one].total_cmp(&angles[other]).then(one.cmp(&other)));
    let along = |at: usize| runs_along(triangles, &around[at]);
    let mut found = Vec::new();
    while let Some(first) =
        (0..left.len()).find(|&at| !along(left[at]) && along(left[(at + 1) % left.len()]))
    {
        let pair = [left[first], left[(first + 1) % left.len()]];
        found.push(pair);
        left.retain(|side| !pair.contains(side));
    }
    found
}

/// The direction of a triangle around one of its edges.
fn angle(mesh: &Mesh, triangles: &[[u32; 3]], side: &Side) -> f64 {
    let [start, end] = side.0.map(|vertex| mesh.vertices[vertex as usize]);
    let apex = triangles[side.1 as usize][(usize::from(side.2) + 2) % 3];
    let along = (end - start).normalize_or(DVec3::Z);
    let [first, second] = along.any_orthonormal_pair().into();
    // The pair and the edge must be a right-handed frame, whatever its convention.
    let turn = first.cross(second).dot(along).signum();
    let out = mesh.vertices[apex as usize] - start;
    (turn * out.dot(second)).atan2(out.dot(first))
}

/// Joins the corners at the ends of an edge that two triangles pass in opposite
/// directions.
pub(super) fn join_ends(corners: &mut Sets, one: &Side, other: &Side) {
    corners.join(3 * one.1 + u32::from(one.2), 3 * other.1 + next(other.2));
    corners.join(3 * one.1 + next(one.2), 3 * other.1 + u32::from(other.2));
}

/// A triangle's corners at the ends of an edge, in the order of the edge's.
pub(super) fn corners_of(triangles: &[[u32; 3]], side: &Side) -> [u32; 2] {
    let [from, to] = [u32::from(side.2), next(side.2)].map(|corner| 3 * side.1 + corner);
    if runs_along(triangles, side) { [from, to] } else { [to, from] }
}

fn next(corner: u8) -> u32 {
    u32::from((corner + 1) % 3)
}

/// The vertex that a triangle passes the edge from.
pub(super) fn starts_at(triangles: &[[u32; 3]], side: &Side) -> u32 {
    triangles[side.1 as usize][usize::from(side.2)]
}
