//! Layers: structures that may overlap, each reconstructed from its own sections as if the others
//! were not there.

mod contours;
mod voxels;

use serde::Serialize;

use crate::change::Change;
use crate::check::{Agreement, Check};
use crate::choice::Choice;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::inspect::{Inspection, inspect};
use crate::mesh::Mesh;
use crate::model::{Model, Options};
use crate::report::Report;
use crate::section::Sections;
use crate::stage::{Stage, Stages};

pub use contours::{drawn_contours, planes_of, structure_contours};
pub use voxels::{own_voxels, require_like, voxel_distances, voxel_layers};

/// A layer that was reconstructed and checked.
#[derive(Debug)]
pub struct Layer {
    /// The sections and what follows from them; nothing is kept for further changes.
    pub model: Model,
    /// What the result is worth.
    pub check: Check,
    /// How the method was chosen, where that was left to the program.
    pub choice: Option<Choice>,
}

impl Layer {
    /// Reconstructs a layer and checks it.
    ///
    /// # Errors
    /// As [`Model::apply`] and [`Model::check`].
    pub fn new(
        sections: Sections,
        options: Options,
        choice: Option<Choice>,
        context: &mut Context,
    ) -> Result<Self> {
        let mut model = Model::new(options);
        model.apply(Change::Add(sections), context)?;
        model.forget();
        let check = model.check(context)?;
        Ok(Self { model, check, choice })
    }
}

/// What there is to say of one layer of several.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LayerReport {
    /// Its materials' numbers.
    pub labels: Vec<u32>,
    /// How many sections it has.
    pub sections: usize,
    /// Its grid's nodes along each axis.
    pub nodes: [i32; 3],
    /// The side of its voxels, in world units.
    pub voxel: f64,
    /// How its method was chosen, where that was left to the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub choice: Option<Choice>,
}

/// The report of layers that were reconstructed one after the other.
///
/// # Errors
/// Without any layer.
pub fn report(layers: Vec<Layer>, stages: &Stages) -> Result<Report> {
    let nothing = || Error::Option("there is nothing to report: no layer is left".to_owned());
    let reports = layers.into_iter().map(|Layer { model, check, choice }| {
        let report = model.report(check, stages).ok_or_else(nothing)?;
        Ok(Report { choice, ..report })
    });
    let mut reports = reports.collect::<Result<Vec<Report>>>()?;
    if reports.is_empty() {
        return Err(nothing());
    }
    let first = reports.remove(0);
    Ok(if reports.is_empty() { first } else { joined(first, reports) })
}

/// Reports of several layers as one. What is of one layer alone, its grid for one, is that of the
/// first.
fn joined(first: Report, rest: Vec<Report>) -> Report {
    let layers = std::iter::once(&first).chain(&rest).map(|report| LayerReport {
        labels: report.materials.iter().map(|material| material.id).collect(),
        sections: report.sections,
        nodes: report.nodes,
        voxel: report.voxel,
        choice: report.choice.clone(),
    });
    let layers: Vec<LayerReport> = layers.collect();
    let mut whole = Report { choice: None, ..first };
    let mut checks = Vec::with_capacity(rest.len());
    for report in rest {
        let new = report.files.into_iter().filter(|file| !whole.files.contains(file));
        let new: Vec<String> = new.collect();
        whole.files.extend(new);
        whole.sections += report.sections;
        whole.materials.extend(report.materials);
        whole.exact = whole.exact.or(report.exact);
        whole.links = match (whole.links, report.links) {
            (Some(mut all), Some(own)) => {
                all.found.extend(own.found);
                Some(all)
            }
            (all, own) => all.or(own),
        };
        whole.decimation = match (whole.decimation, report.decimation) {
            (Some(mut all), Some(own)) => {
                all.before += own.before;
                all.wanted = all.wanted.zip(own.wanted).map(|(all, own)| all + own);
                all.triangles += own.triangles;
                all.moved = all.moved.max(own.moved);
                Some(all)
            }
            (all, own) => all.or(own),
        };
        checks.push(report.check);
        whole.warnings.extend(report.warnings);
        whole.left_out.extend(report.left_out);
        whole.notes.extend(report.notes);
        whole.disagreements.extend(report.disagreements);
    }
    whole.materials.sort_by_key(|material| material.id);
    Report {
        check: joined_checks(whole.check, checks),
        stages: by_name(&whole.stages),
        layers,
        ..whole
    }
}

/// What layers are worth together. Volumes of boxes are added up, though boxes may overlap.
fn joined_checks(mut whole: Check, rest: Vec<Check>) -> Check {
    let weighted = |check: &Check| check.contours.mean * check.contours.vertices as f64;
    let mut sum = weighted(&whole);
    for check in rest {
        sum += weighted(&check);
        whole.voxel = whole.voxel.max(check.voxel);
        whole.dice.sections.extend(check.dice.sections);
        whole.contours.vertices += check.contours.vertices;
        whole.contours.largest = whole.contours.largest.max(check.contours.largest);
        whole.contours.far.extend(check.contours.far);
        whole.contours.thin.extend(check.contours.thin);
        whole.contours.unreached.extend(check.contours.unreached);
        if whole.stack != check.stack {
            whole.stack = None;
        }
        whole.labels.extend(check.labels);
        whole.support.threshold = whole.support.threshold.max(check.support.threshold);
        whole.support.parts.extend(check.support.parts);
        whole.outside_volume += check.outside_volume;
        whole.box_volume += check.box_volume;
    }
    whole.contours.mean = match whole.contours.vertices {
        0 => 0.0,
        count => sum / count as f64,
    };
    whole.labels.sort_by_key(|own| own.label);
    whole.support.parts.sort_by(|one, other| other.distance.total_cmp(&one.distance));
    whole.dice = Agreement::new(whole.dice.sections);
    whole
}

/// Stages that ran once for each layer, as if they had run once.
fn by_name(stages: &[Stage]) -> Vec<Stage> {
    let mut found: Vec<Stage> = Vec::new();
    for stage in stages {
        match found.iter_mut().find(|known| known.name == stage.name) {
            None => found.push(stage.clone()),
            Some(known) => {
                known.seconds += stage.seconds;
                known.peak_memory = known.peak_memory.max(stage.peak_memory);
                for (what, count) in &stage.counts {
                    *known.counts.entry(what.clone()).or_default() += count;
                }
            }
        }
    }
    found
}

/// What is in layers.
///
/// # Errors
/// As [`inspect`].
pub fn inspect_layers(layers: &[Sections]) -> Result<Inspection> {
    let mut whole = inspect(&Sections::side_by_side(layers))?;
    whole.layers = layers.len();
    whole.disagreements = layers.iter().flat_map(Sections::disagreements).collect();
    Ok(whole)
}

/// The networks of layers side by side: surfaces of different layers may cross.
pub fn meshes_side_by_side<'a>(meshes: impl IntoIterator<Item = &'a Mesh>) -> Mesh {
    let mut all = Mesh::default();
    for mesh in meshes {
        let first = all.vertices.len() as u32;
        all.vertices.extend_from_slice(&mesh.vertices);
        let moved = mesh.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first));
        all.triangles.extend(moved);
        all.sides.extend_from_slice(&mesh.sides);
    }
    all
}
