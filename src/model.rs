//! The model: sections and everything derived from them.
//!
//! Sections are ground state; arrangement, samples and mesh follow from them.
//! Only [`Model::apply`] changes a model, all or nothing.

use crate::arrangement::Arrangement;
use crate::change::Change;
use crate::error::{Error, Result};
use crate::field::{self, Boundaries, Device};
use crate::grid::lattice::Resolution;
use crate::grid::memory::require_memory;
use crate::grid::samples::{Lattice, Samples};
use crate::grid::sampling::{Margin, Starts, sample};
use crate::grid::smoothing::{SMOOTHING_MARGIN, smoothed};
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::delaunay::{self, delaunay};
use crate::mesh::dual::dual;
use crate::mesh::fairing::{FairingOptions, fair};
use crate::oracle::Oracle;
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::{Rules, Section, Sections};
use crate::skeleton::{self, Details, skeleton};
use crate::stage::Stages;

/// How far the box reaches beyond all contours, relative to their diagonal.
const MARGIN: f64 = 0.05;

/// How near to a plane the field is told from its limit, in voxels: nearer
/// points are taken to be this far away. On the plane the indicator is a
/// step, in which an interpolated crossing would be lost.
pub(crate) const CLEARANCE: f64 = 0.02;

/// Steps of smoothing on each of fairing's levels.
const FAIRING_STEPS: u32 = 10;

/// How a model is derived from its sections.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// How space between the sections is filled.
    pub method: Method,
    /// How fine the grid is.
    pub resolution: Resolution,
    /// Steps of bi-Laplacian smoothing (Bermano §4.6).
    pub smooth: u32,
    /// Where the field is evaluated.
    pub device: Device,
    /// What is on the box's faces: [`Label::OUTSIDE`] closes every surface in
    /// the box, [`Label::UNKNOWN`] lets materials leave it.
    pub border: Label,
    /// How finely unknown regions are triangulated to be completed: the length
    /// of an edge in world units, a 16th of the box's longest side when none
    /// is given.
    pub spacing: Option<f64>,
    /// How the surface is made from the samples.
    pub mesher: Mesher,
}

/// How space between the sections is filled.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Method {
    /// By the mean-value indicator (Bermano et al. 2011).
    #[default]
    MeanValue,
    /// By the nearest section, exactly (Barequet and Vaxman 2009). Neither
    /// smoothing nor mesher nor device matter to it.
    Skeleton {
        /// How that is done.
        options: skeleton::Options,
        /// Whether the surface is made fair afterwards.
        fairing: Option<Fairing>,
    },
}

/// How an exact surface is made fair.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Fairing {
    /// How long edges are to be, in world units; a voxel when it is not given.
    pub edge_length: Option<f64>,
}

/// How the surface is made from the samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Mesher {
    /// Dual contouring.
    #[default]
    Dual,
    /// Delaunay refinement.
    Delaunay(delaunay::Options),
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::MeanValue,
            resolution: Resolution::Voxels(256),
            smooth: 4,
            device: Device::Auto,
            border: Label::OUTSIDE,
            spacing: None,
            mesher: Mesher::Dual,
        }
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
pub struct Derived {
    /// The cells between the sections, where the field was asked.
    pub arrangement: Option<Arrangement>,
    /// The field's values near the surface, smoothed.
    pub samples: Samples,
    /// The network of surfaces.
    pub mesh: Mesh,
    /// The backend that evaluated the field.
    pub device: String,
    /// What else an exact reconstruction says.
    pub exact: Option<Details>,
}

impl Model {
    /// A model without sections.
    pub fn new(options: Options) -> Self {
        Self { options, sections: Sections::default(), derived: None }
    }

    /// Changes the sections and derives everything anew; the model stays as it
    /// was when that fails.
    ///
    /// # Errors
    /// When there is no contour at all, when sections on one plane contradict
    /// each other, when the grid would not fit into memory, or when a stage
    /// fails.
    pub fn apply(
        &mut self,
        change: Change,
        rules: &Rules,
        stages: &mut Stages,
        progress: &dyn Progress,
    ) -> Result<()> {
        let Change::Add(added) = change;
        let sections = if self.derived.is_none() {
            added
        } else {
            Sections::join(vec![self.sections.clone(), added], rules)?
        };
        let derived = derive(&sections, &self.options, stages, progress)?;
        self.sections = sections;
        self.derived = Some(derived);
        Ok(())
    }

    /// How the model is derived.
    pub fn options(&self) -> &Options {
        &self.options
    }

    /// The sections.
    pub fn sections(&self) -> &Sections {
        &self.sections
    }

    /// What follows from the sections; `None` before the first change.
    pub fn derived(&self) -> Option<&Derived> {
        self.derived.as_ref()
    }
}

/// The box: all contours with a margin, in which the surface closes.
///
/// # Errors
/// When there is no contour, or nothing known at all.
fn bounds_of(sections: &Sections) -> Result<Bounds> {
    sections.require_known()?;
    let Some(contours) = sections.bounds() else {
        return Err(Error::Option(
            "there is nothing to reconstruct: no section has a contour".to_owned(),
        ));
    };
    Ok(contours.grown(MARGIN * contours.diagonal()))
}

/// The whole way from sections to the mesh.
fn derive(
    sections: &Sections,
    options: &Options,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> Result<Derived> {
    let all = &sections.sections;
    let bounds = bounds_of(sections)?;
    let lattice = Lattice::new(bounds, options.resolution)?;
    require_memory(&lattice, all, sections.materials.len())?;
    match &options.method {
        Method::MeanValue => derive_field(all, bounds, &lattice, options, stages, progress),
        Method::Skeleton { options, fairing } => {
            let (options, fairing) = (*options, *fairing);
            derive_skeleton(all, bounds, &lattice, options, fairing, stages, progress)
        }
    }
}

/// Exactly; the samples only say labels. Where there are too many partial
/// sections for that, from nearest points on the grid.
fn derive_skeleton(
    sections: &[Section],
    bounds: Bounds,
    lattice: &Lattice,
    options: skeleton::Options,
    fairing: Option<Fairing>,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> Result<Derived> {
    let mut made = stages.run("skeleton", |counts| {
        let made = skeleton(sections, bounds, &options, progress)?;
        counts.insert("cells".into(), made.details.cells.into());
        counts.insert("vertices".into(), made.mesh.vertices.len() as u64);
        counts.insert("triangles".into(), made.mesh.triangles.len() as u64);
        Ok(made)
    })?;
    let oracle = Oracle::new(sections, bounds, Label::OUTSIDE)?;
    let is_exact = made.details.left_out.is_empty();
    let samples = stages.run("labels", |counts| {
        progress.begin("labels", 0);
        let samples = match is_exact {
            true => oracle.sample_labels(lattice, progress)?,
            false => oracle.sample(lattice, progress)?,
        };
        counts.insert("leaves".into(), samples.leaves.len() as u64);
        Ok(samples)
    })?;
    if !is_exact {
        made.mesh = stages.run("mesh", |_| dual(&samples, progress))?;
    } else if let Some(fairing) = fairing {
        let edge_length = fairing.edge_length.unwrap_or(lattice.voxel);
        let options = FairingOptions { edge_length, steps: FAIRING_STEPS };
        made.mesh = stages.run("fairing", |counts| {
            progress.begin("fairing", 0);
            let mesh = fair(&made.mesh, &made.details.contours, &options)?;
            counts.insert("triangles".into(), mesh.triangles.len() as u64);
            Ok(mesh)
        })?;
    }
    let (device, exact) = ("exact arithmetic".to_owned(), Some(made.details));
    Ok(Derived { arrangement: None, samples, mesh: made.mesh, device, exact })
}

/// By the mean-value field.
fn derive_field(
    all: &[Section],
    bounds: Bounds,
    lattice: &Lattice,
    options: &Options,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> Result<Derived> {
    let arrangement = stages.run("arrangement", |counts| {
        progress.begin("arrangement", 0);
        let arrangement = Arrangement::new(all, bounds, options.border)?;
        let sound = arrangement.sanity_check();
        sound.map_err(|what| Error::Bug { stage: "arrangement", what })?;
        counts.insert("planes".into(), all.len() as u64);
        counts.insert("faces".into(), arrangement.faces().len() as u64);
        counts.insert("cells".into(), arrangement.cells().len() as u64);
        Ok(arrangement)
    })?;
    let boundaries = stages.run("completion", |counts| {
        progress.begin("completion", 0);
        let clearance = CLEARANCE * lattice.voxel;
        let boundaries = Boundaries::new(&arrangement, clearance, options.spacing)?;
        let completion = boundaries.completion();
        counts.insert("triangles of unknown regions".into(), completion.triangle_count() as u64);
        counts.insert("corners".into(), completion.corner_count() as u64);
        counts.insert("sweeps".into(), completion.sweeps().into());
        Ok(boundaries)
    })?;
    let (samples, device) = stages.run("field", |counts| {
        let field = field::new(&boundaries, options.device)?;
        let margin = if options.smooth > 0 { SMOOTHING_MARGIN } else { Margin(1) };
        let starts = Starts { sections: all, completion: boundaries.completion() };
        let sampling = sample(&arrangement, field.as_ref(), &starts, lattice, margin, progress)?;
        counts.insert("leaves".into(), sampling.samples.leaves.len() as u64);
        counts.insert("evaluations".into(), sampling.points);
        Ok((sampling.samples, field.name()))
    })?;
    let samples = stages.run("smoothing", |counts| {
        progress.begin("smoothing", 0);
        counts.insert("steps".into(), options.smooth.into());
        smoothed(samples, all, bounds, options.smooth)
    })?;
    let mesh = stages.run("mesh", |counts| {
        let mesh = match &options.mesher {
            Mesher::Dual => dual(&samples, progress)?,
            Mesher::Delaunay(limits) => delaunay(&samples, limits, progress)?,
        };
        counts.insert("vertices".into(), mesh.vertices.len() as u64);
        counts.insert("triangles".into(), mesh.triangles.len() as u64);
        Ok(mesh)
    })?;
    Ok(Derived { arrangement: Some(arrangement), samples, mesh, device, exact: None })
}
