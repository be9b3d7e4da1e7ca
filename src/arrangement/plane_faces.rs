//! The convex faces of one plane, from its exact subdivision.

use glam::DVec3;

use super::FaceEdge;
use super::layout::Layout;
use super::regions::{self, SubEdge, components};
use super::signs::Signs;
use crate::error::{Error, Result};
use crate::ffi::arrangement::{self as ffi, Subdivision};
use crate::label::Label;

/// A convex face, named by the sides of all planes, so that nothing but the
/// planes that cut this one matter to it.
pub(super) struct PlaneFace {
    pub signs: Signs,
    /// Counter-clockwise, from the one with the smallest name.
    pub corners: Vec<Signs>,
    /// The corners, rounded.
    pub outline: Vec<DVec3>,
    pub labels: Vec<Label>,
    pub edges: Vec<FaceEdge>,
}

/// The faces of a plane, by name; none where it misses the box or merely
/// touches it.
pub(super) fn plane_faces(layout: &Layout, plane: u32) -> Result<Vec<PlaneFace>> {
    let drawing = layout.drawing(plane);
    let [first, second] = drawing.plane.kept_axes();
    let axes = [first as u32, second as u32, drawing.plane.dropped_axis() as u32];
    let bounds: Vec<f64> =
        (0..3).flat_map(|axis| [layout.bounds.min[axis], layout.bounds.max[axis]]).collect();
    let vertices: Vec<f64> = drawing.vertices.iter().flat_map(|point| point.to_array()).collect();
    let edges: Vec<u32> = drawing.edges.iter().flat_map(|edge| [edge.start, edge.end]).collect();
    let (planes, distinct) = (&layout.numbers, &layout.distinct);
    let subdivision = ffi::subdivide(planes, distinct, plane, &axes, &bounds, &vertices, &edges)
        .map_err(|exception| Error::library("arrangement", &exception))?;
    if subdivision.faces == 0 {
        return Ok(Vec::new());
    }
    let planes = layout.planes.len() as u32;
    let labels = regions::labels(&subdivision, &drawing, planes)?;
    let points = (0..subdivision.points.len() as u32 / 2)
        .map(|vertex| drawing.plane.lift(subdivision.point(vertex)))
        .collect();
    Ok(FaceBuilder::new(&subdivision, labels, points, planes).faces())
}

/// A piece of a face's border, the face on its left.
#[derive(Clone, Copy)]
struct Piece {
    start: u32,
    end: u32,
    label: Label,
}

/// Collects what belongs to each convex face.
struct FaceBuilder {
    /// The vertices in space.
    points: Vec<DVec3>,
    /// The name of each vertex that is a corner.
    corners: Vec<Option<Signs>>,
    /// The pieces of each face's border, sorted by start.
    borders: Vec<Vec<Piece>>,
    /// The edges between different labels strictly inside each face.
    inner: Vec<Vec<FaceEdge>>,
    /// The labels on each face, sorted.
    labels: Vec<Vec<Label>>,
    /// How many planes there are.
    planes: usize,
}

impl FaceBuilder {
    fn new(subdivision: &Subdivision, labels: Vec<Label>, points: Vec<DVec3>, planes: u32) -> Self {
        let is_line = |curves: &[u32]| curves.iter().any(|&curve| curve < planes);
        // Regions that only a section's edges part are on one convex face.
        // Face 0 is all that is outside the box.
        let within = subdivision.edges().filter(|(_, curves)| !is_line(curves));
        let faces = components(
            subdivision.faces,
            within.map(|(SubEdge { left, right, .. }, _)| [left, right]),
        );
        let count = faces.iter().max().map_or(0, |&last| last as usize + 1);
        let mut builder = Self {
            corners: corner_names(subdivision, points.len(), planes as usize),
            points,
            borders: vec![Vec::new(); count],
            inner: vec![Vec::new(); count],
            labels: labels_of(&faces, &labels, count),
            planes: planes as usize,
        };
        for (edge, curves) in subdivision.edges() {
            if is_line(curves) {
                builder.add_border(&edge, &faces, &labels);
            } else {
                builder.add_inner(&edge, &faces, &labels);
            }
        }
        for border in &mut builder.borders {
            border.sort_by_key(|piece| piece.start);
        }
        builder
    }

    fn add_border(&mut self, edge: &SubEdge, faces: &[u32], labels: &[Label]) {
        let &SubEdge { start, end, left, right } = edge;
        for (region, start, end) in [(left, start, end), (right, end, start)] {
            let label = labels[region as usize];
            self.borders[faces[region as usize] as usize].push(Piece { start, end, label });
        }
    }

    fn add_inner(&mut self, edge: &SubEdge, faces: &[u32], labels: &[Label]) {
        let [left, right] = [edge.left, edge.right].map(|region| labels[region as usize]);
        if left != right {
            let [start, end] = [edge.start, edge.end].map(|vertex| self.points[vertex as usize]);
            let face = faces[edge.left as usize] as usize;
            self.inner[face].push(FaceEdge { start, end, left, right: Some(right) });
        }
    }

    fn faces(mut self) -> Vec<PlaneFace> {
        let mut faces: Vec<PlaneFace> =
            (1..self.borders.len()).filter_map(|face| self.face(face)).collect();
        faces.sort_by(|one, other| one.signs.cmp(&other.signs));
        faces
    }

    /// Walks around a face. `None` only for a border that does not close,
    /// which the exact subdivision rules out.
    fn face(&mut self, face: usize) -> Option<PlaneFace> {
        let border = &self.borders[face];
        let corner = |piece: &Piece| self.corners[piece.start as usize].as_ref();
        let first =
            border.iter().filter(|piece| corner(piece).is_some()).min_by_key(|p| corner(p))?;
        let mut walk = vec![*first];
        while let Some(last) = walk.last().filter(|last| last.end != first.start) {
            let next = border.binary_search_by_key(&last.end, |piece| piece.start).ok()?;
            walk.push(border[next]);
        }
        let mut signs = Signs::on_all(self.planes);
        let (mut corners, mut outline) = (Vec::new(), Vec::new());
        for piece in &walk {
            if let Some(name) = corner(piece) {
                signs.join(name);
                corners.push(name.clone());
                outline.push(self.points[piece.start as usize]);
            }
        }
        let mut edges = self.border_edges(&walk);
        edges.append(&mut self.inner[face]);
        // Distinct points can have the same doubles.
        edges.retain(|edge| edge.start != edge.end);
        let labels = std::mem::take(&mut self.labels[face]);
        Some(PlaneFace { signs, corners, outline, labels, edges })
    }

    /// The pieces with those joined that continue each other straight on with
    /// the same known label. Unknown regions keep the vertices that they share
    /// with those of the next face, so that their triangulations fit.
    fn border_edges(&self, walk: &[Piece]) -> Vec<FaceEdge> {
        let mut edges: Vec<FaceEdge> = Vec::with_capacity(walk.len());
        for piece in walk {
            let [start, end] = [piece.start, piece.end].map(|vertex| self.points[vertex as usize]);
            let straight = self.corners[piece.start as usize].is_none();
            let joined = straight && piece.label != Label::UNKNOWN;
            match edges.last_mut().filter(|last| joined && last.left == piece.label) {
                Some(last) => last.end = end,
                None => edges.push(FaceEdge { start, end, left: piece.label, right: None }),
            }
        }
        edges
    }
}

/// For each vertex that is a corner its name.
fn corner_names(subdivision: &Subdivision, vertices: usize, planes: usize) -> Vec<Option<Signs>> {
    let mut names = vec![None; vertices];
    for (&vertex, sides) in subdivision.corners.iter().zip(subdivision.sides.chunks_exact(planes)) {
        names[vertex as usize] = Some(Signs::new(sides));
    }
    names
}

/// The labels on each convex face.
fn labels_of(faces: &[u32], labels: &[Label], count: usize) -> Vec<Vec<Label>> {
    let mut sets = vec![Vec::new(); count];
    for (&face, &label) in faces.iter().zip(labels) {
        sets[face as usize].push(label);
    }
    for set in &mut sets {
        set.sort();
        set.dedup();
    }
    sets
}
