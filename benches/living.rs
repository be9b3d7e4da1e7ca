//! `cargo bench --bench living`: what a section costs that comes last and goes again, beside
//! all of them at once; and a sweep whose frames come one by one. How much of the field is
//! evaluated or solved for, and how many patches of the surface change, say how far a section
//! reaches.

mod common;

use std::path::{Path, PathBuf};

use common::{files, median, name};
use transect::grid::lattice::Resolution;
use transect::io::read_sections;
use transect::{
    Change, Context, MeanValue, Method, Model, Options, Patches, Result, Rules, Sections, Skeleton,
};

const RESOLUTION: Resolution = Resolution::Voxels(256);
/// How often the last section comes and goes: the median counts.
const TIMES: usize = 5;

fn main() -> Result<()> {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    println!("resolution 256, {} threads, seconds", rayon::current_num_threads());
    println!(
        "{:<36}{:>9}{:>9}{:>9}{:>9}{:>11}{:>11}",
        "", "at once", "last", "share", "removed", "of field", "patches"
    );
    let is_wanted = |file: &PathBuf| {
        wanted.is_empty() || wanted.iter().any(|part| name(file).contains(part.as_str()))
    };
    let files: Vec<PathBuf> = files().into_iter().filter(is_wanted).collect();
    for file in &files {
        for (method_name, method) in methods() {
            let Some(last) = Last::measured(file, method)? else { continue };
            last.print(&format!("{} {method_name}", name(file)));
        }
    }
    let sweep = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/sweep.json");
    println!("\nframes one by one: seconds of the first, the median, the longest and the last");
    for (method_name, method) in methods() {
        let seconds = one_by_one(&sweep, method)?;
        let median = median(seconds.clone());
        let longest = seconds.iter().copied().fold(0.0, f64::max);
        let [first, last] =
            [seconds.first(), seconds.last()].map(|own| own.copied().unwrap_or(0.0));
        println!(
            "{:<36}{first:>9.3}{median:>9.3}{longest:>9.3}{last:>9.3}",
            format!("{} frames {method_name}", seconds.len())
        );
    }
    Ok(())
}

fn methods() -> [(&'static str, Method); 4] {
    let mvc = |smooth| Method::MeanValue(MeanValue { smooth, ..MeanValue::default() });
    let smooth = MeanValue::default().smooth;
    [
        ("mvc, not smoothed", mvc(0.0)),
        ("mvc", mvc(smooth)),
        ("variational", Method::default()),
        ("skeleton", Method::Skeleton(Skeleton::default())),
    ]
}

/// What the last section of a file costs.
struct Last {
    at_once: f64,
    added: f64,
    removed: f64,
    /// Of the evaluations, unknowns or cells that all sections need.
    of_field: f64,
    /// Of the patches.
    of_patches: f64,
}

impl Last {
    /// `None` for a file without sections.
    fn measured(file: &Path, method: Method) -> Result<Option<Self>> {
        let all = read_sections(file, &Rules::default())?;
        let (Some(bounds), Some(last)) = (all.space(), all.sections.last().cloned()) else {
            return Ok(None);
        };
        let options = Options { method, resolution: RESOLUTION, bounds: Some(bounds) };
        let mut model = Model::new(options);
        let last = Sections { sections: vec![last], ..all.clone() };
        let mut context = Context::default();
        let ids = model.apply(Change::Add(all), &mut context)?;
        let Some(&(mut id)) = ids.last() else { return Ok(None) };
        let (at_once, effort) = (context.stages.seconds(), effort(&context));
        let (mut added, mut removed, mut patches) = (Vec::new(), Vec::new(), Patches::default());
        let (mut of_field, mut of_patches) = (0.0, 0.0);
        for _ in 0..TIMES {
            let mut context = Context::default();
            model.apply(Change::Remove(id), &mut context)?;
            removed.push(context.stages.seconds());
            follow(&model, &mut patches);
            let mut context = Context::default();
            id = model.apply(Change::Add(last.clone()), &mut context)?[0];
            added.push(context.stages.seconds());
            of_field = self::effort(&context) / effort;
            of_patches = follow(&model, &mut patches);
        }
        let (added, removed) = (median(added), median(removed));
        Ok(Some(Self { at_once, added, removed, of_field, of_patches }))
    }

    fn print(&self, name: &str) {
        let Self { at_once, added, removed, of_field, of_patches } = self;
        println!(
            "{name:<36}{at_once:>9.3}{added:>9.3}{:>8.0}%{removed:>9.3}{:>10.0}%{:>10.0}%",
            100.0 * added / at_once,
            100.0 * of_field,
            100.0 * of_patches
        );
    }
}

/// Unknowns of the variational field, evaluations of the mean-value field, or cells computed of
/// the exact surface.
fn effort(context: &Context) -> f64 {
    let counts = ["unknowns", "evaluations", "cells computed"];
    let counts = counts.map(|what| context.stages.count_of(what) as f64);
    counts.into_iter().find(|&count| count > 0.0).unwrap_or(0.0)
}

/// The part of the patches that are others than before.
fn follow(model: &Model, patches: &mut Patches) -> f64 {
    let Some(now) = model.derived() else { return 0.0 };
    let changes = patches.follow(&now.mesh, now.samples.lattice);
    changes.changed.len() as f64 / patches.iter().count().max(1) as f64
}

/// The seconds that each of a file's sections takes when they come one after the other.
fn one_by_one(file: &Path, method: Method) -> Result<Vec<f64>> {
    let all = read_sections(file, &Rules::default())?;
    let mut model = Model::new(Options { method, resolution: RESOLUTION, bounds: all.space() });
    let mut seconds = Vec::new();
    for section in &all.sections {
        let one = Sections { sections: vec![section.clone()], ..all.clone() };
        let mut context = Context::default();
        // A frame that shows nothing cannot be the first.
        if model.apply(Change::Add(one), &mut context).is_ok() {
            seconds.push(context.stages.seconds());
        }
    }
    Ok(seconds)
}
