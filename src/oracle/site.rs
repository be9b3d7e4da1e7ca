//! One section made ready to be asked.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::exact::ExactPlane;
use super::float::FloatPlane;
use super::tree::{BoxTree, Rectangle};
use crate::label::Label;
use crate::section::Section;

/// A section with what it takes to find the known point nearest to any other.
pub struct Site<'a> {
    pub section: &'a Section,
    pub plane: FloatPlane,
    pub exact: ExactPlane,
    /// Whether everything is known on it.
    pub is_full: bool,
    /// The labels on it but *unknown*, sorted.
    pub labels: Vec<Label>,
    /// All edges, by their kept coordinates.
    pub edges: BoxTree,
    /// For every label, the edges with it on one side.
    around: BTreeMap<Label, BoxTree>,
    pub vertices: Vec<Vertex>,
    /// How far off its true place the farthest of the rounded vertices may be.
    pub off: f64,
}

/// A vertex of a section.
pub struct Vertex {
    /// In space, rounded.
    pub place: DVec3,
    /// The smallest label around it.
    pub label: Label,
}

impl<'a> Site<'a> {
    pub fn new(section: &'a Section) -> Self {
        let mut around: BTreeMap<Label, Vec<(u32, Rectangle)>> = BTreeMap::new();
        let mut edges = Vec::with_capacity(section.edges().len());
        for (number, edge) in section.edges().iter().enumerate() {
            let [start, end] =
                [edge.start, edge.end].map(|vertex| section.vertices()[vertex as usize]);
            let edge_in_box = (number as u32, [start.min(end), start.max(end)]);
            edges.push(edge_in_box);
            for label in [edge.left, edge.right] {
                around.entry(label).or_default().push(edge_in_box);
            }
        }
        let mut labels = section.labels();
        labels.retain(|&label| label != Label::UNKNOWN);
        let off = section.vertices().iter().map(|&kept| lift_error(section, kept));
        Self {
            section,
            plane: FloatPlane::new(section.plane()),
            exact: ExactPlane::new(*section.plane()),
            is_full: !section.is_partial(),
            labels,
            edges: BoxTree::new(edges),
            around: around.into_iter().map(|(label, edges)| (label, BoxTree::new(edges))).collect(),
            vertices: vertices(section),
            off: off.fold(0.0, f64::max),
        }
    }

    /// The ends of an edge by their kept coordinates.
    pub fn ends(&self, edge: u32) -> [DVec2; 2] {
        let edge = &self.section.edges()[edge as usize];
        [edge.start, edge.end].map(|vertex| self.section.vertices()[vertex as usize])
    }

    /// The edges with a label on one side; of *unknown* those between known and
    /// unknown.
    pub fn around(&self, label: Label) -> Option<&BoxTree> {
        self.around.get(&label)
    }
}

fn vertices(section: &Section) -> Vec<Vertex> {
    let vertex = |number| Vertex { place: section.point(number), label: Label::UNKNOWN };
    let mut vertices: Vec<Vertex> = (0..section.vertices().len() as u32).map(vertex).collect();
    for edge in section.edges() {
        for end in [edge.start, edge.end] {
            let label = &mut vertices[end as usize].label;
            *label = (*label).min(edge.left).min(edge.right);
        }
    }
    vertices
}

/// A bound on how far a rounded vertex is off its true place.
fn lift_error(section: &Section, kept: DVec2) -> f64 {
    let (plane, point) = (section.plane(), section.plane().lift(kept));
    let [first, second] = plane.kept_axes();
    let terms = (plane.normal[first] * kept.x).abs()
        + (plane.normal[second] * kept.y).abs()
        + plane.offset.abs();
    let dropped = plane.dropped_axis();
    8.0 * f64::EPSILON * (terms / plane.normal[dropped].abs() + point[dropped].abs())
}
