//! `transect slice`: a mesh or a volume of labels cut by planes into sections.

use std::path::Path;

use super::args::{AxisName, SliceArguments};
use super::bars::Watcher;
use super::print_warnings;
use crate::error::{Error, Result};
use crate::io::mesh::{MESH_KINDS, read_mesh};
use crate::io::volume::{VOLUME_KINDS, is_volume, read_volume};
use crate::io::{self, mesh::MeshKind};
use crate::output::Outputs;
use crate::plane::Plane;
use crate::section::{Rules, Sections};
use crate::slice::{Family, slice, slice_volume};

/// Cuts and writes.
pub fn run(arguments: &SliceArguments) -> Result<()> {
    let write = writer(arguments)?;
    let mut outputs = Outputs::reserve([arguments.output.as_path()])?;
    let watcher = Watcher::new(arguments.quiet);
    watcher.progress().begin("slice", 0);
    let sections = cut(arguments).map_err(|error| match error {
        Error::Option(what) => Error::file(&arguments.solid, what),
        other => other,
    })?;
    outputs.write(&arguments.output, |out| write(&sections, out))?;
    watcher.finish();
    outputs.commit()?;
    if !arguments.quiet {
        print_warnings(&sections);
    }
    Ok(())
}

fn cut(arguments: &SliceArguments) -> Result<Sections> {
    let path = &arguments.solid;
    match MeshKind::of(path) {
        Some(_) => cut_mesh(path, &family(arguments)),
        None if is_volume(path) => cut_volume(path, &family(arguments)),
        None => Err(Error::file(
            path,
            format!(
                "this kind of file is not known: {MESH_KINDS} are meshes, {VOLUME_KINDS} volumes \
                 of labels"
            ),
        )),
    }
}

fn cut_mesh(path: &Path, family: &Family) -> Result<Sections> {
    let mesh = read_mesh(path)?;
    let bounds = mesh.bounds().ok_or_else(|| Error::Option("it has no vertex".to_owned()))?;
    let planes = family.planes(&bounds)?;
    Sections::new(slice(&mesh, &planes)?, &Rules::default())
}

fn cut_volume(path: &Path, family: &Family) -> Result<Sections> {
    let volume = read_volume(path)?;
    let planes = match volume.bounds() {
        Some(bounds) => family.planes(&bounds)?,
        None => Vec::new(),
    };
    let mut sections = Sections::new(slice_volume(&volume, &planes)?, &Rules::default())?;
    sections.name_materials(volume.materials);
    (sections.units, sections.frame) = (volume.units, volume.frame);
    Ok(sections)
}

type Writer = fn(&Sections, &mut dyn std::io::Write) -> Result<()>;

fn writer(arguments: &SliceArguments) -> Result<Writer> {
    let path = &arguments.output;
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match ending.as_str() {
        "csl" => Ok(io::csl::write),
        "json" => Ok(io::json::write),
        _ => Err(Error::file(path, "sections are written to .csl and .json; name such a file")),
    }
}

fn family(arguments: &SliceArguments) -> Family {
    let axis = arguments.axis.map(|axis| match axis {
        AxisName::X => 0,
        AxisName::Y => 1,
        AxisName::Z => 2,
    });
    match (axis, arguments.count, arguments.random) {
        (Some(axis), Some(count), _) => Family::Axis { axis, count },
        (_, _, Some(count)) => Family::Random { count, seed: arguments.seed },
        _ => Family::Given(arguments.plane.iter().map(|&[a, b, c, d]| plane(a, b, c, d)).collect()),
    }
}

/// The plane a x + b y + c z + d = 0.
fn plane(a: f64, b: f64, c: f64, d: f64) -> Plane {
    Plane { normal: glam::DVec3::new(a, b, c), offset: -d }
}
