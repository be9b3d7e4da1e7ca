//! The arguments of `transect online`.

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use glam::DVec3;

use super::{
    MethodArguments, PictureArguments, ReadingArguments, ThreadsArgument, VolumeArguments, positive,
};
use crate::plane::Bounds;

#[derive(Debug, Args)]
pub struct OnlineArguments {
    /// Section files to begin with: .csl, .contour, .json, .jser, .obj (polylines), .vtp (lines); volumes of labels: .nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd; or stacks of pictures whose pixels are labels: .png, .tif, or a folder of them
    #[arg(value_name = "SECTIONS", conflicts_with = "watch")]
    pub sections: Vec<PathBuf>,
    /// Follow the section files of this folder as they appear, change and go, instead of commands on standard input
    #[arg(long, value_name = "DIR")]
    pub watch: Option<PathBuf>,
    /// With --watch: end after so many seconds in which nothing happened [default: go on until Ctrl-C]
    #[arg(long, value_name = "SECONDS", requires = "watch", value_parser = seconds)]
    pub idle: Option<Duration>,
    /// Write every change to this file, and to disk, before it is acknowledged
    #[arg(long, value_name = "FILE")]
    pub journal: Option<PathBuf>,
    /// Go on from the last change in the journal, if it holds any
    #[arg(long, requires = "journal")]
    pub resume: bool,
    /// Write the result of every change into this folder, as frame_000001 and so on
    #[arg(long, value_name = "DIR")]
    pub emit: Option<PathBuf>,
    /// What kind of file the results of changes are
    #[arg(long, value_name = "KIND", value_enum, default_value_t = FrameKind::Ply, requires = "emit")]
    pub emit_kind: FrameKind,
    /// Say with every change which patches of the surface are others than before
    #[arg(long)]
    pub patches: bool,
    /// An output file, written at the end, its kind by its name: .vdb, .ply, .vtp, .vtu, .vtm, .glb, .3mf, .obj, .stl, .off, .png; can be repeated. A surface with {label} or {name} in its name is written once for each material
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,
    /// The box that is filled, which no contour may leave. In it, and with --voxel-size, fields are evaluated and solved for only where a change concerns them [default: what the sections fill, anew with every change]
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", allow_hyphen_values = true, value_parser = bounds,
          conflicts_with = "margin")]
    pub bounds: Option<Bounds>,
    #[command(flatten)]
    pub method: MethodArguments,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    #[command(flatten)]
    pub volumes: VolumeArguments,
    /// Write the report at the end, as JSON or, when the name ends in .html, as a page to read
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArguments,
    #[command(flatten)]
    pub reading: ReadingArguments,
    /// No warnings, no table
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FrameKind {
    Ply,
    Vdb,
}

fn seconds(text: &str) -> Result<Duration, String> {
    Duration::try_from_secs_f64(positive(text)?).map_err(|error| error.to_string())
}

fn bounds(text: &str) -> Result<Bounds, String> {
    let numbers = text.split(',').map(|number| number.trim().parse::<f64>().ok());
    let numbers: Option<Vec<f64>> =
        numbers.map(|number| number.filter(|n| n.is_finite())).collect();
    let [x0, y0, z0, x1, y1, z1] =
        numbers.and_then(|numbers| numbers.try_into().ok()).ok_or("six numbers are needed")?;
    let (min, max) = (DVec3::new(x0, y0, z0), DVec3::new(x1, y1, z1));
    if !min.cmplt(max).all() {
        return Err("the first corner must be below the second in x, y and z".to_owned());
    }
    Ok(Bounds { min, max })
}
