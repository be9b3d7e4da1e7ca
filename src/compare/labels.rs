//! How far solids are from a reference, label by label.

use std::collections::BTreeSet;

use serde::Serialize;

use super::agreement::{Agreement, agreement};
use super::shape::{Content, Shape};
use super::solid::Solid;
use super::steps::{Part, Steps};
use super::{Comparison, Options};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::progress::Progress;
use crate::volume::{Boundary, LayeredVolume, Tally};

/// Points drawn on the surface of one of several labels for each of its triangles, and the fewest
/// of all.
const SAMPLES: u32 = 4;
const FEWEST: u32 = 4096;
/// How many names are told to be at odds.
const NAMES: usize = 8;

/// How solids agree with a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelledComparison {
    /// All materials as one, distances over the diagonal of the reference's box.
    #[serde(flatten)]
    pub all: Comparison,
    /// The unit of lengths; empty when unknown.
    pub unit: String,
    /// Whether volumes in common are of the same voxels, and so exact.
    pub exact_overlap: bool,
    /// How far surfaces may be apart for the surface Dice, if it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// All materials as one, in world units.
    pub union: Agreement,
    /// Every label that either has, by its number.
    pub labels: Vec<LabelComparison>,
}

/// How a label agrees with that of the same number.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelComparison {
    /// The number.
    pub label: u32,
    /// What the reference calls it, else the other.
    pub name: Option<String>,
    /// Of the solid and of the reference, in cubic world units; absent where there is no such
    /// label.
    pub volumes: [Option<f64>; 2],
    /// How the two agree; absent where one of them has no such label or encloses nothing.
    pub agreement: Option<Agreement>,
}

/// One of the two, with what is asked of it more than once.
struct Side<'a> {
    name: &'static str,
    shape: &'a Shape,
    /// The boundary of voxels, and how many there are.
    voxels: Option<(Boundary, Tally, f64)>,
}

/// Compares solids with a reference, all materials as one and every label with that of the same
/// number. Where unit and frame are known of both, and are others, lengths and coordinates are
/// turned into those of the reference.
///
/// # Errors
/// When one of them has no material, or encloses no volume.
pub fn compare_labels(
    shape: Shape,
    reference: &Shape,
    options: &Options,
    progress: &dyn Progress,
) -> Result<LabelledComparison> {
    let mut warnings = Vec::new();
    let shape = shape.like(reference, &mut warnings);
    let labels: [BTreeSet<Label>; 2] =
        [&shape, reference].map(|shape| shape.labels().into_iter().collect());
    at_odds([&shape, reference], &labels, &mut warnings);
    let all: Vec<Label> = labels[0].union(&labels[1]).copied().collect();
    // The one label of both is their union.
    let is_single = labels[0] == labels[1] && all.len() == 1;
    let parts = if is_single { 0 } else { all.len() };
    // What is asked more than once takes as long as a label or two.
    let steps = Steps::new("compare", parts + 3, progress);
    let name = match shape.content {
        Content::Mesh(_) => "mesh",
        Content::Voxels(_) => "volume",
    };
    let sides = [
        Side::new(name, &shape, &steps.part(0))?,
        Side::new("reference", reference, &steps.part(1))?,
    ];
    let common = match (&shape.content, &reference.content) {
        (Content::Voxels(one), Content::Voxels(other)) => one.common(other),
        _ => None,
    };
    let pair = Pair { sides, common, options };
    let (union, diagonal) = pair.all(&steps.part(2), &mut warnings)?;
    let mut found = Vec::with_capacity(all.len());
    for (place, &label) in all.iter().enumerate() {
        let has = [0, 1].map(|side: usize| labels[side].contains(&label));
        let name = reference.name(label).or_else(|| shape.name(label)).map(str::to_owned);
        let part = steps.part(3 + place.min(parts.saturating_sub(1)));
        let (volumes, agreement) = match is_single {
            true => (union.volumes.map(Some), Some(union)),
            false => pair.of(label, has, &part, &mut warnings)?,
        };
        part.reach(1.0)?;
        found.push(LabelComparison { label: label.0, name, volumes, agreement });
    }
    let unit = if reference.units.is_empty() { &shape.units } else { &reference.units };
    Ok(LabelledComparison {
        all: Comparison::new(&union, diagonal, warnings),
        unit: unit.clone(),
        exact_overlap: pair.common.is_some(),
        tolerance: options.tolerance,
        union,
        labels: found,
    })
}

/// Names that stand for other numbers, and numbers with other names.
fn at_odds(shapes: [&Shape; 2], labels: &[BTreeSet<Label>; 2], warnings: &mut Vec<String>) {
    let [shape, reference] = shapes;
    let mut found: Vec<String> = Vec::new();
    for &label in &labels[0] {
        let Some(name) = shape.name(label) else { continue };
        let own = reference.name(label).filter(|_| labels[1].contains(&label));
        if own == Some(name) {
            continue;
        }
        let is_named = |other: &&Label| reference.name(**other) == Some(name);
        match (labels[1].iter().find(is_named), own) {
            (Some(other), _) => {
                found.push(format!("{name:?} is {label} here and {other} in the reference"));
            }
            (None, Some(own)) => {
                found.push(format!("{label} is {name:?} here and {own:?} in the reference"));
            }
            (None, None) => (),
        }
    }
    if !found.is_empty() {
        let rest = found.len().saturating_sub(NAMES);
        let more = if rest > 0 { format!(", and {rest} more") } else { String::new() };
        found.truncate(NAMES);
        let found = found.join(", ");
        warnings.push(format!("labels go by their numbers, and names differ: {found}{more}"));
    }
}

impl<'a> Side<'a> {
    fn new(name: &'static str, shape: &'a Shape, part: &Part) -> Result<Self> {
        let measured = |volume: &LayeredVolume| {
            let tally = volume.tally();
            part.reach(0.3)?;
            Ok::<_, Error>((Boundary::new(volume)?, tally, volume.voxel_volume()))
        };
        let voxels = match &shape.content {
            Content::Mesh(_) => None,
            Content::Voxels(volume) => Some(measured(volume)?),
        };
        part.reach(1.0)?;
        Ok(Self { name, shape, voxels })
    }

    /// A label's solid, or that of all (*outside*).
    fn solid(&self, label: Label, name: &str, warnings: &mut Vec<String>) -> Result<Solid> {
        match (&self.shape.content, &self.voxels) {
            (Content::Mesh(mesh), _) if label == Label::OUTSIDE => {
                Solid::of_materials(mesh, name, warnings)
            }
            (Content::Mesh(mesh), _) => Solid::of_surface(mesh.surface(label), name, warnings),
            (Content::Voxels(_), Some((boundary, tally, voxel))) => {
                let count = voxels(tally, label) as f64;
                Solid::of_voxels(boundary.surface(label), count * voxel, name)
            }
            (Content::Voxels(_), None) => {
                Err(Error::Bug { stage: "compare", what: "voxels without a boundary".to_owned() })
            }
        }
    }

    /// The volume of a label, whatever is wrong with its surface.
    fn volume(&self, label: Label) -> Result<f64> {
        match (&self.shape.content, &self.voxels) {
            (_, Some((_, tally, voxel))) => Ok(voxels(tally, label) as f64 * voxel),
            (Content::Mesh(mesh), None) => Ok(mesh.surface(label).facts(false)?.volume.abs()),
            (Content::Voxels(_), None) => Ok(0.0),
        }
    }

    fn voxel(&self) -> Option<(&Tally, f64)> {
        self.voxels.as_ref().map(|(_, tally, voxel)| (tally, *voxel))
    }
}

/// How many voxels a label has, or all together.
fn voxels(tally: &Tally, label: Label) -> u64 {
    match label {
        Label::OUTSIDE => tally.all,
        _ => tally.labels.get(&label.0).copied().unwrap_or(0),
    }
}

/// The two, and what their voxels have in common, if these are the same.
struct Pair<'a> {
    sides: [Side<'a>; 2],
    common: Option<Tally>,
    options: &'a Options,
}

impl Pair<'_> {
    /// All materials as one, and the diagonal of the reference's box.
    fn all(&self, part: &Part, warnings: &mut Vec<String>) -> Result<(Agreement, f64)> {
        let [one, other] = &self.sides;
        let mut solids = [
            one.solid(Label::OUTSIDE, one.name, warnings)?,
            other.solid(Label::OUTSIDE, other.name, warnings)?,
        ];
        let known = self.known(Label::OUTSIDE);
        let found = agreement(&mut solids, known, self.options, part, warnings)?;
        Ok((found, solids[1].bounds.diagonal()))
    }

    /// The volumes of a label where it is, and how they agree where both have it. What cannot be
    /// measured is a warning: other labels can.
    fn of(
        &self,
        label: Label,
        has: [bool; 2],
        part: &Part,
        warnings: &mut Vec<String>,
    ) -> Result<([Option<f64>; 2], Option<Agreement>)> {
        if has == [true; 2] {
            match self.both(label, part, warnings) {
                Ok(found) => return Ok((found.volumes.map(Some), Some(found))),
                Err(Error::Option(what)) => warnings.push(what),
                Err(Error::Library { what, .. }) => warnings.push(format!("label {label}: {what}")),
                Err(error) => return Err(error),
            }
        }
        let volume = |side: usize| has[side].then(|| self.sides[side].volume(label)).transpose();
        Ok(([volume(0)?, volume(1)?], None))
    }

    fn both(&self, label: Label, part: &Part, warnings: &mut Vec<String>) -> Result<Agreement> {
        let [one, other] = &self.sides;
        let name = |side: &Side| format!("surface of label {label} in the {}", side.name);
        let mut solids =
            [one.solid(label, &name(one), warnings)?, other.solid(label, &name(other), warnings)?];
        let triangles = solids.iter().map(|solid| solid.surface.triangles.len()).max().unwrap_or(0);
        let enough = u32::try_from(triangles).unwrap_or(u32::MAX).saturating_mul(SAMPLES);
        let options =
            Options { samples: self.options.samples.min(enough.max(FEWEST)), ..*self.options };
        agreement(&mut solids, self.known(label), &options, part, warnings)
    }

    /// The volume in common and that of the union, where voxels say it.
    fn known(&self, label: Label) -> Option<[f64; 2]> {
        let common = voxels(self.common.as_ref()?, label);
        let [(one, voxel), (other, _)] = [self.sides[0].voxel()?, self.sides[1].voxel()?];
        let union = voxels(one, label) + voxels(other, label) - common;
        Some([common, union].map(|count| count as f64 * voxel))
    }
}

#[cfg(test)]
mod tests;
