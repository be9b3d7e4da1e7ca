//! `transect inspect`: what is in section files, and what is wrong with it.

use serde::Serialize;

use super::args::InspectArguments;
use super::{errors, print};
use crate::error::Result;
use crate::inspect::Inspection;
use crate::io::metaimage::{Facts, sequence_facts};
use crate::layers::inspect_layers;

/// What is printed.
#[derive(Serialize)]
struct Told {
    /// What files of tracked frames say of them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sequences: Vec<Facts>,
    #[serde(flatten)]
    sections: Option<Inspection>,
    /// Why there are no sections in sequences.
    #[serde(skip_serializing_if = "Option::is_none")]
    unreadable: Option<String>,
}

/// Reads, looks and prints. Of sequences there is something to tell even where their frames are no
/// sections.
pub fn run(arguments: &InspectArguments) -> Result<()> {
    let facts = arguments.input.sections.iter().map(|file| sequence_facts(file));
    let sequences: Vec<Facts> = facts.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    let found = arguments.input.read_layers().and_then(|layers| inspect_layers(&layers));
    let (sections, unreadable) = match found {
        Ok(sections) => (Some(sections), None),
        Err(error) if sequences.is_empty() => return Err(error),
        Err(error) => (None, Some(errors::line(&error))),
    };
    print(arguments.json, &Told { sequences, sections, unreadable }, text)
}

fn text(told: &Told) -> String {
    let sequences = told.sequences.iter().map(ToString::to_string);
    let sections = told.sections.iter().map(ToString::to_string);
    let unreadable = told.unreadable.iter().map(|why| format!("sections      none: {why}\n"));
    sequences.chain(sections).chain(unreadable).collect()
}
