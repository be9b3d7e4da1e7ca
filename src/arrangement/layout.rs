//! What is drawn on which plane.

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::error::{Error, Result};
use crate::ffi::arrangement as ffi;
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::section::{Edge, Section};

/// All planes, and which of them are the same.
pub(super) struct Layout<'a> {
    pub sections: &'a [Section],
    pub bounds: Bounds,
    pub border: Label,
    /// The sections' planes, then the six of the box ([`box_planes`]).
    pub planes: Vec<Plane>,
    /// For each plane the first one that is the same set of points. The others
    /// count for nothing: faces lie on the first, signs are those of the first.
    pub first: Vec<u32>,
    /// The planes that are the first of their kind.
    pub distinct: Vec<u32>,
    /// Normal and offset of every plane.
    pub numbers: Vec<f64>,
}

impl<'a> Layout<'a> {
    pub fn new(sections: &'a [Section], bounds: Bounds, border: Label) -> Result<Self> {
        let size = bounds.size();
        if !(size.is_finite() && size.min_element() > 0.0) {
            return Err(Error::Option(format!(
                "the box from {} to {} has no volume: give one that has",
                bounds.min, bounds.max
            )));
        }
        let planes: Vec<Plane> =
            sections.iter().map(|section| section.plane).chain(box_planes(bounds)).collect();
        let numbers: Vec<f64> = planes.iter().flat_map(numbers_of).collect();
        let first = ffi::first_coincident(&numbers)
            .map_err(|exception| Error::library("arrangement", &exception))?;
        let distinct =
            (0..planes.len() as u32).filter(|&plane| first[plane as usize] == plane).collect();
        Ok(Self { sections, bounds, border, planes, first, distinct, numbers })
    }

    /// Which sides of a plane lie in the box when it coincides with a face of
    /// the box: `[in front, behind]`.
    pub fn sides_inside(&self, plane: u32) -> [bool; 2] {
        let first_box = self.sections.len();
        for on_box in first_box..self.planes.len() {
            if self.first[on_box] == plane {
                // The box's normals point outward.
                let outward = !self.reversed(plane as usize, on_box);
                return [!outward, outward];
            }
        }
        [true, true]
    }

    /// What is drawn on a distinct plane.
    pub fn drawing(&self, plane: u32) -> Drawing<'a> {
        let mut drawing = Drawing {
            plane: self.planes[plane as usize],
            vertices: Vec::new(),
            edges: Vec::new(),
            layers: Vec::new(),
        };
        for (index, section) in self.sections.iter().enumerate() {
            if self.first[index] == plane {
                drawing.add(section, self.reversed(plane as usize, index));
            }
        }
        if drawing.layers.is_empty() {
            drawing.layers.push(Layer { name: "", background: self.border, edges: 0..0 });
        }
        drawing
    }

    /// Whether the normals of two coincident planes point to opposite sides.
    fn reversed(&self, one: usize, other: usize) -> bool {
        let axis = self.planes[one].dropped_axis();
        (self.planes[one].normal[axis] > 0.0) != (self.planes[other].normal[axis] > 0.0)
    }
}

/// The planes of the box: lower and upper x, y, z, their normals pointing
/// outward.
fn box_planes(bounds: Bounds) -> [Plane; 6] {
    std::array::from_fn(|index| {
        let axis = index / 2;
        let mut normal = DVec3::ZERO;
        let (sign, offset) =
            if index % 2 == 0 { (-1.0, -bounds.min[axis]) } else { (1.0, bounds.max[axis]) };
        normal[axis] = sign;
        Plane { normal, offset }
    })
}

fn numbers_of(plane: &Plane) -> [f64; 4] {
    [plane.normal.x, plane.normal.y, plane.normal.z, plane.offset]
}

/// The sections on one plane. There is more than one layer where planes of
/// several sections coincide; they must agree.
pub(super) struct Drawing<'a> {
    pub plane: Plane,
    pub vertices: Vec<DVec2>,
    pub edges: Vec<Edge>,
    pub layers: Vec<Layer<'a>>,
}

/// A section on a plane, or the label of a face of the box.
pub(super) struct Layer<'a> {
    pub name: &'a str,
    pub background: Label,
    /// Indices into [`Drawing::edges`].
    pub edges: Range<usize>,
}

impl<'a> Drawing<'a> {
    /// Adds a section; seen from behind (`reversed`) the kept axes and the
    /// sides of every edge are swapped.
    fn add(&mut self, section: &'a Section, reversed: bool) {
        let shift = self.vertices.len() as u32;
        let swap = |point: &DVec2| if reversed { DVec2::new(point.y, point.x) } else { *point };
        self.vertices.extend(section.vertices.iter().map(swap));
        let first = self.edges.len();
        self.edges.extend(section.edges.iter().map(|edge| Edge {
            start: edge.start + shift,
            end: edge.end + shift,
            left: if reversed { edge.right } else { edge.left },
            right: if reversed { edge.left } else { edge.right },
        }));
        let edges = first..self.edges.len();
        self.layers.push(Layer { name: section.name(), background: section.background, edges });
    }

    /// The labels on the left and the right of an edge directed from its
    /// lexicographically smaller end to the other one.
    pub fn sides(&self, edge: usize) -> [Label; 2] {
        let Edge { start, end, left, right } = self.edges[edge];
        let [from, to] = [start, end].map(|vertex| self.vertices[vertex as usize]);
        let ascending = from.x < to.x || (from.x == to.x && from.y < to.y);
        if ascending { [left, right] } else { [right, left] }
    }
}
