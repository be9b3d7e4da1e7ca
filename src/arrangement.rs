//! The exact subdivision of the box by all section planes (Bermano §4.2).

mod assembly;
mod check;
mod layout;
mod locate;
mod plane_faces;
mod regions;
mod signs;
#[cfg(test)]
mod tests;

use glam::DVec3;
use rayon::prelude::*;

use self::assembly::Topology;
use self::layout::Layout;
pub use self::locate::Locator;
pub(crate) use self::regions::components;
use crate::error::Result;
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::section::Section;

/// An edge on a face of a cell: part of a contour, or of the face's border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceEdge {
    /// On the face's plane, rounded; equal points are bitwise equal within a
    /// plane.
    pub start: DVec3,
    /// As `start`.
    pub end: DVec3,
    /// The label left of the edge, seen with the plane's normal pointing at
    /// the viewer.
    pub left: Label,
    /// The label right of the edge; `None` beyond the face's border.
    pub right: Option<Label>,
}

/// A convex polygon on one plane, bordered by other planes, with the labelled
/// regions on it.
#[derive(Debug, Clone)]
pub struct Face {
    /// Index into [`Arrangement::planes`].
    pub plane: u32,
    /// The cells in front of it (where the plane's normal points) and behind
    /// it; `None` outside the box.
    pub cells: [Option<u32>; 2],
    /// The labels on it, sorted.
    pub labels: Vec<Label>,
    /// The borders of its regions: together they close around each region.
    pub edges: Vec<FaceEdge>,
}

/// A convex cell.
#[derive(Debug, Clone)]
pub struct Cell {
    /// Indices into [`Arrangement::faces`].
    pub faces: Vec<u32>,
    /// The labels on its boundary, sorted.
    pub labels: Vec<Label>,
}

/// The cells, their faces and the planes.
///
/// Everything is named by its exact side of every plane, so cells are matched
/// without geometry and keep their names while planes come and go elsewhere.
/// Of planes that coincide only the first has faces; where a section lies on a
/// face of the box, the section's labels count.
#[derive(Debug, Clone)]
pub struct Arrangement {
    pub(crate) bounds: Bounds,
    pub(crate) border: Label,
    pub(crate) planes: Vec<Plane>,
    pub(crate) faces: Vec<Face>,
    pub(crate) cells: Vec<Cell>,
    pub(crate) topology: Topology,
}

impl Arrangement {
    /// The arrangement of all section planes in a box whose faces have the
    /// label `border`.
    ///
    /// # Errors
    /// When the box has no volume, or when the labels of a section, or of two
    /// sections on one plane, contradict each other.
    pub fn new(sections: &[Section], bounds: Bounds, border: Label) -> Result<Self> {
        let layout = Layout::new(sections, bounds, border)?;
        let planes = layout
            .distinct
            .par_iter()
            .map(|&plane| plane_faces::plane_faces(&layout, plane))
            .collect::<Result<Vec<_>>>()?;
        Ok(assembly::assemble(layout, planes))
    }

    /// The box.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The label of the box's faces.
    pub fn border(&self) -> Label {
        self.border
    }

    /// The sections' planes, then the six of the box: lower and upper x, y, z,
    /// their normals pointing outward.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// The faces, by plane.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The corners of a face, rounded, counter-clockwise about its plane's
    /// normal.
    pub fn outline(&self, face: u32) -> &[DVec3] {
        &self.topology.outlines[face as usize]
    }

    /// The cell that a point lies in, or a cell that touches it when the point
    /// is on a plane to rounding. A point outside the box counts as the
    /// nearest one in it.
    pub fn locate(&self, point: DVec3) -> u32 {
        self.cell_of(point)
    }

    /// What locates many points of a region of the box.
    pub fn locator(&self, region: Bounds) -> Locator<'_> {
        Locator::new(self, region)
    }

    /// Whether everything that must hold does: Euler's relation, two cells at
    /// every inner face, convex closed cells, regions that add up to faces.
    pub fn sanity_check(&self) -> std::result::Result<(), String> {
        self.check()
    }
}
