//! `transect inspect`: what is in section files, and what is wrong with it.

use super::args::InspectArguments;
use super::print;
use crate::error::Result;
use crate::inspect::inspect;

/// Reads, looks and prints.
pub fn run(arguments: &InspectArguments) -> Result<()> {
    let sections = arguments.input.read()?;
    print(arguments.json, &inspect(&sections)?, ToString::to_string)
}
