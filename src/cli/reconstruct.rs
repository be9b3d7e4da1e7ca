//! `transect reconstruct`: sections in, volumes, surfaces, pictures and a
//! report out.

use std::path::{Path, PathBuf};

use super::args::{ReconstructArguments, VolumeArguments, VoxelsName};
use super::bars::Watcher;
use super::method::{asked, chosen};
use super::results::{Results, picture_options, require_picture, write_pages};
use super::targets::{Kind, Target, report_targets};
use super::{print_found, print_warnings, table, tell_shortened, write_json};
use crate::choice::choose;
use crate::context::Context;
use crate::error::{Error, Remedy, Result};
use crate::io::dicom::{Template, is_dicom};
use crate::io::exact::write_exact;
use crate::io::read_layers;
use crate::io::structures::Chosen;
use crate::io::vdb::{GridName, require_grids};
use crate::io::volume::is_volume;
use crate::io::volume::like::read_voxels;
use crate::io::volume::write::{Voxels, in_frame};
use crate::layers::{self, Layer};
use crate::memory;
use crate::model::Options;
use crate::output::{Outputs, write_error};
use crate::plane::Plane;
use crate::section::Sections;
use crate::skeleton::Details;

/// Reconstructs and writes.
pub fn run(arguments: &ReconstructArguments) -> Result<()> {
    let mut targets = Target::all(&arguments.output, &arguments.volumes)?;
    let (report_path, page) = report_targets(arguments.report.as_deref())?;
    targets.extend(page);
    let grids = GridName::parse_all(&arguments.volumes.grids)?;
    let grid = arguments.method.grid;
    let (resolution, margin) = (grid.resolution(), grid.margin);
    let asked = asked(&arguments.method, arguments.exact.is_some())?;
    let decimation = arguments.decimate;
    require_rounded(arguments)?;
    require_picture(&arguments.picture, &targets)?;
    require_volumes(&arguments.volumes, &targets)?;
    let like = like(arguments, &targets)?;
    let template = template(arguments, &targets)?;
    let mut outputs = reserve(arguments, report_path, &targets)?;

    let watcher = Watcher::new(arguments.quiet);
    let mut context = Context::new(arguments.input.reading.rules(), watcher.progress());
    let layers = context.stages.run("read", |counts| {
        let layers = arguments.input.read_layers()?;
        let sections = layers.iter().flat_map(|layer| &layer.sections);
        let vertices: usize = sections.map(|one| one.vertices().len()).sum();
        counts.insert("vertices".into(), vertices as u64);
        Ok(layers)
    })?;
    let all = Sections::side_by_side(&layers);
    if !arguments.quiet {
        print_warnings(&all);
    }
    for target in &targets {
        target.reserve_named(&mut outputs, &all.materials)?;
        match target.doubt(&all.materials) {
            Some(doubt) if arguments.input.reading.strict => {
                return Err(Error::Option(doubt).avoidable(Remedy::NotStrict));
            }
            Some(doubt) if !arguments.quiet => tell_shortened(&format!("warning: {doubt}")),
            _ => (),
        }
    }
    if targets.iter().any(|target| target.kind.has_grids()) {
        require_grids(&grids, &all.materials)?;
    }
    targets.iter().try_for_each(|target| target.require_layers(layers.len()))?;
    if let Some(like) = &like {
        layers::require_like(like, &all.units, &all.frame)?;
    }
    let planes = planes_like(arguments, &all.frame)?;
    let picture = picture_options(&arguments.picture, &all.materials)?;
    let mut made: Vec<Layer> = Vec::with_capacity(layers.len());
    for sections in layers {
        let (method, choice) = match asked.clone() {
            Some(asked) => asked,
            None => chosen(&arguments.method, false, choose(&sections, resolution)?)?,
        };
        if let Some(choice) = choice.as_ref().filter(|_| !arguments.quiet) {
            let reasons = choice.reasons.join(" and ");
            tell_shortened(&format!("method: {}, because {reasons}", choice.method.name()));
        }
        let options = Options { method, resolution, bounds: None, margin, decimation };
        let layer = Layer::new(sections, options, choice, &mut context)?;
        let materials = &layer.model.sections().materials;
        if let Some(gone) = layer.check.vanished(materials).into_iter().next()
            && arguments.input.reading.strict
        {
            return Err(Error::Option(gone.what).avoidable(Remedy::NotStrict));
        }
        made.push(layer);
    }
    let results = Results::new(made.iter().map(|layer| &layer.model), &grids, picture)?;
    let results = results.stored(&arguments.volumes).like(like).contoured(planes, template);
    let Context { mut stages, progress, .. } = context;
    let is_page = targets.iter().any(|target| target.kind == Kind::Page);
    let checks = made.iter().map(|layer| &layer.check);
    let page =
        is_page.then(|| stages.run("page", |_| results.page(checks, progress))).transpose()?;
    for target in targets.iter().filter(|target| target.kind != Kind::Page) {
        let stage = target.kind.stage();
        stages.run(stage, |_| {
            progress.begin(stage, 0);
            results.write(&mut outputs, target)
        })?;
    }
    if let Some(path) = &arguments.exact {
        stages.run("exact", |_| write_exact_of(&made, &mut outputs, path))?;
    }
    drop(results);
    let report = layers::report(made, &stages)?;
    if let Some(page) = &page {
        write_pages(&mut outputs, &targets, page, &report)?;
    }
    if let Some(path) = report_path {
        outputs.write(path, |out| write_json(path, &report, out))?;
    }
    watcher.finish();
    outputs.commit()?;
    if !arguments.quiet {
        print_found(&report);
        table::print(&report);
    }
    Ok(())
}

/// Writes the exact surface, of one layer alone.
fn write_exact_of(layers: &[Layer], outputs: &mut Outputs, path: &Path) -> Result<()> {
    let [Layer { model, .. }] = layers else {
        let what = "--exact writes one surface, and here are several structures: choose one with \
                    --structures NAME, or let them exclude each other with --partition";
        return Err(Error::Option(what.to_owned()));
    };
    let Some((derived, details)) =
        model.derived().and_then(|derived| Some((derived, derived.exact.as_ref()?)))
    else {
        return Ok(());
    };
    require_exact(details)?;
    outputs.write(path, |out| {
        write_exact(&derived.mesh, details, out).map_err(|error| write_error(path, &error))
    })
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

/// Vertices that move have no exact coordinates.
fn require_rounded(arguments: &ReconstructArguments) -> Result<()> {
    if arguments.decimate.is_some() && arguments.exact.is_some() {
        let what =
            "--decimate moves vertices away from their exact places: leave it or --exact out";
        return Err(Error::Option(what.to_owned()));
    }
    Ok(())
}

/// Where the voxels of volumes of labels are, if an image says it.
fn like(arguments: &ReconstructArguments, targets: &[Target]) -> Result<Option<Voxels>> {
    let Some(path) = &arguments.like else { return Ok(None) };
    if !targets.iter().any(|target| matches!(target.kind, Kind::Volume(_))) {
        let what = "--like is about volumes of labels: add -o FILE.seg.nrrd or another one";
        return Err(Error::Option(what.to_owned()));
    }
    read_voxels(path).map(Some)
}

/// What structure sets take over: of the file whose planes they are on, else of the sections'.
fn template(arguments: &ReconstructArguments, targets: &[Target]) -> Result<Option<Template>> {
    let like = arguments.planes_like.as_deref();
    if !targets.iter().any(|target| target.kind == Kind::Structures) {
        let what = "--planes-like is about structure sets: add -o FILE.dcm";
        return match like {
            Some(_) => Err(Error::Option(what.to_owned())),
            None => Ok(None),
        };
    }
    let mut files = like.into_iter().chain(arguments.input.sections.iter().map(PathBuf::as_path));
    files.find(|file| is_dicom(file)).map(Template::read).transpose()
}

/// The planes of a file of sections, or the slices of an image, for sections in this frame.
fn planes_like(arguments: &ReconstructArguments, frame: &str) -> Result<Option<Vec<Plane>>> {
    let Some(file) = &arguments.planes_like else { return Ok(None) };
    if is_volume(file) {
        let Voxels { dims: [_, _, count], placement, frame: own, .. } = read_voxels(file)?;
        let needed = (count as u64).saturating_mul(size_of::<Plane>() as u64);
        memory::require(needed, || format!("{}: {count} slices", file.display()))?;
        let placement = in_frame(placement, &own, frame);
        let steps = placement.steps;
        let normal = steps.x_axis.cross(steps.y_axis).normalize();
        let slices = (0..count).map(|slice| placement.origin + slice as f64 * steps.z_axis);
        return Ok(Some(slices.map(|at| Plane { normal, offset: normal.dot(at) }).collect()));
    }
    let rules = arguments.input.reading.rules();
    let layers = read_layers(std::slice::from_ref(file), &Chosen::default(), &rules)?;
    let mut planes: Vec<Plane> = Vec::new();
    for section in layers.iter().flat_map(|layer| &layer.sections) {
        if !planes.contains(section.plane()) {
            planes.push(*section.plane());
        }
    }
    Ok(Some(planes))
}

/// Options of volumes without any are a mistake.
fn require_volumes(arguments: &VolumeArguments, targets: &[Target]) -> Result<()> {
    let mut kinds = targets.iter().map(|target| target.kind);
    let what = if arguments.half && !kinds.clone().any(|kind| matches!(kind, Kind::Vdb | Kind::Usd))
    {
        "--half is about .vdb files: add -o FILE.vdb"
    } else if arguments.voxels != VoxelsName::default()
        && !kinds.any(|kind| matches!(kind, Kind::Volume(_)))
    {
        "--voxels is about volumes: add -o FILE.nrrd or another one"
    } else {
        return Ok(());
    };
    Err(Error::Option(what.to_owned()))
}

/// All files whose names are known before anything is read.
fn reserve(
    arguments: &ReconstructArguments,
    report: Option<&Path>,
    targets: &[Target],
) -> Result<Outputs> {
    let mut outputs = Outputs::default();
    targets.iter().try_for_each(|target| target.reserve_known(&mut outputs))?;
    let mut json = report.into_iter().chain(arguments.exact.as_deref());
    json.try_for_each(|path| outputs.add(path))?;
    Ok(outputs)
}
