//! Contours with the normals of the surface along them (§4.3.1).
//!
//! Where two contours cross, the surface's normal is the cross product of their tangents. Along
//! a contour what is interpolated between crossings is the *tilt*, the angle by which the normal
//! leans out of the section's plane: so the normal is at a right angle to the contour
//! everywhere, and on a sphere it is right everywhere. (The paper interpolates the normals
//! themselves, which is off by 4° midway on a quarter of a great circle.) A contour without
//! crossings, for which the paper takes normals in its plane, leans as the nearest sections
//! before and behind it say: as much as they show more or less of the label around the same
//! place. Where none faces it, it does not lean.
//!
//! What a section itself says of normals ([`Section::normals`]) is known like at a crossing.
//!
//! Tangents are means at vertices, linear along edges, and all the way normalised: those of
//! edges alone are off by half a turn of the polygon.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::label::Label;
use crate::section::{Edge, Section};
use crate::segments::{Hint, SegmentTree};

/// Contours that pass each other at less than this part of the diagonal of all of them cross.
const NEAR: f64 = 5e-3;
/// Normals of sections that face each other enclose an angle with at least this cosine.
const FACING: f64 = 0.7;
/// How much a surface moves within a plane at most, per distance across it: where a section shows
/// nothing near that the next one shows, it is not known how far it moves.
const MOST_LEAN: f64 = 1.0;
/// A normal that lies nearer to the plane's has no part within the plane.
const ALONG: f64 = 1e-6;
/// Where tangents enclose an angle with a sine below this they say nothing of the normal.
const PARALLEL: f64 = 0.1;

/// A piece of a contour between two labels.
#[derive(Debug, Clone, Copy)]
struct Piece {
    ends: [DVec3; 2],
    /// Unit vectors, from the first end to the second.
    tangents: [DVec3; 2],
    /// By how much the surface's normal leans towards the plane's, at the ends, in radians.
    tilts: [f64; 2],
    /// The plane's.
    normal: DVec3,
    /// Left and right of it.
    labels: [Label; 2],
}

/// All contours of one label, with the surface's normals.
#[derive(Debug)]
pub struct Outline {
    label: Label,
    pieces: Vec<Piece>,
    tree: SegmentTree,
}

/// A place on an outline.
#[derive(Debug, Clone, Copy)]
pub struct Foot {
    /// Where it is.
    pub at: DVec3,
    /// How far from the point that it is nearest to.
    pub distance: f64,
    /// The surface's normal, pointing to where the label is.
    pub inward: DVec3,
}

impl Outline {
    /// Of a label, on all sections.
    pub fn new(contours: &Contours, label: Label) -> Self {
        let own = contours.pieces.iter().filter(|piece| piece.labels.contains(&label));
        let pieces: Vec<Piece> = own.copied().collect();
        let tree = SegmentTree::new(pieces.iter().map(|piece| piece.ends).collect());
        Self { label, pieces, tree }
    }

    /// The nearest place to a point, if there is a contour.
    pub fn foot(&self, point: DVec3, hint: &mut Hint) -> Option<Foot> {
        let (nearest, distance) = self.tree.nearest(point, hint)?;
        let piece = &self.pieces[nearest as usize];
        let along = piece.along(point);
        let sign = if piece.labels[0] == self.label { 1.0 } else { -1.0 };
        let at = piece.ends[0].lerp(piece.ends[1], along);
        Some(Foot { at, distance, inward: sign * piece.inward(along) })
    }
}

impl Piece {
    /// Where on it the nearest place to a point is, from 0 to 1.
    fn along(&self, point: DVec3) -> f64 {
        let [start, end] = self.ends;
        let (span, from) = (end - start, point - start);
        let square = span.length_squared();
        if square > 0.0 { (from.dot(span) / square).clamp(0.0, 1.0) } else { 0.0 }
    }

    fn tangent(&self, along: f64) -> DVec3 {
        self.tangents[0].lerp(self.tangents[1], along).normalize_or(self.tangents[0])
    }

    /// Within the plane, to the left.
    fn left(&self, along: f64) -> DVec3 {
        self.normal.cross(self.tangent(along))
    }

    /// The surface's normal, to where the left label is.
    fn inward(&self, along: f64) -> DVec3 {
        let (sine, cosine) = (self.tilts[0] + along * (self.tilts[1] - self.tilts[0])).sin_cos();
        cosine * self.left(along) + sine * self.normal
    }
}

/// All contours between known labels.
#[derive(Debug)]
pub struct Contours {
    pieces: Vec<Piece>,
}

/// A contour between the same two labels, the smaller one on its left.
struct Chain {
    section: usize,
    labels: [Label; 2],
    points: Vec<DVec3>,
    /// At every point.
    tangents: Vec<DVec3>,
    /// The surface's normals that are known, at every point; 0 where they are not.
    normals: Vec<DVec3>,
    is_closed: bool,
}

/// Contours of one section between two labels, to be found from another section.
struct Others {
    tree: SegmentTree,
    /// For every segment its chain and its place in it.
    places: Vec<[u32; 2]>,
}

impl Contours {
    /// Those of some sections; `leans` says whether normals lean out of the sections' planes.
    pub fn new(sections: &[Section], leans: bool) -> Self {
        let chains: Vec<Chain> = sections
            .iter()
            .enumerate()
            .flat_map(|(number, section)| chains(number, section))
            .collect();
        let others = others(&chains);
        let ends = || chains.iter().flat_map(|chain| &chain.points);
        let min = ends().fold(DVec3::INFINITY, |min, &end| min.min(end));
        let max = ends().fold(DVec3::NEG_INFINITY, |max, &end| max.max(end));
        let near = NEAR * (max - min).length();
        let crossing = Crossing { sections, chains: &chains, others: &others, near };
        let pieces = chains.iter().flat_map(|chain| chain.pieces(&crossing, leans)).collect();
        Self { pieces }
    }
}

/// The contours of a section in chains between the same labels.
fn chains(number: usize, section: &Section) -> Vec<Chain> {
    let mut edges: BTreeMap<[Label; 2], Vec<[u32; 2]>> = BTreeMap::new();
    for &Edge { start, end, left, right } in section.edges() {
        if left == Label::UNKNOWN || right == Label::UNKNOWN {
            continue;
        }
        let (labels, edge) = match left < right {
            true => ([left, right], [start, end]),
            false => ([right, left], [end, start]),
        };
        edges.entry(labels).or_default().push(edge);
    }
    let chain = |(labels, edges): ([Label; 2], Vec<[u32; 2]>)| {
        trails(&edges).into_iter().map(move |(trail, is_closed)| {
            let points = trail.iter().map(|&vertex| section.point(vertex)).collect();
            let own = |&vertex: &u32| section.normals().get(vertex as usize).copied();
            let normals = trail.iter().map(|vertex| own(vertex).unwrap_or_default()).collect();
            Chain::new(number, labels, points, is_closed).with(normals)
        })
    };
    edges.into_iter().flat_map(chain).collect()
}

/// Edges in sequences of vertices; a closed one does not name its first vertex again. They end
/// where more than one edge comes or goes.
fn trails(edges: &[[u32; 2]]) -> Vec<(Vec<u32>, bool)> {
    let mut degrees: BTreeMap<u32, [u32; 2]> = BTreeMap::new();
    for [start, end] in edges {
        degrees.entry(*start).or_default()[0] += 1;
        degrees.entry(*end).or_default()[1] += 1;
    }
    let leaving: BTreeMap<u32, usize> =
        edges.iter().enumerate().map(|(edge, [start, _])| (*start, edge)).collect();
    let is_end = |vertex: u32| degrees.get(&vertex) != Some(&[1, 1]);
    let (open, closed): (Vec<usize>, Vec<usize>) =
        (0..edges.len()).partition(|&edge| is_end(edges[edge][0]));
    let mut used = vec![false; edges.len()];
    let mut trails = Vec::new();
    for first in open.into_iter().chain(closed) {
        let mut trail = vec![edges[first][0]];
        let mut next = Some(first).filter(|&edge| !used[edge]);
        while let Some(edge) = next {
            used[edge] = true;
            let end = edges[edge][1];
            trail.push(end);
            next = leaving.get(&end).copied().filter(|&edge| !is_end(end) && !used[edge]);
        }
        if trail.len() > 1 {
            let is_closed = trail.first() == trail.last() && !is_end(trail[0]);
            if is_closed {
                trail.pop();
            }
            trails.push((trail, is_closed));
        }
    }
    trails
}

impl Chain {
    fn new(section: usize, labels: [Label; 2], points: Vec<DVec3>, is_closed: bool) -> Self {
        let count = points.len();
        let direction =
            |edge: usize| (points[(edge + 1) % count] - points[edge % count]).normalize_or_zero();
        let tangent = |point: usize| {
            let before = (is_closed || point > 0).then(|| direction(point + count - 1));
            let after = (is_closed || point + 1 < count).then(|| direction(point));
            let [before, after] = [before, after].map(Option::unwrap_or_default);
            (before + after).normalize_or(after)
        };
        let tangents = (0..count).map(tangent).collect();
        let normals = vec![DVec3::ZERO; count];
        Self { section, labels, points, tangents, normals, is_closed }
    }

    fn with(self, normals: Vec<DVec3>) -> Self {
        Self { normals, ..self }
    }

    /// The tilt at a point where the surface's normal is known. One along the contour says nothing
    /// of it, and of one along the plane's normal it is not known which way it points.
    fn known_tilt(&self, point: usize, normal: DVec3) -> Option<f64> {
        let left = normal.cross(self.tangents[point]);
        let [along, across] = [left, normal].map(|axis| axis.dot(self.normals[point]));
        // It may point either way.
        let sign = if along < 0.0 { -1.0 } else { 1.0 };
        let stands = along.abs() > ALONG * along.hypot(across);
        (stands && along.hypot(across) > PARALLEL).then(|| (sign * across).atan2(sign * along))
    }

    fn edges(&self) -> usize {
        self.points.len() - usize::from(!self.is_closed)
    }

    fn ends(&self, edge: usize) -> [usize; 2] {
        [edge, (edge + 1) % self.points.len()]
    }

    /// Its tangent on an edge.
    fn tangent(&self, edge: usize, along: f64) -> DVec3 {
        let [start, end] = self.ends(edge).map(|point| self.tangents[point]);
        start.lerp(end, along).normalize_or(start)
    }

    /// Its pieces between vertices and crossings, with tilts if it leans.
    fn pieces(&self, crossing: &Crossing, leans: bool) -> Vec<Piece> {
        let normal = crossing.sections[self.section].plane().unit_normal();
        // Places along the chain, and the tilts that are known there.
        let (mut places, mut length) = (Vec::new(), 0.0);
        for edge in 0..self.edges() {
            let [start, end] = self.ends(edge).map(|point| self.points[point]);
            let span = start.distance(end);
            let known = self.known_tilt(edge, normal);
            places.push((length, start, self.tangent(edge, 0.0), known));
            for (along, tilt) in crossing.tilts(self, edge, normal) {
                let (at, tangent) = (start.lerp(end, along), self.tangent(edge, along));
                places.push((length + along * span, at, tangent, Some(tilt)));
            }
            length += span;
        }
        let last = self.ends(self.edges() - 1)[1];
        places.push((
            length,
            self.points[last],
            self.tangents[last],
            self.known_tilt(last, normal),
        ));
        let mut known: Vec<(f64, f64)> =
            places.iter().filter_map(|place| Some((place.0, place.3?))).collect();
        if !leans {
            known.clear();
        } else if known.is_empty() {
            let lean = |place: &(f64, DVec3, DVec3, Option<f64>)| {
                Some((place.0, crossing.lean(self, place.1, normal)?))
            };
            known.extend(places.iter().filter_map(lean));
        }
        let tilts = Tilts { known, length, is_closed: self.is_closed };
        let pieces = places.windows(2).filter(|ends| ends[0].1 != ends[1].1);
        let piece = |ends: &[(f64, DVec3, DVec3, Option<f64>)]| Piece {
            ends: [ends[0].1, ends[1].1],
            tangents: [ends[0].2, ends[1].2],
            tilts: [tilts.at(ends[0].0), tilts.at(ends[1].0)],
            normal,
            labels: self.labels,
        };
        pieces.map(piece).collect()
    }
}

/// Tilts by their places along a chain.
struct Tilts {
    known: Vec<(f64, f64)>,
    length: f64,
    is_closed: bool,
}

impl Tilts {
    /// Linear between those that are known, around a closed chain; 0 where none is.
    fn at(&self, place: f64) -> f64 {
        let Some((&first, &last)) = self.known.first().zip(self.known.last()) else { return 0.0 };
        let after = self.known.partition_point(|known| known.0 < place);
        let shifted = |(at, tilt): (f64, f64), by: f64| (at + by * self.length, tilt);
        let before = match after {
            0 if self.is_closed => shifted(last, -1.0),
            0 => first,
            after => self.known[after - 1],
        };
        let after = match self.known.get(after) {
            Some(&after) => after,
            None if self.is_closed => shifted(first, 1.0),
            None => last,
        };
        let span = after.0 - before.0;
        let along = if span > 0.0 { (place - before.0) / span } else { 0.0 };
        before.1 + along * (after.1 - before.1)
    }
}

/// The chains of every section by their labels, to be searched.
fn others(chains: &[Chain]) -> BTreeMap<(usize, [Label; 2]), Others> {
    let mut numbers: BTreeMap<(usize, [Label; 2]), Vec<[u32; 2]>> = BTreeMap::new();
    for (number, chain) in chains.iter().enumerate() {
        let own = numbers.entry((chain.section, chain.labels)).or_default();
        own.extend((0..chain.edges()).map(|edge| [number as u32, edge as u32]));
    }
    let tree = |places: Vec<[u32; 2]>| {
        let segment = |&[chain, edge]: &[u32; 2]| {
            let chain = &chains[chain as usize];
            chain.ends(edge as usize).map(|point| chain.points[point])
        };
        Others { tree: SegmentTree::new(places.iter().map(segment).collect()), places }
    };
    numbers.into_iter().map(|(key, places)| (key, tree(places))).collect()
}

/// Where contours of different sections cross.
struct Crossing<'a> {
    sections: &'a [Section],
    chains: &'a [Chain],
    others: &'a BTreeMap<(usize, [Label; 2]), Others>,
    near: f64,
}

impl Crossing<'_> {
    /// The tilt at a place on a contour that the nearest sections before and behind it, along its
    /// plane's normal, say.
    fn lean(&self, chain: &Chain, at: DVec3, normal: DVec3) -> Option<f64> {
        let seen = |(number, section): (usize, &Section)| {
            let plane = section.plane().unit();
            let cosine = plane.normal.dot(normal);
            let along = -plane.distance(at) / cosine;
            let is_ahead = cosine.abs() >= FACING && along.abs() > self.near;
            (number != chain.section && is_ahead).then_some((number, along))
        };
        let mut all: Vec<(usize, f64)> =
            self.sections.iter().enumerate().filter_map(seen).collect();
        all.sort_by(|one, other| one.1.abs().total_cmp(&other.1.abs()));
        let slope = |sign: f64| {
            let mut own = all.iter().filter(|(_, along)| sign * along > 0.0);
            own.find_map(|&(number, along)| {
                let growth = self.growth(chain.labels, at + along * normal, number)?;
                Some((sign * growth / along.abs()).clamp(-MOST_LEAN, MOST_LEAN))
            })
        };
        match (slope(-1.0), slope(1.0)) {
            (Some(before), Some(behind)) => Some(0.5 * (before + behind)),
            (before, behind) => before.or(behind),
        }
        .map(f64::atan)
    }

    /// How much farther the smaller label of a contour reaches on a section than up to a place:
    /// negative where it reaches less; `None` where the section does not know.
    fn growth(&self, labels: [Label; 2], at: DVec3, section: usize) -> Option<f64> {
        let own = &self.sections[section];
        let label = own.label_at(own.plane().project(at));
        let far = match self.others.get(&(section, labels)) {
            Some(others) => others.tree.distance(at, &mut Hint::default()),
            None => f64::MAX,
        };
        match label {
            Label::UNKNOWN => None,
            label if label == labels[0] => Some(far),
            _ => Some(-far),
        }
    }

    /// Where other contours cross an edge of a chain, from 0 to 1, and the tilts there.
    fn tilts(&self, chain: &Chain, edge: usize, normal: DVec3) -> Vec<(f64, f64)> {
        let [start, end] = chain.ends(edge).map(|point| chain.points[point]);
        let mut tilts = Vec::new();
        for (number, section) in self.sections.iter().enumerate() {
            if number == chain.section {
                continue;
            }
            let [from, to] = [start, end].map(|point| section.plane().distance(point));
            // A vertex on the plane belongs to the edge that begins there.
            if (from < 0.0) == (to < 0.0) {
                continue;
            }
            let along = from / (from - to);
            let tangent = chain.tangent(edge, along);
            let tilt = self.tilt(chain.labels, (start.lerp(end, along), tangent, normal), number);
            tilts.extend(tilt.map(|tilt| (along, tilt)));
        }
        tilts.sort_by(|one, other| one.0.total_cmp(&other.0));
        tilts
    }

    /// The tilt that a contour of another section gives to one with this tangent and this normal
    /// of its plane; `None` where there is none, or it says nothing.
    fn tilt(
        &self,
        labels: [Label; 2],
        (at, tangent, normal): (DVec3, DVec3, DVec3),
        section: usize,
    ) -> Option<f64> {
        let others = self.others.get(&(section, labels))?;
        let (nearest, distance) = others.tree.nearest(at, &mut Hint::default())?;
        if distance > self.near {
            return None;
        }
        let [chain, edge] = others.places[nearest as usize].map(|number| number as usize);
        let chain = &self.chains[chain];
        let [start, end] = chain.ends(edge).map(|point| chain.points[point]);
        let span = end - start;
        let along = ((at - start).dot(span) / span.length_squared()).clamp(0.0, 1.0);
        let other = chain.tangent(edge, along);
        let cross = tangent.cross(other);
        if cross.length() < PARALLEL {
            return None;
        }
        let left = normal.cross(tangent);
        let other_left = self.sections[section].plane().unit_normal().cross(other);
        let inward = if cross.dot(left + other_left) < 0.0 { -cross } else { cross };
        // Where the two contradict each other about which side is inside nothing follows.
        let agree = inward.dot(left) > 0.0 && inward.dot(other_left) > 0.0;
        agree.then(|| inward.dot(normal).atan2(inward.dot(left)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::disc;
    use crate::plane::Plane;

    /// The worst angle, in degrees, by which normals at a sphere's contours are off.
    fn worst(sections: &[Section], points: impl Iterator<Item = DVec3>) -> f64 {
        let outline = Outline::new(&Contours::new(sections, true), Label(1));
        let off = |point: DVec3| {
            let foot = outline.foot(point, &mut Hint::default()).unwrap();
            foot.inward.dot(-foot.at.normalize()).clamp(-1.0, 1.0).acos().to_degrees()
        };
        points.map(off).fold(0.0, f64::max)
    }

    fn circle(normal: DVec3, offset: f64, corners: u32) -> Section {
        disc(Plane { normal, offset }, 1.0, corners, Label(1))
    }

    fn along(section: &Section) -> impl Iterator<Item = DVec3> + '_ {
        section
            .segments()
            .flat_map(|[start, end]| (0..8).map(move |step| start.lerp(end, f64::from(step) / 8.0)))
    }

    /// Great circles of a sphere, and small ones across them.
    fn sphere(corners: u32) -> Vec<Section> {
        let great =
            [DVec3::X, DVec3::new(0.3, 1.0, 0.1)].map(|normal| circle(normal, 0.0, corners));
        great.into_iter().chain([-0.5, 0.4].map(|z| small(z, corners))).collect()
    }

    /// The circle at a height on the unit sphere.
    fn small(height: f64, corners: u32) -> Section {
        let plane = Plane { normal: DVec3::Z, offset: height };
        disc(plane, (1.0 - height * height).sqrt(), corners, Label(1))
    }

    #[test]
    fn normals_lean_between_crossings_as_a_sphere_does() {
        let sections = sphere(48);
        for section in &sections {
            let worst = worst(&sections, along(section));
            assert!(worst < 0.3, "{}: {worst}", section.name());
        }
    }

    #[test]
    fn a_contour_alone_has_normals_in_its_plane() {
        // They are off by the angle whose sine is the height.
        for height in [-0.5f64, 0.4] {
            let sections = [small(height, 48)];
            let worst = worst(&sections, along(&sections[0]));
            assert!((worst - height.abs().asin().to_degrees()).abs() < 0.3, "{height}: {worst}");
        }
    }

    #[test]
    fn contours_of_a_stack_lean_as_their_neighbours_say() {
        let sections = [-0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6].map(|height| small(height, 48));
        for (number, limit) in [(1, 2.0), (2, 1.0), (3, 0.3), (4, 1.0), (5, 2.0)] {
            let worst = worst(&sections, along(&sections[number]));
            assert!(worst < limit, "{number}: {worst}");
        }
    }

    /// Sections before and behind that show the label everywhere, and so have no contour.
    #[test]
    fn what_has_no_contours_leans_as_little_as_any() {
        let blank = |height: f64| {
            let plane = Plane { normal: DVec3::Z, offset: height };
            crate::check::shapes::partition(plane, &[], Label(1))
        };
        let sections = [blank(-0.5), small(0.0, 12), blank(0.5)];
        let worst = worst(&sections, along(&sections[1]));
        assert!(worst < 0.3, "{worst}");
    }

    #[test]
    fn known_normals_may_point_either_way() {
        let sphere = small(0.4, 48);
        let known = |sign: f64| {
            let points: Vec<DVec3> = (0..48).map(|vertex| sphere.point(vertex)).collect();
            let own = points.into_iter().map(|at| (at, sign * at));
            [sphere.clone().with_normals(own).unwrap()]
        };
        for sign in [1.0, -1.0] {
            let sections = known(sign);
            let worst = worst(&sections, along(&sections[0]));
            assert!(worst < 0.3, "{sign}: {worst}");
        }
        // What is along the plane's normal says nothing.
        let along_axis = (0..48).map(|vertex| (sphere.point(vertex), DVec3::Z));
        let sections = [sphere.clone().with_normals(along_axis).unwrap()];
        let worst = worst(&sections, along(&sections[0]));
        assert!((worst - 0.4f64.asin().to_degrees()).abs() < 0.3, "{worst}");
    }

    #[test]
    fn tangents_are_means_and_not_those_of_edges() {
        for (corners, limit) in [(48, 0.05), (24, 0.2)] {
            let sections = sphere(corners);
            let worst = worst(&sections, sections[0].segments().map(|[start, _]| start));
            // Edges alone would be off by 360° / corners / 2.
            assert!(worst < limit, "{corners}: {worst}");
        }
    }

    #[test]
    fn trails_end_where_contours_meet() {
        let square = [[0, 1], [1, 2], [2, 3], [3, 0]];
        assert_eq!(trails(&square), [(vec![0, 1, 2, 3], true)]);
        let eight = [[0, 1], [1, 2], [2, 0], [0, 3], [3, 4], [4, 0]];
        assert_eq!(trails(&eight), [(vec![0, 1, 2, 0], false), (vec![0, 3, 4, 0], false)]);
        assert_eq!(trails(&[[5, 6], [4, 5]]), [(vec![4, 5, 6], false)]);
    }
}
