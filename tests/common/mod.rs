//! What the integration tests share.

mod skipped;

use std::path::{Path, PathBuf};

pub use skipped::skipped;

/// A file of our own (`tests/anatomy` makes them), or else of real data, in the folder that
/// `TRANSECT_DATA` names; says so when it is absent.
pub fn data(name: &str) -> Option<PathBuf> {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR"));
    let own = repository.join("tests/data").join(name);
    if own.exists() {
        return Some(own);
    }
    let folder = std::env::var_os("TRANSECT_DATA")
        .map_or_else(|| repository.join("../shared/data"), PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        Some(path)
    } else {
        skipped(format_args!("{} is absent", path.display()));
        None
    }
}
