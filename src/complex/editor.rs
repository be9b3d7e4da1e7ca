//! Changes a complex, all or nothing.

use std::collections::{BTreeMap, BTreeSet};

use cxx::UniquePtr;
use glam::{DVec2, DVec3};

use super::{BOX_PLANES, Cell, Complex, Facet, FacetEdge};
use crate::error::{Error, Result};
use crate::ffi::complex::{ExactComplex, Parts, new_complex};
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::section::{Edge, Section};
use crate::slots::Slots;

/// What no cell and no plane has for a number.
const NONE: u32 = u32::MAX;

/// An exact complex that changes, and its rounded image.
///
/// Changes show in [`Editor::complex`] from [`Editor::commit`] on; until then
/// [`Editor::rollback`] takes them back.
pub struct Editor {
    exact: UniquePtr<ExactComplex>,
    complex: Complex,
    /// As they were when changes began.
    saved: Saved,
    is_new: bool,
}

/// What is there for the way back besides the exact complex.
struct Saved {
    names: BTreeMap<u32, String>,
    planes: Slots<Plane>,
}

/// The cells and facets that changes concern.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Touched {
    /// New or changed, ascending.
    pub cells: Vec<u32>,
    /// No more there, ascending.
    pub removed_cells: Vec<u32>,
    /// New or changed, ascending.
    pub facets: Vec<u32>,
    /// No more there, ascending.
    pub removed_facets: Vec<u32>,
}

impl Editor {
    /// A box without sections, whose faces have the label `border`.
    ///
    /// # Errors
    /// When the box has no volume.
    pub fn new(bounds: Bounds, border: Label) -> Result<Self> {
        let size = bounds.size();
        if !(size.is_finite() && size.min_element() > 0.0) {
            return Err(Error::Option(format!(
                "the box from {} to {} has no volume: give one that has",
                bounds.min, bounds.max
            )));
        }
        let numbers: Vec<f64> =
            (0..3).flat_map(|axis| [bounds.min[axis], bounds.max[axis]]).collect();
        let mut exact = new_complex(&numbers, border.0).map_err(failed)?;
        exact.pin_mut().begin();
        let mut planes = Slots::default();
        for (plane, id) in bounds.faces().into_iter().zip(0..) {
            planes.put(id, Some(plane));
        }
        let saved = Saved { names: BTreeMap::new(), planes: planes.clone() };
        let (facets, cells, names) = Default::default();
        let complex = Complex { bounds, border, planes, facets, cells, names };
        Ok(Self { exact, complex, saved, is_new: true })
    }

    /// The complex as it was after the last commit.
    pub fn complex(&self) -> &Complex {
        &self.complex
    }

    /// The complex alone, which does not change any more.
    pub fn into_complex(self) -> Complex {
        self.complex
    }

    /// Adds a section and returns its plane's number: that of a face of the box, if it lies
    /// there.
    ///
    /// # Errors
    /// When another section lies on the plane, or when the section's labels contradict each
    /// other.
    pub fn add(&mut self, section: &Section) -> Result<u32> {
        let numbers = numbers_of(&section.plane);
        let there = self.exact.coincident(&numbers).map_err(failed)?;
        if let Some(other) = self.complex.names.get(&there) {
            let what = format!("it lies on the plane of section {other}: leave one of them out");
            return Err(Error::Section { section: section.name.clone(), what });
        }
        let plane = match there {
            NONE => self.exact.pin_mut().insert(&numbers).map_err(failed)?,
            on_box => on_box,
        };
        if there == NONE {
            self.complex.planes.put(plane, Some(section.plane));
        }
        self.complex.names.insert(plane, section.name.clone());
        self.draw(plane, section)?;
        Ok(plane)
    }

    /// Draws a section in the place of the one on its plane.
    ///
    /// # Errors
    /// When the section's labels contradict each other.
    pub fn replace(&mut self, plane: u32, section: &Section) -> Result<()> {
        self.complex.names.insert(plane, section.name.clone());
        self.draw(plane, section)
    }

    /// Removes the section on a plane.
    ///
    /// # Errors
    /// Exceptions of the exact arithmetic.
    pub fn remove(&mut self, plane: u32) -> Result<()> {
        self.complex.names.remove(&plane);
        if plane < BOX_PLANES {
            return self.exact.pin_mut().erase(plane).map_err(failed);
        }
        self.exact.pin_mut().remove(plane).map_err(failed)?;
        self.complex.planes.put(plane, None);
        Ok(())
    }

    /// Draws what a section shows; seen from behind the kept axes and the sides of every edge
    /// are swapped.
    fn draw(&mut self, plane: u32, section: &Section) -> Result<()> {
        let own = self.complex.planes[plane];
        let axis = own.dropped_axis();
        let is_reversed = (own.normal[axis] > 0.0) != (section.plane.normal[axis] > 0.0);
        let seen = |point: &DVec2| match is_reversed {
            true => [point.y, point.x],
            false => [point.x, point.y],
        };
        let vertices: Vec<f64> = section.vertices.iter().flat_map(seen).collect();
        let edges: Vec<u32> = section
            .edges
            .iter()
            .flat_map(|&Edge { start, end, left, right }| match is_reversed {
                true => [start, end, right.0, left.0],
                false => [start, end, left.0, right.0],
            })
            .collect();
        let drawn = self.exact.pin_mut().draw(plane, &vertices, &edges, section.background.0);
        drawn.map_err(|exception| Error::Section {
            section: section.name.clone(),
            what: format!(
                "{}: close its contours and check the labels on their sides",
                exception.what()
            ),
        })
    }

    /// Makes what was changed hold, and says what that concerns.
    ///
    /// # Errors
    /// When the exact complex is not as it must be, which is a bug; then nothing changes.
    pub fn commit(&mut self) -> Result<Touched> {
        let parts = match self.is_new {
            true => self.exact.parts(),
            false => self.exact.changes(),
        };
        let touched = parts.map_err(failed).map(|parts| self.complex.take(parts))?;
        self.exact.pin_mut().commit();
        self.exact.pin_mut().begin();
        self.saved =
            Saved { names: self.complex.names.clone(), planes: self.complex.planes.clone() };
        self.is_new = false;
        Ok(touched)
    }

    /// Takes back what was changed since the last commit.
    pub fn rollback(&mut self) {
        self.exact.pin_mut().rollback();
        self.exact.pin_mut().begin();
        self.complex.names = self.saved.names.clone();
        self.complex.planes = self.saved.planes.clone();
    }

    /// Whether everything that must hold does: Euler's relation, two cells at
    /// every inner facet, convex closed cells, regions that add up to facets.
    ///
    /// # Errors
    /// What does not hold.
    pub fn sanity_check(&self) -> std::result::Result<(), String> {
        self.exact.check().map_err(|exception| exception.what().to_owned())?;
        self.complex.check_regions()
    }
}

#[cfg(test)]
impl Editor {
    /// All that must hold, and that every place is on its planes, computed exactly.
    pub(super) fn assert_sane(&self) {
        assert_eq!(self.sanity_check(), Ok(()));
        self.exact.check_places().expect("places on their planes");
    }
}

impl Complex {
    /// Takes over what changed.
    fn take(&mut self, parts: Parts) -> Touched {
        for &facet in &parts.removed_facets {
            self.facets.put(facet, None);
        }
        // One that is drawn anew mostly shows what it did.
        let mut facets = Vec::new();
        for (index, &id) in parts.facets.iter().enumerate() {
            let drawn = facet(&parts, index);
            if self.facets.get(id) != Some(&drawn) {
                self.facets.put(id, Some(drawn));
                facets.push(id);
            }
        }
        for &cell in &parts.removed_cells {
            self.cells.put(cell, None);
        }
        // Labels of a cell change with its facets as well.
        let mut cells: BTreeSet<u32> = parts.cells.iter().copied().collect();
        for (index, &id) in parts.cells.iter().enumerate() {
            let facets = range(&parts.cell_starts, index);
            let facets = parts.cell_facets[facets].to_vec();
            self.cells.put(id, Some(Cell { facets, labels: Vec::new() }));
        }
        for &id in &facets {
            cells.extend(self.facets[id].cells.into_iter().flatten());
        }
        for &cell in &cells {
            self.cells[cell].labels = self.labels_around(cell);
        }
        Touched {
            cells: cells.into_iter().collect(),
            removed_cells: parts.removed_cells,
            facets,
            removed_facets: parts.removed_facets,
        }
    }

    fn labels_around(&self, cell: u32) -> Vec<Label> {
        let mut labels: Vec<Label> =
            self.facets_of(cell).flat_map(|(_, facet)| &facet.labels).copied().collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }
}

fn numbers_of(plane: &Plane) -> [f64; 4] {
    [plane.normal.x, plane.normal.y, plane.normal.z, plane.offset]
}

fn failed(exception: cxx::Exception) -> Error {
    Error::library("complex", &exception)
}

/// What belongs to the i-th of some parts.
fn range(starts: &[u32], index: usize) -> std::ops::Range<usize> {
    starts[index] as usize..starts[index + 1] as usize
}

/// The i-th facet that changed.
fn facet(parts: &Parts, index: usize) -> Facet {
    let corners = range(&parts.corner_starts, index);
    let edges = range(&parts.edge_starts, index);
    let border = edges.start + parts.border_edges[index] as usize;
    let cell = |which| Some(parts.facet_ids[3 * index + which]).filter(|&cell| cell != NONE);
    let point = |numbers: &[f64], at: usize| DVec3::from_slice(&numbers[3 * at..]);
    let edges: Vec<FacetEdge> = edges
        .map(|edge| {
            let [left, right] = [0, 1].map(|side| Label(parts.edge_labels[2 * edge + side]));
            let right = (edge >= border).then_some(right);
            let [start, end] = [0, 1].map(|end| point(&parts.edges, 2 * edge + end));
            FacetEdge { start, end, left, right }
        })
        .collect();
    let mut labels: Vec<Label> =
        edges.iter().flat_map(|edge| std::iter::once(edge.left).chain(edge.right)).collect();
    labels.sort_unstable();
    labels.dedup();
    Facet {
        plane: parts.facet_ids[3 * index],
        cells: [cell(1), cell(2)],
        labels,
        // Distinct points can have the same doubles.
        edges: edges.into_iter().filter(|edge| edge.start != edge.end).collect(),
        outline: corners.map(|corner| point(&parts.outlines, corner)).collect(),
    }
}
