//! `transect slice`: a mesh or a volume of labels cut by planes into sections.

use super::args::{AxisName, SliceArguments};
use super::bars::Watcher;
use super::convert::{self, Writer};
use super::print_warnings;
use crate::error::{Error, Result};
use crate::io::mesh::MeshKind;
use crate::io::mesh::{MESH_KINDS, read_mesh};
use crate::io::volume::{VOLUME_KINDS, is_volume, read_volume};
use crate::output::Outputs;
use crate::plane::{Bounds, Plane};
use crate::section::{Rules, Section, Sections};
use crate::slice::{Family, slice_volume, slice_with_warnings};
use crate::sweep::{Sweep, framed};

/// Cuts and writes.
pub fn run(arguments: &SliceArguments) -> Result<()> {
    let write = writer(arguments)?;
    let mut outputs = Outputs::reserve([arguments.output.as_path()])?;
    let watcher = Watcher::new(arguments.quiet);
    watcher.progress().begin("slice", 0);
    let sections = cut(arguments).map_err(|error| match error {
        Error::Option(what) => Error::file(&arguments.solid, what),
        Error::Mesh(what) => Error::file(&arguments.solid, format!("the mesh {what}")),
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
        Some(_) => cut_mesh(arguments),
        None if is_volume(path) => cut_volume(arguments),
        None => Err(Error::file(
            path,
            format!(
                "this kind of file is not known: {MESH_KINDS} are meshes, {VOLUME_KINDS} volumes \
                 of labels"
            ),
        )),
    }
}

fn cut_mesh(arguments: &SliceArguments) -> Result<Sections> {
    let mesh = read_mesh(&arguments.solid)?;
    let bounds = mesh.bounds().ok_or_else(|| Error::Option("it has no vertex".to_owned()))?;
    let mut warnings = Vec::new();
    let sections = cut_by(arguments, &bounds, |planes| {
        let (sections, found) = slice_with_warnings(&mesh, planes)?;
        warnings = found;
        Ok(sections)
    })?;
    let mut sections = Sections::new(sections, &Rules::default())?;
    sections.warnings.append(&mut warnings);
    Ok(sections)
}

fn cut_volume(arguments: &SliceArguments) -> Result<Sections> {
    let volume = read_volume(&arguments.solid)?;
    let cut = |planes: &[Plane]| slice_volume(&volume, planes);
    let sections = match volume.bounds() {
        Some(bounds) => cut_by(arguments, &bounds, cut)?,
        None => cut(&[])?,
    };
    let mut sections = Sections::new(sections, &Rules::default())?;
    sections.name_materials(volume.materials);
    (sections.units, sections.frame) = (volume.units, volume.frame);
    Ok(sections)
}

/// The sections by the planes, or within the frames, that arguments ask for.
fn cut_by(
    arguments: &SliceArguments,
    bounds: &Bounds,
    mut cut: impl FnMut(&[Plane]) -> Result<Vec<Section>>,
) -> Result<Vec<Section>> {
    match arguments.sweep {
        None => cut(&family(arguments).planes(bounds)?),
        Some(count) => {
            let axis = arguments.axis.map_or(2, AxisName::number);
            let SliceArguments { tilt, extent: size, seed, .. } = *arguments;
            let frames = Sweep { axis, count, tilt, size, seed }.frames(bounds)?;
            let planes: Vec<Plane> = frames.iter().map(|frame| frame.plane).collect();
            framed(cut(&planes)?, &frames)
        }
    }
}

fn writer(arguments: &SliceArguments) -> Result<Writer> {
    let path = &arguments.output;
    let is_csl = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("csl"));
    if is_csl && arguments.sweep.is_some() {
        let what = "beyond frames all is unknown, and only .json has a word for it: name such a \
                    file";
        return Err(Error::file(path, what));
    }
    convert::writer(path)
}

fn family(arguments: &SliceArguments) -> Family {
    match (arguments.axis, arguments.count, arguments.random) {
        (Some(axis), Some(count), _) => Family::Axis { axis: axis.number(), count },
        (_, _, Some(count)) => Family::Random { count, seed: arguments.seed },
        _ => Family::Given(arguments.plane.iter().map(|&[a, b, c, d]| plane(a, b, c, d)).collect()),
    }
}

impl AxisName {
    fn number(self) -> usize {
        match self {
            Self::X => 0,
            Self::Y => 1,
            Self::Z => 2,
        }
    }
}

/// The plane a x + b y + c z + d = 0.
fn plane(a: f64, b: f64, c: f64, d: f64) -> Plane {
    Plane { normal: glam::DVec3::new(a, b, c), offset: -d }
}
