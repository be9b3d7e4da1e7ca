//! Many nodes evaluated at once, sorted by cell as the backends want them.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::{Field, Queries, Run};
use crate::grid::locate::NO_CELL;
use crate::label::Label;

/// Nodes, the cells they lie in, and the field's values there.
pub(super) struct Batch<'a> {
    field: &'a dyn Field,
    /// For every node its cell, or [`NO_CELL`] outside the box.
    cells: Vec<u32>,
    /// For every evaluated node where its values begin.
    offsets: Vec<u32>,
    values: Vec<f32>,
    /// How many nodes were evaluated.
    pub(super) points: u64,
}

impl<'a> Batch<'a> {
    /// Evaluates the field at the nodes that lie in cells of several labels.
    pub(super) fn evaluate(
        field: &'a dyn Field,
        cells: Vec<u32>,
        position: impl Fn(usize) -> DVec3 + Sync,
    ) -> Result<Self> {
        let mut order: Vec<(u32, u32)> = cells
            .par_iter()
            .enumerate()
            .filter(|&(_, &cell)| cell != NO_CELL && field.labels(cell).len() > 1)
            .map(|(node, &cell)| (cell, node as u32))
            .collect();
        order.par_sort_unstable();
        let points = order.par_iter().map(|&(_, node)| position(node as usize)).collect();
        let queries = Queries { points, runs: runs(&order) };
        let mut offsets = vec![0; cells.len()];
        let mut end = 0;
        for &(cell, node) in &order {
            offsets[node as usize] = end as u32;
            end += field.labels(cell).len();
        }
        let values = if order.is_empty() { Vec::new() } else { field.evaluate(&queries)? };
        if values.len() != end {
            let what = format!("{} values where {end} were asked for", values.len());
            return Err(Error::Bug { stage: "field", what });
        }
        Ok(Self { field, cells, offsets, values, points: order.len() as u64 })
    }

    /// The materials that can occur in any of some nodes, sorted.
    pub(super) fn materials(&self, nodes: std::ops::Range<usize>) -> Vec<Label> {
        let mut cells = self.cells[nodes].to_vec();
        cells.sort_unstable();
        cells.dedup();
        let labels = cells.into_iter().filter(|&cell| cell != NO_CELL);
        let mut labels: Vec<Label> =
            labels.flat_map(|cell| self.field.labels(cell)).copied().collect();
        labels.retain(|label| label.is_material());
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// The materials at a node, each with its value.
    pub(super) fn node(&self, node: usize) -> impl Iterator<Item = (Label, f32)> + '_ {
        let labels = match self.cells[node] {
            NO_CELL => &[],
            cell => self.field.labels(cell),
        };
        let values = match labels {
            [] | [_] => &[1.0], // nothing else is near
            _ => &self.values[self.offsets[node] as usize..][..labels.len()],
        };
        // Rounding may lead a little out of the range.
        let clamped = values.iter().map(|value| value.clamp(-1.0, 1.0));
        labels.iter().copied().zip(clamped).filter(|(label, _)| label.is_material())
    }

    /// The label with the largest share of a node, of equals the smallest:
    /// [`LeafOf::labels`](crate::grid::leaf::LeafOf::labels) for one node.
    pub(super) fn label(&self, node: usize) -> Label {
        let shares = || self.node(node).map(|(label, f)| (label, (f64::from(f) + 1.0) / 2.0));
        let outside = (Label::OUTSIDE, 1.0 - shares().map(|(_, share)| share).sum::<f64>());
        shares().fold(outside, |best, next| if next.1 > best.1 { next } else { best }).0
    }
}

/// Runs of equal cells in a sorted order.
fn runs(order: &[(u32, u32)]) -> Vec<Run> {
    let mut start = 0;
    order
        .chunk_by(|a, b| a.0 == b.0)
        .map(|chunk| {
            let points = start..start + chunk.len();
            start = points.end;
            Run { cell: chunk[0].0, points }
        })
        .collect()
}
