//! `transect slice`: a mesh cut by planes into sections.

use super::args::{AxisName, SliceArguments};
use super::bars::Watcher;
use super::print_warnings;
use crate::error::{Error, Result};
use crate::io::mesh::read_mesh;
use crate::io::{self};
use crate::output::Outputs;
use crate::plane::Plane;
use crate::section::{Rules, Sections};
use crate::slice::{Family, slice};

/// Cuts and writes.
pub fn run(arguments: &SliceArguments) -> Result<()> {
    let write = writer(arguments)?;
    let mut outputs = Outputs::reserve([arguments.output.as_path()])?;
    let watcher = Watcher::new(arguments.quiet);
    watcher.progress().begin("slice", 0);
    let mesh = read_mesh(&arguments.mesh)?;
    let bounds = mesh.bounds().ok_or_else(|| Error::file(&arguments.mesh, "it has no vertex"))?;
    let planes = family(arguments).planes(&bounds)?;
    let cuts = slice(&mesh, &planes).map_err(|error| match error {
        Error::Option(what) => Error::file(&arguments.mesh, what),
        other => other,
    })?;
    let sections = Sections::new(cuts, &Rules::default())?;
    outputs.write(&arguments.output, |out| write(&sections, out))?;
    watcher.finish();
    outputs.commit()?;
    if !arguments.quiet {
        print_warnings(&sections);
    }
    Ok(())
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
