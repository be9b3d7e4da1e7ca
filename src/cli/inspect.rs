//! `transect inspect`: what is in section files, and what is wrong with it.

use super::args::InspectArguments;
use super::print;
use crate::error::Result;
use crate::inspect::inspect;
use crate::io;

/// Reads, looks and prints.
pub fn run(arguments: &InspectArguments) -> Result<()> {
    let sections = io::read_all(&arguments.sections, &arguments.reading.rules())?;
    print(arguments.json, &inspect(&sections)?, ToString::to_string)
}
