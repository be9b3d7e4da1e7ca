//! Sections that come one by one: after each of them the surface is there. Says what every
//! stage takes, and how many points were evaluated.
//!
//! `cargo run --release --example living -- FILE [VOXELS]`

use std::path::Path;

use transect::change::Change;
use transect::context::Context;
use transect::error::{Error, Result};
use transect::grid::lattice::Resolution;
use transect::io::read_sections;
use transect::method::{MeanValue, Method};
use transect::model::{Model, Options};
use transect::section::{Rules, Sections};

const STAGES: [&str; 5] = ["arrangement", "completion", "field", "smoothing", "mesh"];

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let file = arguments.first().map_or("examples/phantom.json", String::as_str);
    let voxels = arguments.get(1).and_then(|word| word.parse().ok()).unwrap_or(256);

    let rules = Rules::default();
    let all = read_sections(Path::new(file), &rules)?;
    let bounds = all.space().ok_or_else(|| Error::Option("there is no contour".to_owned()))?;
    // In a box that stays as it is, a section concerns only the cells that it cuts.
    let mut model = Model::new(Options {
        method: Method::MeanValue(MeanValue::default()),
        resolution: Resolution::Voxels(voxels),
        bounds: Some(bounds),
    });
    print!("{:<24}", "seconds");
    STAGES.iter().for_each(|stage| print!("{stage:>12}"));
    println!("{:>12}{:>12}{:>12}", "cells", "touched", "evaluations");
    for section in &all.sections {
        let mut context = Context::default();
        let one = Sections { sections: vec![section.clone()], ..all.clone() };
        if let Err(error) = model.apply(Change::Add(one), &mut context) {
            println!("{:<24}refused: {error}", section.name());
            continue;
        }
        let stages = context.stages;
        print!("{:<24}", section.name());
        STAGES.iter().for_each(|stage| print!("{:>12.4}", stages.seconds_of(stage)));
        let counts = ["cells", "touched", "evaluations"].map(|what| stages.count_of(what));
        counts.iter().for_each(|count| print!("{count:>12}"));
        println!();
    }
    Ok(())
}
