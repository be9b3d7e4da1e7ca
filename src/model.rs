//! The model: sections and everything derived from them.
//!
//! Sections are ground state; arrangement, samples and mesh follow from them.
//! Only [`Model::apply`] changes a model, all or nothing.

use glam::DVec3;

use crate::arrangement::Arrangement;
use crate::change::Change;
use crate::error::{Error, Result};
use crate::field::{self, Device};
use crate::grid::samples::{Lattice, Samples};
use crate::label::Label;
use crate::mesh::Mesh;
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::Sections;
use crate::stage::Stages;

/// How far the box reaches beyond all contours, relative to their diagonal.
const MARGIN: f64 = 0.05;

/// How near to a plane the field is told from its limit, in voxels: nearer
/// points are taken to be this far away. On the plane the indicator is a
/// step, in which an interpolated crossing would be lost.
const CLEARANCE: f64 = 0.02;

/// How fine the grid is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// Voxels on the longest side of the box.
    Longest(u32),
    /// The side of a voxel, in world units.
    VoxelSize(f64),
}

/// How a model is derived from its sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How fine the grid is.
    pub resolution: Resolution,
    /// Steps of bi-Laplacian smoothing (Bermano §4.6).
    pub smooth: u32,
    /// Where the field is evaluated.
    pub device: Device,
}

impl Default for Options {
    fn default() -> Self {
        Self { resolution: Resolution::Longest(256), smooth: 4, device: Device::Auto }
    }
}

/// Sections and everything derived from them.
#[derive(Debug)]
pub struct Model {
    options: Options,
    sections: Sections,
    derived: Option<Derived>,
}

/// What follows from the sections.
#[derive(Debug)]
struct Derived {
    arrangement: Arrangement,
    samples: Samples,
    mesh: Mesh,
}

impl Model {
    /// A model without sections.
    pub fn new(options: Options) -> Self {
        Self { options, sections: Sections::default(), derived: None }
    }

    /// Changes the sections and derives everything anew; leaves the model as
    /// it was when that fails.
    ///
    /// # Errors
    /// When the sections contradict each other, when the grid would not fit
    /// into memory, or when a stage fails.
    pub fn apply(
        &mut self,
        change: Change,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<()> {
        let Change::Add(added) = change;
        let sections = self.sections.clone().joined(added)?;
        let derived = derive(&sections, &self.options, stages, progress)?;
        self.sections = sections;
        self.derived = Some(derived);
        Ok(())
    }

    /// The sections.
    pub fn sections(&self) -> &Sections {
        &self.sections
    }
}
