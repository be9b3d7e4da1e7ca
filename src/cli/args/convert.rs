//! The arguments of `transect convert`.

use std::path::PathBuf;

use clap::Args;

use super::InputArguments;

#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// The section file to write: .json, .csl, .contour, .obj (polylines), .vtp (lines), or a structure set: .dcm
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    #[command(flatten)]
    pub input: InputArguments,
    /// No warnings and no notes
    #[arg(short, long)]
    pub quiet: bool,
}
