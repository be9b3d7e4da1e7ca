//! The CPU backend.

use glam::DVec3;
use rayon::prelude::*;

use super::kernel::{Scratch, values};
use super::packing::HermiteCell;
use super::{Nodes, Options};
use crate::error::Result;
use crate::field::cpu::{Instructions, Lanewise, Piece, pieces, value_count};
use crate::field::{Boundaries, Field, Queries};
use crate::grid::samples::Values;
use crate::label::Label;

/// The f32 backend on the CPU. A point's values depend on nothing but the point.
pub struct Cpu {
    cells: Vec<HermiteCell>,
    is_single: bool,
    unit: f64,
    instructions: Instructions,
}

impl Cpu {
    /// The field inside some boundaries, with what is said at nodes; values are in units of
    /// `unit` world units.
    pub fn on(boundaries: &Boundaries, nodes: &Nodes, options: &Options, unit: f64) -> Self {
        let cell = |cell| HermiteCell::new(boundaries, nodes, cell, unit, options.density);
        let cells = (0..boundaries.count() as u32).into_par_iter().map(cell).collect();
        let is_single = boundaries.materials().len() == 1;
        Self { cells, is_single, unit, instructions: Instructions::detect() }
    }

    pub(super) fn cells(&self) -> &[HermiteCell] {
        &self.cells
    }

    /// World units per unit of values.
    pub(super) fn unit(&self) -> f64 {
        self.unit
    }

    /// As many values as queries ask for, all 0.
    ///
    /// # Errors
    /// When the queries' runs do not cover their points, or name no cell.
    pub(super) fn room_for(&self, queries: &Queries) -> Result<Vec<f32>> {
        queries.check(self.cells.len())?;
        Ok(vec![0.0; value_count(&self.cells, queries)])
    }

    /// The values in those cells that are wanted.
    pub(super) fn evaluate_where(
        &self,
        queries: &Queries,
        values: &mut [f32],
        wanted: impl Fn(&HermiteCell) -> bool + Sync,
    ) {
        pieces(&self.cells, queries, values)
            .into_par_iter()
            .filter(|piece| wanted(piece.cell))
            .for_each(|piece| self.instructions.run(piece));
    }

    /// The values of a few points of one cell.
    pub(super) fn evaluate_in(&self, cell: u32, points: &[DVec3], values: &mut [f32]) {
        let cell = &self.cells[cell as usize];
        self.instructions.run(Piece { cell, points, values });
    }

    /// The same with a given instruction set, which the processor must have.
    #[cfg(test)]
    pub(super) fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }
}

impl Field for Cpu {
    fn labels(&self, cell: u32) -> &[Label] {
        &self.cells[cell as usize].labels
    }

    fn edges(&self, cell: u32) -> u64 {
        self.cells[cell as usize].edge_count()
    }

    fn name(&self) -> String {
        let threads = rayon::current_num_threads();
        format!("cpu ({:?}, threads: {threads})", self.instructions).to_lowercase()
    }

    fn values(&self) -> Values {
        Values::Distances
    }

    fn is_single(&self) -> bool {
        self.is_single
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        let mut values = self.room_for(queries)?;
        self.evaluate_where(queries, &mut values, |_| true);
        Ok(values)
    }
}

impl Lanewise for Piece<'_, HermiteCell> {
    #[inline(always)]
    fn run_lanes<const N: usize, const FMA: bool>(self) {
        let labels = self.cell.labels.len();
        if labels == 0 {
            return;
        }
        let mut scratch = Scratch::<N, FMA>::default();
        let mut found = vec![[0.0; N]; labels];
        for (points, out) in self.points.chunks(N).zip(self.values.chunks_mut(N * labels)) {
            values(self.cell, points, &mut scratch, &mut found);
            for (lane, out) in out.chunks_exact_mut(labels).enumerate() {
                for (out, value) in out.iter_mut().zip(&found) {
                    *out = value[lane];
                }
            }
        }
    }
}
