//! The command line of transect.

use std::process::ExitCode;

fn main() -> ExitCode {
    transect::cli::run()
}
