//! Two sections of one plane laid over each other: the merging of coincident
//! planes, extents and masks.

use glam::DVec3;

use super::draft::{Draft, stretch};
use super::normals::Normals;
use super::subdivision::{Curves, Subdivision, Windings, times};
use super::{Edge, Section};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Plane;

/// Two sections over each other.
pub(super) struct Overlay {
    subdivision: Subdivision,
    normals: Normals,
    /// The labels of both sections on every face.
    pub labels: Vec<[Label; 2]>,
}

impl Overlay {
    /// Lays two sections with the same kept axes over each other. What nearly touches the second
    /// is put on it.
    pub fn new(draft: &mut Draft, sections: [&Section; 2]) -> Result<Self> {
        let mut curves = Curves::default();
        // Every label but the background is a curve: the boundary of its
        // regions. A face has the label that winds around it. So labels stay
        // meaningful when rounding moves an edge across a vertex.
        let labels = sections.map(Section::labels);
        let count = labels[0].len();
        for (section, labels, first) in
            [(sections[0], &labels[0], 0), (sections[1], &labels[1], count)]
        {
            let numbers: Vec<u32> =
                section.vertices.iter().map(|&vertex| curves.point(vertex)).collect();
            let is_drawn = |label: &Label| *label != section.background;
            curves.boundaries(&section.edges, &numbers, |label| {
                labels.binary_search(&label).ok().filter(|_| is_drawn(&label)).map(|i| first + i)
            });
        }
        curves.fixed = Some(count as u32);
        let subdivision = curves.subdivide(draft)?;
        let faces = subdivision.windings();
        let of = |windings: &Windings| {
            [
                label(windings, sections[0], &labels[0], 0),
                label(windings, sections[1], &labels[1], count),
            ]
        };
        let mut normals = Normals::default();
        sections.into_iter().for_each(|section| normals.add(section));
        Ok(Self { normals, labels: faces.iter().map(of).collect(), subdivision })
    }

    /// The area on which both sections speak and say different things, and a
    /// place there.
    pub fn conflict(&self, draft: &Draft) -> Option<(f64, DVec3)> {
        self.part(draft, |[first, second]| {
            first != second && first != Label::UNKNOWN && second != Label::UNKNOWN
        })
    }

    /// The area of the faces with certain labels, in world units, and a place
    /// on the largest of them.
    pub fn part(
        &self,
        draft: &Draft,
        belongs: impl Fn([Label; 2]) -> bool,
    ) -> Option<(f64, DVec3)> {
        let areas = self.subdivision.areas();
        let faces = || (0..areas.len()).filter(|&face| belongs(self.labels[face]));
        let largest = faces().max_by(|&a, &b| areas[a].total_cmp(&areas[b]))?;
        let area: f64 = faces().map(|face| areas[face]).sum();
        let place = draft.place(self.subdivision.place(largest));
        Some((area * stretch(&draft.plane), place))
    }

    /// The section whose labels are made of both.
    pub fn section(self, draft: &Draft, combine: impl Fn([Label; 2]) -> Label) -> Section {
        let labels: Vec<Label> = self.labels.iter().map(|&pair| combine(pair)).collect();
        let mut section = self.subdivision.section(draft, &labels);
        self.normals.give(&mut section);
        section
    }
}

/// The label of a section that winds around a face most, the background when
/// none does.
fn label(windings: &Windings, section: &Section, labels: &[Label], first: usize) -> Label {
    let around = |i: usize| times(windings, (first + i) as u32);
    (0..labels.len())
        .filter(|&i| around(i) > 0)
        .max_by_key(|&i| (around(i), std::cmp::Reverse(i)))
        .map_or(section.background, |i| labels[i])
}

impl Section {
    /// The same on a plane that is nearly this one's, either way round, as points off their plane
    /// are put on it. Exactly the same where it is this one's.
    pub(super) fn onto(&self, plane: Plane) -> Self {
        let is_turned = self.plane.normal.dot(plane.normal) < 0.0;
        let swap = |edge: &Edge| match is_turned {
            true => Edge { left: edge.right, right: edge.left, ..*edge },
            false => *edge,
        };
        let vertices = 0..self.vertices.len() as u32;
        Self {
            name: self.name.clone(),
            plane,
            vertices: vertices.map(|vertex| plane.project(self.point(vertex)) + 0.0).collect(),
            edges: self.edges.iter().map(swap).collect(),
            background: self.background,
            normals: self.normals.clone(),
        }
    }

    /// The same after its vertices have moved a little: edges meet in vertices alone again.
    pub(super) fn settled(self, draft: &mut Draft) -> Result<Self> {
        let blank = Self {
            vertices: Vec::new(),
            edges: Vec::new(),
            normals: Vec::new(),
            background: Label::UNKNOWN,
            ..self.clone()
        };
        let overlay = Overlay::new(draft, [&self, &blank])?;
        Ok(overlay.section(draft, |[own, _]| own))
    }
}
