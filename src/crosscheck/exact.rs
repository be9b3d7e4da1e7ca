//! The oracle in the field's place: its labels at the lattice's nodes, found
//! by the same search along changes of label.

use rayon::prelude::*;

use crate::arrangement::Arrangement;
use crate::error::Result;
use crate::field::{Field, Queries};
use crate::label::Label;
use crate::oracle::Oracle;

/// A field that is 1 for the label of the nearest known point, and −1 for all
/// others.
pub struct Exact<'a> {
    oracle: &'a Oracle<'a>,
    /// For every cell the labels that it can have.
    labels: Vec<Vec<Label>>,
}

impl<'a> Exact<'a> {
    /// In the cells of an arrangement of the oracle's sections. The nearest
    /// known point is seen from where it is the nearest: it lies on the cell's
    /// own walls, unless there is something unknown on them.
    pub fn new(oracle: &'a Oracle<'a>, arrangement: &Arrangement) -> Self {
        let known = |labels: &[Label]| -> Vec<Label> {
            labels.iter().copied().filter(|&label| label != Label::UNKNOWN).collect()
        };
        let mut all: Vec<Label> =
            arrangement.cells().iter().flat_map(|cell| known(&cell.labels)).collect();
        all.sort_unstable();
        all.dedup();
        let cells = arrangement.cells().iter();
        let labels = cells.map(|cell| match cell.labels.contains(&Label::UNKNOWN) {
            true => all.clone(),
            false => cell.labels.clone(),
        });
        Self { oracle, labels: labels.collect() }
    }
}

impl Field for Exact<'_> {
    fn labels(&self, cell: u32) -> &[Label] {
        &self.labels[cell as usize]
    }

    fn edges(&self, cell: u32) -> u64 {
        u64::from(self.labels(cell).len() > 1)
    }

    fn name(&self) -> String {
        "exact nearest points".to_owned()
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        let label = |&point| self.oracle.nearest(point).label;
        let found: Vec<Label> = queries.points.par_iter().map(label).collect();
        let mut values = Vec::new();
        for run in &queries.runs {
            let labels = self.labels(run.cell);
            for own in &found[run.points.clone()] {
                values.extend(labels.iter().map(|label| if label == own { 1.0 } else { -1.0 }));
            }
        }
        Ok(values)
    }
}
