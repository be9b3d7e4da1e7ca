//! The arguments of `transect slice`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::two_lengths;

#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("planes").required(true)))]
#[command(group(clap::ArgGroup::new("along")))]
pub struct SliceArguments {
    /// A closed mesh: .ply (with labels or without), .obj, .stl, .off; or a volume of labels: .nrrd, .nii, .nii.gz, .mha, .mhd
    #[arg(value_name = "SOLID")]
    pub solid: PathBuf,
    /// Parallel planes, normal to this axis; with --count. Or what --sweep advances along [default: z]
    #[arg(long, value_enum, requires = "along")]
    pub axis: Option<AxisName>,
    /// How many parallel planes
    #[arg(long, value_name = "N", groups = ["planes", "along"], requires = "axis",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub count: Option<u32>,
    /// This many planes of random orientation
    #[arg(long, value_name = "N", group = "planes",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub random: Option<u32>,
    /// This many frames of a freehand sweep: they advance along an axis while they rock and turn, cross each other, and know nothing beyond their rectangle
    #[arg(long, value_name = "N", groups = ["planes", "along"],
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub sweep: Option<u32>,
    /// With --sweep: how far frames lean at most, in degrees, up to 60
    #[arg(long, value_name = "DEG", default_value_t = 25.0, value_parser = tilt,
          conflicts_with_all = ["count", "random", "plane"])]
    pub tilt: f64,
    /// With --sweep: width and height of a frame [default: three quarters of the solid]
    #[arg(long, value_name = "W,H", value_parser = two_lengths,
          conflicts_with_all = ["count", "random", "plane"])]
    pub extent: Option<[f64; 2]>,
    /// What random planes and sweeps are drawn from
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// The plane A x + B y + C z + D = 0; can be repeated
    #[arg(long, value_name = "A,B,C,D", group = "planes", allow_hyphen_values = true,
          value_parser = four_numbers)]
    pub plane: Vec<[f64; 4]>,
    /// The section file to write: .csl or .json
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// No progress, no warnings
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AxisName {
    X,
    Y,
    Z,
}

fn tilt(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if (0.0..=60.0).contains(&degrees) => Ok(degrees),
        _ => Err("an angle from 0 to 60 degrees is needed".to_owned()),
    }
}

fn four_numbers(text: &str) -> Result<[f64; 4], String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|number| number.trim().parse::<f64>().ok().filter(|number| number.is_finite()))
        .collect::<Option<_>>()
        .ok_or("four numbers A,B,C,D are needed")?;
    let plane: [f64; 4] = numbers.try_into().map_err(|_| "four numbers A,B,C,D are needed")?;
    if plane[..3].iter().all(|&component| component == 0.0) {
        return Err("the normal A,B,C must not be zero".to_owned());
    }
    Ok(plane)
}
