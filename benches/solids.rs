//! What every method makes of six solids that are known: volume in common, mean
//! distance, volume, topology, and how the surface leans near the sections.
//!
//! `cargo bench --bench solids -- [NAME...] [VOXELS]` takes only the solids whose
//! names contain a NAME, and so many voxels on the longest side.

#[path = "../examples/solids/formulas/mod.rs"]
#[allow(dead_code)] // volumes are known, too
mod formulas;
#[path = "../tests/common/trials.rs"]
mod trials;

use transect::error::Result;
use transect::label::Label;
use transect::mesh::Mesh;

use formulas::Solid;
use trials::{Cut, Trial, methods, trial};

/// Voxels of the reconstructions.
const VOXELS: u32 = 128;
/// Voxels of the solids themselves.
const TRUE_VOXELS: u32 = 320;
/// What random planes are drawn from.
const SEEDS: [u64; 3] = [1, 2, 3];

fn main() -> Result<()> {
    let arguments: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let (numbers, names): (Vec<&String>, Vec<&String>) =
        arguments.iter().partition(|argument| argument.parse::<u32>().is_ok());
    let voxels = numbers.first().and_then(|number| number.parse().ok()).unwrap_or(VOXELS);
    println!("resolution {voxels}; distances in thousandths of the diagonal, angles in degrees");
    println!(
        "{:<8}{:<10}{:<12}{:>8}{:>9}{:>8}{:>11}{:>8}{:>9}{:>9}{:>7}{:>9}",
        "solid",
        "planes",
        "method",
        "IoU",
        "distance",
        "volume",
        "components",
        "genus",
        "normals",
        "steep",
        "true",
        "seconds"
    );
    for solid in formulas::solids() {
        if names.is_empty() || names.iter().any(|name| solid.name.contains(name.as_str())) {
            all_trials(&solid, voxels)?;
        }
    }
    Ok(())
}

/// All rows of a solid. What a method cannot do is a row, too.
fn all_trials(solid: &Solid, voxels: u32) -> Result<()> {
    let mesh = formulas::mesh(solid, TRUE_VOXELS)?;
    print_truth(solid, &mesh)?;
    let bounds = mesh.bounds().unwrap_or(solid.bounds);
    let random = SEEDS.map(Cut::random);
    for cut in [Cut::parallel(&bounds), Cut::axes()].into_iter().chain(random) {
        let planes = cut.planes(&bounds)?;
        for (method, options) in methods() {
            print!("{:<8}{:<10}{method:<12}", solid.name, cut.name);
            match trial(&mesh, &planes, options, voxels) {
                Ok(trial) => print_trial(&trial),
                Err(error) => println!("failed: {error}"),
            }
        }
    }
    Ok(())
}

fn print_truth(solid: &Solid, mesh: &Mesh) -> Result<()> {
    let facts = mesh.surface_of(Label::is_material).facts(false)?;
    println!(
        "{:<30}{:>8.4}{:>9.2}{:>8.3}{:>11}{:>8}",
        format!("{}, as it is", solid.name),
        1.0,
        0.0,
        1.0,
        facts.components,
        facts.genus
    );
    Ok(())
}

fn print_trial(trial: &Trial) {
    let Trial { comparison, facts, leaning, seconds } = trial;
    let [error, steep, truly] = leaning.map_or([f64::NAN; 3], |leaning| {
        [leaning.error, leaning.steepness, leaning.true_steepness]
    });
    println!(
        "{:>8.4}{:>9.2}{:>8.3}{:>11}{:>8}{error:>9.1}{steep:>9.1}{truly:>7.1}{seconds:>9.2}{}",
        comparison.iou,
        1e3 * comparison.chamfer,
        comparison.volume_ratio,
        facts.components,
        facts.genus,
        if facts.closed { "" } else { "  not closed" }
    );
}
