//! Volumes of labels.

use cxx::UniquePtr;

use super::library;
use crate::error::{Error, Remedy, Result};
use crate::ffi::vdb as ffi;
use crate::grid::labels::LabelGrid;
use crate::grid::volume::{self, Volume};
use crate::label::Label;

/// Adds the number of the material at every node.
pub fn add_labels(
    volumes: &mut UniquePtr<ffi::Volumes>,
    name: &str,
    grid: &LabelGrid,
) -> Result<()> {
    let numbers = |labels: &[Label]| -> Result<Vec<i32>> {
        labels.iter().map(|&label| number(label, name)).collect()
    };
    let Volume { leaves, values, tiles, tile_values, .. } = volume::labels(grid);
    let (leaves, tiles) = (leaves.as_flattened(), tiles.as_flattened());
    let (values, tile_values) = (numbers(&values)?, numbers(&tile_values)?);
    ffi::add_numbers(volumes.pin_mut(), name, leaves, &values, tiles, &tile_values).map_err(library)
}

fn number(label: Label, name: &str) -> Result<i32> {
    i32::try_from(label.0).map_err(|_| {
        let what = format!(
            "the grid {name} cannot hold the label {label}, which is over {}: number the labels \
             anew",
            i32::MAX
        );
        Error::Option(what).avoidable(Remedy::OtherGrids)
    })
}
