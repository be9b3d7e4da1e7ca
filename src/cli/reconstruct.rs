//! `transect reconstruct`: sections in, volumes, surfaces, pictures and a
//! report out.

use std::path::Path;

use super::args::{PictureArguments, ReconstructArguments};
use super::bars::Watcher;
use super::method::method;
use super::targets::{Kind, Target};
use super::{print_found, print_warnings, table, write_json};
use crate::change::Change;
use crate::check::{self, check};
use crate::error::{Error, Result};
use crate::io::exact::write_exact;
use crate::io::mesh::{About, MeshKind, write_mesh};
use crate::io::vdb::{self, GridName, VdbContents};
use crate::io::{self};
use crate::label::{Label, Material};
use crate::mesh::Mesh;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::method::{Caps, Mesher};
use crate::model::{Derived, Model, Options};
use crate::output::{Outputs, write_error};
use crate::picture::{self, PictureOptions};
use crate::report::Report;
use crate::section::Sections;
use crate::skeleton::Details;
use crate::stage::Stages;

/// How many materials an error lists.
const LISTED: usize = 20;

/// Reconstructs and writes.
pub fn run(arguments: &ReconstructArguments) -> Result<()> {
    let targets =
        arguments.output.iter().map(|path| Target::new(path)).collect::<Result<Vec<_>>>()?;
    let grids =
        arguments.grids.iter().map(|name| name.trim().parse()).collect::<Result<Vec<_>>>()?;
    let resolution = arguments.grid.resolution();
    let options = Options { method: method(arguments)?, resolution, bounds: None };
    require_picture(&arguments.picture, &targets)?;
    let mut outputs = reserve(arguments, &targets)?;
    super::limit_threads(arguments.threads)?;

    let watcher = Watcher::new(arguments.quiet);
    let mut stages = Stages::default();
    let rules = arguments.reading.rules();
    let sections = stages.run("read", |counts| {
        let sections = io::read_all(&arguments.sections, &rules)?;
        let vertices: usize = sections.sections.iter().map(|one| one.vertices().len()).sum();
        counts.insert("vertices".into(), vertices as u64);
        Ok(sections)
    })?;
    if !arguments.quiet {
        print_warnings(&sections);
    }
    for target in targets.iter().filter(|target| target.is_pattern()) {
        let files = target.files(&sections.materials)?;
        files.iter().try_for_each(|(path, _)| outputs.add(path))?;
    }
    let picture = picture_options(&arguments.picture, &sections)?;
    let mut model = Model::new(options);
    model.apply(Change::Add(sections), &rules, &mut stages, watcher.progress())?;
    let derived = model
        .derived()
        .ok_or_else(|| Error::Bug { stage: "model", what: "nothing was derived".to_owned() })?;
    // With flat caps the surfaces are closed in the faces of an open box.
    let open = derived.samples.open.filter(|_| model.options().method.caps() != Caps::Flat);
    let checked = stages.run("check", |_| {
        // Cheap for the delaunay mesher's fewer triangles, and promised.
        let self_intersections = !matches!(model.options().method.mesher(), Some(Mesher::Dual));
        let options = check::Options { open, self_intersections };
        let Derived { mesh, samples, .. } = derived;
        check(&model.sections().sections, mesh, samples, options, watcher.progress())
    })?;

    if let Some(what) = checked.fault(&derived.mesh) {
        return Err(Error::Bug { stage: "check", what });
    }
    let tolerance = CAP_TOLERANCE * derived.samples.lattice.voxel;
    let opened = open.map(|bounds| derived.mesh.without_caps(bounds, tolerance));
    let results = Results {
        sections: model.sections(),
        derived,
        surfaces: opened.as_ref().unwrap_or(&derived.mesh),
        grids: &grids,
        picture,
    };
    for target in &targets {
        let stage = target.kind.stage();
        stages.run(stage, |_| {
            watcher.progress().begin(stage, 0);
            write(&mut outputs, target, &results)
        })?;
    }
    if let (Some(path), Some(details)) = (&arguments.exact, &derived.exact) {
        require_exact(details)?;
        stages.run("exact", |_| {
            outputs.write(path, |out| {
                write_exact(&derived.mesh, details, out).map_err(|error| write_error(path, &error))
            })
        })?;
    }
    let report = Report::new(&model, derived, checked, &stages);
    if let Some(path) = &arguments.report {
        outputs.write(path, |out| write_json(path, &report, out))?;
    }
    watcher.finish();
    outputs.commit()?;
    if !arguments.quiet {
        print_found(&report.check.warnings(&report.materials));
        table::print(&report);
    }
    Ok(())
}

/// Exact coordinates are of an exact surface alone.
fn require_exact(details: &Details) -> Result<()> {
    let cells = details.left_out.len().max(details.inexact.len());
    if cells == 0 {
        return Ok(());
    }
    Err(Error::Option(format!(
        "{cells} cells hold more partial sections than can be done exactly: leave --exact out"
    )))
}

/// Options of pictures without any are a mistake.
fn require_picture(arguments: &PictureArguments, targets: &[Target]) -> Result<()> {
    let is_drawn = targets.iter().any(|target| target.kind == Kind::Picture);
    if arguments.is_used() && !is_drawn {
        let what = "--view, --up, --size and --labels are for pictures: add -o FILE.png";
        return Err(Error::Option(what.to_owned()));
    }
    Ok(())
}

fn picture_options(arguments: &PictureArguments, sections: &Sections) -> Result<PictureOptions> {
    let default = PictureOptions::default();
    let labels = arguments.labels.iter().map(|word| drawn(word, &sections.materials));
    let labels = labels.collect::<Result<Vec<_>>>()?;
    Ok(PictureOptions {
        size: arguments.size.unwrap_or(default.size),
        view: arguments.view.clone(),
        up: arguments.up,
        labels: (!labels.is_empty()).then_some(labels),
        ..default
    })
}

/// The material of a number or a name.
fn drawn(word: &str, materials: &[Material]) -> Result<Label> {
    let word = word.trim();
    let by_number = || materials.iter().find(|material| Ok(material.id) == word.parse());
    let by_name = || materials.iter().find(|material| material.name == word);
    by_number().or_else(by_name).map(|material| Label(material.id)).ok_or_else(|| {
        let known = materials.iter().take(LISTED);
        let known: Vec<String> =
            known.map(|material| format!("{} ({})", material.id, material.name)).collect();
        let more = materials.len().saturating_sub(LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let known = known.join(", ");
        Error::Option(format!("--labels: there is no material {word:?}, but {known}{more}"))
    })
}

/// All files whose names are known before anything is read.
fn reserve(arguments: &ReconstructArguments, targets: &[Target]) -> Result<Outputs> {
    let known = arguments.output.iter().zip(targets).filter(|(_, target)| !target.is_pattern());
    let known = known.map(|(path, _)| path);
    let json = arguments.report.iter().chain(&arguments.exact);
    Outputs::reserve(known.chain(json).map(|path| path.as_path()))
}

/// What there is to write.
struct Results<'a> {
    sections: &'a Sections,
    derived: &'a Derived,
    /// The network as it goes to files: without caps where the box is open.
    surfaces: &'a Mesh,
    grids: &'a [GridName],
    picture: PictureOptions,
}

fn write(outputs: &mut Outputs, target: &Target, results: &Results) -> Result<()> {
    let Results { sections, surfaces, .. } = results;
    for (path, label) in target.files(&sections.materials)? {
        match (target.kind, label) {
            (Kind::Mesh(kind), None) => {
                write_surface(outputs, &path, kind, surfaces, &About::from(*sections))?;
            }
            (Kind::Mesh(kind), Some(label)) => {
                let part = surfaces.surface(label).into_mesh(label);
                let own: Vec<Material> = sections.material(label).cloned().into_iter().collect();
                let about = About { materials: &own, ..About::from(*sections) };
                write_surface(outputs, &path, kind, &part, &about)?;
            }
            (Kind::Vdb, _) => write_volumes(outputs, &path, results)?,
            (Kind::Picture, _) => write_picture(outputs, &path, results)?,
        }
    }
    Ok(())
}

fn write_surface(
    outputs: &mut Outputs,
    path: &Path,
    kind: MeshKind,
    mesh: &Mesh,
    about: &About,
) -> Result<()> {
    outputs.write(path, |out| {
        write_mesh(kind, mesh, about, out).map_err(|error| write_error(path, &error))
    })
}

fn write_volumes(outputs: &mut Outputs, path: &Path, results: &Results) -> Result<()> {
    let Derived { samples, mesh, .. } = results.derived;
    let Sections { sections, materials, units, frame, .. } = results.sections;
    let (lattice, grids) = (&samples.lattice, results.grids);
    let contents = VdbContents { lattice, mesh, samples, sections, materials, units, frame, grids };
    outputs.write_at(path, |temporary| vdb::write(temporary, &contents))
}

fn write_picture(outputs: &mut Outputs, path: &Path, results: &Results) -> Result<()> {
    let image = picture::render(results.surfaces, results.sections, &results.picture);
    outputs.write(path, |out| {
        picture::write_png(&image, out).map_err(|error| write_error(path, &error))
    })
}
