//! `transect crosscheck`: the field, the exact reconstruction, both meshers
//! and a mesh of the user's held against each other.

use std::path::Path;

use super::args::{CrosscheckArguments, FieldName, MesherName};
use super::bars::Watcher;
use super::targets::{self, Target};
use super::{print, print_warnings, table, write_json};
use crate::crosscheck::{Findings, Kind, Options, Other, crosscheck};
use crate::error::{Error, Result};
use crate::io::mesh::read_mesh;
use crate::io::vdb::{self, DifferenceContents};
use crate::mesh::delaunay;
use crate::output::{Outputs, write_error};
use crate::picture::{self, PictureOptions};
use crate::stage::Stages;

/// Reconstructs, compares and writes; fails last of all when a point that must
/// agree does not.
pub fn run(arguments: &CrosscheckArguments) -> Result<()> {
    if arguments.spacing.is_some() && arguments.method != FieldName::Mvc {
        let what = "--spacing is an option of --method mvc, and means nothing to variational: \
                    leave it out, or choose another method";
        return Err(Error::Option(what.to_owned()));
    }
    let targets = arguments.output.iter().map(|path| target(path)).collect::<Result<Vec<_>>>()?;
    let known = arguments.output.iter().chain(&arguments.report);
    let mut outputs = Outputs::reserve(known.map(|path| path.as_path()))?;

    let watcher = Watcher::new(arguments.quiet);
    let mut stages = Stages::default();
    let rules = arguments.input.reading.rules();
    let sections = stages.run("read", |_| arguments.input.read())?;
    if !arguments.quiet {
        print_warnings(&sections);
    }
    let other = arguments.against.as_deref().map(other).transpose()?;
    let findings = crosscheck(
        sections,
        &rules,
        &options(arguments),
        other.as_ref(),
        &mut stages,
        watcher.progress(),
    )?;
    for (path, kind) in arguments.output.iter().zip(targets) {
        watcher.progress().begin(kind.stage(), 0);
        match kind {
            targets::Kind::Vdb => write_volumes(&mut outputs, path, &findings)?,
            _ => write_picture(&mut outputs, path, &findings)?,
        }
    }
    if let Some(path) = &arguments.report {
        outputs.write(path, |out| write_json(path, &findings.report, out))?;
    }
    watcher.finish();
    outputs.commit()?;
    if !arguments.quiet {
        table::print_crosscheck(&findings.report);
    }
    if arguments.json {
        print(true, &findings.report, |_| String::new())?;
    }
    findings.verdict()
}

/// What an output's name asks for.
fn target(path: &Path) -> Result<targets::Kind> {
    match Target::new(path)?.kind {
        kind @ (targets::Kind::Vdb | targets::Kind::Picture) => Ok(kind),
        _ => Err(Error::file(
            path,
            "a cross-check writes only .vdb and .png: for this one use `transect reconstruct`",
        )),
    }
}

fn options(arguments: &CrosscheckArguments) -> Options {
    let delaunay = arguments.meshers.contains(&MesherName::Delaunay);
    Options {
        field: match arguments.method {
            FieldName::Mvc => Kind::MeanValue,
            FieldName::Variational => Kind::Variational,
        },
        resolution: arguments.grid.resolution(),
        device: arguments.device.into(),
        border: arguments.border.into(),
        margin: arguments.grid.margin,
        spacing: arguments.spacing,
        points: arguments.points,
        seed: arguments.seed,
        delaunay: delaunay.then(delaunay::Options::default),
    }
}

/// The user's mesh.
fn other(path: &Path) -> Result<Other> {
    Ok(Other { file: path.display().to_string(), mesh: read_mesh(path)? })
}

fn write_volumes(outputs: &mut Outputs, path: &Path, findings: &Findings) -> Result<()> {
    let sections = findings.model.sections();
    let contents = DifferenceContents {
        field: &findings.pair.field,
        skeleton: &findings.pair.skeleton,
        differing: &findings.differing,
        depths: &findings.depths,
        about: sections.into(),
    };
    outputs.write_at(path, |temporary| vdb::write_difference(temporary, &contents))
}

fn write_picture(outputs: &mut Outputs, path: &Path, findings: &Findings) -> Result<()> {
    let sections = findings.model.sections();
    let options = PictureOptions::default();
    let (mesh, distances) = (findings.field()?, &findings.distances);
    let image = picture::render_values(mesh, distances, "voxels", sections, &options);
    outputs.write(path, |out| {
        picture::write_png(&image, out).map_err(|error| write_error(path, &error))
    })
}
