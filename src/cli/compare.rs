//! `transect compare`: how far a solid is from a reference.

use super::args::CompareArguments;
use super::bars::Watcher;
use super::{print, table};
use crate::compare::{Options, compare_labels};
use crate::error::Result;
use crate::io::shapes::read_shape;

/// Measures and prints.
pub fn run(arguments: &CompareArguments) -> Result<()> {
    let watcher = Watcher::new(arguments.quiet);
    watcher.progress().begin("read", 0);
    let solid = read_shape(&arguments.solid)?;
    let reference = read_shape(&arguments.reference)?;
    let options = Options { tolerance: arguments.tolerance, ..Options::default() };
    let comparison = compare_labels(solid, &reference, &options, watcher.progress())?;
    watcher.finish();
    print(arguments.json, &comparison, table::comparison)
}
