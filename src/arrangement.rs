//! The exact subdivision of the box by all section planes (Bermano §4.2).

use glam::DVec3;

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
#[derive(Debug, Clone)]
pub struct Arrangement {
    pub(crate) bounds: Bounds,
    pub(crate) planes: Vec<Plane>,
    pub(crate) faces: Vec<Face>,
    pub(crate) cells: Vec<Cell>,
}

impl Arrangement {
    /// The arrangement of all section planes in a box whose faces have the
    /// label `border`.
    pub fn new(sections: &[Section], bounds: Bounds, border: Label) -> Result<Self> {
        todo!("{sections:?} {bounds:?} {border}")
    }

    /// The box.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The sections' planes, then the six of the box.
    pub fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// The faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// The cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cell that a point of the box lies in, or a cell that touches it
    /// when the point is on a plane to rounding.
    pub fn locate(&self, point: DVec3) -> u32 {
        todo!("{point}")
    }

    /// Whether everything that must hold does: Euler's relation, two cells at
    /// every inner face, convex closed cells, regions that add up to faces.
    pub fn sanity_check(&self) -> std::result::Result<(), String> {
        todo!()
    }
}
