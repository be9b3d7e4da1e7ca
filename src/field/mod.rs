//! The field: for every label a function on the box, positive inside,
//! negative outside, zero on the surface.

use std::ops::Range;

use glam::DVec3;

use crate::error::Result;
use crate::label::Label;

/// Points grouped by the cell they lie in.
#[derive(Debug, Clone, Default)]
pub struct Queries {
    /// World units.
    pub points: Vec<DVec3>,
    /// Consecutive ranges of points that together cover them all.
    pub runs: Vec<Run>,
}

/// Points in one cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// Index into [`Arrangement::cells`](crate::arrangement::Arrangement::cells).
    pub cell: u32,
    /// Indices into [`Queries::points`].
    pub points: Range<usize>,
}

/// What every backend does.
pub trait Field: Send + Sync {
    /// The labels that can occur in a cell, sorted.
    fn labels(&self, cell: u32) -> &[Label];

    /// For each run in turn, for each of its points, one value in [−1, 1] per
    /// label of its cell in the order of [`Field::labels`].
    ///
    /// # Errors
    /// When the device fails.
    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>>;
}
