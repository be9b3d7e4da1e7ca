//! The CPU backend: rayon over chunks of points, one point per vector lane.

use glam::DVec3;
use rayon::prelude::*;

use super::gpu::batch::LaidOut;
use super::kernel;
use super::packing::{PackedCell, Part};
use super::{Boundaries, Field, Queries};
use crate::error::Result;
use crate::label::Label;

/// Points in one unit of parallel work.
const CHUNK: usize = 64;

/// The f32 backend on the CPU. A point's values depend on nothing but the
/// point: neither on its lane nor on its neighbours or the threads.
pub struct Cpu {
    cells: Vec<PackedCell>,
    instructions: Instructions,
}

/// The instruction sets that the kernel is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Instructions {
    /// Whatever every processor of this architecture has.
    Baseline,
    /// 256-bit vectors with fused multiply and add.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512-bit vectors.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

/// The part of a query that one thread takes: points in one cell, and where
/// their values go.
pub(super) struct Job<'a> {
    pub cell: &'a PackedCell,
    pub part: Part,
    pub points: &'a [DVec3],
    pub values: &'a mut [f32],
}

/// Points of a query that are evaluated together, and where their values go.
pub(super) struct Piece<'a, Cell> {
    pub cell: &'a Cell,
    pub points: &'a [DVec3],
    pub values: &'a mut [f32],
}

/// Work on many points, one a lane of a vector.
pub(super) trait Lanewise {
    /// Does it with `N` lanes, and if there is one with a fused multiply and add. To be compiled
    /// for several instruction sets it must be inlined.
    fn run_lanes<const N: usize, const FMA: bool>(self);
}

impl Cpu {
    /// The field inside some boundaries.
    ///
    /// # Errors
    /// As [`field::new`](super::new).
    pub fn new(boundaries: &Boundaries) -> Result<Self> {
        let cell = |cell| PackedCell::new(&boundaries.boundary(cell));
        let cells = (0..boundaries.count()).into_par_iter().map(cell).collect::<Result<_>>()?;
        Ok(Self { cells, instructions: Instructions::detect() })
    }

    /// The same with a given instruction set, which the processor must have.
    #[cfg(test)]
    pub(super) fn with_instructions(mut self, instructions: Instructions) -> Self {
        self.instructions = instructions;
        self
    }

    pub(super) fn cells(&self) -> &[PackedCell] {
        &self.cells
    }

    /// The values in those cells that are wanted.
    pub(super) fn evaluate_where(
        &self,
        queries: &Queries,
        values: &mut [f32],
        wanted: impl Fn(&PackedCell) -> bool + Sync,
    ) {
        pieces(&self.cells, queries, values)
            .into_par_iter()
            .filter(|piece| wanted(piece.cell))
            .map(|Piece { cell, points, values }| Job { cell, part: Part::All, points, values })
            .for_each(|job| job.run(self.instructions));
    }

    /// The values of a few points of one cell.
    pub(super) fn evaluate_in(&self, cell: u32, points: &[DVec3], values: &mut [f32]) {
        Job { cell: &self.cells[cell as usize], part: Part::All, points, values }
            .run(self.instructions);
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

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        queries.check(self.cells.len())?;
        let mut values = vec![0.0; value_count(&self.cells, queries)];
        self.evaluate_where(queries, &mut values, |_| true);
        Ok(values)
    }
}

/// How many values a query asks for.
pub(super) fn value_count<Cell: LaidOut>(cells: &[Cell], queries: &Queries) -> usize {
    queries.runs.iter().map(|run| run.points.len() * cells[run.cell as usize].label_count()).sum()
}

/// A query cut into pieces for threads.
pub(super) fn pieces<'a, Cell: LaidOut>(
    cells: &'a [Cell],
    queries: &'a Queries,
    mut values: &'a mut [f32],
) -> Vec<Piece<'a, Cell>> {
    let mut pieces = Vec::new();
    for run in &queries.runs {
        let cell = &cells[run.cell as usize];
        for points in queries.points[run.points.clone()].chunks(CHUNK) {
            let (own, others) = values.split_at_mut(points.len() * cell.label_count());
            pieces.push(Piece { cell, points, values: own });
            values = others;
        }
    }
    pieces
}

impl Instructions {
    /// The best that this processor has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            let wide = is_x86_feature_detected!("avx512f");
            return if wide { Self::Avx512 } else { Self::Avx2 };
        }
        Self::Baseline
    }

    /// Does work with them.
    pub fn run(self, work: impl Lanewise) {
        match self {
            // 64-bit ARM always has a fused multiply and add.
            Self::Baseline => work.run_lanes::<8, { cfg!(target_arch = "aarch64") }>(),
            // SAFETY: `detect` found these instructions on this processor.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { run_avx2(work) },
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { run_avx512(work) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_avx2(work: impl Lanewise) {
    work.run_lanes::<8, true>();
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx2,fma")]
fn run_avx512(work: impl Lanewise) {
    work.run_lanes::<16, true>();
}

impl Job<'_> {
    /// f of every label at every point.
    fn run(self, instructions: Instructions) {
        let labels = self.cell.labels.len();
        if labels == 1 {
            self.values.fill(1.0);
            return;
        }
        let Self { cell, part, points, values } = self;
        Job { cell, part, points, values: &mut *values }.weigh(instructions);
        values.chunks_exact_mut(labels).for_each(indicator);
    }

    /// W of every label at every point, up to a common factor.
    pub fn weigh(self, instructions: Instructions) {
        instructions.run(self);
    }
}

impl Lanewise for Job<'_> {
    #[inline(always)]
    fn run_lanes<const N: usize, const FMA: bool>(self) {
        let labels = self.cell.labels.len();
        let mut weights = vec![[0.0; N]; labels];
        let mut scratch = Vec::new();
        for (points, values) in self.points.chunks(N).zip(self.values.chunks_mut(N * labels)) {
            kernel::weights::<N, FMA>(self.cell, self.part, points, &mut scratch, &mut weights);
            for (lane, values) in values.chunks_exact_mut(labels).enumerate() {
                for (value, weight) in values.iter_mut().zip(&weights) {
                    *value = weight[lane];
                }
            }
        }
    }
}

/// f_l = (2 W_l − W) / W from the weights of a point, within [−1, 1] whatever
/// the rounding.
#[inline(always)]
pub(super) fn indicator(values: &mut [f32]) {
    let total: f32 = values.iter().sum();
    for value in values {
        *value = ((2.0 * *value - total) / total).clamp(-1.0, 1.0);
    }
}
