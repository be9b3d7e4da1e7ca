//! The command line: a thin reader of arguments over the library.

mod allocator;
mod args;
mod bars;
mod compare;
mod compare_methods;
mod convert;
mod crosscheck;
mod errors;
mod frames;
mod inspect;
mod mask;
mod method;
mod online;
mod reconstruct;
mod replies;
mod results;
mod slice;
mod table;
mod targets;

use std::io::{self, Write};
use std::num::NonZero;
use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::ffi::threads;
use crate::output;
use crate::report::Report;
use crate::section::{Sections, Warning};
use crate::terminal;
use args::{Arguments, Command, ThreadsArgument};

pub use allocator::Allocator;

/// How many warnings are printed one by one.
const WARNINGS: usize = 8;

/// What Ctrl-C ends the program with, by the shells' convention.
const INTERRUPTED: i32 = 130;

/// Runs the program; exit status 0 when done, 1 when failed, 2 on wrong
/// usage.
pub fn run() -> ExitCode {
    let arguments = Arguments::parse();
    let command = &arguments.command;
    match start().and_then(|()| start_threads(command)).and_then(|()| dispatch(command)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::tell(&format!("error: {}", errors::line(&error)));
            ExitCode::FAILURE
        }
    }
}

fn dispatch(command: &Command) -> Result<()> {
    match command {
        Command::Reconstruct(arguments) => reconstruct::run(arguments),
        Command::Online(arguments) => online::run(arguments),
        Command::Slice(arguments) => slice::run(arguments),
        Command::Mask(arguments) => mask::run(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
        Command::CompareMethods(arguments) => compare_methods::run(arguments),
        Command::Crosscheck(arguments) => crosscheck::run(arguments),
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

/// Makes rayon and TBB use as many threads as a command asks for, but no more than can run at
/// once; all processors where it does not.
fn start_threads(command: &Command) -> Result<()> {
    let (threads, quiet) = match command {
        Command::Reconstruct(arguments) => (&arguments.threads, arguments.quiet),
        Command::Online(arguments) => (&arguments.threads, arguments.quiet),
        Command::CompareMethods(arguments) => (&arguments.threads, arguments.quiet),
        Command::Crosscheck(arguments) => (&arguments.threads, arguments.quiet),
        Command::Slice(_)
        | Command::Mask(_)
        | Command::Convert(_)
        | Command::Inspect(_)
        | Command::Compare(_) => (&ThreadsArgument { count: None }, true),
    };
    let most = std::thread::available_parallelism().map_or(usize::MAX, NonZero::get);
    let asked = threads.count.map(|count| count as usize);
    let count = asked.map(|asked| asked.min(most));
    if let Some(asked) = asked.filter(|&asked| asked > most && !quiet) {
        terminal::tell(&format!(
            "note: --threads asks for {asked}, and {most} can run at once: {most} are used"
        ));
    }
    // 0 leaves it to rayon.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(count.unwrap_or(0)).build_global();
    pool.map_err(|error| Error::Option(format!("threads cannot be started: {error}")))?;
    match count {
        Some(count) => {
            threads::limit_threads(count).map_err(|exception| Error::library("threads", &exception))
        }
        None => Ok(()),
    }
}

/// Prints a result to stdout, as JSON or as text. A reader that closes the
/// pipe has seen enough.
fn print<T: Serialize>(json: bool, value: &T, text: impl Fn(&T) -> String) -> Result<()> {
    let text = if json {
        serde_json::to_string_pretty(value)
            .map_err(|error| Error::Bug { stage: "output", what: error.to_string() })?
    } else {
        text(value)
    };
    match writeln!(io::stdout(), "{}", text.trim_end()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Option(format!("the result cannot be printed: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a report.
fn write_json<T: Serialize>(path: &Path, report: &T, out: &mut dyn Write) -> Result<()> {
    serde_json::to_writer_pretty(&mut *out, report)
        .map_err(io::Error::from)
        .and_then(|()| out.write_all(b"\n"))
        .map_err(|error| output::write_error(path, &error))
}

/// How files of sections were understood, what was doubtful about them, and left out.
fn print_warnings(sections: &Sections) {
    let all = sections.warnings.iter().map(|warning| ("warning", warning));
    let all = all.chain(sections.left_out.iter().map(|left_out| ("left out", left_out)));
    let all = sections.notes.iter().map(|note| ("note", note)).chain(all);
    print_first(all, "`transect inspect` lists them all");
}

/// What a result must be read with, and by which option that may be helped.
fn print_found(report: &Report) {
    let unlinked = report.unlinked();
    let with_option = |mut warning: Warning| {
        if unlinked.as_ref() == Some(&warning) {
            warning.what.push_str("; --link connects them");
        }
        warning
    };
    let warnings: Vec<Warning> = report.found().into_iter().map(with_option).collect();
    print_first(warnings.iter().map(|warning| ("warning", warning)), "--report lists them all");
}

fn print_first<'a>(
    all: impl Iterator<Item = (&'static str, &'a Warning)> + Clone,
    where_all_are: &str,
) {
    for (word, warning) in all.clone().take(WARNINGS) {
        match warning.section.as_str() {
            "" => tell_shortened(&format!("{word}: {}", warning.what)),
            section => tell_shortened(&format!("{word}: section {section}: {}", warning.what)),
        }
    }
    let rest = all.count().saturating_sub(WARNINGS);
    if rest > 0 {
        terminal::tell(&format!("warning: and {rest} more; {where_all_are}"));
    }
}

fn tell_shortened(message: &str) {
    terminal::tell(&terminal::shortened(message));
}
