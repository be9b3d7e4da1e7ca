//! `transect reconstruct`: sections in, volumes, surfaces, pictures and a
//! report out.

use std::io::Write;
use std::path::{Path, PathBuf};

use super::args::ReconstructArguments;
use super::bars::Watcher;
use super::{print_warnings, table};
use crate::change::Change;
use crate::check::{self, check};
use crate::error::{Error, Result};
use crate::grid::lattice::Resolution;
use crate::io::mesh::{About, MeshKind, write_mesh};
use crate::io::vdb::{self, GridName, VdbContents};
use crate::io::{self};
use crate::model::{Derived, Mesher, Model, Options};
use crate::output::{Outputs, write_error};
use crate::picture::{self, PictureOptions};
use crate::report::Report;
use crate::section::Sections;
use crate::stage::Stages;

/// Reconstructs and writes.
pub fn run(arguments: &ReconstructArguments) -> Result<()> {
    let kinds = arguments.output.iter().map(|path| Kind::of(path)).collect::<Result<Vec<_>>>()?;
    let grids =
        arguments.grids.iter().map(|name| name.trim().parse()).collect::<Result<Vec<_>>>()?;
    let paths = arguments.output.iter().chain(&arguments.report).map(PathBuf::as_path);
    let options = options(arguments)?;
    let mut outputs = Outputs::reserve(paths)?;
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
    let mut model = Model::new(options);
    model.apply(Change::Add(sections), &rules, &mut stages, watcher.progress())?;
    let derived = model
        .derived()
        .ok_or_else(|| Error::Bug { stage: "model", what: "nothing was derived".to_owned() })?;
    let checked = stages.run("check", |_| {
        // Cheap for the delaunay mesher's fewer triangles, and promised.
        let self_intersections = matches!(model.options().mesher, Mesher::Delaunay(_));
        let options = check::Options { self_intersections };
        let (mesh, lattice) = (&derived.mesh, &derived.samples.lattice);
        check(&model.sections().sections, mesh, lattice, options, watcher.progress())
    })?;

    if !checked.is_sound() {
        return Err(Error::Bug { stage: "check", what: "a surface is not closed".to_owned() });
    }
    for (path, kind) in arguments.output.iter().zip(kinds) {
        stages.run(kind.stage(), |_| {
            watcher.progress().begin(kind.stage(), 0);
            write(&mut outputs, path, kind, model.sections(), derived, &grids)
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

fn options(arguments: &ReconstructArguments) -> Result<Options> {
    let resolution = match (arguments.voxel_size, arguments.resolution) {
        (Some(size), _) => Resolution::VoxelSize(size),
        (None, Some(voxels)) => Resolution::Voxels(voxels),
        (None, None) => Options::default().resolution,
    };
    Ok(Options {
        resolution,
        smooth: arguments.smooth,
        device: arguments.device.into(),
        mesher: arguments.meshing.mesher()?,
    })
}

/// The kinds of files that a reconstruction is written to.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Vdb,
    Mesh(MeshKind),
    Picture,
}

impl Kind {
    fn of(path: &Path) -> Result<Self> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match (ending.as_str(), MeshKind::of(path)) {
            ("vdb", _) => Ok(Self::Vdb),
            ("png", _) => Ok(Self::Picture),
            (_, Some(kind)) => Ok(Self::Mesh(kind)),
            _ => Err(Error::file(
                path,
                "this kind of file is not known: the name of an output ends in .vdb, .ply, .obj, \
                 .stl, .off or .png",
            )),
        }
    }

    fn stage(self) -> &'static str {
        match self {
            Self::Vdb => "volumes",
            Self::Mesh(_) => "surfaces",
            Self::Picture => "picture",
        }
    }
}

fn write(
    outputs: &mut Outputs,
    path: &Path,
    kind: Kind,
    sections: &Sections,
    derived: &Derived,
    grids: &[GridName],
) -> Result<()> {
    let Derived { samples, mesh, .. } = derived;
    let Sections { materials, units, frame, .. } = sections;
    match kind {
        Kind::Vdb => {
            let lattice = &samples.lattice;
            let contents = VdbContents { lattice, mesh, samples, materials, units, frame, grids };
            outputs.write_at(path, |temporary| vdb::write(temporary, &contents))
        }
        Kind::Mesh(kind) => outputs.write(path, |out| {
            write_mesh(kind, mesh, &About::from(sections), out)
                .map_err(|error| write_error(path, &error))
        }),
        Kind::Picture => {
            let options = PictureOptions::default();
            let image = picture::render(mesh, &sections.sections, materials, &options);
            outputs.write(path, |out| {
                picture::write_png(&image, out).map_err(|error| write_error(path, &error))
            })
        }
    }
}

fn write_json(path: &Path, report: &Report, out: &mut dyn Write) -> Result<()> {
    serde_json::to_writer_pretty(&mut *out, report)
        .map_err(std::io::Error::from)
        .and_then(|()| out.write_all(b"\n"))
        .map_err(|error| write_error(path, &error))
}
