//! Volumes of labels, read as the sections that were drawn in them.

use std::path::Path;

use crate::error::{Error, Result};
use crate::io::metaimage::{self, is_metaimage};
use crate::io::read_bytes;
use crate::io::volume::read_volume;
use crate::section::{Rules, Sections, Warning};
use crate::volume::Slices;

/// Reads a volume of labels as sections: the slices that were drawn, or every one of a full
/// volume. A sequence of tracked frames gives each of these.
///
/// # Errors
/// As [`read_volume`], and where there is no material.
pub fn read_slices(file: &Path, rules: &Rules) -> Result<Sections> {
    if is_metaimage(file) {
        let bytes = read_bytes(file)?;
        if let Some(frames) = metaimage::read_frames(&bytes, file)? {
            return super::frames::sections(file, &frames, rules);
        }
    }
    let volume = read_volume(file)?;
    let Slices { images, found, left_out } =
        volume.slices(&rules.images).map_err(|what| Error::file(file, what))?;
    let mut sections = super::sections(file, images, rules)?;
    sections.notes.push(Warning { section: String::new(), what: found });
    if let Some((count, [i, j, k])) = left_out {
        let voxels = if count == 1 { "voxel is" } else { "voxels are" };
        let what = format!(
            "{count} {voxels} on no drawn slice, the first at ({i}, {j}, {k}), and left out"
        );
        super::warn(&mut sections, file, what, rules)?;
    }
    sections.name_materials(volume.materials);
    (sections.units, sections.frame) = (volume.units, volume.frame);
    Ok(sections)
}
