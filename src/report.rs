//! What a reconstruction is worth, for people and for programs. The JSON form
//! is described in `docs/report.md`.

use serde::Serialize;

use crate::check::Check;
use crate::choice::Choice;
use crate::ffi::measure::library_versions;
use crate::layers::LayerReport;
use crate::mesh::decimation::Outcome;
use crate::model::{Derived, Model};
use crate::section::{Disagreement, Warning};
use crate::skeleton::Details;
use crate::stack::Links;
use crate::stage::{Stage, Stages};

/// The version of the JSON form.
const VERSION: u32 = 1;

/// Everything there is to say about a reconstruction.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Always `"report"`.
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
    pub materials: Vec<crate::label::Material>,
    /// The method that was chosen and why, where that was left to the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choice: Option<Choice>,
    /// The layers, where structures that may overlap were reconstructed one by one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub layers: Vec<LayerReport>,
    /// What evaluated the field.
    pub device: String,
    /// The grid's nodes along each axis.
    pub nodes: [i32; 3],
    /// The side of a voxel, in world units.
    pub voxel: f64,
    /// What an exact reconstruction says besides.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exact: Option<Details>,
    /// The parts of a stack that are linked, or would be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub links: Option<Links>,
    /// What making the surface simpler did, when it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimation: Option<Outcome>,
    /// What the result is worth.
    pub check: Check,
    /// What was doubtful about the sections, and then what is about the result.
    pub warnings: Vec<Warning>,
    /// What was left out of them.
    pub left_out: Vec<Warning>,
    /// How files were understood where they leave a choice.
    pub notes: Vec<Warning>,
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

impl Report {
    /// The report of a model that was derived and checked.
    pub(crate) fn new(model: &Model, derived: &Derived, check: Check, stages: &Stages) -> Self {
        let sections = model.sections();
        let mut report = Self {
            transect: "report",
            version: VERSION,
            program: format!("transect {}, {}", env!("CARGO_PKG_VERSION"), library_versions()),
            files: sections.files.iter().map(|file| file.display().to_string()).collect(),
            sections: sections.sections.len(),
            units: sections.units.clone(),
            frame: sections.frame.clone(),
            materials: sections.materials.clone(),
            choice: None,
            layers: Vec::new(),
            device: derived.device.clone(),
            nodes: derived.samples.lattice.dims,
            voxel: derived.samples.lattice.voxel,
            exact: derived.exact.clone(),
            links: derived.links.clone(),
            decimation: derived.decimation,
            check,
            warnings: sections.warnings.clone(),
            left_out: sections.left_out.clone(),
            notes: sections.notes.clone(),
            disagreements: sections.disagreements(),
            stages: stages.stages.clone(),
            seconds: stages.seconds(),
            peak_memory: stages.peak_memory(),
        };
        let found = report.found();
        report.warnings.extend(found);
        report
    }

    /// What a reader should be warned of about the result.
    pub fn found(&self) -> Vec<Warning> {
        let short = self.decimation.and_then(|outcome| outcome.shortfall());
        let short = short.map(|what| Warning { section: String::new(), what });
        let found = self.check.warnings(&self.materials);
        found.into_iter().chain(short).chain(self.unlinked()).collect()
    }

    /// That parts of a stack were not linked which could be; among what was [`found`](Self::found).
    pub fn unlinked(&self) -> Option<Warning> {
        self.links.as_ref().and_then(|links| links.warning(&self.materials))
    }
}
