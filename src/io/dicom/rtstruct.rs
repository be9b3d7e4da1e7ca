//! Structure sets (RTSTRUCT): contours that people and planning systems drew on slices, in
//! millimetres and the patient's frame (DICOM PS3.3, A.19 and C.8.8.6). Structures overlap as
//! they like, so each is a layer of its own.

use std::path::Path;

use dicom_dictionary_std::tags;
use glam::DVec3;
use rayon::prelude::*;

use super::slices::{Slice, Slices, area, slices};
use super::{Object, items, text};
use crate::error::{Error, Result};
use crate::io::structures::{Chosen, Named};
use crate::io::text::shortened;
use crate::io::{diagonal, doubt};
use crate::label::{Label, Material};
use crate::section::{Curve, Findings, Holes, Rules, Section, Sections, Warning};

/// What coordinates are in, by the standard.
const UNITS: &str = "mm";
const FRAME: &str = "LPS";
/// Gaps between slices that are more than this many times the usual one are told.
const UNEVEN: f64 = 1.5;

/// One structure (a region of interest, ROI).
struct Structure {
    number: u32,
    name: String,
    color: Option<[u8; 3]>,
    curves: Vec<Curve>,
    /// Contours that enclose nothing by what they are.
    left_out: Vec<Warning>,
    /// What is doubtful about it.
    doubts: Vec<String>,
}

/// Reads the structures that are chosen, each as a layer; those in which nothing is enclosed are
/// left out, with a word in the first layer.
///
/// # Errors
/// Where contours are not flat, overlap in part, or none encloses anything.
pub fn read(file: &Path, object: &Object, chosen: &Chosen, rules: &Rules) -> Result<Vec<Sections>> {
    let mut structures = structures(file, object)?;
    let named = |one: &'_ Structure| one.curves.iter().map(|curve| area(&curve.points)).sum();
    let sizes: Vec<f64> = structures.iter().map(named).collect();
    let known: Vec<Named> = structures
        .iter()
        .zip(sizes)
        .map(|(one, size)| Named { number: one.number, name: &one.name, size })
        .collect();
    let order = chosen.of(&known)?;
    let all = structures.iter().flat_map(|structure| &structure.curves);
    let diagonal = diagonal(all.flat_map(|curve| &curve.points));
    let labels = labels(&structures);
    let mut layers: Vec<Sections> = Vec::new();
    let mut left_out: Vec<Warning> = Vec::new();
    for place in order {
        let structure = &mut structures[place];
        let mut own = std::mem::take(&mut structure.left_out);
        match layer(file, structure, labels[place], diagonal, rules)? {
            Some(mut layer) => {
                layer.left_out.splice(0..0, own);
                layers.push(layer);
            }
            None => {
                let what = "nothing of it encloses an area: the structure is left out".to_owned();
                own.push(Warning { section: structure.name.clone(), what });
                left_out.append(&mut own);
            }
        }
    }
    let Some(first) = layers.first_mut() else {
        let what = "no contour of any structure encloses an area: export the contours again";
        return Err(Error::file(file, what));
    };
    first.left_out.splice(0..0, left_out);
    Ok(layers)
}

/// The structures' own numbers, where they are labels; else they are numbered.
fn labels(structures: &[Structure]) -> Vec<Label> {
    let mut numbers: Vec<u32> = structures.iter().map(|structure| structure.number).collect();
    let are_labels = numbers.iter().all(|number| (1..=Label::LARGEST.0).contains(number));
    numbers.sort_unstable();
    let are_different = numbers.windows(2).all(|pair| pair[0] != pair[1]);
    let own = |(place, structure): (usize, &Structure)| match are_labels && are_different {
        true => Label(structure.number),
        false => Label(place as u32 + 1),
    };
    structures.iter().enumerate().map(own).collect()
}

/// The sections of a structure; `None` where nothing is enclosed.
fn layer(
    file: &Path,
    structure: &Structure,
    label: Label,
    diagonal: f64,
    rules: &Rules,
) -> Result<Option<Sections>> {
    let Structure { number, name, color, curves, doubts, .. } = structure;
    let points: Vec<&[DVec3]> = curves.iter().map(|curve| curve.points.as_slice()).collect();
    let Slices { slices, moved, farthest, bent, astray } =
        slices(&points, rules.tolerance * diagonal);
    if let Some(&(contour, distance)) = bent.first() {
        let what = format!(
            "{} is not flat: its points are up to {distance:.3} {UNITS} off any plane: correct it, \
             or choose other structures",
            curves[contour].name
        );
        return Err(Error::input(file, format!("structure {name}"), what));
    }
    let section = |slice: &Slice| -> Result<(Section, Holes, Findings)> {
        let onto = |&point: &DVec3| slice.plane.lift(slice.plane.project(point));
        let own = slice.contours.iter().map(|&contour| &curves[contour]);
        let own: Vec<Curve> = own
            .map(|curve| Curve { points: curve.points.iter().map(onto).collect(), ..curve.clone() })
            .collect();
        let title = format!("{name} at {}", rounded(slice.plane.offset));
        Section::from_parity(&title, slice.plane, label, &own, diagonal, rules)
            .map_err(|error| in_file(file, error))
    };
    let made = slices.par_iter().map(section).collect::<Result<Vec<_>>>()?;
    let (mut found, mut holes) = (Findings::default(), Holes::default());
    let mut sections = Vec::with_capacity(made.len());
    for (section, own, findings) in made {
        if !findings.is_void {
            sections.push(section);
        }
        found.append(findings);
        holes.nested += own.nested;
        holes.exclusive += own.exclusive;
        holes.keyholes += own.keyholes;
    }
    if sections.is_empty() {
        return Ok(None);
    }
    let planes: Vec<_> = sections.iter().map(|section| *section.plane()).collect();
    let mut layer = Sections::new(sections, rules).map_err(|error| in_file(file, error))?;
    layer.note(found);
    layer.off_plane = farthest;
    layer.left_out.extend(astray.into_iter().map(|contour| {
        let Curve { name: called, points, .. } = &curves[contour];
        let what = format!("{called} ({} points) encloses no area", points.len());
        Warning { section: name.clone(), what }
    }));
    let plain = Material::numbered(label);
    let material =
        Material { id: label.0, name: name.clone(), color: color.unwrap_or(plain.color) };
    layer.name_materials(vec![material]);
    (layer.units, layer.frame, layer.up) = (UNITS.to_owned(), FRAME.to_owned(), Some(DVec3::Z));
    layer.files = vec![file.to_owned()];
    let note = |what: String| Warning { section: String::new(), what: format!("{name}: {what}") };
    if let Some(what) = told(holes) {
        layer.notes.push(note(what));
    }
    if moved > 0 {
        layer.notes.push(note(format!(
            "{moved} contours were off their slices, by up to {farthest:.4} {UNITS}, and are put on \
             them"
        )));
    }
    if let Some(what) = uneven(&planes) {
        layer.notes.push(note(what));
    }
    for what in doubts {
        doubt(&mut layer, file, &format!("structure {name} ({number})"), what.clone(), rules)?;
    }
    Ok(Some(layer))
}

/// Which ways of drawing holes occur.
fn told(Holes { nested, exclusive, keyholes }: Holes) -> Option<String> {
    let ways = [
        (nested - exclusive, "as contours within others"),
        (exclusive, "as contours that say so (XOR)"),
        (keyholes, "as keyholes"),
    ];
    let ways = ways.iter().filter(|(count, _)| *count > 0);
    let ways: Vec<String> = ways.map(|(count, way)| format!("{count} {way}")).collect();
    (!ways.is_empty()).then(|| format!("holes: {}", ways.join(", ")))
}

/// Gaps between neighbouring slices that are wider than usual.
fn uneven(planes: &[crate::plane::Plane]) -> Option<String> {
    let first = planes.first()?;
    let parallel = planes.iter().all(|plane| plane.normal == first.normal);
    let mut offsets: Vec<f64> = planes.iter().map(|plane| plane.offset).collect();
    offsets.sort_by(f64::total_cmp);
    let gaps: Vec<f64> = offsets.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mut sorted = gaps.clone();
    sorted.sort_by(f64::total_cmp);
    let usual = *sorted.get(sorted.len() / 2)?;
    let wide: Vec<f64> = gaps.into_iter().filter(|&gap| gap > UNEVEN * usual).collect();
    let widest = wide.iter().copied().fold(0.0, f64::max);
    (parallel && !wide.is_empty()).then(|| {
        let (count, gaps) = (wide.len(), if wide.len() == 1 { "gap is" } else { "gaps are" });
        format!(
            "its slices are {} {UNITS} apart, but {count} {gaps} wider, up to {} {UNITS}",
            rounded(usual),
            rounded(widest)
        )
    })
}

/// A length to a thousandth.
fn rounded(length: f64) -> f64 {
    (length * 1e3).round() / 1e3 + 0.0 // no -0
}

/// What an error says of a section is about this file.
fn in_file(file: &Path, error: Error) -> Error {
    error.map(|error| match error {
        Error::Section { section, what } => {
            Error::input(file, format!("structure {section}"), what)
        }
        Error::Option(what) => Error::file(file, what),
        other => other,
    })
}

/// All structures of a file, also those without contours.
fn structures(file: &Path, object: &Object) -> Result<Vec<Structure>> {
    let mut structures: Vec<Structure> = Vec::new();
    for item in items(object, tags::STRUCTURE_SET_ROI_SEQUENCE) {
        let number = number(item, tags::ROI_NUMBER);
        let name = match text(item, tags::ROI_NAME).trim() {
            "" => format!("ROI {number}"),
            name => name.to_owned(),
        };
        let (curves, left_out, doubts) = Default::default();
        structures.push(Structure { number, name, color: None, curves, left_out, doubts });
    }
    if structures.is_empty() {
        return Err(Error::file(file, "the structure set has no structures: export it again"));
    }
    for item in items(object, tags::ROI_CONTOUR_SEQUENCE) {
        let number = number(item, tags::REFERENCED_ROI_NUMBER);
        let own = structures.iter_mut().find(|structure| structure.number == number);
        let Some(structure) = own else {
            let what = format!("contours are of structure {number}, which there is not");
            let place = "ROI contour sequence";
            return Err(Error::input(file, place, format!("{what}: export it again")));
        };
        structure.color = color(item);
        for (number, contour) in items(item, tags::CONTOUR_SEQUENCE).iter().enumerate() {
            structure.add(file, number, contour)?;
        }
    }
    Ok(structures)
}

fn number(object: &Object, tag: dicom_core::Tag) -> u32 {
    text(object, tag).parse().unwrap_or(0)
}

fn color(item: &Object) -> Option<[u8; 3]> {
    let channels = item.get(tags::ROI_DISPLAY_COLOR)?.to_multi_int::<i64>().ok()?;
    let channels: Vec<u8> = channels.iter().map(|&own| own.clamp(0, 255) as u8).collect();
    channels.try_into().ok()
}

impl Structure {
    fn add(&mut self, file: &Path, number: usize, contour: &Object) -> Result<()> {
        let kind = text(contour, tags::CONTOUR_GEOMETRIC_TYPE);
        let called = match text(contour, tags::CONTOUR_NUMBER).parse::<u32>() {
            Ok(own) => format!("contour {own}"),
            Err(_) => format!("contour {}", number + 1),
        };
        let points = points(contour).map_err(|what| {
            let place = format!("structure {}, {called}", self.name);
            Error::input(file, place, format!("{what}: export it again"))
        })?;
        let promised = text(contour, tags::NUMBER_OF_CONTOUR_POINTS).parse::<usize>();
        if let Some(promised) = promised.ok().filter(|&promised| promised != points.len()) {
            let count = points.len();
            self.doubts.push(format!(
                "{called} promises {promised} points and has {count}: what it has is read"
            ));
        }
        let is_exclusive = matches!(kind.as_str(), "CLOSEDPLANAR_XOR" | "CLOSED_PLANAR_XOR");
        let at = points.first().map_or(String::new(), |point| format!(", at {point}"));
        let reason = match kind.as_str() {
            "CLOSED_PLANAR" | "" if points.len() < 3 => "encloses no area".to_owned(),
            "CLOSED_PLANAR" | "" => String::new(),
            _ if is_exclusive => String::new(),
            "POINT" => "is a point".to_owned(),
            "OPEN_PLANAR" | "OPEN_NONPLANAR" => format!("is open ({kind})"),
            other => format!("is of an unknown kind ({})", shortened(other)),
        };
        if reason.is_empty() {
            self.curves.push(Curve { name: called, points, is_exclusive });
        } else {
            let what = format!("{called} ({} points{at}) {reason}", points.len());
            self.left_out.push(Warning { section: self.name.clone(), what });
        }
        Ok(())
    }
}

/// The points of a contour; what is wrong with them.
pub(super) fn points(contour: &Object) -> std::result::Result<Vec<DVec3>, String> {
    let Some(element) = contour.get(tags::CONTOUR_DATA) else { return Ok(Vec::new()) };
    let numbers =
        element.to_multi_float64().map_err(|_| "its coordinates are not all numbers".to_owned())?;
    if numbers.len() % 3 != 0 {
        return Err(format!("it has {} coordinates, which are no points", numbers.len()));
    }
    if let Some(place) = numbers.iter().position(|number| !number.is_finite()) {
        return Err(format!("coordinate {place} is not finite"));
    }
    Ok(numbers.as_chunks::<3>().0.iter().map(|&point| DVec3::from(point)).collect())
}
