//! Pictures of a pelvis of sorts, in stacks as Marker et al. (2006, Table 1) had: seconds from
//! pixels to a surface with voxels as large as pixels, and peak memory.
//!
//! `cargo bench --bench stack`

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use transect::change::Change;
use transect::context::Context;
use transect::error::{Error, Result};
use transect::grid::lattice::Resolution;
use transect::label_image::{ImagePlacement, LabelImage};
use transect::method::{Method, ShapeBased};
use transect::model::{Model, Options};
use transect::section::{Rules, Section, Sections};

/// Pixels of a row, and rows.
const SIDE: usize = 500;
/// Slices, and how far they are apart in pixels: 34 into 458 levels, and 63 levels to one slice.
const STACKS: [(u32, f64); 2] = [(34, 458.0 / 34.0), (4, 63.0)];
/// How high the bones are, in pixels.
const HEIGHT: f64 = 458.0;

fn main() -> Result<()> {
    println!(
        "{:<8}{:>10}{:>10}{:>10}{:>10}{:>10}{:>12}{:>8}{:>12}",
        "slices",
        "curves s",
        "field s",
        "mesh s",
        "all s",
        "MiB",
        "components",
        "genus",
        "triangles"
    );
    for (count, spacing) in STACKS {
        stack(count, spacing)?;
    }
    Ok(())
}

fn stack(count: u32, spacing: f64) -> Result<()> {
    let pictures: Vec<LabelImage> = (0..count)
        .into_par_iter()
        .map(|slice| picture(slice, count, spacing))
        .collect::<Result<_>>()?;
    let start = Instant::now();
    let rules = Rules::default();
    let named = pictures.into_par_iter().enumerate();
    let sections: Vec<Section> = named
        .map(|(slice, picture)| Ok(picture.section(&format!("slice {slice}"), &rules)?.0))
        .collect::<Result<_>>()?;
    let curves = start.elapsed().as_secs_f64();
    let options = Options {
        method: Method::Stack(ShapeBased::default()),
        resolution: Resolution::VoxelSize(1.0),
        ..Options::default()
    };
    let mut model = Model::new(options);
    let mut context = Context::new(rules, &transect::progress::Silent);
    model.apply(Change::Add(Sections::new(sections, &rules)?), &mut context)?;
    let all = start.elapsed().as_secs_f64();
    let seconds = |name: &str| {
        let own = context.stages.stages.iter().filter(|stage| stage.name == name);
        own.map(|stage| stage.seconds).sum::<f64>()
    };
    let (field, mesh, memory) = (seconds("field"), seconds("mesh"), context.stages.peak_memory());
    let check = model.check(&mut context)?;
    let facts = || check.labels.iter().map(|label| &label.facts);
    let triangles = model.derived().map_or(0, |derived| derived.mesh.triangles.len());
    println!(
        "{:<8}{curves:>10.2}{field:>10.2}{mesh:>10.2}{all:>10.2}{:>10}{:>12}{:>8}{triangles:>12}",
        count,
        memory >> 20,
        facts().map(|facts| facts.components).sum::<usize>(),
        facts().map(|facts| facts.genus).sum::<i64>(),
    );
    Ok(())
}

/// A slice; those of a low stack are around the middle.
fn picture(slice: u32, count: u32, spacing: f64) -> Result<LabelImage> {
    let height = 0.5 * HEIGHT + (f64::from(slice) - 0.5 * f64::from(count - 1)) * spacing;
    let place = |index: usize| DVec3::new((index % SIDE) as f64, (index / SIDE) as f64, height);
    let labels = (0..SIDE * SIDE).map(|index| u32::from(is_bone(place(index)))).collect();
    let placement = ImagePlacement { origin: DVec3::Z * height, steps: [DVec3::X, DVec3::Y] };
    LabelImage::new([SIDE; 2], labels, placement).map_err(Error::Option)
}

/// Two wings, a sacrum between them, two joints with their thighbones, and an arch in front.
fn is_bone(at: DVec3) -> bool {
    let relative = |center: DVec3, radii: DVec3| ((at - center) / radii).length();
    let sacrum = relative(DVec3::new(250.0, 330.0, 330.0), DVec3::new(60.0, 40.0, 120.0)) < 1.0;
    let ring = DVec3::new(at.x - 250.0, at.y - 200.0, at.z - 140.0);
    let around = ring.x.hypot(ring.z) - 90.0;
    let arch = around.hypot(ring.y) < 18.0 && ring.z < 20.0;
    let half = |side: f64| {
        let wing = relative(
            DVec3::new(250.0 + side * 110.0, 250.0, 300.0),
            DVec3::new(60.0, 120.0, 150.0),
        );
        let outer = side * (at.x - 250.0) > 100.0 && at.z > 200.0;
        let joint = DVec3::new(250.0 + side * 150.0, 250.0, 150.0);
        let from = at.distance(joint);
        let cup = (53.0..64.0).contains(&from) && at.z > 140.0;
        let shaft = DVec3::new(250.0 + side * (170.0 + 0.1 * (100.0 - at.z)), 250.0, at.z);
        (outer && (wing - 1.0).abs() < 0.09)
            || cup
            || from < 45.0
            || (at.z < 150.0 && at.distance(shaft) < 28.0)
    };
    sacrum || arch || half(1.0) || half(-1.0)
}
