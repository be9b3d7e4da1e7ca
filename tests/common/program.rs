//! The program as a user runs it.

#![allow(dead_code)] // every test uses a part of it

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use tempfile::TempDir;

/// The bundled example, coarse enough to be quick.
pub const COARSE: &[&str] = &["--resolution", "48"];

/// A file of this repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The bundled example.
pub fn phantom() -> PathBuf {
    repository("examples/phantom.json")
}

/// The program.
pub fn transect() -> Command {
    Command::new(env!("CARGO_BIN_EXE_transect"))
}

/// A folder that is removed at the end.
pub fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

/// Runs to the end.
pub fn run(command: &mut Command) -> Output {
    command.output().expect("the program runs")
}

/// What went to standard error.
pub fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Reconstructs the example into files of a folder.
pub fn reconstruct(folder: &Path, names: &[&str], more: &[&str]) -> Output {
    let mut command = transect();
    command.arg("reconstruct").arg(phantom()).args(COARSE).args(more);
    for name in names {
        command.arg("-o").arg(folder.join(name));
    }
    run(&mut command)
}

/// Exit status 0.
pub fn assert_done(output: &Output) {
    assert!(output.status.success(), "{}", stderr(output));
}

/// Exit status 1 and one line that begins with `error: ` and holds all words.
pub fn assert_refused(output: &Output, words: &[&str]) {
    let text = stderr(output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    let errors: Vec<&str> = text.lines().filter(|line| line.starts_with("error: ")).collect();
    assert_eq!(errors.len(), 1, "{text}");
    assert_eq!(text.lines().last(), Some(errors[0]));
    for word in words {
        assert!(errors[0].contains(word), "{word:?} is not in {text:?}");
    }
}

/// The names of the files in a folder, sorted.
pub fn entries(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("the folder can be read")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}
