//! `./x bench`: seconds per stage, field evaluations, edge evaluations per
//! second for each backend beside the scalar f64 reference, and peak memory,
//! for the bundled example and the real files there are; what it costs when a
//! fifth of every section is unknown; unknowns × iterations per second of the
//! variational solver's backends; how its seconds grow with the resolution; points per second of the oracle beside
//! plain floats that look at every edge; and the exact reconstruction beside the
//! way from sections to a mesh by the field.
//!
//! `cargo bench -- NAME...` takes only the files whose names contain a NAME.

use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;
use transect::change::Change;
use transect::complex::Complex;
use transect::context::Context;
use transect::error::{Error, Result};
use transect::field::{
    Adapter, Boundaries, Cpu, Device, Evaluator, Field, Gpu, Queries, Reference, Run, hermite,
};
use transect::grid::frame::Frame;
use transect::grid::lattice::Resolution;
use transect::io;
use transect::label::Label;
use transect::mask::{Blobs, Mask, mask};
use transect::method::{MeanValue, Method, Variational};
use transect::model::{Model, Options};
use transect::oracle::Oracle;
use transect::plane::Bounds;
use transect::progress::Silent;
use transect::section::{Rules, Section, Sections};
use transect::skeleton::{self, skeleton};
use transect::stage::Stages;
use transect::variational::Trial;

/// The stages that are shown, in their order.
const STAGES: [&str; 7] =
    ["read", "arrangement", "completion", "field", "smoothing", "mesh", "check"];
/// The methods whose stages are shown, the default first.
fn methods() -> [(&'static str, Method); 2] {
    [("variational", Method::default()), ("mvc", Method::MeanValue(MeanValue::default()))]
}
/// The blobs that are made unknown.
const BLOBS: Blobs = Blobs { fraction: 0.2, size: 0.2, seed: 1 };
/// Points that the oracle is timed on, and plain floats.
const ORACLE_POINTS: [u32; 2] = [1_000_000, 100_000];
/// Points that the backends are timed on: as many as the reference can do in
/// about a second, and more for the others.
const POINTS: [(&str, usize); 3] = [("reference", 20_000), ("cpu", 1_000_000), ("gpu", 200_000)];

/// The same for the Hermite field.
const HERMITE_POINTS: usize = 50_000;

/// Voxels on the longest side for which the seconds of the default method are shown, and
/// last those for which it is shown what an unknown takes.
const GROWTH: [u32; 5] = [96, 192, 384, 768, 512];

/// What the solver is timed on: a software adapter has some half a million updates a
/// second, so no more than it can do.
const SOLVER_VOXELS: Resolution = Resolution::Voxels(96);

fn main() -> Result<()> {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let files = files().into_iter().filter(|file| {
        wanted.is_empty() || wanted.iter().any(|part| name(file).contains(part.as_str()))
    });
    let files: Vec<PathBuf> = files.collect();
    println!("{} threads, resolution 256, default options", rayon::current_num_threads());
    print!("\n{:<22}", "seconds");
    STAGES.iter().for_each(|stage| print!("{stage:>12}"));
    println!("{:>9}{:>11}{:>14}{:>14}", "all", "peak MiB", "evaluations", "triangles");
    let mut models = Vec::new();
    for file in &files {
        let masked = Mask { blobs: Some(BLOBS), frame: None };
        for (method_name, method) in methods() {
            let (model, known) = reconstruct(file, method, Ok)?;
            let (partial, unknown) = reconstruct(file, method, |sections| mask(sections, &masked))?;
            let factor = unknown / known;
            println!("{method_name:<22}× {factor:.2} with a fifth unknown, the row above");
            if matches!(model.options().method, Method::MeanValue(_)) {
                models.push((name(file), model, partial));
            }
        }
    }
    println!("\n{:<22}{:>14}  G edge evaluations a second (× the reference)", "", "edges/point");
    for (name, model, _) in &models {
        rates(name, model)?;
    }
    println!("\n{:<22}{:>14}  M unknowns × iterations a second of the solver", "", "unknowns");
    for (name, model, _) in &models {
        solver_rates(name, model)?;
    }
    print!("\n{:<22}", "field, seconds at");
    GROWTH.iter().for_each(|voxels| print!("{voxels:>12}"));
    println!("{:>24}", "µs an unknown, at 512");
    for file in &files {
        growth(file)?;
    }
    println!("\n{:<22}M points a second of the oracle (× plain floats)", "");
    for (name, model, partial) in &models {
        oracle_rates(name, model, partial)?;
    }
    println!("\n{:<22}seconds of the exact reconstruction (× the field's)", "");
    for (name, model, _) in &models {
        exact_seconds(name, model)?;
    }
    Ok(())
}

/// The bundled example, and the real files where they are.
fn files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("TRANSECT_DATA")
        .map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let mut files = vec![root.join("examples/phantom.json")];
    for folder in ["csl", "contour"] {
        let Ok(entries) = std::fs::read_dir(data.join(folder)) else {
            println!("skipped: {} is absent", data.join(folder).display());
            continue;
        };
        let mut found: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        found.sort();
        files.extend(found);
    }
    files
}

fn name(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn complex(model: &Model) -> Result<&Complex> {
    let complex = model.derived().and_then(|derived| derived.complex.as_ref());
    complex.ok_or_else(|| Error::Option("nothing was derived".into()))
}

/// One row of the table of stages; returns the model and the seconds of all
/// stages.
fn reconstruct(
    file: &Path,
    method: Method,
    change: impl FnOnce(Sections) -> Result<Sections>,
) -> Result<(Model, f64)> {
    let mut context = Context::default();
    let rules = context.rules;
    let sections = context.stages.run("read", |_| io::read_sections(file, &rules))?;
    let sections = change(sections)?;
    let mut model = Model::new(Options { method, ..Options::default() });
    model.apply(Change::Add(sections), &mut context)?;
    model.check(&mut context)?;
    let derived = model.derived().ok_or_else(|| Error::Option("nothing was derived".into()))?;
    let stages = context.stages;
    print!("{:<22}", name(file));
    STAGES.iter().for_each(|stage| print!("{:>12.3}", stages.seconds_of(stage)));
    println!(
        "{:>9.3}{:>11}{:>14}{:>14}",
        stages.seconds(),
        stages.peak_memory() >> 20,
        stages.count_of("evaluations"),
        derived.mesh.triangles.len()
    );
    Ok((model, stages.seconds()))
}

/// One row of the table of resolutions.
fn growth(file: &Path) -> Result<()> {
    print!("{:<22}", name(file));
    let rules = Rules::default();
    let sections = io::read_sections(file, &rules)?;
    let mut last = Stages::default();
    for voxels in GROWTH {
        let mut context = Context::default();
        let resolution = Resolution::Voxels(voxels);
        let mut model = Model::new(Options { resolution, ..Options::default() });
        model.apply(Change::Add(sections.clone()), &mut context)?;
        print!("{:>12.3}", context.stages.seconds_of("field"));
        last = context.stages;
    }
    let an_unknown = last.seconds_of("field") / last.count_of("unknowns") as f64;
    println!("{:>24.3}", 1e6 * an_unknown);
    Ok(())
}

/// One row of the table of the exact reconstruction.
fn exact_seconds(name: &str, model: &Model) -> Result<()> {
    let bounds = complex(model)?.bounds();
    let sections = &model.sections().sections;
    let start = Instant::now();
    let exact = skeleton(sections, bounds, &skeleton::Options::default(), &Silent)?;
    let seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let added = model.sections().clone();
    let mut other = Model::new(*model.options());
    other.apply(Change::Add(added), &mut Context::default())?;
    let field = start.elapsed().as_secs_f64();
    let (cells, triangles) = (exact.details.cells, exact.mesh.triangles.len());
    println!(
        "{name:<22}{seconds:>8.3} (× {:.2})  {cells} cells, {triangles} triangles",
        seconds / field
    );
    Ok(())
}

/// One row of the table of the oracle: all sections full, and a fifth unknown.
fn oracle_rates(name: &str, model: &Model, partial: &Model) -> Result<()> {
    print!("{name:<22}");
    let bounds = complex(model)?.bounds();
    let sections = &model.sections().sections;
    let plain = rate_of(bounds, ORACLE_POINTS[1], |point| plain_label(sections, bounds, point));
    for (model, what) in [(model, "full"), (partial, "a fifth unknown")] {
        let oracle = Oracle::new(&model.sections().sections, bounds, Label::OUTSIDE)?;
        let rate = rate_of(bounds, ORACLE_POINTS[0], |point| oracle.nearest(point).label);
        print!("  {what} {:.2} (× {:.1})", rate / 1e6, rate / plain);
    }
    println!();
    Ok(())
}

/// Points of a box a second, on all threads.
fn rate_of(bounds: Bounds, count: u32, label: impl Fn(DVec3) -> Label + Sync) -> f64 {
    // Roberts' evenly spread sequence.
    let steps =
        DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    let point = |at: u32| bounds.min + bounds.size() * (f64::from(at) * steps).fract();
    let start = Instant::now();
    let sum: u64 = (0..count).into_par_iter().map(|at| u64::from(label(point(at)).0)).sum();
    std::hint::black_box(sum);
    f64::from(count) / start.elapsed().as_secs_f64()
}

/// What the oracle says of full sections, with rounded feet and without any index.
fn plain_label(sections: &[Section], bounds: Bounds, point: DVec3) -> Label {
    let to_box = (point - bounds.min).min(bounds.max - point).min_element();
    let distance = |section: &&Section| section.plane().distance(point).abs();
    let nearest = sections.iter().min_by(|one, other| distance(one).total_cmp(&distance(other)));
    let Some(section) = nearest.filter(|section| distance(section) < to_box) else {
        return Label::OUTSIDE;
    };
    let plane = section.plane();
    let foot = plane.project(point - plane.distance(point) * plane.unit_normal());
    section.label_at(foot)
}

/// One row of the table of backends, and below it the Hermite field on the CPU: how many edges of
/// triangles it has a point, and how many a second.
fn rates(name: &str, model: &Model) -> Result<()> {
    let complex = complex(model)?;
    let clearance = 1e-4 * complex.bounds().diagonal();
    let boundaries = Boundaries::new(complex, clearance, None)?;
    let reference = Reference::new(&boundaries)?;
    let cpu = Cpu::new(&boundaries)?;
    let gpu = Gpu::new(&boundaries, Adapter::Any);
    let per_point = queries(complex, &cpu, 10_000);
    let edges = per_point.edge_evaluations(&cpu) as f64 / per_point.points.len() as f64;
    print!("{name:<22}{edges:>14.0}");
    let (mut of_reference, mut of_cpu) = (f64::NAN, f64::NAN);
    let fields: [Option<&dyn Field>; 3] =
        [Some(&reference), Some(&cpu), gpu.as_ref().ok().map(|gpu| gpu as &dyn Field)];
    for ((backend, points), field) in POINTS.into_iter().zip(fields) {
        let Some(field) = field else {
            print!("  {backend} skipped: no adapter");
            continue;
        };
        let rate = rate(field, &queries(complex, field, points))?;
        match backend {
            "reference" => of_reference = rate,
            "cpu" => of_cpu = rate,
            _ => {}
        }
        print!("  {} {:.3} (× {:.1})", field.name(), rate / 1e9, rate / of_reference);
    }
    println!();
    let options = hermite::Options::default();
    let nodes = hermite::Nodes::new(&boundaries, &model.sections().sections, &options, &Silent)?;
    let unit = complex.bounds().diagonal();
    let field = Evaluator::default().hermite(&boundaries, &nodes, &options, unit, Device::Cpu)?;
    let queries = queries(complex, field.as_ref(), HERMITE_POINTS);
    let edges = queries.edge_evaluations(field.as_ref()) as f64 / queries.points.len() as f64;
    let rate = rate(field.as_ref(), &queries)?;
    println!("  hermite{edges:>28.0}  cpu {:.3} (× {:.2} of mvc's)", rate / 1e9, rate / of_cpu);
    Ok(())
}

/// One row of the table of the variational solver's backends.
fn solver_rates(name: &str, model: &Model) -> Result<()> {
    let frame = Frame::new(complex(model)?.bounds(), SOLVER_VOXELS)?;
    let trial = Trial::new(&model.sections().sections, &frame, &Variational::default())?;
    print!("{name:<22}{:>14}", trial.unknowns());
    for (device, times) in [(Device::Cpu, 3), (Device::Gpu, 1)] {
        match trial.run(device, times) {
            Ok(rate) => print!("  {} {:.1}", rate.device, rate.updates / 1e6),
            Err(Error::Device(_)) => print!("  gpu skipped: no adapter"),
            Err(other) => return Err(other),
        }
    }
    println!();
    Ok(())
}

/// Edge evaluations a second, the best of three runs.
fn rate(field: &dyn Field, queries: &Queries) -> Result<f64> {
    let edges = queries.edge_evaluations(field) as f64;
    let mut best = 0.0_f64;
    for _ in 0..3 {
        let start = Instant::now();
        field.evaluate(queries)?;
        best = best.max(edges / start.elapsed().as_secs_f64());
    }
    Ok(best)
}

/// About `count` points, spread evenly over the cells that need evaluation:
/// on the way from a cell's middle to the middles of its faces.
fn queries(complex: &Complex, field: &dyn Field, count: usize) -> Queries {
    let cells: Vec<u32> = complex.cells().ids().filter(|&cell| field.edges(cell) > 0).collect();
    let each = count.div_ceil(cells.len().max(1)).max(1);
    let mut queries = Queries::default();
    for cell in cells {
        let start = queries.points.len();
        let facets = &complex.cells()[cell].facets;
        let corners = || facets.iter().flat_map(|&facet| &complex.facets()[facet].outline);
        let middle =
            corners().fold(DVec3::ZERO, |sum, &corner| sum + corner) / corners().count() as f64;
        for place in 0..each {
            let outline = &complex.facets()[facets[place % facets.len()]].outline;
            let goal = outline[place % outline.len()];
            let part = (place as f64 + 0.5) / each as f64;
            queries.points.push(middle.lerp(goal, 0.98 * part));
        }
        queries.runs.push(Run { cell, points: start..queries.points.len() });
    }
    queries
}
