//! `transect compare`: how far a mesh is from a reference.

use super::args::CompareArguments;
use super::bars::Watcher;
use super::{print, table};
use crate::compare::{Options, compare};
use crate::error::Result;
use crate::io::mesh::read_mesh;

/// Measures and prints.
pub fn run(arguments: &CompareArguments) -> Result<()> {
    let mesh = read_mesh(&arguments.mesh)?;
    let reference = read_mesh(&arguments.reference)?;
    let watcher = Watcher::new(arguments.quiet);
    let comparison = compare(&mesh, &reference, &Options::default(), watcher.progress())?;
    watcher.finish();
    print(arguments.json, &comparison, table::comparison)
}
