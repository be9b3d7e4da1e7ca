//! What the field interpolates: the labelled regions on the boundary of every
//! cell, the unknown ones completed.

use std::collections::BTreeMap;

use glam::DVec3;

use super::completion::{CellShares, Completion};
use crate::complex::{Cell, Complex, Facet};
use crate::error::{Error, Remedy, Result};
use crate::label::Label;

/// The smallest clearance, in units of the box's diagonal or the cell's size.
pub(super) const SMALLEST_CLEARANCE: f64 = 1e-9;

/// A label that has less than this share everywhere on a cell's boundary can
/// win nowhere in the cell, and is left out of it.
const NEGLIGIBLE: f32 = 1e-3;

/// How unknown regions are triangulated when nothing else is said: the edges'
/// length as a part of the box's longest side.
pub(crate) const SPACING: f64 = 1.0 / 16.0;

/// The smallest spacing, as a part of the box's longest side: finer triangles
/// would take all memory and show nothing more.
const FINEST: f64 = 1.0 / 512.0;

/// The boundaries of a complex's cells.
#[derive(Debug)]
pub struct Boundaries<'a> {
    complex: &'a Complex,
    clearance: f64,
    /// The known labels of each cell, sorted; none where there is no cell.
    labels: Vec<Vec<Label>>,
    completion: Completion,
}

/// The boundary of one cell.
pub(super) struct Boundary<'a> {
    pub complex: &'a Complex,
    pub completion: &'a Completion,
    /// In world units.
    pub clearance: f64,
    pub labels: &'a [Label],
    /// None where there is no cell.
    pub facets: &'a [u32],
}

impl<'a> Boundaries<'a> {
    /// The boundaries of the cells of a complex. Distances to a plane
    /// below `clearance` count as `clearance`. Unknown regions are triangulated
    /// with edges of about `spacing`, a 16th of the box's longest side when
    /// none is given (both in world units, positive), and completed
    /// (Bermano §5).
    ///
    /// # Errors
    /// [`Error::Option`] for a bad clearance or spacing (one below a 512th of
    /// the longest side, too), and where everything is unknown.
    pub fn new(complex: &'a Complex, clearance: f64, spacing: Option<f64>) -> Result<Self> {
        Self::following(complex, clearance, spacing, None)
    }

    /// The same; the search for the shares on unknown regions begins at those `before` a change.
    ///
    /// # Errors
    /// As [`Boundaries::new`].
    pub fn following(
        complex: &'a Complex,
        clearance: f64,
        spacing: Option<f64>,
        before: Option<&Completion>,
    ) -> Result<Self> {
        let bounds = complex.bounds();
        let spacing = spacing.unwrap_or(SPACING * bounds.size().max_element());
        for (what, number) in [("clearance", clearance), ("spacing", spacing)] {
            if !(number.is_finite() && number > 0.0) {
                return Err(Error::Option(format!(
                    "the field's {what} must be a positive number, not {number}"
                )));
            }
        }
        let finest = FINEST * bounds.size().max_element();
        if spacing < finest {
            let what =
                format!("a spacing of {spacing} is too small for this box: the least is {finest}");
            return Err(Error::Option(what).avoidable(Remedy::LargerSpacing));
        }
        // Below this f32 could underflow.
        let clearance = clearance.max(SMALLEST_CLEARANCE * bounds.diagonal());
        let completion = Completion::new(complex, clearance, spacing, before)?;
        let labels = (0..complex.cells().end() as u32)
            .map(|cell| known_labels(complex, &completion, cell))
            .collect();
        Ok(Self { complex, clearance, labels, completion })
    }

    /// The distance that smaller ones to a plane count as, in world units.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// What they are boundaries in.
    pub fn complex(&self) -> &'a Complex {
        self.complex
    }

    /// The known labels of a cell, sorted.
    pub fn labels(&self, cell: u32) -> &[Label] {
        &self.labels[cell as usize]
    }

    /// The materials that occur, sorted.
    pub fn materials(&self) -> Vec<Label> {
        let mut labels: Vec<Label> = self.labels.iter().flatten().copied().collect();
        labels.retain(|label| label.is_material());
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// One more than the largest number of a cell.
    pub fn count(&self) -> usize {
        self.labels.len()
    }

    /// What completed the unknown regions.
    pub fn completion(&self) -> &Completion {
        &self.completion
    }

    /// What is said on the unknown regions of every cell that has some.
    pub fn shares(&self) -> BTreeMap<u32, CellShares> {
        let of_cell = |(number, cell): (u32, &Cell)| {
            let shares = self.completion.shares_on(&cell.facets, &self.labels[number as usize]);
            Some((number, shares?))
        };
        self.complex.cells().iter().filter_map(of_cell).collect()
    }

    /// What is to be kept for the next change.
    pub fn into_completion(self) -> Completion {
        self.completion
    }

    pub(super) fn boundary(&self, cell: usize) -> Boundary<'_> {
        Boundary {
            complex: self.complex,
            completion: &self.completion,
            clearance: self.clearance,
            labels: &self.labels[cell],
            facets: self.complex.cells().get(cell as u32).map_or(&[], |cell| &cell.facets),
        }
    }
}

impl<'a> Boundary<'a> {
    /// The facets with their numbers.
    pub fn facets(&self) -> impl Iterator<Item = (u32, &'a Facet)> {
        let complex = self.complex;
        self.facets.iter().map(move |&facet| (facet, &complex.facets()[facet]))
    }

    /// The corners of the triangles on a facet, in space.
    pub fn triangles(&self, facet: u32) -> impl Iterator<Item = [(u32, DVec3); 3]> {
        let place = |corner: u32| (corner, self.completion.point(corner));
        self.completion.triangles(facet).iter().map(move |corners| corners.map(place))
    }
}

/// The labels of a cell's known regions and of its completed ones.
fn known_labels(complex: &Complex, completion: &Completion, cell: u32) -> Vec<Label> {
    let Some(cell) = complex.cells().get(cell) else { return Vec::new() };
    let mut labels = cell.labels.clone();
    if labels.contains(&Label::UNKNOWN) {
        labels.retain(|&label| label != Label::UNKNOWN);
        for (slot, &label) in completion.labels().iter().enumerate() {
            let shows = |corner: &u32| completion.share(*corner, slot) >= f64::from(NEGLIGIBLE);
            let corners =
                cell.facets.iter().flat_map(|&facet| completion.triangles(facet)).flatten();
            if corners.into_iter().any(shows) {
                labels.push(label);
            }
        }
        labels.sort();
        labels.dedup();
    }
    labels
}
