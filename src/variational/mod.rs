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
//! It is solved from coarse to fine (`label_field`): on the whole box with about 48
//! voxels on its longest side, where it is decided how parts hang together, then in
//! a narrow band around the surface and the contours on ever finer lattices, started
//! from the interpolated level below, which is also the band's boundary condition.
//!
//! The same energy smooths a surface that another method made ([`smoothing`]).
//!
//! ```text
//! metric ─► outline, plane_samples ─► label_field: level ─► system ─► backend ─► level … ─► assembly ─► Samples
//! ```

mod anchor;
mod assembly;
mod backend;
mod cpu;
mod gpu;
mod label_field;
mod level;
mod metric;
mod outline;
mod plane_samples;
mod segments;
pub mod smoothing;
pub(crate) mod specks;
mod stencil;
mod system;
mod trial;

#[cfg(test)]
mod contract;
#[cfg(test)]
mod reference;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::field::{Adapter, Device};
use crate::grid::lattice::Resolution;
use crate::grid::samples::{Lattice, Samples};
use crate::label::Label;
use crate::method::Variational;
use crate::plane::{Bounds, Plane};
use crate::progress::Progress;
use crate::section::Section;
use crate::section::ends::{End, ends};
use crate::section::reach::{reaches_with, space};

use backend::Backend;
use cpu::Cpu;
use gpu::Gpu;
use label_field::{LabelField, Scene};
use metric::Metric;
use plane_samples::{Region, plane_samples};
use specks::remove_specks;

pub use trial::{Rate, Trial};

/// Voxels on the longest side of the box on which all of it is solved for.
const WHOLE_VOXELS: f64 = 48.0;
/// The voxels on the longest side for which the soft values' weight is given.
const UNIT_VOXELS: f64 = 96.0;
/// How far that box reaches beyond contours within their planes, relative to the
/// diagonal of them all. The given one is near to the surface; half way between two
/// sections the −d on its faces, whose d is larger there, would draw a waist.
const WIDE: f64 = 0.15;
/// How far beyond the last sections of a stack, in spacings: what is −d there is 0
/// a little less than half a spacing beyond.
const BEYOND: f64 = 1.25;
/// Nodes there are to be at least then, in a box that is long.
const WHOLE_NODES: f64 = 45_000.0;
/// Systems with fewer unknowns stay on the CPU when the device is chosen
/// automatically: its threads are done with an iteration in about the time that a GPU
/// takes to begin the five dispatches of one.
const FEW_UNKNOWNS: u64 = 50_000;
/// Levels between that one and the given lattice have so many voxels on the longest side
/// of the box that is filled, or 2, 4, 8 … times as many: whatever is asked for, the
/// shape comes from the same levels.
const NARROW_VOXELS: f64 = 64.0;
/// The next finer level has voxels smaller by this factor at least, but for the given
/// lattice.
const STEP: f64 = 1.3;

/// By how much of a voxel a node may be beyond an end, for rounding.
const ROUNDING: f64 = 1e-6;

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

/// The samples of the variational field.
///
/// # Errors
/// [`Error::Device`] when a GPU is asked for and none works.
pub fn variational(
    sections: &[Section],
    bounds: Bounds,
    lattice: &Lattice,
    method: &Variational,
    progress: &dyn Progress,
) -> Result<Solved> {
    let backend = backend(method.device)?;
    let space = Space::around(sections, bounds, method.border, lattice)?;
    let scene = scene(sections, &space, method, backend.as_ref());
    let (samples, effort, specks) = solve(&scene, "field", progress)?;
    Ok(Solved { samples, effort, specks, device: backend.name() })
}

/// Solves for all labels and removes specks; how many, comes last.
fn solve(
    scene: &Scene,
    stage: &'static str,
    progress: &dyn Progress,
) -> Result<(Samples, Effort, u64)> {
    let labels = labels(scene.sections);
    progress.begin(stage, labels.len() as u64);
    let fields: Vec<LabelField> = labels
        .par_iter()
        .map(|&label| {
            let field = LabelField::new(scene, label)?;
            progress.advance(1);
            Ok(field)
        })
        .collect::<Result<_>>()?;
    let mut effort = Effort::default();
    for field in &fields {
        effort.unknowns += field.effort.unknowns;
        effort.updates += field.effort.updates;
    }
    let mut samples = assembly::assemble(fields, scene);
    let specks = remove_specks(&mut samples, scene.sections, scene.space.bounds) as u64;
    Ok((samples, effort, specks))
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
) -> Scene<'a> {
    let &Space { bounds, wide, ref lattices, whole, .. } = space;
    let everywhere =
        |lattice: &Lattice| plane_samples(sections, wide, lattice.voxel, Region::Everywhere);
    let metric = Metric::new(sections);
    Scene {
        sections,
        space,
        metric,
        directions: metric.directions(),
        is_open: method.border == Label::UNKNOWN,
        samples: lattices[..whole].iter().map(everywhere).collect(),
        unit: metric.length() * bounds.size().max_element() / UNIT_VOXELS,
        weights: &method.weights,
        original: None,
        backend,
    }
}

/// The labels that get a field: with a single material that one alone, since the
/// field of *outside* is the same but for its sign.
fn labels(sections: &[Section]) -> Vec<Label> {
    let mut labels: Vec<Label> = sections.iter().flat_map(Section::labels).collect();
    labels.retain(|label| label.is_material());
    labels.sort_unstable();
    labels.dedup();
    if labels.len() > 1 {
        labels.insert(0, Label::OUTSIDE);
    }
    labels
}

/// Where is solved.
struct Space {
    /// The box that the result fills.
    bounds: Bounds,
    /// The box of the coarse lattices, around it.
    wide: Bounds,
    /// From the coarsest to the given one.
    lattices: Vec<Lattice>,
    /// So many of them are solved on the whole box, at least two.
    whole: usize,
    /// Beyond them is nothing, as beyond the wide box: a stack that leans has its box's
    /// corners there.
    wide_ends: Vec<Plane>,
    /// The same for the given box.
    ends: Vec<Plane>,
}

impl Space {
    /// Around sections, with a wide box unless the given one is open.
    fn around(
        sections: &[Section],
        bounds: Bounds,
        border: Label,
        finest: &Lattice,
    ) -> Result<Self> {
        let wide = space(sections, WIDE, BEYOND).filter(|_| border != Label::UNKNOWN);
        let Some(wide) = wide else { return Self::new(bounds, bounds, finest) };
        let reaches = reaches_with(sections, WIDE);
        let all = ends(sections);
        let wide_end = |end: &End| end.beyond(BEYOND * reaches[end.section]);
        let wide_ends = all.iter().map(wide_end).collect();
        let ends = all.iter().map(|end| end.beyond(end.reach)).collect();
        Ok(Self { wide_ends, ends, ..Self::new(bounds, bounds.union(wide), finest)? })
    }

    /// The given lattice is itself solved on all of its box when it is as coarse as what
    /// would be.
    fn new(bounds: Bounds, wide: Bounds, finest: &Lattice) -> Result<Self> {
        let longest = wide.size().max_element() / WHOLE_VOXELS;
        let coarse = longest.min((wide.volume() / WHOLE_NODES).cbrt());
        let is_coarse = finest.voxel >= coarse;
        let whole = if is_coarse { finest.voxel } else { coarse };
        let on = |bounds: Bounds, voxel: f64| Lattice::new(bounds, Resolution::VoxelSize(voxel));
        let second = if is_coarse { *finest } else { on(wide, whole)? };
        let mut lattices = vec![on(wide, 2.0 * whole)?, second];
        let mut voxel = bounds.size().max_element() / NARROW_VOXELS;
        while voxel >= finest.voxel * STEP {
            if voxel * STEP < whole {
                lattices.push(on(bounds, voxel)?);
            }
            voxel /= 2.0;
        }
        if !is_coarse {
            lattices.push(*finest);
        }
        Ok(Self { bounds, wide, lattices, whole: 2, wide_ends: Vec::new(), ends: Vec::new() })
    }

    /// Whether nodes of a lattice are beyond an end. So many are asked for that it is a
    /// matter of a product.
    fn beyond(&self, lattice: &Lattice) -> impl Fn([i32; 3]) -> bool + use<> {
        let ends = if self.is_wide(lattice) { &self.wide_ends } else { &self.ends };
        let in_nodes = |end: &Plane| {
            let height = -end.distance(lattice.origin) / lattice.voxel;
            (end.unit_normal(), height + ROUNDING)
        };
        let ends: Vec<(DVec3, f64)> = ends.iter().map(in_nodes).collect();
        move |node| {
            let node = IVec3::from_array(node).as_dvec3();
            ends.iter().any(|&(normal, height)| normal.dot(node) > height)
        }
    }

    /// Whether a lattice is one over the wide box.
    fn is_wide(&self, lattice: &Lattice) -> bool {
        let finest = self.lattices.last().map_or(0.0, |finest| finest.voxel);
        lattice.voxel >= self.lattices[self.whole - 1].voxel && lattice.voxel > finest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_lattice_is_the_given_one_and_those_before_are_always_the_same() {
        for size in [DVec3::ONE, DVec3::new(1.0, 0.3, 0.2), DVec3::new(0.6, 1.0, 1.0)] {
            let bounds = Bounds { min: -size, max: size };
            let wide = bounds.grown(0.3);
            let spaces = (16..=300).map(|voxels| {
                let finest = Lattice::new(bounds, Resolution::Voxels(voxels)).unwrap();
                let space = Space::new(bounds, wide, &finest).unwrap();
                assert_eq!(space.lattices.last(), Some(&finest), "{voxels}");
                let [before @ .., _] = &space.lattices[..] else { panic!() };
                assert!(before.is_sorted_by(|a, b| a.voxel >= b.voxel * STEP));
                assert!(space.lattices.is_sorted_by(|a, b| a.voxel > b.voxel));
                space
            });
            let spaces: Vec<Space> = spaces.collect();
            let [.., largest] = &spaces[..] else { panic!() };
            for space in spaces.iter().filter(|space| space.lattices.len() > 2) {
                let given = space.lattices.len() - 1;
                assert_eq!(space.lattices[..given], largest.lattices[..given]);
            }
        }
    }
}
