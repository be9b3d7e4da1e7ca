//! The field against an independent reconstruction of the same sections, one
//! mesher against the other, and all of it against a mesh of the user's.
//!
//! ```text
//!            ┌► Model: field ─► samples ─► dual, delaunay ─┐
//! sections ──┤                    ╎ same lattice           ├─► report, io::vdb, picture
//!            └► oracle ─► samples ╎   skeleton (exact) ────┘
//! ```
//!
//! The field is the mean-value indicator or the variational one. The indicator
//! is not smoothed: that the two must agree somewhere holds for it as it is, and
//! for no other field.

mod against;
mod agreement;
mod certain;
mod depth;
mod gap;
mod pairing;
mod parts;
mod report;
mod rows;
mod solids;
#[cfg(test)]
mod tests;
mod work;

pub use against::{Against, Other};
pub use agreement::{Agreement, Bin, LabelAgreement, Pair};
pub use certain::{Points, Violation};
pub use gap::{Gap, OneWay};
pub use pairing::{Difference, Pairing, Reconstruction, Region};
pub use parts::Part;
pub use parts::positions;
pub use report::{Crosscheck, Distances, Found, SkeletonReport};
pub use solids::{LabelSolids, Solid};

use crate::bounding::{Faces, bounds_of};
use crate::change::Change;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::field::Device;
use crate::grid::lattice::Resolution;
use crate::label::Label;
use crate::mesh::{Mesh, delaunay};
use crate::method::{Caps, MeanValue, Mesher, Method, Variational};
use crate::model::{self, Derived, Model};
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::{Rules, Sections};
use crate::stage::Stages;
use serde::Serialize;
use work::{Compared, Work};

/// Which field is held against the skeleton.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The mean-value indicator, not smoothed ([`MeanValue`]).
    #[default]
    #[serde(rename = "mvc")]
    MeanValue,
    /// The smoothest field through the contours ([`Variational`]).
    Variational,
}

/// How the two reconstructions are made and compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The field.
    pub field: Kind,
    /// How fine the grid is.
    pub resolution: Resolution,
    /// Where the field is evaluated.
    pub device: Device,
    /// What is on the box's faces, as in [`MeanValue`].
    pub border: Label,
    /// How far the box reaches beyond the contours, as in [`model::Options`].
    pub margin: Option<f64>,
    /// As in [`MeanValue`].
    pub spacing: Option<f64>,
    /// Random points at which both are asked.
    pub points: u32,
    /// What they are drawn from.
    pub seed: u64,
    /// Whether the delaunay mesher is held against the dual one.
    pub delaunay: Option<delaunay::Options>,
}

impl Default for Options {
    fn default() -> Self {
        let MeanValue { device, border, spacing, .. } = MeanValue::default();
        let resolution = model::Options::default().resolution;
        let delaunay = Some(delaunay::Options::default());
        let (field, points, seed) = (Kind::default(), 100_000, 0);
        Self { field, resolution, device, border, margin: None, spacing, points, seed, delaunay }
    }
}

impl Options {
    /// The box that both fill.
    fn bounds(&self, sections: &Sections) -> Result<Bounds> {
        let is_outside = self.border == Label::OUTSIDE;
        let faces = if is_outside { Faces::Outside } else { Faces::Silent };
        bounds_of(sections, self.margin, faces)
    }
}

/// What was found, and what it was found on.
#[derive(Debug)]
pub struct Findings {
    /// For people and for programs.
    pub report: Crosscheck,
    /// The sections, the cells and the field's surface.
    pub model: Model,
    /// The skeleton's surface.
    pub skeleton: Mesh,
    /// Both labels at every node.
    pub pair: Pair,
    /// The nodes at which they differ, leaf by leaf.
    pub differing: Vec<[i32; 3]>,
    /// For each of them how far the nearest node is where they agree, in world
    /// units.
    pub depths: Vec<f32>,
    /// For each vertex of the field's surface how far it is from the skeleton's,
    /// in voxels.
    pub distances: Vec<f32>,
}

impl Findings {
    /// The field's surface.
    ///
    /// # Errors
    /// When nothing was derived.
    pub fn field(&self) -> Result<&Mesh> {
        Ok(&derived(&self.model)?.mesh)
    }

    /// Whether all points agree that must.
    ///
    /// # Errors
    /// Where some do not: the first of them.
    pub fn verdict(&self) -> Result<()> {
        let Some(points) = &self.report.found.points else { return Ok(()) };
        let Some(first) = points.first.first() else { return Ok(()) };
        let [x, y, z] = first.at;
        let what = format!(
            "at {} points the field and the skeleton must agree and do not; at ({x}, {y}, {z}) \
             the field says {}, the skeleton {}",
            points.violations,
            Label(first.field),
            Label(first.skeleton)
        );
        Err(Error::Bug { stage: "crosscheck", what })
    }
}

/// Reconstructs sections both ways and compares.
///
/// # Errors
/// Those of the two reconstructions.
pub fn crosscheck(
    sections: Sections,
    rules: &Rules,
    options: &Options,
    other: Option<&Other>,
    stages: &mut Stages,
    progress: &dyn Progress,
) -> Result<Findings> {
    // One box for both, though the variational field asks nothing of its faces.
    let bounds = match options.field {
        Kind::Variational => Some(options.bounds(&sections)?),
        Kind::MeanValue => None,
    };
    let mut model = Model::new(model::Options { bounds, ..model_options(options) });
    let mut context = Context { rules: *rules, progress, stages: std::mem::take(stages) };
    let applied = model.apply(Change::Add(sections), &mut context);
    *stages = context.stages;
    applied?;
    let compared = Work { model: &model, options, progress }.compare(other, stages)?;
    let Compared { found, skeleton, pair, differing, depths, distances } = compared;
    let report = Crosscheck::new(&model, options.field, found, stages)?;
    Ok(Findings { report, model, skeleton, pair, differing, depths, distances })
}

/// The field as it is, and meshed by dual contouring.
fn model_options(options: &Options) -> model::Options {
    let Options { field, resolution, device, border, margin, spacing, .. } = *options;
    let (caps, mesher) = (Caps::Rounded, Mesher::Dual);
    let method = match field {
        Kind::MeanValue => {
            Method::MeanValue(MeanValue { smooth: 0.0, border, caps, device, spacing, mesher })
        }
        Kind::Variational => Method::Variational(Variational {
            border,
            caps,
            device,
            mesher,
            ..Variational::default()
        }),
    };
    model::Options { method, resolution, margin, ..model::Options::default() }
}

fn derived(model: &Model) -> Result<&Derived> {
    let what = || Error::Bug { stage: "model", what: "nothing was derived".to_owned() };
    model.derived().ok_or_else(what)
}
