//! `transect compare`: how far a mesh is from a reference.

use std::io::stdout;

use super::args::CompareArguments;
use super::print;
use crate::compare;
use crate::error::Result;
use crate::io;

/// Measures and prints.
pub fn run(arguments: &CompareArguments) -> Result<()> {
    let mesh = io::read_mesh(&arguments.mesh)?;
    let reference = io::read_mesh(&arguments.reference)?;
    let comparison = compare::compare(&mesh, &reference)?;
    print(&mut stdout(), arguments.json, &comparison)
}
