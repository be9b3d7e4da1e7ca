//! Volumes of labels.

use cxx::UniquePtr;

use super::library;
use crate::error::{Error, Result};
use crate::ffi::vdb as ffi;
use crate::grid::labels::{LabelGrid, leaf_nodes};
use crate::label::Label;

/// Adds the number of the material at every node.
pub fn add_labels(
    volumes: &mut UniquePtr<ffi::Volumes>,
    name: &str,
    grid: &LabelGrid,
) -> Result<()> {
    let number = |label: Label| {
        i32::try_from(label.0).map_err(|_| {
            Error::Option(format!(
                "the grid {name} cannot hold the label {label}, which is over {}: leave it out of \
                 --grids, or number the labels anew",
                i32::MAX
            ))
        })
    };
    let (mut leaves, mut values) = (Vec::new(), Vec::new());
    let (mut tiles, mut tile_values) = (Vec::new(), Vec::new());
    for leaf in 0..grid.lattice.leaf_count() as usize {
        let at = grid.lattice.leaf_at(leaf);
        match grid.tile(leaf) {
            Some(label) if label.is_material() => {
                tiles.extend(at);
                tile_values.push(number(label)?);
            }
            Some(_) => {}
            None => {
                leaves.extend(at);
                for (node, label) in leaf_nodes(at).zip(grid.leaf(leaf)) {
                    // Beyond an open box nothing is, though values lead there.
                    let beyond = grid.is_open && !grid.lattice.is_inner(node);
                    values.push(if beyond { 0 } else { number(label)? });
                }
            }
        }
    }
    ffi::add_numbers(volumes.pin_mut(), name, &leaves, &values, &tiles, &tile_values)
        .map_err(library)
}
