//! The command line: a thin reader of arguments over the library.

mod args;
mod bars;
mod compare;
mod inspect;
mod reconstruct;
mod slice;
mod table;

use std::process::ExitCode;

use clap::Parser;

use crate::error::{Error, Result};
use crate::output;
use args::{Arguments, Command};

/// What Ctrl-C ends the program with, by the shells' convention.
const INTERRUPTED: i32 = 130;

/// Runs the program; exit status 0 when done, 1 when failed, 2 on wrong
/// usage.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    match start().and_then(|()| dispatch(&arguments.command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // One line, whatever a library's words contain.
            let words = error.to_string();
            let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
            eprintln!("error: {words}");
            ExitCode::FAILURE
        }
    }
}

fn dispatch(command: &Command) -> Result<()> {
    match command {
        Command::Reconstruct(arguments) => reconstruct::run(arguments),
        Command::Slice(arguments) => slice::run(arguments),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
    }
}

/// Ctrl-C and termination end the program at once and leave no half-written
/// file.
fn start() -> Result<()> {
    ctrlc::set_handler(|| {
        output::remove_temporary_files();
        std::process::exit(INTERRUPTED);
    })
    .map_err(|error| Error::Option(format!("cannot listen for Ctrl-C: {error}")))
}
