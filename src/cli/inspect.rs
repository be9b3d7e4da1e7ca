//! `transect inspect`: what is in section files, and what is wrong with it.

use super::args::InspectArguments;
use super::print;
use crate::error::Result;
use crate::layers::inspect_layers;

/// Reads, looks and prints.
pub fn run(arguments: &InspectArguments) -> Result<()> {
    let layers = arguments.input.read_layers()?;
    print(arguments.json, &inspect_layers(&layers)?, ToString::to_string)
}
