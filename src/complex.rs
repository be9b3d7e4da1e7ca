//! The exact subdivision of the box by all section planes into convex cells (Bermano §4.2),
//! one plane after the other (§7).

mod check;
mod editor;
mod locate;
mod same;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::section::Section;
use crate::slots::Slots;

pub use editor::{Editor, Touched};
pub use locate::Locator;

/// The planes of the box are the first of a complex: lower and upper x, y, z.
pub const BOX_PLANES: u32 = 6;

/// An edge on a facet: part of a contour, or of the facet's border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacetEdge {
    /// On the facet's plane, rounded; equal points are bitwise equal.
    pub start: DVec3,
    /// As `start`.
    pub end: DVec3,
    /// The label left of the edge, seen with the plane's normal pointing at
    /// the viewer.
    pub left: Label,
    /// The label right of the edge; `None` beyond the facet's border.
    pub right: Option<Label>,
}

/// A convex polygon on one plane, bordered by other planes, with the labelled
/// regions on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Facet {
    /// A number of [`Complex::planes`].
    pub plane: u32,
    /// The cells in front of it (where the plane's normal points) and behind
    /// it; `None` outside the box.
    pub cells: [Option<u32>; 2],
    /// The labels on it, sorted.
    pub labels: Vec<Label>,
    /// The borders of its regions: together they close around each region.
    pub edges: Vec<FacetEdge>,
    /// Its corners, rounded, counter-clockwise about its plane's normal.
    pub outline: Vec<DVec3>,
}

/// A convex cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Numbers of [`Complex::facets`].
    pub facets: Vec<u32>,
    /// The labels on its boundary, sorted.
    pub labels: Vec<Label>,
}

/// The cells, their facets and the planes, each by a number that it keeps as long as no
/// change concerns it. An [`Editor`] makes it.
///
/// Where a section lies on a face of the box, it is drawn there.
#[derive(Debug, Clone)]
pub struct Complex {
    pub(crate) bounds: Bounds,
    pub(crate) border: Label,
    pub(crate) planes: Slots<Plane>,
    pub(crate) facets: Slots<Facet>,
    pub(crate) cells: Slots<Cell>,
    /// The sections' names, by plane.
    pub(crate) names: BTreeMap<u32, String>,
}

impl Complex {
    /// All sections' planes in a box whose faces have the label `border`.
    ///
    /// # Errors
    /// As [`Editor::new`] and [`Editor::add`], and what [`Editor::sanity_check`] finds.
    pub fn new(sections: &[Section], bounds: Bounds, border: Label) -> Result<Self> {
        let mut editor = Editor::new(bounds, border)?;
        for section in sections {
            editor.add(section)?;
        }
        editor.commit()?;
        let sound = editor.sanity_check();
        sound.map_err(|what| Error::Bug { stage: "arrangement", what })?;
        Ok(editor.into_complex())
    }

    /// The box.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The label of the box's faces.
    pub fn border(&self) -> Label {
        self.border
    }

    /// The six of the box (lower and upper x, y, z, their normals pointing outward) and those
    /// of sections.
    pub fn planes(&self) -> &Slots<Plane> {
        &self.planes
    }

    /// The name of the section on a plane, if there is one.
    pub fn name(&self, plane: u32) -> Option<&str> {
        self.names.get(&plane).map(String::as_str)
    }

    /// The facets.
    pub fn facets(&self) -> &Slots<Facet> {
        &self.facets
    }

    /// The cells.
    pub fn cells(&self) -> &Slots<Cell> {
        &self.cells
    }

    /// Whether there is an unknown region on a facet.
    pub fn is_partial(&self) -> bool {
        self.facets.values().any(|facet| facet.labels.binary_search(&Label::UNKNOWN).is_ok())
    }

    /// The facets around a cell.
    pub fn facets_of(&self, cell: u32) -> impl Iterator<Item = (u32, &Facet)> {
        self.cells[cell].facets.iter().map(|&facet| (facet, &self.facets[facet]))
    }

    /// The cell that a point lies in. What lies on planes counts as moved off them in one
    /// direction, the same for all; a point outside the box as the nearest one in it.
    pub fn locate(&self, point: DVec3) -> u32 {
        locate::walk(self, locate::first_cell(self), point)
    }

    /// What locates many points of a region of the box.
    pub fn locator(&self, region: Bounds) -> Locator<'_> {
        Locator::new(self, region)
    }
}
