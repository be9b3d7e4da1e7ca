//! `transect reconstruct`: sections in, volumes, surfaces, pictures and a
//! report out.

use std::io::Write;
use std::path::Path;

use super::args::ReconstructArguments;
use super::bars::Watcher;
use super::targets::{Kind, Target};
use super::{print_warnings, table};
use crate::change::Change;
use crate::check::{self, check};
use crate::error::{Error, Result};
use crate::grid::lattice::Resolution;
use crate::io::mesh::{About, MeshKind, write_mesh};
use crate::io::vdb::{self, GridName, VdbContents};
use crate::io::{self};
use crate::label::Material;
use crate::mesh::Mesh;
use crate::model::{Derived, Model, Options};
use crate::output::{Outputs, write_error};
use crate::picture::{self, PictureOptions};
use crate::report::Report;
use crate::section::Sections;
use crate::stage::Stages;

/// Reconstructs and writes.
pub fn run(arguments: &ReconstructArguments) -> Result<()> {
    let targets =
        arguments.output.iter().map(|path| Target::new(path)).collect::<Result<Vec<_>>>()?;
    let grids =
        arguments.grids.iter().map(|name| name.trim().parse()).collect::<Result<Vec<_>>>()?;
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
    let mut model = Model::new(options(arguments));
    model.apply(Change::Add(sections), &rules, &mut stages, watcher.progress())?;
    let derived = model
        .derived()
        .ok_or_else(|| Error::Bug { stage: "model", what: "nothing was derived".to_owned() })?;
    let checked = stages.run("check", |_| {
        let options = check::Options { self_intersections: false };
        let (mesh, lattice) = (&derived.mesh, &derived.samples.lattice);
        check(&model.sections().sections, mesh, lattice, options, watcher.progress())
    })?;

    if !checked.is_sound() {
        return Err(Error::Bug { stage: "check", what: "a surface is not closed".to_owned() });
    }
    for target in &targets {
        let stage = target.kind.stage();
        stages.run(stage, |_| {
            watcher.progress().begin(stage, 0);
            write(&mut outputs, target, model.sections(), derived, &grids)
        })?;
    }
    let report = Report::new(&model, derived, checked, &stages);
    if let Some(path) = &arguments.report {
        outputs.write(path, |out| write_json(path, &report, out))?;
    }
    watcher.finish();
    outputs.commit()?;
    if !arguments.quiet {
        table::print(&report);
    }
    Ok(())
}

fn options(arguments: &ReconstructArguments) -> Options {
    let resolution = match (arguments.voxel_size, arguments.resolution) {
        (Some(size), _) => Resolution::VoxelSize(size),
        (None, Some(voxels)) => Resolution::Voxels(voxels),
        (None, None) => Options::default().resolution,
    };
    Options {
        resolution,
        smooth: arguments.smooth,
        device: arguments.device.into(),
        spacing: arguments.spacing,
    }
}

/// All files whose names are known before anything is read.
fn reserve(arguments: &ReconstructArguments, targets: &[Target]) -> Result<Outputs> {
    let known = arguments.output.iter().zip(targets).filter(|(_, target)| !target.is_pattern());
    let known = known.map(|(path, _)| path);
    Outputs::reserve(known.chain(&arguments.report).map(|path| path.as_path()))
}

fn write(
    outputs: &mut Outputs,
    target: &Target,
    sections: &Sections,
    derived: &Derived,
    grids: &[GridName],
) -> Result<()> {
    for (path, label) in target.files(&sections.materials)? {
        match (target.kind, label) {
            (Kind::Mesh(kind), None) => {
                write_surface(outputs, &path, kind, &derived.mesh, &About::from(sections))?;
            }
            (Kind::Mesh(kind), Some(label)) => {
                let part = derived.mesh.surface(label).into_mesh(label);
                let own: Vec<Material> = sections.material(label).cloned().into_iter().collect();
                let about = About { materials: &own, ..About::from(sections) };
                write_surface(outputs, &path, kind, &part, &about)?;
            }
            (Kind::Vdb, _) => write_volumes(outputs, &path, sections, derived, grids)?,
            (Kind::Picture, _) => write_picture(outputs, &path, sections, &derived.mesh)?,
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

fn write_volumes(
    outputs: &mut Outputs,
    path: &Path,
    sections: &Sections,
    derived: &Derived,
    grids: &[GridName],
) -> Result<()> {
    let Derived { samples, mesh, .. } = derived;
    let Sections { materials, units, frame, .. } = sections;
    let lattice = &samples.lattice;
    let contents = VdbContents { lattice, mesh, samples, materials, units, frame, grids };
    outputs.write_at(path, |temporary| vdb::write(temporary, &contents))
}

fn write_picture(
    outputs: &mut Outputs,
    path: &Path,
    sections: &Sections,
    mesh: &Mesh,
) -> Result<()> {
    let options = PictureOptions::default();
    let image = picture::render(mesh, &sections.sections, &sections.materials, &options);
    outputs.write(path, |out| {
        picture::write_png(&image, out).map_err(|error| write_error(path, &error))
    })
}

fn write_json(path: &Path, report: &Report, out: &mut dyn Write) -> Result<()> {
    serde_json::to_writer_pretty(&mut *out, report)
        .map_err(std::io::Error::from)
        .and_then(|()| out.write_all(b"\n"))
        .map_err(|error| write_error(path, &error))
}
