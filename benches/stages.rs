//! `./x bench`: seconds per stage, field evaluations, edge evaluations per
//! second for each backend beside the scalar f64 reference, and peak memory,
//! for the bundled example and the real files there are; and what it costs when
//! a fifth of every section is unknown.
//!
//! `cargo bench -- NAME...` takes only the files whose names contain a NAME.

use std::path::{Path, PathBuf};
use std::time::Instant;

use transect::arrangement::Arrangement;
use transect::change::Change;
use transect::check::{self, check};
use transect::error::{Error, Result};
use transect::field::{Adapter, Boundaries, Cpu, Field, Gpu, Queries, Reference, Run};
use transect::io;
use transect::mask::{Blobs, Mask, mask};
use transect::model::{Model, Options};
use transect::progress::Silent;
use transect::section::{Rules, Sections};
use transect::stage::Stages;

/// The stages that are shown, in their order.
const STAGES: [&str; 7] =
    ["read", "arrangement", "completion", "field", "smoothing", "mesh", "check"];
/// The blobs that are made unknown.
const BLOBS: Blobs = Blobs { fraction: 0.2, size: 0.2, seed: 1 };
/// Points that the backends are timed on: as many as the reference can do in
/// about a second, and more for the others.
const POINTS: [(&str, usize); 3] = [("reference", 20_000), ("cpu", 1_000_000), ("gpu", 200_000)];

fn main() -> Result<()> {
    let wanted: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let files = files().into_iter().filter(|file| {
        wanted.is_empty() || wanted.iter().any(|part| name(file).contains(part.as_str()))
    });
    println!("{} threads, resolution 256, default options", rayon::current_num_threads());
    print!("\n{:<22}", "seconds");
    STAGES.iter().for_each(|stage| print!("{stage:>12}"));
    println!("{:>9}{:>11}{:>14}{:>14}", "all", "peak MiB", "evaluations", "triangles");
    let mut backends = Vec::new();
    for file in files {
        let (arrangement, known) = reconstruct(&file, Ok)?;
        let masked = Mask { blobs: Some(BLOBS), frame: None };
        let (_, unknown) = reconstruct(&file, |sections| mask(sections, &masked))?;
        println!("{:<22}× {:.2} with a fifth unknown, the row above", "", unknown / known);
        backends.push((name(&file), arrangement));
    }
    println!("\n{:<22}{:>14}  G edge evaluations a second (× the reference)", "", "edges/point");
    for (name, arrangement) in &backends {
        rates(name, arrangement)?;
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

/// One row of the table of stages; returns the arrangement and the seconds of
/// all stages.
fn reconstruct(
    file: &Path,
    change: impl FnOnce(Sections) -> Result<Sections>,
) -> Result<(Arrangement, f64)> {
    let mut stages = Stages::default();
    let rules = Rules::default();
    let sections = stages.run("read", |_| io::read_sections(file, &rules))?;
    let sections = change(sections)?;
    let mut model = Model::new(Options::default());
    model.apply(Change::Add(sections), &rules, &mut stages, &Silent)?;
    let derived = model.derived().ok_or_else(|| Error::Option("nothing was derived".into()))?;
    stages.run("check", |_| {
        let options = check::Options::default();
        let lattice = &derived.samples.lattice;
        check(&model.sections().sections, &derived.mesh, lattice, options, &Silent)
    })?;
    print!("{:<22}", name(file));
    STAGES.iter().for_each(|stage| print!("{:>12.3}", stages.seconds_of(stage)));
    println!(
        "{:>9.3}{:>11}{:>14}{:>14}",
        stages.seconds(),
        stages.peak_memory() >> 20,
        stages.count_of("evaluations"),
        derived.mesh.triangles.len()
    );
    Ok((derived.arrangement.clone(), stages.seconds()))
}

/// One row of the table of backends.
fn rates(name: &str, arrangement: &Arrangement) -> Result<()> {
    let clearance = 1e-4 * arrangement.bounds().diagonal();
    let boundaries = Boundaries::new(arrangement, clearance, None)?;
    let reference = Reference::new(&boundaries)?;
    let cpu = Cpu::new(&boundaries)?;
    let gpu = Gpu::new(&boundaries, Adapter::Any);
    let per_point = queries(arrangement, &cpu, 10_000);
    let edges = per_point.edge_evaluations(&cpu) as f64 / per_point.points.len() as f64;
    print!("{name:<22}{edges:>14.0}");
    let mut of_reference = f64::NAN;
    let fields: [Option<&dyn Field>; 3] =
        [Some(&reference), Some(&cpu), gpu.as_ref().ok().map(|gpu| gpu as &dyn Field)];
    for ((backend, points), field) in POINTS.into_iter().zip(fields) {
        let Some(field) = field else {
            print!("  {backend} skipped: no adapter");
            continue;
        };
        let rate = rate(field, &queries(arrangement, field, points))?;
        if backend == "reference" {
            of_reference = rate;
        }
        print!("  {} {:.3} (× {:.1})", field.name(), rate / 1e9, rate / of_reference);
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
fn queries(arrangement: &Arrangement, field: &dyn Field, count: usize) -> Queries {
    let cells: Vec<u32> =
        (0..arrangement.cells().len() as u32).filter(|&cell| field.edges(cell) > 0).collect();
    let each = count.div_ceil(cells.len().max(1)).max(1);
    let mut queries = Queries::default();
    for cell in cells {
        let start = queries.points.len();
        let faces = &arrangement.cells()[cell as usize].faces;
        let corners = || faces.iter().flat_map(|&face| arrangement.outline(face));
        let middle = corners().fold(glam::DVec3::ZERO, |sum, &corner| sum + corner)
            / corners().count() as f64;
        for place in 0..each {
            let outline = arrangement.outline(faces[place % faces.len()]);
            let goal = outline[place % outline.len()];
            let part = (place as f64 + 0.5) / each as f64;
            queries.points.push(middle.lerp(goal, 0.98 * part));
        }
        queries.runs.push(Run { cell, points: start..queries.points.len() });
    }
    queries
}
