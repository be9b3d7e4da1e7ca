//! The variational field: for every label the smoothest function that the
//! sections allow.
//!
//! In voxels of the lattice it is solved on, the field f of a label minimises
//!
//! ```text
//! Σ ‖Hess f‖²  +  10 Σ_contours f²  +  w Σ_planes (f − s)²  +  10 Σ_planes max(0, m − σ f)²
//! ```
//!
//! - contours are those of the label, sampled every half voxel;
//! - planes are the known parts of all sections, sampled every voxel: σ is 1 where
//!   the section says this label and −1 elsewhere, d the distance to the nearest
//!   contour of the label on any section, s = σ d, and m = min(d, ½);
//! - the last sum is over samples on the wrong side, or nearer to the surface than m.
//!   Which these are is found by solving several times (an *active set*);
//! - the soft values s are wanted at one sample in four, which counts for all: they are
//!   smooth, and to look for the distances takes longer than to solve;
//! - w is small: it gives shape to what no contour is near to, and keeps what is thin. It
//!   is the same physical weight on all levels but the finest, which does without: its
//!   distances are many and change nothing that is left for it to do;
//! - second derivatives and distances are those of a space that is squeezed across stacks
//!   of sections (`metric`);
//! - beyond a closed box, and as far beyond the ends of a stack that leans in it, f is −d
//!   (for *outside* d), and that box is wider than the one that is filled; at an open one the boundary is natural: the sum over the Hessian
//!   ends there.
//!
//! The mean-value indicator meets every section at a right angle, and so makes beads
//! between parallel ones; this one goes through them as a bent plate would. A label
//! is where its field is the largest of all; *outside* has one like the others.
//!
//! It is solved from coarse to fine (`label_field`): on the whole box with 24 voxels or
//! some more on its longest side, then in a wide band around the surface with twice as many,
//! where it is decided how parts hang together, then in a narrow one around the surface and
//! the contours on ever finer lattices, each started from the interpolated level below, which
//! is also the band's boundary condition. On all narrow ones but the first λ Σ (f − start)² is added over the band's nodes: what is longer
//! than ℓ = λ^(−¼) has been solved for below, and is not again.
//!
//! The same energy smooths a surface that another method made ([`smoothing`]).
//!
//! ```text
//! metric ─► outline, plane_samples ─► label_field: level ─► system ─► backend ─► level … ─► grid::assembly ─► Samples
//! ```

mod anchor;
mod backend;
mod cpu;
mod differences;
mod gpu;
mod kept;
mod label_field;
mod level;
mod metric;
mod outline;
pub(crate) mod plane_samples;
pub mod smoothing;
mod space;
pub(crate) mod specks;
mod stencil;
mod system;
mod trial;

#[cfg(test)]
mod contract;
#[cfg(test)]
mod reference;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::{Adapter, Device};
use crate::grid::assembly::assemble;
use crate::grid::frame::Frame;
use crate::grid::samples::{Lattice, Samples};
use crate::label::Label;
use crate::method::Variational;
use crate::progress::Progress;
use crate::section::Section;

use backend::Backend;
use cpu::Cpu;
use gpu::Gpu;
use kept::Before;
pub(crate) use kept::Kept;
use label_field::{LabelField, Scene};
use metric::Metric;
use plane_samples::{Region, plane_samples};
use space::Space;
use specks::remove_specks;

pub use trial::{Rate, Trial};

/// The voxels on the longest side for which the soft values' weight is given.
const UNIT_VOXELS: f64 = 96.0;
/// Systems with fewer unknowns stay on the CPU when the device is chosen
/// automatically: its threads are done with an iteration in about the time that a GPU
/// takes to begin the five dispatches of one.
const FEW_UNKNOWNS: u64 = 50_000;

/// What counts how much.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// The weight w of the soft values with 96 voxels on the box's longest side.
    pub soft: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self { soft: 0.04 }
    }
}

impl Weights {
    /// w on a level; `unit` are the voxels it is given for.
    fn soft_weight(&self, voxel: f64, unit: f64) -> f32 {
        (self.soft * (voxel / unit).powi(3)) as f32
    }
}

/// What solving took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Effort {
    /// Unknowns of all systems together.
    pub unknowns: u64,
    /// Unknowns times iterations of all systems together.
    pub updates: u64,
}

impl Effort {
    fn add(&mut self, unknowns: u64, iterations: u32) {
        self.unknowns += unknowns;
        self.updates += unknowns * u64::from(iterations);
    }
}

/// A solved field.
#[derive(Debug, Clone, PartialEq)]
pub struct Solved {
    /// The samples.
    pub samples: Samples,
    /// What it took.
    pub effort: Effort,
    /// Pieces and bubbles that no section speaks for, and that were removed.
    pub specks: u64,
    /// What it was solved on, for people to read.
    pub device: String,
}

/// The samples of the variational field. What is `kept` of the field of other sections
/// in the same frame, or one that [continues](Frame::continues) it, saves solving for what both have in common; with `keeps` it is what this
/// one leaves behind afterwards.
///
/// # Errors
/// [`Error::Device`] when a GPU is asked for and none works; then `kept` is as it was.
pub(crate) fn variational(
    sections: &[Section],
    frame: &Frame,
    method: &Variational,
    (keeps, kept): (bool, &mut Option<Kept>),
    solver: &mut KeptBackend,
    progress: &dyn Progress,
) -> Result<Solved> {
    let backend = solver.on(method.device)?;
    let space = Space::around(sections, method.border, frame)?;
    let scene = scene(sections, &space, method, backend, progress);
    solve(scene, (keeps, kept), "field")
}

/// Solves for all labels and removes specks.
fn solve(
    mut scene: Scene,
    (keeps, kept): (bool, &mut Option<Kept>),
    stage: &'static str,
) -> Result<Solved> {
    scene.keeps = keeps;
    let progress = scene.progress;
    let labels = labels(scene.sections);
    progress.begin(stage, labels.len() as u64);
    let before = kept.as_ref().and_then(|kept| kept.before(&scene));
    let mut fields: Vec<LabelField> = labels
        .par_iter()
        .map(|&label| {
            let field = LabelField::new(&scene, before.as_ref(), label)?;
            progress.advance(1);
            Ok(field)
        })
        .collect::<Result<_>>()?;
    let mut effort = Effort::default();
    for field in &fields {
        effort.unknowns += field.effort.unknowns;
        effort.updates += field.effort.updates;
    }
    let metric = before.as_ref().map_or(scene.metric, Before::metric);
    *kept = keeps.then(|| Kept::new(&scene, metric, &mut fields));
    let open = scene.is_open.then_some(scene.space.frame.bounds);
    let starts = fields.iter().flat_map(|field| field.band.iter().copied()).collect();
    let lattice = scene.space.lattices[scene.space.lattices.len() - 1];
    let mut samples = assemble(fields, starts, lattice, open);
    let specks = remove_specks(&mut samples, scene.sections, scene.space.frame.bounds) as u64;
    Ok(Solved { samples, effort, specks, device: scene.backend.name() })
}

/// What solves for one field after another: opened for the first, and kept.
#[derive(Default)]
pub(crate) struct KeptBackend(Option<Box<dyn Backend>>);

impl KeptBackend {
    /// On a device, which is to be the same every time.
    ///
    /// # Errors
    /// [`Error::Device`] when a GPU is asked for and none works.
    fn on(&mut self, device: Device) -> Result<&dyn Backend> {
        Ok(match &mut self.0 {
            Some(own) => &**own,
            none => &**none.insert(backend(device)?),
        })
    }
}

impl std::fmt::Debug for KeptBackend {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("KeptBackend").field(&self.0.as_ref().map(|own| own.name())).finish()
    }
}

/// What a device stands for.
fn backend(device: Device) -> Result<Box<dyn Backend>> {
    match device {
        Device::Cpu => Ok(Box::new(Cpu::new())),
        Device::Gpu => Ok(Box::new(Gpu::new(Adapter::Any)?)),
        Device::Auto => match Gpu::new(Adapter::Hardware) {
            Ok(gpu) => Ok(Box::new(gpu.sparing(FEW_UNKNOWNS))),
            Err(Error::Device(_)) => backend(Device::Cpu),
            Err(other) => Err(other),
        },
    }
}

fn scene<'a>(
    sections: &'a [Section],
    space: &'a Space,
    method: &'a Variational,
    backend: &'a dyn Backend,
    progress: &'a dyn Progress,
) -> Scene<'a> {
    let Space { frame, lattices, whole, .. } = space;
    let everywhere = |lattice: &Lattice| {
        plane_samples(sections, space.sampled(lattice), lattice.voxel, Region::Everywhere)
    };
    let metric = Metric::new(sections);
    Scene {
        sections,
        space,
        metric,
        directions: metric.directions(),
        is_open: method.border == Label::UNKNOWN,
        samples: lattices[..*whole].iter().map(everywhere).collect(),
        unit: metric.length() * frame.size() / UNIT_VOXELS,
        weights: &method.weights,
        original: None,
        keeps: false,
        backend,
        progress,
    }
}

/// The labels that get a field: with a single material that one alone, since the
/// field of *outside* is the same but for its sign.
pub(crate) fn labels(sections: &[Section]) -> Vec<Label> {
    let mut labels: Vec<Label> = sections.iter().flat_map(Section::labels).collect();
    labels.retain(|label| label.is_material());
    labels.sort_unstable();
    labels.dedup();
    if labels.len() > 1 {
        labels.insert(0, Label::OUTSIDE);
    }
    labels
}
