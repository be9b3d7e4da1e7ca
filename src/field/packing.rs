//! Cells laid out for the f32 backends.
//!
//! Coordinates are local to the cell: its centre is the origin, and a power
//! of two scales it into the unit cube. W is homogeneous, so f is not
//! affected. A coordinate is split into a part on a grid and the remainder:
//! differences of the parts on the grid are exact, so that p = q − foot keeps
//! its *relative* accuracy however close the point is to a contour, where f
//! changes quickly.
//!
//! The edges of a face that have the same labels left and right are joined
//! into chains. Consecutive edges share p and r, and the sum along a chain
//! stays in a register. The edges of triangles on unknown regions are ramps
//! (`ramps`), each with a slope for every label that changes there.

use std::collections::BTreeMap;
use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};

use super::boundaries::{Boundary, SMALLEST_CLEARANCE};
use super::completion::Completion;
use super::ramps::{Change, RampEdge, Ramps};
use super::reference::slot;
use crate::complex::{Facet, FacetEdge};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Bounds;

/// The right side of an edge on its face's border.
pub(super) const BORDER: u32 = u32::MAX;

/// An edge q − p of a chain, without its start.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct PackedEdge {
    /// q, the part on the grid.
    pub end: [f32; 2],
    /// q, the remainder.
    pub end_rest: [f32; 2],
    /// q − p, rounded once: for short edges this is far more accurate than a
    /// difference of rounded ends.
    pub span: [f32; 2],
    /// ‖q − p‖².
    pub span_squared: f32,
    padding: f32,
}

/// Consecutive edges with the same labels on their sides.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Chain {
    /// The first vertex, the part on the grid.
    pub start: [f32; 2],
    /// The first vertex, the remainder.
    pub start_rest: [f32; 2],
    /// The first edge, among the cell's.
    pub first_edge: u32,
    /// The edge after the last one.
    pub end_edge: u32,
    /// The label left of it, as an index into the cell's.
    pub left: u32,
    /// The label right of it, or [`BORDER`].
    pub right: u32,
}

/// A corner of triangles on an unknown region: the part on the grid, and the
/// remainder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PackedCorner {
    pub at: [f32; 2],
    pub rest: [f32; 2],
}

/// An edge of a triangle on an unknown region.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PackedRamp {
    /// p and q, among the face's corners.
    pub ends: [u32; 2],
    /// q − p, rounded once.
    pub span: [f32; 2],
    /// ‖q − p‖².
    pub span_squared: f32,
    /// Slopes `first_slope..end_slope` of the cell.
    pub first_slope: u32,
    pub end_slope: u32,
}

/// What a ramp adds to a label ([`Change`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PackedSlope {
    /// An index into the cell's labels.
    pub label: u32,
    pub value: f32,
    pub along: f32,
    pub across: f32,
}

/// A face's plane, in the cell's coordinates: u = tangents · x, and
/// γ = normal · x + offset.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub tangents: [DVec3; 2],
    pub normal: DVec3,
    pub offset: f64,
}

/// A face: chains `first_chain..end_chain`, corners `first_corner..end_corner`
/// and ramps `first_ramp..end_ramp` of the cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct PackedFace {
    pub frame: Frame,
    pub first_chain: u32,
    pub end_chain: u32,
    pub first_corner: u32,
    pub end_corner: u32,
    pub first_ramp: u32,
    pub end_ramp: u32,
}

impl PackedFace {
    /// The face's corners among the cell's.
    pub fn corners(&self) -> Range<usize> {
        self.first_corner as usize..self.end_corner as usize
    }

    /// The face's ramps among the cell's.
    pub fn ramps(&self) -> Range<usize> {
        self.first_ramp as usize..self.end_ramp as usize
    }
}

/// A cell. One with a single label has no faces: nothing is to be evaluated.
#[derive(Debug, Clone)]
pub(super) struct PackedCell {
    pub labels: Vec<Label>,
    /// World units.
    pub origin: DVec3,
    /// Cell units per world unit.
    pub scale: f64,
    /// The smallest |γ|, in cell units.
    pub clearance: f32,
    pub faces: Vec<PackedFace>,
    pub chains: Vec<Chain>,
    pub edges: Vec<PackedEdge>,
    pub corners: Vec<PackedCorner>,
    pub ramps: Vec<PackedRamp>,
    pub slopes: Vec<PackedSlope>,
}

/// A part of what surrounds a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// All regions on all faces.
    All,
    /// The known regions of all faces but one.
    KnownBut(u32),
    /// The unknown regions of all faces but one.
    UnknownBut(u32),
}

impl Part {
    /// Whether a face's known regions, and its unknown ones, belong to it.
    #[inline(always)]
    pub fn of_face(self, face: usize) -> [bool; 2] {
        match self {
            Self::All => [true; 2],
            Self::KnownBut(other) => [face != other as usize, false],
            Self::UnknownBut(other) => [false, face != other as usize],
        }
    }
}

impl PackedCell {
    /// A cell's boundary, with the shares that the completion has now.
    pub fn new(boundary: &Boundary) -> Result<Self> {
        let (mut packed, ramps) = Self::with_ramps(boundary)?;
        packed.set_slopes(&ramps, boundary.completion);
        Ok(packed)
    }

    /// A cell's boundary without slopes, and the ramps of its faces.
    pub fn with_ramps(boundary: &Boundary) -> Result<(Self, Vec<Ramps>)> {
        let starts =
            boundary.facets().flat_map(|(_, face)| face.edges.iter().map(|edge| edge.start));
        let (origin, scale) = Bounds::around(starts).map_or((DVec3::ZERO, 1.0), unit_cube);
        let mut packed = Self {
            labels: boundary.labels.to_vec(),
            origin,
            scale,
            clearance: (boundary.clearance * scale).max(SMALLEST_CLEARANCE) as f32,
            faces: Vec::new(),
            chains: Vec::new(),
            edges: Vec::new(),
            corners: Vec::new(),
            ramps: Vec::new(),
            slopes: Vec::new(),
        };
        let mut ramps = Vec::new();
        if boundary.labels.len() > 1 {
            for (index, face) in boundary.facets() {
                ramps.push(packed.add_face(boundary, index, face)?);
            }
        }
        Ok((packed, ramps))
    }

    /// Gives every ramp the slopes that follow from the corners' shares.
    pub fn set_slopes(&mut self, ramps: &[Ramps], completion: &Completion) {
        self.slopes.clear();
        let slots = completion.slots(&self.labels);
        let edges =
            ramps.iter().flat_map(|ramps| ramps.edges.iter().map(move |edge| (ramps, edge)));
        for (packed, (ramps, edge)) in self.ramps.iter_mut().zip(edges) {
            packed.first_slope = self.slopes.len() as u32;
            for (label, &slot) in slots.iter().enumerate() {
                let Change { value, along, across } =
                    ramps.change(edge, |corner| completion.share(corner, slot));
                if [value, along, across] != [0.0; 3] {
                    let [value, along, across] = [value, along, across].map(|part| part as f32);
                    self.slopes.push(PackedSlope { label: label as u32, value, along, across });
                }
            }
            packed.end_slope = self.slopes.len() as u32;
        }
    }

    fn add_face(&mut self, boundary: &Boundary, index: u32, face: &Facet) -> Result<Ramps> {
        let plane = boundary.complex.planes()[face.plane];
        let frame = Frame {
            tangents: plane.tangents(),
            normal: plane.unit_normal(),
            offset: plane.distance(self.origin) * self.scale,
        };
        let first_chain = self.chains.len() as u32;
        for (sides, pieces) in pieces_by_sides(face, &self.labels)? {
            for trail in trails(&pieces) {
                self.add_chain(&frame, sides, &trail);
            }
        }
        let end_chain = self.chains.len() as u32;
        let completion = boundary.completion;
        let (origin, scale) = (self.origin, self.scale);
        let place = |corner| frame.flatten((completion.point(corner) - origin) * scale);
        let ramps = Ramps::new(completion.triangles(index).to_vec(), place);
        let corners = ramps.corners.iter().map(|&corner| PackedCorner::new(place(corner)));
        let (first_corner, first_ramp) = (self.corners.len() as u32, self.ramps.len() as u32);
        self.corners.extend(corners);
        self.ramps.extend(ramps.edges.iter().map(PackedRamp::new));
        let (end_corner, end_ramp) = (self.corners.len() as u32, self.ramps.len() as u32);
        self.faces.push(PackedFace {
            frame,
            first_chain,
            end_chain,
            first_corner,
            end_corner,
            first_ramp,
            end_ramp,
        });
        Ok(ramps)
    }

    fn add_chain(&mut self, frame: &Frame, [left, right]: [u32; 2], trail: &[Piece]) {
        let Some(first) = trail.first() else { return };
        let (start, start_rest) = split_point(self.flatten(frame, first.start));
        let first_edge = self.edges.len() as u32;
        let end_edge = first_edge + trail.len() as u32;
        self.chains.push(Chain { start, start_rest, first_edge, end_edge, left, right });
        for piece in trail {
            let end = self.flatten(frame, piece.end);
            let span = end - self.flatten(frame, piece.start);
            let (end, end_rest) = split_point(end);
            self.edges.push(PackedEdge {
                end,
                end_rest,
                span: span.as_vec2().to_array(),
                span_squared: span.length_squared() as f32,
                padding: 0.0,
            });
        }
    }

    /// Edges that are evaluated for a point.
    pub fn edge_count(&self) -> u64 {
        (self.edges.len() + self.ramps.len()) as u64
    }

    /// A point on a face, in the face's frame.
    fn flatten(&self, frame: &Frame, point: DVec3) -> DVec2 {
        frame.flatten(self.localize(point))
    }

    /// A point in the cell's coordinates.
    pub fn localize(&self, point: DVec3) -> DVec3 {
        (point - self.origin) * self.scale
    }
}

impl Frame {
    /// A point in the cell's coordinates, in the face's frame.
    pub fn flatten(&self, local: DVec3) -> DVec2 {
        DVec2::new(self.tangents[0].dot(local), self.tangents[1].dot(local))
    }
}

impl PackedCorner {
    pub fn new(point: DVec2) -> Self {
        let (at, rest) = split_point(point);
        Self { at, rest }
    }
}

impl PackedRamp {
    fn new(edge: &RampEdge) -> Self {
        let (ends, span) = (edge.ends, edge.end - edge.start);
        let (span, span_squared) = (span.as_vec2().to_array(), span.length_squared() as f32);
        Self { ends, span, span_squared, first_slope: 0, end_slope: 0 }
    }
}

/// The centre of some bounds and the power of two that shrinks them into a
/// cube of side one.
pub(super) fn unit_cube(bounds: Bounds) -> (DVec3, f64) {
    let centre = bounds.middle();
    let side = bounds.size().max_element();
    let scale = if side > 0.0 { (-side.log2().ceil()).exp2() } else { 1.0 };
    (centre, scale)
}

/// A coordinate of magnitude one at most, rounded to a grid of 2⁻²⁴, and the
/// remainder. Adding and subtracting 1.5 · 2²⁸ rounds to its unit in the last
/// place.
#[inline(always)]
pub(super) fn split(value: f64) -> (f32, f32) {
    const ROUND: f64 = 1.5 * (1u64 << 28) as f64;
    let coarse = (value + ROUND) - ROUND;
    (coarse as f32, (value - coarse) as f32)
}

fn split_point(point: DVec2) -> ([f32; 2], [f32; 2]) {
    let ((u, u_rest), (v, v_rest)) = (split(point.x), split(point.y));
    ([u, v], [u_rest, v_rest])
}

/// A directed piece of a border between two labels.
#[derive(Debug, Clone, Copy)]
struct Piece {
    start: DVec3,
    end: DVec3,
}

/// A face's edges by the labels on their sides, the smaller one on the left;
/// edges without length left out. Beyond a known region's border an unknown
/// region is as good as none: its triangles have borders of their own.
fn pieces_by_sides(face: &Facet, labels: &[Label]) -> Result<BTreeMap<[u32; 2], Vec<Piece>>> {
    let mut groups: BTreeMap<[u32; 2], Vec<Piece>> = BTreeMap::new();
    for edge in face.edges.iter().filter(|edge| edge.start != edge.end) {
        let [left, right] = sides(edge, labels)?;
        if left < right {
            let piece = Piece { start: edge.start, end: edge.end };
            groups.entry([left, right]).or_default().push(piece);
        } else if right < left {
            let piece = Piece { start: edge.end, end: edge.start };
            groups.entry([right, left]).or_default().push(piece);
        }
    }
    Ok(groups)
}

/// The labels on an edge's sides as indices, [`BORDER`] for none.
fn sides(edge: &FacetEdge, labels: &[Label]) -> Result<[u32; 2]> {
    let side = |label: Option<Label>| match label.filter(|&label| label != Label::UNKNOWN) {
        Some(label) => Ok(slot(labels, label)? as u32),
        None => Ok(BORDER),
    };
    Ok([side(Some(edge.left))?, side(edge.right)?])
}

/// The bits of a point: equal points of a plane are bitwise equal.
fn key(point: DVec3) -> [u64; 3] {
    point.to_array().map(f64::to_bits)
}

/// Pieces in sequences in which each one starts where the last one ends. Open
/// sequences begin where no other piece arrives.
fn trails(pieces: &[Piece]) -> Vec<Vec<Piece>> {
    let mut leaving: BTreeMap<[u64; 3], Vec<usize>> = BTreeMap::new();
    let mut arriving: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    for (index, piece) in pieces.iter().enumerate().rev() {
        leaving.entry(key(piece.start)).or_default().push(index);
        *arriving.entry(key(piece.end)).or_default() += 1;
    }
    let (inner, open): (Vec<usize>, Vec<usize>) =
        (0..pieces.len()).partition(|&index| arriving.contains_key(&key(pieces[index].start)));

    let mut used = vec![false; pieces.len()];
    let mut trails = Vec::new();
    for first in open.into_iter().chain(inner) {
        let mut trail = Vec::new();
        let mut next = Some(first).filter(|&index| !used[index]);
        while let Some(index) = next {
            used[index] = true;
            trail.push(pieces[index]);
            let others = leaving.get_mut(&key(pieces[index].end));
            next = others.and_then(|others| take_unused(others, &used));
        }
        if !trail.is_empty() {
            trails.push(trail);
        }
    }
    trails
}

fn take_unused(candidates: &mut Vec<usize>, used: &[bool]) -> Option<usize> {
    while let Some(index) = candidates.pop() {
        if !used[index] {
            return Some(index);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piece(start: (f64, f64), end: (f64, f64)) -> Piece {
        let lift = |(x, y)| DVec3::new(x, y, 0.0);
        Piece { start: lift(start), end: lift(end) }
    }

    fn lengths(pieces: &[Piece]) -> Vec<usize> {
        let trails = trails(pieces);
        for trail in &trails {
            for pair in trail.windows(2) {
                assert_eq!(pair[0].end, pair[1].start);
            }
        }
        trails.iter().map(Vec::len).collect()
    }

    /// Two triangles that share a corner: one trail, or two, but every piece.
    #[test]
    fn closed_loops_become_trails() {
        let [o, a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-1.0, 0.0), (-1.0, -1.0)];
        let triangle = [piece(o, a), piece(a, b), piece(b, o)];
        assert_eq!(lengths(&triangle), [3]);
        let both = [triangle.to_vec(), vec![piece(o, c), piece(c, d), piece(d, o)]].concat();
        assert_eq!(lengths(&both).iter().sum::<usize>(), 6);
    }

    /// A path given in the wrong order is still one trail, from its beginning.
    #[test]
    fn open_paths_start_at_their_beginning() {
        let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 1.0)];
        let path = [piece(b, c), piece(c, d), piece(a, b)];
        assert_eq!(lengths(&path), [3]);
        assert_eq!(key(trails(&path)[0][0].start), key(DVec3::ZERO));
    }

    #[test]
    fn split_loses_nothing_that_f32_could_keep() {
        for value in [0.0, 0.1, -0.7, 0.999_999, 1e-9, -3.3e-5] {
            let (coarse, rest) = split(value);
            let error = (f64::from(coarse) + f64::from(rest) - value).abs();
            assert!(error < 4e-15, "{value}: {error:e}");
            let steps = f64::from(coarse) * f64::from(1 << 24);
            assert_eq!(steps, steps.round(), "{value} off the grid");
        }
    }
}
