//! The volumes in which two reconstructions differ.

use std::path::Path;

use super::labels::add_labels;
use super::{Storage, add_volume, describe, finish, scale, volumes_on};
use crate::error::Result;
use crate::grid::labels::LabelGrid;
use crate::grid::volume;
use crate::io::mesh::About;

/// What is written.
#[derive(Debug, Clone, Copy)]
pub struct DifferenceContents<'a> {
    /// The labels of the field.
    pub field: &'a LabelGrid,
    /// Those of the skeleton, on the same lattice.
    pub skeleton: &'a LabelGrid,
    /// The nodes at which they differ, leaf by leaf.
    pub differing: &'a [[i32; 3]],
    /// For each of them its distance from where they agree, in world units.
    pub depths: &'a [f32],
    /// Materials, units and frame.
    pub about: About<'a>,
}

/// Writes `disagreement`, `label_field` and `label_skeleton`. The same contents
/// make the same bytes.
///
/// # Errors
/// As [`write`](super::write).
pub fn write_difference(path: &Path, contents: &DifferenceContents) -> Result<()> {
    let lattice = &contents.field.lattice;
    let scale = scale(lattice)?;
    let mut volumes = volumes_on(lattice, scale, false)?;
    let depths: Vec<f32> = contents.depths.iter().map(|depth| depth * scale as f32).collect();
    let depths = volume::at_nodes(contents.differing, &depths);
    add_volume(&mut volumes, "disagreement", &depths)?;
    add_labels(&mut volumes, "label_field", contents.field)?;
    add_labels(&mut volumes, "label_skeleton", contents.skeleton)?;
    for name in ["disagreement", "label_field", "label_skeleton", ""] {
        describe(&mut volumes, name, contents.about.units, contents.about.frame, scale)?;
    }
    finish(&mut volumes, contents.about.materials, path, Storage::OpenVdb { half: false })
}
