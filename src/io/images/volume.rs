//! Volumes of labels, read as the sections that were drawn in them.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use rayon::prelude::*;

use super::values::Values;
use crate::error::{Error, Result};
use crate::io::metaimage::{self, is_metaimage};
use crate::io::structures::{Chosen, Named};
use crate::io::volume::read_volume;
use crate::io::{nrrd, read_bytes};
use crate::label::{Label, Material};
use crate::section::{Rules, Sections, Warning};
use crate::volume::{LabelVolume, Slices};

/// A header is no longer, as a rule: what is longer is not taken for one of layers.
const LONGEST_HEADER: u64 = 1 << 22;

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
    sections_of(file, read_volume(file)?, rules)
}

/// Whether a file holds several layers of labels that may overlap.
pub fn is_layered(file: &Path) -> bool {
    let name = file.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
    let mut start = Vec::new();
    name.ends_with(".nrrd")
        && std::fs::metadata(file).is_ok_and(|about| about.is_file())
        && File::open(file)
            .and_then(|opened| opened.take(LONGEST_HEADER).read_to_end(&mut start))
            .is_ok()
        && nrrd::has_layers(&start)
}

/// Reads the layers of a segmentation, each as [`read_slices`] does; those in which nothing is
/// chosen are left out.
///
/// # Errors
/// As [`read_slices`], and where a segment is chosen that is none of the file's.
pub fn read_layers(file: &Path, chosen: &Chosen, rules: &Rules) -> Result<Vec<Sections>> {
    layers_of(file, nrrd::read_layers(&read_bytes(file)?, file)?, chosen, rules)
}

/// The same of layers that were read.
///
/// # Errors
/// As [`read_layers`].
pub fn layers_of(
    file: &Path,
    layers: Vec<LabelVolume>,
    chosen: &Chosen,
    rules: &Rules,
) -> Result<Vec<Sections>> {
    let sizes: Vec<_> = layers.iter().map(LabelVolume::sizes).collect();
    let all = layers.iter().zip(&sizes).enumerate().flat_map(|(layer, (volume, sizes))| {
        let size = |id: u32| sizes.get(&Label(id)).copied().unwrap_or(0) as f64;
        volume.materials.iter().map(move |own| (layer, own, size(own.id)))
    });
    let all: Vec<(usize, &Material, f64)> = all.collect();
    let named = all.iter().map(|&(_, own, size)| Named { number: own.id, name: &own.name, size });
    let order = chosen.of(&named.collect::<Vec<_>>())?;
    let mut wanted: Vec<(usize, Vec<u32>)> = Vec::new();
    for (layer, material, _) in order.into_iter().map(|place| all[place]) {
        match wanted.iter_mut().find(|(known, _)| *known == layer) {
            Some((_, labels)) => labels.push(material.id),
            None => wanted.push((layer, vec![material.id])),
        }
    }
    let mut found: Vec<Sections> = Vec::new();
    let mut empty: Vec<String> = Vec::new();
    let mut layers: Vec<Option<LabelVolume>> = layers.into_iter().map(Some).collect();
    for (layer, labels) in wanted {
        let Some(volume) = layers[layer].take() else { continue };
        let volume = volume.of_labels(&labels);
        let nothing = labels.iter().filter(|&&label| !sizes[layer].contains_key(&Label(label)));
        let name = |label: &u32| volume.materials.iter().find(|own| own.id == *label);
        empty.extend(nothing.filter_map(name).map(|own| own.name.clone()));
        if volume.bounds().is_some() {
            let mut sections = sections_of(file, volume, rules)?;
            sections.files = vec![file.to_owned()];
            found.push(sections);
        }
    }
    let Some(first) = found.first_mut() else {
        let what = "all of its voxels are 0, which is outside: export the labels";
        return Err(Error::file(file, what));
    };
    first.left_out.extend(empty.into_iter().map(|section| {
        let what = "no voxel has its number: the segment is left out".to_owned();
        Warning { section, what }
    }));
    Ok(found)
}

/// The sections that were drawn in a volume.
fn sections_of(file: &Path, volume: LabelVolume, rules: &Rules) -> Result<Sections> {
    let Slices { images, found, left_out } =
        volume.slices(&rules.images).map_err(|what| Error::file(file, what))?;
    if volume.materials.is_empty() {
        // Where nobody named labels there may be none.
        let slices = images.par_iter().map(|(_, image)| Values::of_slice(image));
        let values = slices.reduce(Values::default, Values::sum);
        values.require_areas("volume").map_err(|what| Error::file(file, what))?;
    }
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
