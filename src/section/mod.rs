//! Sections: labelled planar partitions, valid by construction.

mod agreement;
mod builder;
mod common_lines;
mod draft;
pub mod ends;
mod extent;
mod graph;
mod images;
mod loops;
mod near_planes;
mod normals;
mod overlay;
mod parity;
mod partition;
mod ray;
pub mod reach;
mod rectangle;
mod regions;
mod sections;
mod snapping;
mod stack;
mod subdivision;
#[cfg(test)]
mod tests;
mod unknown;

use std::path::PathBuf;

use glam::{DVec2, DVec3};
use serde::Serialize;

use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::plane::Plane;

pub use agreement::Disagreement;
pub(crate) use agreement::in_common;
pub use builder::SectionBuilder;
pub use ends::End;
pub(crate) use extent::COVERED;
pub use images::{ImageRules, Spacing, VolumeAxis};
pub use parity::{Curve, Holes};
pub(crate) use ray::{Here, Ray, Target};
pub use rectangle::Rectangle;
pub use regions::Region;
pub use stack::Stack;

/// An edge of a section's planar graph, with a label on either side as seen
/// with the plane's normal pointing at the viewer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edge {
    /// Index of the first vertex.
    pub start: u32,
    /// Index of the second vertex.
    pub end: u32,
    /// The label left of the edge, looking from start to end.
    pub left: Label,
    /// The label right of the edge; differs from `left`.
    pub right: Label,
}

/// A plane with a labelled planar partition on it.
///
/// Invariants: vertices are distinct; edges meet only in shared vertices
/// (decided exactly); the labels around every vertex, and so of every face of
/// the graph, agree; the unbounded face has the label `background`.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    pub(crate) name: String,
    pub(crate) plane: Plane,
    pub(crate) vertices: Vec<DVec2>,
    pub(crate) edges: Vec<Edge>,
    pub(crate) background: Label,
    /// As [`Section::normals`] has them.
    pub(crate) normals: Vec<DVec3>,
}

impl Section {
    /// What errors and reports call the section.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The plane it lies on.
    pub fn plane(&self) -> &Plane {
        &self.plane
    }

    /// The vertices by their two kept coordinates ([`Plane::project`]), which
    /// name points exactly on the plane.
    pub fn vertices(&self) -> &[DVec2] {
        &self.vertices
    }

    /// The edges between differing labels.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The label far away: *outside*, or *unknown* beyond an extent.
    pub fn background(&self) -> Label {
        self.background
    }

    /// The same with the label far away stated: it must be what the edges say,
    /// and only without edges it makes a difference.
    ///
    /// # Errors
    /// Where the edges say another label.
    pub fn with_background(mut self, background: Label) -> Result<Self> {
        if !self.edges.is_empty() && background != self.background {
            let what = format!(
                "its background is given as {background}, but its edges say {}: correct one",
                self.background
            );
            return Err(Error::Section { section: self.name, what });
        }
        self.background = background;
        Ok(self)
    }

    /// A vertex in space, rounded.
    pub fn point(&self, vertex: u32) -> DVec3 {
        self.plane.lift(self.vertices[vertex as usize])
    }

    /// The edges in space, rounded.
    pub fn segments(&self) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        self.edges.iter().map(|edge| [self.point(edge.start), self.point(edge.end)])
    }

    /// All labels that occur, sorted.
    pub fn labels(&self) -> Vec<Label> {
        let mut labels: Vec<Label> =
            self.edges.iter().flat_map(|edge| [edge.left, edge.right]).collect();
        labels.push(self.background);
        labels.sort();
        labels.dedup();
        labels
    }

    /// Whether a part of the plane is unknown, or all of it.
    pub fn is_partial(&self) -> bool {
        let unknown = |edge: &Edge| edge.left == Label::UNKNOWN || edge.right == Label::UNKNOWN;
        self.background == Label::UNKNOWN || self.edges.iter().any(unknown)
    }
}

/// Something doubtful that was dealt with; an error under `--strict`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Warning {
    /// The section's name, or nothing where the whole file is meant.
    pub section: String,
    /// What was found, where, and what was done about it.
    pub what: String,
}

/// Sections with what they share.
#[derive(Debug, Clone, Default)]
pub struct Sections {
    /// In the order of the files.
    pub sections: Vec<Section>,
    /// Name and colour of every material that occurs, by number.
    pub materials: Vec<Material>,
    /// The unit of length, as the file gives it ("mm"); empty when unknown.
    pub units: String,
    /// The frame of the coordinates, as the file gives it ("LPS"); empty when
    /// unknown.
    pub frame: String,
    /// Which way is up, as the file gives it; any length but 0.
    pub up: Option<DVec3>,
    /// What was doubtful.
    pub warnings: Vec<Warning>,
    /// What was left out (degenerate loops, for one).
    pub left_out: Vec<Warning>,
    /// How files were understood where they leave a choice; nothing doubtful.
    pub notes: Vec<Warning>,
    /// The largest distance of a vertex off its plane as the files give it, in
    /// world units; vertices are put on their planes.
    pub off_plane: f64,
    /// Whether the label that means *unknown* ([`Rules::unknown`]) occurs in the
    /// files.
    pub unknown_occurs: bool,
    /// The files they came from.
    pub files: Vec<PathBuf>,
}

/// A closed polygon as files give it; the last point joins the first.
#[derive(Debug, Clone, PartialEq)]
pub struct Loop {
    /// On the plane, within the tolerance; either orientation.
    pub points: Vec<DVec3>,
    /// What is inside; not looked at for a hole.
    pub label: Label,
    /// The index of the loop that this one is a hole of.
    pub hole_of: Option<usize>,
}

/// Who wins where loops of different labels overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overlap {
    /// The loop that comes first.
    First,
    /// The loop that comes last.
    Last,
    /// The loop with the smallest area.
    Smallest,
}

/// How sections are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// How far off its plane a vertex may lie, relative to the diagonal of
    /// all vertices of the file.
    pub tolerance: f64,
    /// How near to one another vertices and edges of a section are the same, in world units; 0
    /// takes every drawing as it is. Without it, 1e-8 of the diagonal of all vertices of the file.
    pub snapping: Option<f64>,
    /// Who wins where loops overlap; without it that is an error.
    pub overlap: Option<Overlap>,
    /// An ordinary label that means *unknown* in the files.
    pub unknown: Option<Label>,
    /// Whether every warning is an error.
    pub strict: bool,
    /// The unit of all lengths, whatever the files say; without it what they say.
    pub unit: Option<&'static str>,
    /// What files of images do not say themselves.
    pub images: ImageRules,
}

impl Rules {
    /// What a label of a file stands for.
    pub fn meaning(&self, label: Label) -> Label {
        if self.unknown == Some(label) { Label::UNKNOWN } else { label }
    }
}

impl Default for Rules {
    fn default() -> Self {
        let images = ImageRules::default();
        Self {
            tolerance: 1e-3,
            snapping: None,
            overlap: None,
            unknown: None,
            strict: false,
            unit: None,
            images,
        }
    }
}

/// What was doubtful about a section and what was left out of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Findings {
    /// What was doubtful.
    pub warnings: Vec<Warning>,
    /// What was left out.
    pub left_out: Vec<Warning>,
    /// The largest distance of a vertex off the plane, in world units.
    pub off_plane: f64,
    /// How many vertices were nearer than the tolerance to others, or to edges, and so were put
    /// on them.
    pub snapped: usize,
    /// The largest such tolerance ([`Rules::snapping`]), in world units.
    pub snapping: f64,
    /// Whether there are contours, and none of them encloses anything: then the section says
    /// nothing, not that all is outside.
    pub is_void: bool,
}

impl Findings {
    /// Adds what was found elsewhere.
    pub fn append(&mut self, other: Self) {
        self.warnings.extend(other.warnings);
        self.left_out.extend(other.left_out);
        self.off_plane = self.off_plane.max(other.off_plane);
        self.snapped += other.snapped;
        self.snapping = self.snapping.max(other.snapping);
        self.is_void |= other.is_void;
    }
}
