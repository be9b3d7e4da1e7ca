//! What a cross-check found, for people and for programs. The JSON form is
//! described in `docs/crosscheck.md`.

use serde::Serialize;

use super::Kind;
use super::against::Against;
use super::agreement::Agreement;
use super::certain::Points;
use super::gap::Gap;
use super::pairing::Pairing;
use super::parts::Part;
use super::solids::LabelSolids;
use crate::error::Result;
use crate::ffi::measure::library_versions;
use crate::label::Material;
use crate::model::Model;
use crate::section::{Disagreement, Warning};
use crate::skeleton::Details;
use crate::stage::{Stage, Stages};

/// The version of the JSON form.
const VERSION: u32 = 1;

/// Everything there is to say about how two reconstructions differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Crosscheck {
    /// Always `"crosscheck"`.
    pub transect: &'static str,
    /// The version of this form.
    pub version: u32,
    /// The program's version and those of the libraries it was built with.
    pub program: String,
    /// The files that the sections came from.
    pub files: Vec<String>,
    /// How many sections there are.
    pub sections: usize,
    /// The unit of length; empty when unknown.
    pub units: String,
    /// The frame of the coordinates; empty when unknown.
    pub frame: String,
    /// The names of the materials, by number.
    pub materials: Vec<Material>,
    /// Which field it is.
    pub method: Kind,
    /// What evaluated the field.
    pub device: String,
    /// The grid's nodes along each axis.
    pub nodes: [i32; 3],
    /// The side of a voxel, in world units.
    pub voxel: f64,
    /// What was found.
    #[serde(flatten)]
    pub found: Found,
    /// What was doubtful about the sections.
    pub warnings: Vec<Warning>,
    /// What was left out of them.
    pub left_out: Vec<Warning>,
    /// Where sections contradict each other along their common lines.
    pub disagreements: Vec<Disagreement>,
    /// What each stage took.
    pub stages: Vec<Stage>,
    /// All stages together, by the wall clock.
    pub seconds: f64,
    /// The largest resident size of the program, in bytes; 0 where the system
    /// does not tell.
    pub peak_memory: u64,
}

/// How two reconstructions differ.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// How the skeleton's surface was made.
    pub skeleton: SkeletonReport,
    /// The labels of the lattice's nodes.
    pub agreement: Agreement,
    /// Random points, and where the two must agree; none where that is not
    /// known of the field.
    pub points: Option<Points>,
    /// Connected parts of the lattice in which they differ.
    pub part_count: usize,
    /// The deepest of them.
    pub parts: Vec<Part>,
    /// What is joined within cells.
    pub pairing: Pairing,
    /// Every label's surface.
    pub labels: Vec<LabelSolids>,
    /// How far the surfaces are from each other.
    pub distances: Distances,
    /// Ours and the one that the user brought.
    pub against: Option<Against>,
}

/// How the skeleton's surface was made.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct SkeletonReport {
    /// Whether its vertices are the exact ones, rounded; else the oracle was
    /// sampled on the grid, and the surface is within a voxel.
    pub exact: bool,
    /// Its vertices.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// What else an exact one has to say.
    #[serde(flatten)]
    pub details: Details,
}

/// How far surfaces are from each other, in voxels; none where one of them is
/// missing or has no triangle.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Distances {
    /// From the field's surface by the dual mesher to the skeleton's and back.
    pub dual_skeleton: Option<Gap>,
    /// From the field's surface by the dual mesher to that by the delaunay
    /// mesher and back.
    pub dual_delaunay: Option<Gap>,
}

impl Crosscheck {
    /// The report on a model.
    ///
    /// # Errors
    /// When nothing was derived.
    pub fn new(model: &Model, method: Kind, found: Found, stages: &Stages) -> Result<Self> {
        let derived = super::derived(model)?;
        let sections = model.sections();
        Ok(Self {
            transect: "crosscheck",
            version: VERSION,
            program: format!("transect {}, {}", env!("CARGO_PKG_VERSION"), library_versions()),
            files: sections.files.iter().map(|file| file.display().to_string()).collect(),
            sections: sections.sections.len(),
            units: sections.units.clone(),
            frame: sections.frame.clone(),
            materials: sections.materials.clone(),
            method,
            device: derived.device.clone(),
            nodes: derived.samples.lattice.dims,
            voxel: derived.samples.lattice.voxel,
            found,
            warnings: sections.warnings.clone(),
            left_out: sections.left_out.clone(),
            disagreements: sections.disagreements(),
            stages: stages.stages.clone(),
            seconds: stages.seconds(),
            peak_memory: stages.peak_memory(),
        })
    }
}
