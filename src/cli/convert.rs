//! `transect convert`: from any kind of section files to one that is written.

use std::path::Path;

use super::args::ConvertArguments;
use super::print_warnings;
use crate::error::{Error, Result};
use crate::io::{csl, json};
use crate::label::{Label, Material};
use crate::output::Outputs;
use crate::section::Sections;
use crate::terminal;

/// Reads and writes.
pub fn run(arguments: &ConvertArguments) -> Result<()> {
    let path = &arguments.output;
    let write = writer(path)?;
    let mut outputs = Outputs::reserve([path.as_path()])?;
    let sections = arguments.input.read()?;
    outputs.write(path, |out| write(&sections, out))?;
    outputs.commit()?;
    if arguments.quiet {
        return Ok(());
    }
    print_warnings(&sections);
    let lost = unsaid(&sections);
    if ending(path) == "csl" && !lost.is_empty() {
        let what = format!("note: .csl has no words for {}: .json has", lost.join(", "));
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
        "json" => Ok(json::write),
        _ => Err(Error::file(path, "sections are written to .csl and .json; name such a file")),
    }
}

fn ending(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

/// What is known of sections besides planes, contours and numbers of labels.
fn unsaid(sections: &Sections) -> Vec<&'static str> {
    let mut names = (1..).zip(&sections.sections);
    let is_plain = |own: &Material| *own == Material::numbered(Label(own.id));
    let known = [
        (!sections.units.is_empty(), "the unit of length"),
        (!sections.frame.is_empty(), "the frame"),
        (sections.up.is_some(), "what is up"),
        (!sections.materials.iter().all(is_plain), "names and colours of labels"),
        (names.any(|(number, own)| own.name() != number.to_string()), "names of sections"),
        (sections.sections.iter().any(|own| !own.normals().is_empty()), "the surface's normals"),
    ];
    known.into_iter().filter(|(is_known, _)| *is_known).map(|(_, what)| what).collect()
}
