//! The CPU backend.

use glam::DVec3;
use rayon::prelude::*;

use super::kernel::{Scratch, values};
use super::packing::HermiteCell;
use super::{Nodes, Options};
use crate::error::Result;
use crate::field::cpu::{CHUNK, Instructions};
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

/// Points in one cell, and where their values go.
struct Job<'a> {
    cell: &'a HermiteCell,
    points: &'a [DVec3],
    values: &'a mut [f32],
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
        let labels = |cell: u32| self.cells[cell as usize].labels.len();
        let count = queries.runs.iter().map(|run| run.points.len() * labels(run.cell)).sum();
        Ok(vec![0.0; count])
    }

    /// The values in those cells that are wanted.
    pub(super) fn evaluate_where(
        &self,
        queries: &Queries,
        mut values: &mut [f32],
        wanted: impl Fn(&HermiteCell) -> bool,
    ) {
        let mut jobs = Vec::new();
        for run in &queries.runs {
            let cell = &self.cells[run.cell as usize];
            let own = values.split_off_mut(..run.points.len() * cell.labels.len());
            let Some(own) = own.filter(|own| !own.is_empty() && wanted(cell)) else { continue };
            let points = queries.points[run.points.clone()].chunks(CHUNK);
            let parts = own.chunks_mut(CHUNK * cell.labels.len());
            jobs.extend(points.zip(parts).map(|(points, values)| Job { cell, points, values }));
        }
        jobs.into_par_iter().for_each(|job| job.run(self.instructions));
    }

    /// The values of a few points of one cell.
    pub(super) fn evaluate_in(&self, cell: u32, points: &[DVec3], values: &mut [f32]) {
        Job { cell: &self.cells[cell as usize], points, values }.run(self.instructions);
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

impl Job<'_> {
    fn run(self, instructions: Instructions) {
        match instructions {
            Instructions::Baseline => self.run_baseline(),
            // SAFETY: `detect` found these instructions on this processor.
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx2 => unsafe { self.run_avx2() },
            #[cfg(target_arch = "x86_64")]
            Instructions::Avx512 => unsafe { self.run_avx512() },
        }
    }

    fn run_baseline(self) {
        // 64-bit ARM always has a fused multiply and add.
        self.run_lanes::<8, { cfg!(target_arch = "aarch64") }>();
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn run_avx2(self) {
        self.run_lanes::<8, true>();
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx2,fma")]
    fn run_avx512(self) {
        self.run_lanes::<16, true>();
    }

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
