//! Files of sections, by the ending of their name.

mod bodies;
pub mod contour;
pub mod csl;
pub mod dicom;
pub mod exact;
pub mod glb;
pub mod images;
pub mod jser;
pub mod json;
pub mod mesh;
pub mod metaimage;
pub mod nifti;
pub mod nrrd;
pub mod obj;
pub mod off;
pub mod ply;
mod polygons;
pub mod polylines;
pub mod shapes;
pub mod stl;
pub mod structures;
mod text;
pub mod threemf;
pub(crate) mod units;
pub mod usd;
pub mod vdb;
pub mod volume;
pub mod vtk;
mod vtk_xml;
pub mod vtm;
pub mod vtp;

use std::io::{self, Read};
use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Remedy, Result};
use crate::label::Label;
use crate::memory;
use crate::plane::{Bounds, Plane};
use crate::section::{Findings, Region, Rules, Section, Sections, Warning};

use structures::Chosen;

pub use mesh::{read_mesh, write_mesh};

/// The kinds of files that sections are read from.
pub const KINDS: &str = ".csl, .contour, .json, .jser, .obj (polylines), .vtp (lines), DICOM structure sets \
                         and segmentations (.dcm), volumes of labels (.nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd) and \
                         pictures (.png, .tif, .tiff, a folder of them)";

/// Reads the sections of a file, its kind given by the ending of its name.
///
/// # Errors
/// Where the file cannot be read or breaks a rule; the error names the file,
/// the section and the place.
pub fn read_sections(path: &Path, rules: &Rules) -> Result<Sections> {
    let mut sections = read_part(path, rules)?;
    sections.expect_unknown(rules)?;
    Ok(sections)
}

/// Reads one of several files: a label that means *unknown* may be in another.
///
/// # Errors
/// As [`read_sections`].
pub fn read_part(path: &Path, rules: &Rules) -> Result<Sections> {
    let mut sections = match path {
        path if path.is_dir() => images::read_folder(path, rules)?,
        path if images::is_image(path) => images::read_files(&[path.to_owned()], rules)?,
        path if is_layered(path) => only(path, read_file(path, &Chosen::default(), rules)?)?,
        path if volume::is_volume(path) => images::read_slices(path, rules)?,
        path if is_vtp(path) => vtp::read(&read_bytes(path)?, path, rules)?,
        path => read_drawing(path, rules)?,
    };
    units::measure(&mut sections, rules);
    sections.files = vec![path.to_owned()];
    Ok(sections)
}

/// Whether a file may hold structures that overlap, and so several layers.
pub fn is_layered(path: &Path) -> bool {
    images::is_layered(path) || !is_text(path) && dicom::is_dicom(path)
}

/// The layers of a file that may have several.
fn read_file(path: &Path, chosen: &Chosen, rules: &Rules) -> Result<Vec<Sections>> {
    let mut layers = match images::is_layered(path) {
        true => images::read_layers(path, chosen, rules)?,
        false => dicom::read(path, chosen, rules)?,
    };
    for (place, layer) in layers.iter_mut().enumerate() {
        let notes = layer.notes.len();
        units::measure(layer, rules);
        // Once for the file.
        if place > 0 {
            layer.notes.truncate(notes);
        }
    }
    Ok(layers)
}

fn is_vtp(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("vtp"))
}

/// Whether a file is one of ours by the ending of its name, whatever is in it.
fn is_text(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    matches!(
        ending.as_str(),
        "csl"
            | "contour"
            | "json"
            | "jser"
            | "obj"
            | "vtp"
            | "nrrd"
            | "nhdr"
            | "mha"
            | "mhd"
            | "nii"
    )
}

/// The one layer of a file.
fn only(path: &Path, mut layers: Vec<Sections>) -> Result<Sections> {
    match (layers.pop(), layers.is_empty()) {
        (Some(only), true) => Ok(only),
        (last, _) => {
            let count = layers.len() + usize::from(last.is_some());
            Err(structures::several(&[path.to_owned()], count))
        }
    }
}

/// Reads the sections of several files in layers: in each of them labels exclude each other, and
/// layers may overlap. Most files hold one layer, and those of several files are one set; a file of
/// several structures is read alone, unless one of them is chosen or they are made to exclude each
/// other.
///
/// # Errors
/// As [`read_all`], and where a structure is chosen that is in none of the files.
pub fn read_layers(paths: &[PathBuf], chosen: &Chosen, rules: &Rules) -> Result<Vec<Sections>> {
    if !paths.iter().any(|path| is_layered(path)) {
        return Ok(vec![read_all(paths, rules)?]);
    }
    let of = |path: &PathBuf| -> Result<Vec<Sections>> {
        let layers = read_file(path, chosen, rules)?;
        match chosen.partition {
            Some(_) => Ok(vec![Sections::partition(layers, rules)?]),
            None => Ok(layers),
        }
    };
    if let [path] = paths {
        let mut layers = of(path)?;
        layers.iter_mut().try_for_each(|layer| layer.expect_unknown(rules))?;
        return Ok(layers);
    }
    let (layered, others): (Vec<&PathBuf>, Vec<&PathBuf>) =
        paths.iter().partition(|path| is_layered(path));
    let parts = layered.into_iter().map(|path| only(path, of(path)?));
    let mut parts = parts.collect::<Result<Vec<_>>>()?;
    if !others.is_empty() {
        let others: Vec<PathBuf> = others.into_iter().cloned().collect();
        parts.push(read_all(&others, rules)?);
    }
    Ok(vec![Sections::join(parts, rules)?])
}

/// Reads a file of contours.
fn read_drawing(path: &Path, rules: &Rules) -> Result<Sections> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let read: fn(&str, &Path, &Rules) -> Result<Sections> = match ending.as_str() {
        "csl" => csl::read,
        "contour" => contour::read,
        "json" => json::read,
        "jser" => jser::read,
        "obj" => polylines::read,
        _ if images::is_lossy(path) => return Err(Error::file(path, images::LOSSY)),
        _ => {
            let what = format!("this kind of file is not known: sections are read from {KINDS}");
            return Err(Error::file(path, what));
        }
    };
    read(&read_text(path)?, path, rules)
}

/// Reads the sections of several files as one set. Pictures that are named one by one are one
/// stack.
///
/// # Errors
/// As [`read_sections`], and where the files do not go together.
pub fn read_all(paths: &[PathBuf], rules: &Rules) -> Result<Sections> {
    if let [path] = paths {
        return read_sections(path, rules);
    }
    let is_slice = |path: &&PathBuf| images::is_image(path) && !path.is_dir();
    let (slices, others): (Vec<&PathBuf>, Vec<&PathBuf>) = paths.iter().partition(is_slice);
    let slices: Vec<PathBuf> = slices.into_iter().cloned().collect();
    let others = others.into_iter().map(|path| read_part(path, rules));
    let mut parts = others.collect::<Result<Vec<_>>>()?;
    if !slices.is_empty() {
        let mut stack = images::read_files(&slices, rules)?;
        units::measure(&mut stack, rules);
        parts.push(stack);
    }
    let mut sections = match parts.len() {
        1 => parts.remove(0),
        _ => Sections::join(parts, rules)?,
    };
    sections.expect_unknown(rules)?;
    Ok(sections)
}

/// What is read from a file takes up to so many times as much memory.
const TIMES_READ: u64 = 4;

/// The bytes of a file that has an end and fits into memory, and is not empty.
fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let failed = |error: io::Error| Error::file(path, reason(&error));
    // Before it is opened: a pipe may wait for ever for somebody to write to it.
    let about = std::fs::metadata(path).map_err(failed)?;
    if !about.is_file() && !about.is_dir() {
        let what = "this is no file but a device or a pipe: copy what it gives to a file first";
        return Err(Error::file(path, what));
    }
    let mut file = std::fs::File::open(path).map_err(failed)?;
    let needed = about.len().saturating_mul(TIMES_READ);
    memory::require(needed, || format!("reading {}", path.display()))?;
    let mut bytes = Vec::new();
    file.by_ref().take(about.len()).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.is_empty() {
        return Err(Error::file(path, "the file is empty: export it again"));
    }
    Ok(bytes)
}

/// The bytes of a text without the mark that some programs begin it with.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

fn read_text(path: &Path) -> Result<String> {
    let mut bytes = read_bytes(path)?;
    bytes.drain(..bytes.len() - without_mark(&bytes).len());
    String::from_utf8(bytes).map_err(|error| {
        let place = error.utf8_error().valid_up_to();
        Error::file(path, format!("this is no text file (byte {place}): export it again as text"))
    })
}

fn reason(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::NotFound => "there is no such file: check the name".to_owned(),
        io::ErrorKind::PermissionDenied => {
            "the file may not be read: check its permissions".to_owned()
        }
        io::ErrorKind::IsADirectory => "this is a folder: name a file in it".to_owned(),
        _ => format!("it cannot be read: {error}"),
    }
}

/// A section as a file gives it, before it is checked.
struct Raw<T> {
    name: String,
    /// Where it is in the file, for errors: "line 7".
    place: String,
    content: T,
}

/// Checks the sections of a file, in parallel; the first error counts.
fn check<T: Sync>(
    file: &Path,
    raw: &[Raw<T>],
    rules: &Rules,
    make: impl Fn(&Raw<T>) -> Result<(Section, Findings)> + Sync,
) -> Result<Sections> {
    let made: Vec<Result<(Section, Findings)>> =
        raw.par_iter().map(|raw| make(raw).map_err(|error| at(file, raw, error))).collect();
    let mut sections = Vec::with_capacity(made.len());
    let mut found = Findings::default();
    let mut unknown_occurs = false;
    for (result, raw) in made.into_iter().zip(raw) {
        let (section, findings) = result?;
        unknown_occurs |= rules.unknown.is_some_and(|label| section.labels().contains(&label));
        if !findings.is_void {
            // Before sections of one plane are merged: each completes the other.
            let section = section.relabelled(|label| rules.meaning(label));
            require_labels(&section).map_err(|error| at(file, raw, error))?;
            sections.push(section);
        }
        found.append(findings);
    }
    if sections.is_empty() && found.is_void {
        let what = "no contour of any section encloses an area: export the contours again";
        return Err(Error::file(file, what));
    }
    let mut sections = Sections::new(sections, rules).map_err(|error| in_file(file, raw, error))?;
    sections.note(found);
    sections.unknown_occurs = unknown_occurs;
    Ok(sections)
}

/// Refuses labels that files of results have no room for, before any work is done.
fn require_labels(section: &Section) -> Result<()> {
    let labels = section.labels().into_iter().filter(|label| label.is_material());
    match labels.max().filter(|&label| label > Label::LARGEST) {
        Some(label) => {
            let what = format!(
                "label {label} is too large: labels go up to {}, number them anew",
                Label::LARGEST
            );
            Err(Error::Section { section: section.name().to_owned(), what })
        }
        None => Ok(()),
    }
}

/// An error of a section, with its place in a file.
fn at<T>(file: &Path, raw: &Raw<T>, error: Error) -> Error {
    error.map(|error| match error {
        Error::Section { section, what } => {
            Error::input(file, format!("section {section} ({})", raw.place), what)
        }
        Error::Option(what) => Error::file(file, what),
        other => other,
    })
}

/// An error of sections together, with the place of the one that it names.
fn in_file<T>(file: &Path, raw: &[Raw<T>], error: Error) -> Error {
    error.map(|error| {
        let named = match &error {
            Error::Section { section, .. } => raw.iter().rev().find(|raw| raw.name == *section),
            _ => None,
        };
        match (named, error) {
            (Some(raw), error) => at(file, raw, error),
            (None, Error::Option(what)) => Error::file(file, what),
            (None, other) => other,
        }
    })
}

/// How far points are off their planes at most, in world units: with the planes as a file gives
/// them, and with the other sign of their offsets.
fn off_planes<'a>(planes: impl Iterator<Item = (&'a Plane, &'a [DVec3])>) -> [f64; 2] {
    planes.fold([0.0; 2], |most, (plane, points)| {
        let other = Plane { offset: -plane.offset, ..*plane };
        [(most[0], *plane), (most[1], other)].map(|(most, plane)| {
            points.iter().map(|&point| plane.distance(point).abs()).fold(most, f64::max)
        })
    })
}

/// The diagonal of all vertices of a file.
fn diagonal<'a>(points: impl Iterator<Item = &'a DVec3>) -> f64 {
    let finite = points.copied().filter(|point| point.is_finite());
    Bounds::around(finite).map_or(0.0, |bounds| bounds.diagonal())
}

/// The regions of a section that have boundaries of their own, for a kind of file that says nothing
/// else.
fn writable(section: &Section, kind: &str) -> Result<Vec<Region>> {
    let error = |what: &str| Error::Section {
        section: section.name().to_owned(),
        what: format!("{what} cannot be written as {kind}: write .json instead"),
    };
    if section.is_partial() {
        return Err(error("an unknown region"));
    }
    if section.background() != Label::OUTSIDE {
        return Err(error("a material that reaches to infinity"));
    }
    let mut regions = section.regions()?;
    regions.retain(|region| region.label.is_material() && region.outer.is_some());
    Ok(regions)
}

/// What a failed write to `what` means.
fn unwritten(what: &str, error: &io::Error) -> Error {
    Error::file(Path::new(what), format!("the sections cannot be written: {error}"))
}

/// What follows the last section that the header promises is not read, which
/// is doubtful.
fn refuse_rest(
    rows: &mut text::Rows,
    count: usize,
    file: &Path,
    rules: &Rules,
    sections: &mut Sections,
) -> Result<()> {
    if rows.try_next().is_none() {
        return Ok(());
    }
    let what = format!(
        "line {}: the header promises {count} sections, but more follows: it is not read",
        rows.line
    );
    doubt(sections, file, "the end", what, rules)
}

/// Something is doubtful about a place of a file: a warning, or an error when strict.
fn doubt(
    sections: &mut Sections,
    file: &Path,
    place: &str,
    what: String,
    rules: &Rules,
) -> Result<()> {
    if rules.strict {
        return Err(Error::input(file, place, what).avoidable(Remedy::NotStrict));
    }
    sections.warnings.push(Warning { section: String::new(), what });
    Ok(())
}
