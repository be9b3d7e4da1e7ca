//! What is said of parts that were linked, or could be.

use serde::Serialize;

use crate::label::{Label, Material};
use crate::section::Warning;

/// How many places a warning names.
const NAMED: usize = 3;

/// Parts of neighbouring slices that overlap nothing of their label on the other one, and match
/// when one is moved.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Links {
    /// Whether the solid connects them.
    pub connected: bool,
    /// Slice by slice, label by label.
    pub found: Vec<Link>,
}

/// A part of one slice and the part of the next one that it becomes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Link {
    /// The label's number; 0 is *outside*: a hole that moves.
    pub label: u32,
    /// The names of the two sections.
    pub sections: [String; 2],
    /// The middle of the part on the first section, in world units.
    pub at: [f64; 3],
    /// By what it moves within the section's plane, in world units, to a voxel.
    pub translation: [f64; 3],
    /// How long that is.
    pub length: f64,
    /// How well the part, moved, matches the other one: intersection over union.
    pub overlap: f64,
}

impl Links {
    /// What to warn of where they are not connected.
    pub fn warning(&self, materials: &[Material]) -> Option<Warning> {
        let count = self.found.len();
        if self.connected || count == 0 {
            return None;
        }
        let place = |link: &Link| {
            let Link { sections: [one, other], .. } = link;
            format!("{} from {one} to {other}", link.name(materials))
        };
        let named: Vec<String> = self.found.iter().take(NAMED).map(place).collect();
        let rest = match count - named.len() {
            0 => String::new(),
            rest => format!(" and {rest} more"),
        };
        let parts = if count == 1 { "a part was" } else { "parts were" };
        let what = format!(
            "{parts} not connected that overlap nothing of their label on the next section, \
             though parts there match when they are moved: {}{rest}",
            named.join(", ")
        );
        Some(Warning { section: String::new(), what })
    }
}

impl Link {
    /// Of which label it is.
    pub fn name(&self, materials: &[Material]) -> String {
        if self.label == Label::OUTSIDE.0 {
            return "a hole".to_owned();
        }
        let own = materials.iter().find(|material| material.id == self.label);
        own.map_or_else(
            || format!("label {}", self.label),
            |material| format!("label {} ({})", self.label, material.name),
        )
    }
}
