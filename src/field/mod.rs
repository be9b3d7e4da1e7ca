//! The field: for every label a function on the box, positive inside,
//! negative outside, zero on the surface.
//!
//! The mean-value indicator of Bermano et al., Eqs. 2–5. For x in a cell, W_l
//! is the sum over the regions P of label l on the cell's boundary of
//!
//! ```text
//! I_P(x) = ∬_P |γ| / ‖y − x‖⁴ dA = S_P / (2 |γ|),
//! S_P = Σ_edges θ · cross(p, q) / c,   c² = cross(p, q)² + γ² ‖q − p‖²,
//! θ = atan2(c, p·q + γ²),
//! ```
//!
//! with γ the distance from x to P's plane and p, q an edge's ends relative to
//! x's foot point, in the plane's own right-handed frame, the region on the
//! left. Then f_l = (2 W_l − W) / W with W = Σ_l W_l. The sum S_P does not
//! depend on the side that x is on, since only γ² occurs in it. Close to its
//! own face it tends to 2π, so |γ| is clamped to a small positive *clearance*
//! and points on a plane need no case of their own.
//!
//! Unknown regions are completed first ([`Completion`]): on them the labels'
//! shares are linear on triangles, and W_l is the integral with the share as a
//! factor (`ramps` has its closed form).
//!
//! [`Reference`] states this in f64. [`Cpu`] and [`Gpu`] evaluate what
//! `packing` lays out for them in f32; one contract binds all three.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::grid::samples::Values;
use crate::label::Label;

mod boundaries;
mod completion;
mod cpu;
mod gpu;
pub mod hermite;
mod kernel;
mod lanes;
mod packing;
mod places;
mod ramps;
mod reference;

#[cfg(test)]
mod contract;
#[cfg(test)]
mod fixture;

pub use boundaries::Boundaries;
pub(crate) use boundaries::SPACING;
pub use completion::{CellShares, Completion};
pub use cpu::Cpu;
pub use gpu::Gpu;
use gpu::Opened;
pub use reference::Reference;

pub use crate::gpu::Adapter;

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
    /// Index into [`Complex::cells`](crate::complex::Complex::cells).
    pub cell: u32,
    /// Indices into [`Queries::points`].
    pub points: Range<usize>,
}

/// What every backend does.
pub trait Field: Send + Sync {
    /// The labels that can occur in a cell, sorted.
    fn labels(&self, cell: u32) -> &[Label];

    /// How many edges are evaluated for one point of a cell; none where nothing is to be
    /// evaluated, in a cell with a single label whose indicator is one everywhere.
    fn edges(&self, cell: u32) -> u64;

    /// The backend and what it runs on, for people to read.
    fn name(&self) -> String;

    /// What the values are.
    fn values(&self) -> Values {
        Values::Indicators
    }

    /// Whether *outside* is what the only material is not, −f of it, and needs no values of its
    /// own.
    fn is_single(&self) -> bool {
        true
    }

    /// For each run in turn, for each of its points, one value per
    /// label of its cell in the order of [`Field::labels`].
    ///
    /// # Errors
    /// When the device fails.
    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>>;
}

/// Where the field is evaluated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Device {
    /// A hardware GPU when there is one, else the CPU.
    #[default]
    Auto,
    /// The CPU, all threads of the current rayon pool.
    Cpu,
    /// A GPU; a software adapter when there is no other.
    Gpu,
}

/// The field inside some boundaries.
///
/// # Errors
/// [`Error::Device`] when a GPU is asked for and none works.
pub fn new(boundaries: &Boundaries, device: Device) -> Result<Box<dyn Field>> {
    Evaluator::default().field(boundaries, device)
}

/// What evaluates one field after another, all of one method: a GPU is opened for the first, and
/// stays open.
#[derive(Default)]
pub struct Evaluator {
    gpu: Option<Arc<Opened>>,
}

impl Evaluator {
    /// The field inside some boundaries. The device is to be the same every time.
    ///
    /// # Errors
    /// As [`new`].
    pub fn field(&mut self, boundaries: &Boundaries, device: Device) -> Result<Box<dyn Field>> {
        let found = match device {
            Device::Cpu => return Ok(Box::new(Cpu::new(boundaries)?)),
            Device::Gpu => self.on_gpu(boundaries, Adapter::Any),
            Device::Auto => self.on_gpu(boundaries, Adapter::Hardware),
        };
        match found {
            Err(Error::Device(_)) if device == Device::Auto => Ok(Box::new(Cpu::new(boundaries)?)),
            found => Ok(Box::new(found?)),
        }
    }

    /// The Hermite field with what is said at nodes, in units of `unit` world units.
    ///
    /// # Errors
    /// As [`new`].
    pub fn hermite(
        &mut self,
        boundaries: &Boundaries,
        nodes: &hermite::Nodes,
        options: &hermite::Options,
        unit: f64,
        device: Device,
    ) -> Result<Box<dyn Field>> {
        let cpu = hermite::Cpu::on(boundaries, nodes, options, unit);
        let adapter = match device {
            Device::Cpu => return Ok(Box::new(cpu)),
            Device::Gpu => Adapter::Any,
            Device::Auto => Adapter::Hardware,
        };
        match self.opened(|| hermite::gpu::open(adapter)) {
            Err(Error::Device(_)) if device == Device::Auto => Ok(Box::new(cpu)),
            opened => Ok(Box::new(hermite::Gpu::on(opened?, cpu))),
        }
    }

    /// The GPU, opened if it is not yet.
    fn opened(&mut self, open: impl FnOnce() -> Result<Opened>) -> Result<Arc<Opened>> {
        Ok(match &self.gpu {
            Some(opened) => Arc::clone(opened),
            None => Arc::clone(self.gpu.insert(Arc::new(open()?))),
        })
    }

    fn on_gpu(&mut self, boundaries: &Boundaries, adapter: Adapter) -> Result<Gpu> {
        let opened = self.opened(|| Opened::new(adapter))?;
        Gpu::on(opened, boundaries)
    }
}

impl std::fmt::Debug for Evaluator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Evaluator").field("is_open", &self.gpu.is_some()).finish()
    }
}

impl Queries {
    /// How many edges `field` evaluates for these points.
    pub fn edge_evaluations(&self, field: &dyn Field) -> u64 {
        self.runs.iter().map(|run| run.points.len() as u64 * field.edges(run.cell)).sum()
    }

    /// Whether the runs cover the points in order and name existing cells.
    fn check(&self, cells: usize) -> Result<()> {
        let mut covered = 0;
        for run in &self.runs {
            let fits = run.points.start == covered && run.points.end >= covered;
            if !fits || run.cell as usize >= cells {
                return Err(bug(format!("run {run:?} does not follow point {covered}")));
            }
            covered = run.points.end;
        }
        if covered == self.points.len() {
            Ok(())
        } else {
            Err(bug(format!("runs cover {covered} of {} points", self.points.len())))
        }
    }
}

fn bug(what: impl Into<String>) -> Error {
    Error::Bug { stage: "field", what: what.into() }
}
