//! What is said about a change that was made.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::change::SectionId;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::patches::ChangedPatches;
use crate::model::Model;
use crate::section::{Findings, Section, Warning};
use crate::stage::{Stage, Stages};

/// What a change did to a model, and what the model is like now.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// Which change this is: they count from 1, and one that is taken back counts twice.
    pub change: u64,
    /// The sections that came, by number.
    pub added: Vec<Listed>,
    /// The numbers of sections that others took the place of.
    pub replaced: Vec<SectionId>,
    /// The numbers of sections that went.
    pub removed: Vec<SectionId>,
    /// How many sections there are.
    pub sections: usize,
    /// How many triangles there are between all labels.
    pub triangles: usize,
    /// What each material has become.
    pub labels: Vec<Material>,
    /// The patches of the surface that are others than before, when somebody follows them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub patches: Option<ChangedPatches>,
    /// All stages together, by the wall clock.
    pub seconds: f64,
    /// What each of them took.
    pub stages: Vec<Stage>,
    /// What was doubtful about the sections.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<Warning>,
    /// What was left out of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<Warning>,
}

/// A section, by number and name.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Listed {
    /// What it can be replaced and removed by.
    pub id: SectionId,
    /// What errors call it.
    pub name: String,
}

impl From<(SectionId, &Section)> for Listed {
    fn from((id, section): (SectionId, &Section)) -> Self {
        Self { id, name: section.name().to_owned() }
    }
}

/// One material's surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Material {
    /// Its label.
    pub label: u32,
    /// What it is called.
    pub name: String,
    /// How many triangles bound it.
    pub triangles: usize,
    /// What they enclose, in cubic world units.
    pub volume: f64,
}

/// What a model is like before a change.
pub(super) struct Before {
    /// Its sections by number, and where each is kept: another place once it is replaced.
    sections: BTreeMap<SectionId, *const Section>,
    warnings: Vec<Warning>,
}

impl Before {
    pub(super) fn of(model: &Model) -> Self {
        Self { sections: places(model), warnings: model.sections().warnings.clone() }
    }
}

fn places(model: &Model) -> BTreeMap<SectionId, *const Section> {
    model.given().map(|(id, section)| (id, std::ptr::from_ref(section))).collect()
}

impl Answer {
    pub(super) fn new(
        change: u64,
        before: &Before,
        model: &Model,
        findings: Findings,
        patches: Option<ChangedPatches>,
        stages: &Stages,
    ) -> Self {
        let (old, new) = (&before.sections, places(model));
        let added = model.given().filter(|(id, _)| !old.contains_key(id));
        let differs = |(id, place): &(&SectionId, &*const Section)| {
            old.get(id).is_some_and(|before| before != *place)
        };
        // Of sections on one plane the model itself warns.
        let told = model.sections().warnings.iter();
        let told = told.filter(|warning| !before.warnings.contains(warning)).cloned();
        let mesh = model.derived().map(|derived| &derived.mesh);
        Self {
            change,
            added: added.map(Listed::from).collect(),
            replaced: new.iter().filter(differs).map(|(&id, _)| id).collect(),
            removed: old.keys().filter(|id| !new.contains_key(id)).copied().collect(),
            sections: new.len(),
            triangles: mesh.map_or(0, |mesh| mesh.triangles.len()),
            labels: mesh.map_or_else(Vec::new, |mesh| materials(mesh, model)),
            patches,
            seconds: stages.seconds(),
            stages: stages.stages.clone(),
            warnings: findings.warnings.into_iter().chain(told).collect(),
            left_out: findings.left_out,
        }
    }
}

/// Triangles and volume of all materials at once, by the divergence theorem.
fn materials(mesh: &Mesh, model: &Model) -> Vec<Material> {
    // Far from the origin the tetrahedra would cancel digits away.
    let base = mesh.vertices.first().copied().unwrap_or_default();
    let mut found: BTreeMap<Label, (usize, f64)> = BTreeMap::new();
    for (triangle, [back, front]) in mesh.sides.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - base);
        let cone = a.dot(b.cross(c)) / 6.0;
        for (label, cone) in [(back, cone), (front, -cone)] {
            let (triangles, volume) = found.entry(*label).or_default();
            *triangles += 1;
            *volume += cone;
        }
    }
    let name = |label| model.sections().material(label).map(|material| material.name.clone());
    let materials = found.into_iter().filter(|(label, _)| label.is_material());
    materials
        .map(|(label, (triangles, volume))| Material {
            label: label.0,
            name: name(label).unwrap_or_default(),
            triangles,
            volume,
        })
        .collect()
}
