//! `transect compare-methods`: every method on the same sections.

use super::args::{CompareMethodsArguments, MethodName};
use super::bars::Watcher;
use super::{print, print_warnings, table, write_json};
use crate::compare::methods::{Common, Entry};
use crate::error::{Error, Result};
use crate::io::mesh::read_mesh;
use crate::mesh::Mesh;
use crate::method::{Hermite, MeanValue, Method, ShapeBased, Skeleton, Variational};
use crate::model::Options;
use crate::output::{Outputs, write_error};
use crate::picture::{self, PictureOptions};
use crate::section::Sections;

/// The size of each method's picture, in pixels.
const SIZE: [u32; 2] = [800, 600];

/// Tries each method, prints and writes.
pub fn run(arguments: &CompareMethodsArguments) -> Result<()> {
    let known = arguments.output.iter().chain(&arguments.report);
    if let Some(path) = arguments.output.as_ref().filter(|path| !is_png(path)) {
        return Err(Error::file(path, "what is written is one picture of all methods: .png"));
    }
    if arguments.methods.contains(&MethodName::Auto) {
        let what = "--methods tries methods by their names, and auto is one of them: leave it out";
        return Err(Error::Option(what.to_owned()));
    }
    let mut outputs = Outputs::reserve(known.map(|path| path.as_path()))?;
    let watcher = Watcher::new(arguments.quiet);
    let sections = arguments.input.read()?;
    if !arguments.quiet {
        print_warnings(&sections);
    }
    let reference = arguments.reference.as_deref().map(read_mesh).transpose()?;
    let (resolution, margin) = (arguments.grid.resolution(), arguments.grid.margin);
    let options = Options { resolution, margin, ..Options::default() };
    let common = Common { sections: &sections, options, reference: reference.as_ref() };
    let mut found: Vec<(Entry, Option<Mesh>)> = Vec::new();
    for &name in &arguments.methods {
        found.push(common.tried(name.name(), method(name), watcher.progress())?);
    }
    if found.iter().all(|(entry, _)| entry.figures.is_none()) {
        let whys = found.iter().filter_map(|(entry, _)| {
            Some(format!("{}: {}", entry.method, entry.refused.as_ref()?))
        });
        let whys: Vec<String> = whys.collect();
        return Err(Error::Option(format!("no method applies; {}", whys.join("; "))));
    }
    if let Some(path) = &arguments.output {
        watcher.progress().begin("picture", 0);
        let image = drawn(&found, reference.as_ref(), &sections);
        outputs.write(path, |out| {
            picture::write_png(&image, out).map_err(|error| write_error(path, &error))
        })?;
    }
    let entries: Vec<Entry> = found.into_iter().map(|(entry, _)| entry).collect();
    if let Some(path) = &arguments.report {
        outputs.write(path, |out| write_json(path, &entries, out))?;
    }
    watcher.finish();
    outputs.commit()?;
    print(arguments.json, &entries, |entries| table::methods(entries))
}

fn is_png(path: &std::path::Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"))
}

/// A method with its own default options.
fn method(name: MethodName) -> Method {
    match name {
        MethodName::Auto | MethodName::Variational => Method::Variational(Variational::default()),
        MethodName::Mvc => Method::MeanValue(MeanValue::default()),
        MethodName::Hermite => Method::Hermite(Hermite::default()),
        MethodName::Skeleton => Method::Skeleton(Skeleton::default()),
        MethodName::Stack => Method::Stack(ShapeBased::default()),
    }
}

/// All results from one direction, side by side, the reference first.
fn drawn(
    found: &[(Entry, Option<Mesh>)],
    reference: Option<&Mesh>,
    sections: &Sections,
) -> image::RgbaImage {
    let entries = found.iter().filter_map(|(entry, mesh)| Some((title(entry), mesh.as_ref()?)));
    let all: Vec<(String, &Mesh)> =
        reference.map(|mesh| ("reference".to_owned(), mesh)).into_iter().chain(entries).collect();
    let options = PictureOptions { size: SIZE, ..PictureOptions::default() };
    let first = found.iter().find_map(|(_, mesh)| mesh.as_ref());
    let view = first.map(|mesh| picture::viewpoint(mesh, sections, &options));
    let options = PictureOptions { view, ..options };
    let pictures: Vec<(String, image::RgbaImage)> = all
        .into_iter()
        .map(|(title, mesh)| (title, picture::render(mesh, sections, &options)))
        .collect();
    picture::side_by_side(&pictures)
}

fn title(entry: &Entry) -> String {
    let against = entry.figures.as_ref().and_then(|figures| figures.reference.as_ref());
    match against {
        Some(against) => format!("{}  IoU {:.3}", entry.method, against.iou),
        None => entry.method.clone(),
    }
}
