//! Many nodes evaluated at once, sorted by cell as the backends want them.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::{Field, Queries, Run};
use crate::grid::leaf::{LeafNodes, LeafValues};
use crate::grid::locate::NO_CELL;
use crate::grid::samples::Values;
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
    /// Evaluates the field at the nodes that lie in cells where there is something to evaluate.
    pub(super) fn evaluate(
        field: &'a dyn Field,
        cells: Vec<u32>,
        position: impl Fn(usize) -> DVec3 + Sync,
    ) -> Result<Self> {
        let mut order: Vec<(u32, u32)> = cells
            .par_iter()
            .enumerate()
            .filter(|&(_, &cell)| cell != NO_CELL && field.edges(cell) > 0)
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

    /// The labels that can occur in any of some nodes and have values of their own, sorted:
    /// *outside* has where distances are those of several materials.
    pub(super) fn labels(&self, nodes: std::ops::Range<usize>) -> Vec<Label> {
        let mut cells = self.cells[nodes].to_vec();
        cells.sort_unstable();
        cells.dedup();
        let labels = cells.into_iter().filter(|&cell| cell != NO_CELL);
        let mut labels: Vec<Label> =
            labels.flat_map(|cell| self.field.labels(cell)).copied().collect();
        if !self.field.is_single() {
            labels.push(Label::OUTSIDE);
        }
        labels.retain(|label| label.is_material() || !self.field.is_single());
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// Whether values are indicators: a label that cannot occur has −1 then.
    pub(super) fn are_indicators(&self) -> bool {
        self.field.values() == Values::Indicators
    }

    /// All labels that can occur at a node, each with its value.
    fn own(&self, node: usize) -> impl Iterator<Item = (Label, f32)> + '_ {
        let labels = match self.cells[node] {
            NO_CELL => &[],
            cell => self.field.labels(cell),
        };
        let values = match self.cells[node] {
            NO_CELL => &[],
            cell if self.field.edges(cell) == 0 => &[1.0][..], // nothing else is near
            _ => &self.values[self.offsets[node] as usize..][..labels.len()],
        };
        // Rounding may lead a little out of the range.
        let most = if self.are_indicators() { 1.0 } else { f32::INFINITY };
        labels.iter().copied().zip(values.iter().map(move |value| value.clamp(-most, most)))
    }

    /// Sets the values of some labels, sorted, at a node, which is a leaf's `inner`-th. Beyond the
    /// box it is outside; where a label cannot occur, its distance is as large as that of the
    /// one that is there.
    pub(super) fn values_at(
        &self,
        node: usize,
        labels: &mut [LeafValues<Box<LeafNodes>>],
        inner: usize,
    ) {
        let best = || self.own(node).map(|(_, value)| value).reduce(f32::max);
        let absent = match self.are_indicators() {
            true => -1.0,
            false => best().map_or(-1.0, |best| -best.abs()),
        };
        let is_beyond = self.cells[node] == NO_CELL;
        let mut present = self.own(node).peekable();
        for own in labels {
            while present.next_if(|(label, _)| *label < own.label).is_some() {}
            own.values[inner] = match present.next_if(|(label, _)| *label == own.label) {
                Some((_, value)) => value,
                None if is_beyond && own.label == Label::OUTSIDE => 1.0,
                None => absent,
            };
        }
    }

    /// The label of a node: [`LeafOf::labels`](crate::grid::leaf::LeafOf::labels) for one.
    pub(super) fn label(&self, node: usize) -> Label {
        let is_single = self.field.is_single();
        let own = || self.own(node).filter(|(label, _)| label.is_material() || !is_single);
        let shares = || own().map(|(label, f)| (label, (f64::from(f) + 1.0) / 2.0));
        let outside = match (is_single, self.cells[node]) {
            (false, cell) if cell != NO_CELL => f64::NEG_INFINITY,
            _ => 1.0 - shares().map(|(_, share)| share).sum::<f64>(),
        };
        let outside = (Label::OUTSIDE, outside);
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
