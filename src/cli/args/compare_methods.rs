//! The arguments of `transect compare-methods`.

use std::path::PathBuf;

use clap::Args;

use super::{GridArguments, InputArguments, MethodName, ThreadsArgument};

#[derive(Debug, Args)]
pub struct CompareMethodsArguments {
    /// Which methods, each with its own default options
    #[arg(
        long,
        value_enum,
        value_name = "NAME,...",
        value_delimiter = ',',
        default_value = "variational,mvc,hermite,skeleton,stack"
    )]
    pub methods: Vec<MethodName>,
    /// A closed mesh that is right: .ply, .obj, .stl, .off
    #[arg(long, value_name = "MESH")]
    pub reference: Option<PathBuf>,
    /// A picture of all results from one direction, side by side
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE.json")]
    pub report: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    pub grid: GridArguments,
    #[command(flatten)]
    pub threads: ThreadsArgument,
    #[command(flatten)]
    pub input: InputArguments,
    /// No progress, no warnings
    #[arg(short, long)]
    pub quiet: bool,
}
