//! `transect inspect`: what is in section files, and what is wrong with it.

use std::io::stdout;

use super::args::InspectArguments;
use super::print;
use crate::error::Result;
use crate::inspect;
use crate::io;

/// Reads, looks and prints.
pub fn run(arguments: &InspectArguments) -> Result<()> {
    let sections = io::read_all(&arguments.sections, &arguments.reading.rules())?;
    print(&mut stdout(), arguments.json, &inspect::inspect(&sections))
}
