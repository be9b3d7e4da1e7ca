//! Sections that come one by one: after each of them the surface is there. Says what every
//! stage takes, how much is evaluated, solved for or computed, and how many patches of the surface
//! change; last what all sections at once take.
//!
//! `cargo run --release --example living -- [FILE [VOXELS [mvc|variational|skeleton]]]`

use std::path::Path;

use transect::grid::lattice::Resolution;
use transect::io::read_sections;
use transect::{
    Change, Context, Error, MeanValue, Method, Model, Options, Patches, Result, Rules, Sections,
    Skeleton,
};

const STAGES: [&str; 6] = ["arrangement", "completion", "field", "smoothing", "skeleton", "mesh"];
const COUNTS: [&str; 3] = ["evaluations", "unknowns", "cells computed"];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let file = arguments.first().map_or("examples/phantom.json", String::as_str);
    let voxels = arguments.get(1).and_then(|word| word.parse().ok()).unwrap_or(256);
    let method = match arguments.get(2).map(String::as_str) {
        Some("mvc") => Method::MeanValue(MeanValue::default()),
        Some("skeleton") => Method::Skeleton(Skeleton::default()),
        _ => Method::default(),
    };
    let rules = Rules::default();
    let all = read_sections(Path::new(file), &rules)?;
    let bounds = all.space().ok_or_else(|| Error::Option("there is no contour".to_owned()))?;
    // In a box that stays as it is, a section concerns only what is near.
    let options = Options {
        method,
        resolution: Resolution::Voxels(voxels),
        bounds: Some(bounds),
        ..Options::default()
    };
    let (mut model, mut patches) = (Model::new(options), Patches::default());
    print!("{:<24}", "seconds");
    STAGES.iter().for_each(|stage| print!("{stage:>12}"));
    COUNTS.iter().for_each(|what| print!("{what:>16}"));
    println!("{:>12}{:>12}", "changed", "patches");
    for section in &all.sections {
        let one = Sections { sections: vec![section.clone()], ..all.clone() };
        add(&mut model, section.name(), one, &mut patches);
    }
    add(&mut Model::new(options), "all at once", all, &mut Patches::default());
    Ok(())
}

/// Adds sections and says what that took.
fn add(model: &mut Model, name: &str, sections: Sections, patches: &mut Patches) {
    let mut context = Context::default();
    if let Err(error) = model.apply(Change::Add(sections), &mut context) {
        println!("{name:<24}refused: {error}");
        return;
    }
    let Some(derived) = model.derived() else { return };
    let changes = patches.follow(&derived.mesh, derived.samples.lattice);
    print!("{name:<24}");
    STAGES.iter().for_each(|stage| print!("{:>12.4}", context.stages.seconds_of(stage)));
    COUNTS.iter().for_each(|what| print!("{:>16}", context.stages.count_of(what)));
    println!("{:>12}{:>12}", changes.changed.len(), patches.iter().count());
}
