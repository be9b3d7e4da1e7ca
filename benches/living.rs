//! `cargo bench --bench living`: what a section costs that comes last and goes again, and one
//! whose contour is edited in one place, beside all of them at once; and a sweep whose frames
//! come one by one. How much of the field is evaluated or solved for, and how many patches of
//! the surface change, say how far a change reaches.

mod common;

use std::path::{Path, PathBuf};

use common::{files, median, name};
use transect::grid::lattice::Resolution;
use transect::io::read_sections;
use transect::{
    Change, Context, DVec3, MeanValue, Method, Model, Options, Patches, Result, Rules, Section,
    SectionId, Sections, Skeleton,
};

const RESOLUTION: Resolution = Resolution::Voxels(256);
/// How often a section comes and goes: the median counts.
const TIMES: usize = 5;
/// How far an edit moves a contour, and how wide the bulge is, in voxels.
const BULGE: f64 = 3.0;
const WIDTH: f64 = 8.0;

fn main() -> Result<()> {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    println!("resolution 256, {} threads, seconds", rayon::current_num_threads());
    println!(
        "{:<36}{:>9}{:>9}{:>9}{:>9}{:>11}{:>11}",
        "", "at once", "away", "again", "share", "of field", "patches"
    );
    let is_wanted = |file: &PathBuf| {
        wanted.is_empty() || wanted.iter().any(|part| name(file).contains(part.as_str()))
    };
    let files: Vec<PathBuf> = files().into_iter().filter(is_wanted).collect();
    for file in &files {
        for (method_name, method) in methods() {
            measure(file, &format!("{} {method_name}", name(file)), method)?;
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

/// Measures what a file's last section costs, and an edit of the one in the middle.
fn measure(file: &Path, name: &str, method: Method) -> Result<()> {
    let all = read_sections(file, &Rules::default())?;
    let Some(bounds) = all.space() else { return Ok(()) };
    let options =
        Options { method, resolution: RESOLUTION, bounds: Some(bounds), ..Options::default() };
    let mut model = Model::new(options);
    let mut context = Context::default();
    let ids = model.apply(Change::Add(all.clone()), &mut context)?;
    let (Some(&id), Some(section)) = (ids.last(), all.sections.last()) else { return Ok(()) };
    let last = Sections { sections: vec![section.clone()], ..all.clone() };
    let at_once = (context.stages.seconds(), effort(&context));
    let cost = Cost::of(&mut model, id, Change::Remove, |_| Change::Add(last.clone()), at_once)?;
    cost.print(&format!("{name}, last"));
    let middle = ids.len() / 2;
    let section = &all.sections[middle];
    let voxel = bounds.size().max_element() / 256.0;
    let edited = edited(section, voxel)?;
    let to = |section: &Section| {
        let section = section.clone();
        move |id| Change::Replace(id, section.clone())
    };
    Cost::of(&mut model, ids[middle], to(&edited), to(section), at_once)?
        .print(&format!("{name}, edited"));
    Ok(())
}

/// A section with a bulge where it is farthest from its middle.
fn edited(section: &Section, voxel: f64) -> Result<Section> {
    let mut points: Vec<DVec3> =
        (0..section.vertices().len() as u32).map(|vertex| section.point(vertex)).collect();
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let farther = |a: &&DVec3, b: &&DVec3| middle.distance(**a).total_cmp(&middle.distance(**b));
    let Some(&tip) = points.iter().max_by(farther) else { return Ok(section.clone()) };
    let outward = (tip - middle).normalize_or_zero();
    for point in &mut points {
        let near = point.distance(tip) / (WIDTH * voxel);
        *point += BULGE * voxel * (-near * near).exp() * outward;
    }
    let rules = Rules::default();
    let size = 2.0 * middle.distance(tip);
    let plane = *section.plane();
    Ok(Section::from_graph(section.name(), plane, &points, section.edges(), size, &rules)?.0)
}

/// What a change costs.
struct Cost {
    /// The seconds that all sections take at once.
    at_once: f64,
    away: f64,
    again: f64,
    /// Of the evaluations, unknowns or cells that all sections need.
    of_field: f64,
    /// Of the patches.
    of_patches: f64,
}

impl Cost {
    /// Of a change that takes something away, and one that brings it again; `id` is the section that it concerns.
    fn of(
        model: &mut Model,
        mut id: SectionId,
        take: impl Fn(SectionId) -> Change,
        bring: impl Fn(SectionId) -> Change,
        (at_once, effort): (f64, f64),
    ) -> Result<Self> {
        let (mut away, mut again, mut patches) = (Vec::new(), Vec::new(), Patches::default());
        let (mut of_field, mut of_patches) = (0.0, 0.0);
        for _ in 0..TIMES {
            let mut context = Context::default();
            model.apply(take(id), &mut context)?;
            away.push(context.stages.seconds());
            follow(model, &mut patches);
            let mut context = Context::default();
            id = model.apply(bring(id), &mut context)?.first().copied().unwrap_or(id);
            again.push(context.stages.seconds());
            of_field = self::effort(&context) / effort;
            of_patches = follow(model, &mut patches);
        }
        let (away, again) = (median(away), median(again));
        Ok(Self { at_once, away, again, of_field, of_patches })
    }

    fn print(&self, name: &str) {
        let Self { at_once, away, again, of_field, of_patches } = self;
        println!(
            "{name:<36}{at_once:>9.3}{away:>9.3}{again:>9.3}{:>8.0}%{:>10.0}%{:>10.0}%",
            100.0 * again / at_once,
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
    let mut model = Model::new(Options {
        method,
        resolution: RESOLUTION,
        bounds: all.space(),
        ..Options::default()
    });
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
