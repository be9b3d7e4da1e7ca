//! Tests that cannot run here say so, and are counted.

use std::fmt::Display;
use std::fs::OpenOptions;
use std::io::Write;

/// Says that a test, or a part of it, did not run, and why. Test runners hide that of tests that
/// pass, so it is also written to the file that `TRANSECT_SKIPPED` names, a line each.
pub fn skipped(why: impl Display) {
    println!("skipped: {why}");
    let Some(list) = std::env::var_os("TRANSECT_SKIPPED") else { return };
    let thread = std::thread::current();
    let line = format!("{}: {why}\n", thread.name().unwrap_or("a test"));
    let file = OpenOptions::new().create(true).append(true).open(&list);
    let written = file.and_then(|mut file| file.write_all(line.as_bytes()));
    written.unwrap_or_else(|error| panic!("cannot write {}: {error}", list.display()));
}
