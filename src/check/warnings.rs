//! What a reader should be warned of before trusting a result.

use super::{Check, LabelCheck};
use crate::label::Material;
use crate::section::Warning;

/// By how many degrees more than at the sections a surface leans between them
/// when it looks like beads.
pub const BEADS: f64 = 5.0;
/// How many places a warning names.
const NAMED: usize = 3;

impl Check {
    /// What a reader should be warned of, label by label.
    pub fn warnings(&self, materials: &[Material]) -> Vec<Warning> {
        let warn = |label: &LabelCheck| {
            let found = [beads(label), torn(label), afloat(label)];
            let name = name(label.label, materials);
            found.into_iter().flatten().map(move |what| Warning {
                section: String::new(),
                what: format!("{name}: {what}"),
            })
        };
        self.labels.iter().flat_map(warn).collect()
    }
}

fn name(label: u32, materials: &[Material]) -> String {
    let own = materials.iter().find(|material| material.id == label);
    own.map_or_else(
        || format!("label {label}"),
        |material| format!("label {label} ({})", material.name),
    )
}

fn beads(label: &LabelCheck) -> Option<String> {
    let ripple = label.ripple.filter(|ripple| ripple.angle() > BEADS)?;
    Some(format!(
        "its surface ripples in step with the sections, like beads or terraces: it leans by \
         {:.0}° against the sections' planes between them and by {:.0}° at them; that is the \
         method's doing and not the sections'",
        ripple.between, ripple.at_sections
    ))
}

fn torn(label: &LabelCheck) -> Option<String> {
    let torn: Vec<String> = label
        .passages
        .iter()
        .flat_map(|passage| {
            let [one, other] = &passage.sections;
            let place = move |at: &[f64; 3]| format!("{} ({one} to {other})", place(*at));
            passage.torn.iter().map(place)
        })
        .collect();
    let count = torn.len();
    (count > 0).then(|| {
        let bodies = if count == 1 { "a place" } else { "places" };
        format!(
            "its regions on neighbouring sections lie over each other and the solid does not \
             connect them in {bodies}: {}",
            listed(&torn, count)
        )
    })
}

fn afloat(label: &LabelCheck) -> Option<String> {
    let count = label.afloat.pieces;
    let places: Vec<String> = label.afloat.largest.iter().map(|piece| place(piece.at)).collect();
    let pieces = if count == 1 { "a piece hangs" } else { "pieces hang" };
    (count > 0).then(|| {
        format!(
            "{pieces} in the air, where no section shows the label: near {}",
            listed(&places, count)
        )
    })
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("({x:.4}, {y:.4}, {z:.4})")
}

/// The first of so many.
fn listed(all: &[String], count: usize) -> String {
    let shown = &all[..all.len().min(NAMED)];
    let rest = match count - shown.len() {
        0 => String::new(),
        rest => format!(" and {rest} more"),
    };
    format!("{}{rest}", shown.join(", "))
}
