//! Sections from pictures whose pixels are labels, and from the slices of volumes.

mod frames;
mod names;
mod page;
mod png;
mod stack;
mod tiff;
mod values;
mod volume;

use std::path::{Path, PathBuf};

use super::{Raw, check, reason};
use crate::error::{Error, Remedy, Result};
use crate::label::Label;
use crate::label_image::LabelImage;
use crate::section::{Findings, Rules, Sections, Warning};

pub use volume::{is_layered, layers_of, read_layers, read_slices};

/// The kinds of pictures that sections are read from.
pub const IMAGE_KINDS: &str = ".png, .tif, .tiff";

/// How many names a message holds.
const NAMED: usize = 6;

/// Whether a file is a picture by the ending of its name.
pub fn is_image(path: &Path) -> bool {
    ["png", "tif", "tiff"].contains(&ending(path).as_str())
}

/// Whether a file is a picture that has been compressed at the expense of its values.
pub(super) fn is_lossy(path: &Path) -> bool {
    ["jpg", "jpeg", "jp2"].contains(&ending(path).as_str())
}

/// Why such a picture is refused.
pub(super) const LOSSY: &str = "JPEG changes values near edges, so they are no labels: save it as \
                                PNG or TIFF where it was made; converting it does not help";

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// Reads the pictures of a folder as one stack, in the order of the numbers in their names.
///
/// # Errors
/// Where there is none, where one cannot be read or holds no labels, where their sizes differ,
/// and where it is not known how far they are apart.
pub fn read_folder(folder: &Path, rules: &Rules) -> Result<Sections> {
    let (mut images, mut others) = (Vec::new(), Vec::new());
    let failed = |error| Error::file(folder, reason(&error));
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let is_hidden = name(&path).starts_with('.');
        // What a link leads nowhere to is no file either.
        let is_file = std::fs::metadata(&path).is_ok_and(|about| about.is_file());
        match is_image(&path) && is_file {
            _ if is_hidden => (),
            true => images.push(path),
            false => others.push(path),
        }
    }
    others.sort();
    if images.is_empty() {
        return Err(Error::file(folder, no_images(&others)));
    }
    let mut sections = stack::read(folder, images, rules)?;
    if !others.is_empty() {
        let what = format!("{}: only {IMAGE_KINDS} are read in a folder", list(&others));
        sections.left_out.push(Warning { section: String::new(), what });
    }
    sections.files = vec![folder.to_owned()];
    Ok(sections)
}

fn no_images(others: &[PathBuf]) -> String {
    match others {
        [] => format!("the folder is empty: name one with {IMAGE_KINDS} in it"),
        others if others.iter().any(|path| is_lossy(path)) => LOSSY.to_owned(),
        others => format!(
            "there are no pictures in this folder ({IMAGE_KINDS}), but {}: name the files, or a \
             folder of pictures",
            list(others)
        ),
    }
}

/// Reads pictures as one stack, in the order of the numbers in their names.
///
/// # Errors
/// As [`read_folder`].
pub fn read_files(files: &[PathBuf], rules: &Rules) -> Result<Sections> {
    let first = files.first().map_or(Path::new(""), PathBuf::as_path);
    let mut sections = stack::read(first, files.to_vec(), rules)?;
    sections.files = files.to_vec();
    Ok(sections)
}

/// Sections of images that are called by names, with what is doubtful about them.
fn sections(file: &Path, images: Vec<(String, LabelImage)>, rules: &Rules) -> Result<Sections> {
    let raw: Vec<Raw<LabelImage>> = images
        .into_iter()
        .map(|(name, content)| Raw { name, place: "its pixels".to_owned(), content })
        .collect();
    let mut sections = check(file, &raw, rules, |raw| raw.content.section(&raw.name, rules))?;
    if let Some(what) = on_border(&raw, rules) {
        warn(&mut sections, file, what, rules)?;
    }
    Ok(sections)
}

/// Which labels end at the border of images only because these do.
fn on_border(images: &[Raw<LabelImage>], rules: &Rules) -> Option<String> {
    let (mut labels, mut names) = (Vec::new(), Vec::new());
    for image in images {
        let mut own = image.content.on_border();
        own.retain(|&label| rules.unknown != Some(Label(label)));
        if !own.is_empty() {
            names.push(image.name.as_str());
            labels.append(&mut own);
        }
    }
    labels.sort_unstable();
    labels.dedup();
    let word = if labels.len() == 1 { "label" } else { "labels" };
    let numbers: Vec<String> = labels.iter().map(ToString::to_string).collect();
    (!names.is_empty()).then(|| {
        format!(
            "{word} {} may be cut off by the border of the image in {}: all beyond it counts as \
             outside",
            shortened(&numbers),
            shortened(&names)
        )
    })
}

fn warn(sections: &mut Sections, file: &Path, what: String, rules: &Rules) -> Result<()> {
    if rules.strict {
        return Err(Error::file(file, what).avoidable(Remedy::NotStrict));
    }
    let warnings = vec![Warning { section: String::new(), what }];
    sections.note(Findings { warnings, ..Findings::default() });
    Ok(())
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// The names of files, as a text that any terminal may show.
fn list(files: &[PathBuf]) -> String {
    let names: Vec<String> =
        files.iter().map(|file| name(file).escape_debug().to_string()).collect();
    shortened(&names)
}

/// "a, b and 3 more"
fn shortened(names: &[impl AsRef<str>]) -> String {
    let shown: Vec<&str> = names.iter().take(NAMED).map(AsRef::as_ref).collect();
    match names.len().saturating_sub(NAMED) {
        0 => shown.join(", "),
        more => format!("{} and {more} more", shown.join(", ")),
    }
}
