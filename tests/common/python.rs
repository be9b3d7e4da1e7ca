//! Programs of others, by way of the scripts in `tests/clients`. Python is the one that
//! `TRANSECT_PYTHON` names, or that of `target/clients-venv`, where `./x test` puts what
//! `requirements.txt` lists.

use std::path::PathBuf;
use std::process::Command;

use serde::de::DeserializeOwned;

use crate::program::{repository, run, stderr};
use crate::skipped;

/// A script of `tests/clients`.
pub fn script(name: &str) -> PathBuf {
    repository("tests/clients").join(name)
}

/// Python with modules; says so when there is none.
pub fn python(modules: &str) -> Option<PathBuf> {
    let own = repository("target/clients-venv/bin/python");
    let given = std::env::var_os("TRANSECT_PYTHON").map(PathBuf::from);
    let python = given.unwrap_or_else(|| if own.exists() { own } else { "python3".into() });
    let imports = format!("import numpy, {modules}");
    match Command::new(&python).args(["-c", &imports]).output() {
        Ok(output) if output.status.success() => Some(python),
        _ => {
            skipped::skipped(format_args!("{} has no module {modules}", python.display()));
            None
        }
    }
}

/// What a script found: what it prints on a line of its own.
pub fn result<T: DeserializeOwned>(command: &mut Command) -> T {
    let output = run(command);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", stderr(&output));
    let result = text.lines().find_map(|line| line.strip_prefix("RESULT "));
    let result = result.unwrap_or_else(|| panic!("no result: {text}{}", stderr(&output)));
    serde_json::from_str(result).expect("what was found")
}
