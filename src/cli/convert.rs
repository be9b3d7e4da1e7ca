//! `transect convert`: from any kind of section files to one that is written.

use std::path::Path;

use super::args::ConvertArguments;
use super::print_warnings;
use crate::error::{Error, Result};
use crate::io::dicom::{self, Template, is_dicom};
use crate::io::{contour, csl, json, polylines, vtp};
use crate::label::{Label, Material};
use crate::layers::drawn_contours;
use crate::output::{Outputs, write_error};
use crate::section::{Section, Sections};
use crate::terminal;

/// Reads and writes.
pub fn run(arguments: &ConvertArguments) -> Result<()> {
    let path = &arguments.output;
    let kind = ending(path);
    let write = match kind.as_str() {
        "dcm" => None,
        _ => Some(writer(path)?),
    };
    let mut outputs = Outputs::reserve([path.as_path()])?;
    let sections = arguments.input.read()?;
    match write {
        Some(write) => outputs.write(path, |out| write(&sections, out))?,
        None => {
            let mut files = arguments.input.sections.iter();
            let template = files.find(|file| is_dicom(file));
            let template = template.map(|file| Template::read(file)).transpose()?;
            let structures = drawn_contours(&sections)?;
            outputs.write(path, |out| {
                dicom::write(&structures, template.as_ref(), out)
                    .map_err(|error| write_error(path, &error))
            })?;
        }
    }
    outputs.commit()?;
    if arguments.quiet {
        return Ok(());
    }
    print_warnings(&sections);
    let lost = unsaid(&sections, &kind);
    if !lost.is_empty() {
        let what = format!("note: .{kind} has no words for {}: .json has", lost.join(", "));
        terminal::tell(&terminal::shortened(&what));
    }
    Ok(())
}

/// What writes sections.
pub type Writer = fn(&Sections, &mut dyn std::io::Write) -> Result<()>;

/// By the ending of a file's name.
pub fn writer(path: &Path) -> Result<Writer> {
    match ending(path).as_str() {
        "csl" => Ok(csl::write),
        "contour" => Ok(contour::write),
        "json" => Ok(json::write),
        "obj" => Ok(polylines::write),
        "vtp" => Ok(vtp::write),
        _ => Err(Error::file(
            path,
            "sections are written to .json, .csl, .contour, .obj and .vtp, by convert also to .dcm: \
             name such a file",
        )),
    }
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// What is known of sections that this kind of file does not say.
fn unsaid(sections: &Sections, kind: &str) -> Vec<&'static str> {
    let all = &sections.sections;
    let mut names = (1..).zip(all);
    let plain = |own: &Material| Material::numbered(Label(own.id));
    let is_named = sections.materials.iter().any(|own| own.name != plain(own).name);
    let is_coloured = sections.materials.iter().any(|own| own.color != plain(own).color);
    let mut numbers = (1..).zip(&sections.materials);
    let is_numbered = numbers.any(|(number, own)| number != own.id);
    let draws_nothing = |own: &Section| own.labels().iter().all(|label| !label.is_material());
    let (by_lines, by_structures) = (matches!(kind, "obj" | "vtp" | "dcm"), kind == "dcm");
    // Sets are in millimetres and LPS, and data of VTK have fields.
    let is_told = matches!(kind, "vtp" | "dcm");
    let known = [
        (!sections.units.is_empty() && !is_told, "the unit of length"),
        (!sections.frame.is_empty() && !is_told, "the frame"),
        (sections.up.is_some(), "what is up"),
        (is_named && !is_told && kind != "obj", "names of labels"),
        (is_coloured && !is_told, "colours of labels"),
        (is_numbered && kind == "obj", "numbers of labels"),
        (names.any(|(number, own)| own.name() != number.to_string()), "names of sections"),
        (all.iter().any(|own| !own.normals().is_empty()), "the surface's normals"),
        (by_lines && all.iter().any(draws_nothing), "sections that show nothing"),
        (by_structures && all.iter().any(Section::is_partial), "unknown regions"),
    ];
    let known = known.into_iter().filter(|(is_known, _)| kind != "json" && *is_known);
    known.map(|(_, what)| what).collect()
}
