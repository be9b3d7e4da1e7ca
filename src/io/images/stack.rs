//! A stack of pictures, one slice each.
//!
//! Pixel (i, j) of slice k has its centre at (i · DX, j · DY, k · DZ): x goes along rows to the
//! right, y down from row to row, and z away from who looks at the picture, so that coordinates
//! are right-handed.

use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use super::names::{self, Numbering};
use super::page::{Page, Resolution};
use super::values::Values;
use super::{is_image, name, png, sections, tiff, warn};
use crate::error::{Error, Remedy, Result};
use crate::label::{Label, Material};
use crate::label_image::{ImagePlacement, LabelImage};
use crate::section::{Rules, Sections, Spacing, Warning};
use crate::volume::{Shown, nth, shown};

/// A picture of the stack.
struct Slice {
    /// The file's name, and the page where there are several.
    name: String,
    file: PathBuf,
    size: [usize; 2],
    /// With one pixel as the unit of length, on z = 0.
    image: LabelImage,
    values: Values,
    resolution: Option<Resolution>,
    palette: Vec<[u8; 3]>,
}

/// Reads pictures, in the order of the numbers in their names; `stack` is for errors.
pub fn read(stack: &Path, mut files: Vec<PathBuf>, rules: &Rules) -> Result<Sections> {
    files.sort_by(|one, other| names::compare(&name(one), &name(other)));
    let slices: Vec<Result<Vec<Slice>>> = files.par_iter().map(|file| slices(file)).collect();
    let slices: Vec<Slice> =
        slices.into_iter().collect::<Result<Vec<_>>>()?.into_iter().flatten().collect();
    require_one_size(&slices)?;
    let (spacing, unit) = spacing(stack, &slices, rules)?;
    let values = slices.iter().map(|slice| slice.values.clone()).reduce(Values::sum);
    let values = values.unwrap_or_default();
    if values.count() == 0 {
        let what = "all of its pixels are 0, which is outside: is it the right picture?";
        return Err(Error::file(stack, what));
    }
    values.require_labels().map_err(|what| Error::file(stack, what))?;
    let white = values.white().filter(|&white| rules.unknown != Some(Label(white)));
    let numbering =
        names::places(&slices.iter().map(|slice| slice.name.clone()).collect::<Vec<_>>());
    let (kept, which) = kept(&slices, rules.images.every);
    let about = About { size: slices[0].size, spacing, count: slices.len() };
    let note = about.words(numbering.as_ref(), &values, white) + &which;
    let materials = materials(&slices);
    let mut images = Vec::with_capacity(kept.len());
    for (index, slice) in slices.into_iter().enumerate().filter(|(index, _)| kept.contains(index)) {
        let place = numbering.as_ref().map_or(index as u64, |numbering| numbering.places[index]);
        let image = slice.image.relabelled(|label| if white == Some(label) { 1 } else { label });
        let image = image.scaled(spacing, place as f64 * spacing[2]);
        images.push((slice.name, image.map_err(|what| Error::file(&slice.file, what))?));
    }
    let mut sections = sections(stack, images, rules)?;
    if let Some(what) = numbering.as_ref().and_then(missing) {
        warn(&mut sections, stack, what, rules)?;
    }
    sections.notes.push(Warning { section: String::new(), what: note });
    sections.name_materials(materials);
    sections.units = unit;
    Ok(sections)
}

/// The pictures of a file.
fn slices(file: &Path) -> Result<Vec<Slice>> {
    let mut slices = Vec::new();
    if super::ending(file) == "png" {
        slices.push(slice(name(file), file, png::read(file)?)?);
        return Ok(slices);
    }
    debug_assert!(is_image(file));
    tiff::read(file, |number, page| {
        slices.push(slice(format!("{}, page {number}", name(file)), file, page)?);
        Ok(())
    })?;
    if let [only] = slices.as_mut_slice() {
        only.name = name(file);
    }
    Ok(slices)
}

fn slice(name: String, file: &Path, page: Page) -> Result<Slice> {
    let values = Values::new(&page).map_err(|what| Error::file(file, what))?;
    let Page { size, values: labels, resolution, palette, .. } = page;
    let placement = ImagePlacement { origin: DVec3::ZERO, steps: [DVec3::X, DVec3::Y] };
    let image = LabelImage::new(size, labels, placement);
    let image = image.map_err(|what| Error::file(file, what))?.cropped();
    Ok(Slice { name, file: file.to_owned(), size, image, values, resolution, palette })
}

fn require_one_size(slices: &[Slice]) -> Result<()> {
    let Some((first, rest)) = slices.split_first() else { return Ok(()) };
    let Some(other) = rest.iter().find(|slice| slice.size != first.size) else { return Ok(()) };
    let [[width, height], [own_width, own_height]] = [first.size, other.size];
    let what = format!(
        "{} has {own_width} × {own_height} pixels, and {} has {width} × {height}: pictures of a \
         stack are of one size: crop them alike, or take the one out",
        other.name, first.name
    );
    Err(Error::file(&other.file, what))
}

/// How far pixels, rows and slices are apart, and the unit of length where a file says it.
fn spacing(stack: &Path, slices: &[Slice], rules: &Rules) -> Result<([f64; 3], String)> {
    let resolution = slices.first().and_then(|slice| slice.resolution.clone());
    let missing = |what: &str| Error::file(stack, what).avoidable(Remedy::ImageSpacing);
    match (rules.images.spacing, resolution) {
        (Some(Spacing::All(spacing)), _) => Ok((spacing, String::new())),
        (Some(Spacing::Slices(z)), Some(Resolution { spacing: [x, y], unit })) => {
            Ok(([x, y, z], unit))
        }
        (Some(Spacing::Slices(_)), None) => {
            Err(missing("only the distance of slices is known, and it does not say that of pixels"))
        }
        (None, Some(_)) => Err(missing("it says how far pixels are apart, but not slices")),
        (None, None) => Err(missing("nothing says how far pixels and slices are apart")),
    }
}

/// Which pictures become sections, by their numbers, and a word on it.
fn kept(slices: &[Slice], every: usize) -> (Vec<usize>, String) {
    let is_filled: Vec<bool> = slices.iter().map(|slice| slice.values.count() > 0).collect();
    let empty = is_filled.iter().filter(|is_filled| !**is_filled).count();
    let (kept, mut words): (Vec<usize>, _) = match shown(&is_filled) {
        Shown::Sparse(kept) if empty > 0 => {
            (kept, format!("; what the {empty} empty ones show is unknown"))
        }
        Shown::Sparse(kept) => (kept, String::new()),
        Shown::Full(kept) => (kept.collect(), String::new()),
    };
    let kept: Vec<usize> = kept.into_iter().step_by(every.max(1)).collect();
    if every > 1 {
        words += &format!("; every {} is taken, {}", nth(every), kept.len());
    }
    (kept, words)
}

/// What is said about a stack.
struct About {
    size: [usize; 2],
    spacing: [f64; 3],
    count: usize,
}

impl About {
    fn words(&self, numbering: Option<&Numbering>, values: &Values, white: Option<u32>) -> String {
        let Self { size: [width, height], spacing: [x, y, z], count } = self;
        let numbers = match numbering.map(|numbering| (&numbering.numbers[..], numbering.step)) {
            Some(([first, .., last], step)) => format!(" (numbered {first} to {last} by {step})"),
            _ => String::new(),
        };
        let labels = match (white, values.count()) {
            (Some(white), _) => format!("white ({white}) is label 1"),
            (None, 1) => "one label".to_owned(),
            (None, count) => format!("{count} labels"),
        };
        let pictures = match count {
            1 => "one picture".to_owned(),
            count => format!("a stack of {count} pictures"),
        };
        format!(
            "{pictures}{numbers}, {z} apart, {width} × {height} pixels of \
             {x} × {y}, y goes down; {labels}"
        )
    }
}

fn missing(numbering: &Numbering) -> Option<String> {
    let (first, count) = numbering.missing()?;
    let more = match count {
        1 => String::new(),
        count => format!(" and {} more", count - 1),
    };
    Some(format!(
        "number {first}{more} is missing between the pictures: its place stays empty, and what is \
         there is unknown"
    ))
}

/// The colours of a palette that all pictures have in common.
fn materials(slices: &[Slice]) -> Vec<Material> {
    let Some(first) = slices.first() else { return Vec::new() };
    if slices.iter().any(|slice| slice.palette != first.palette) {
        return Vec::new();
    }
    let labels = (0..).zip(&first.palette).skip(1);
    labels.map(|(id, &color)| Material { color, ..Material::numbered(Label(id)) }).collect()
}
