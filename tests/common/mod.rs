//! What integration tests share.

use std::path::{Path, PathBuf};

/// A file or folder of the real inputs: in the folder named by `TRANSECT_DATA`,
/// else in `../shared/data`. Says *skipped* and returns `None` where it is
/// absent.
pub fn data(name: &str) -> Option<PathBuf> {
    let default = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let folder = std::env::var_os("TRANSECT_DATA").map_or_else(default, PathBuf::from);
    let path = folder.join(name);
    if path.exists() {
        return Some(path);
    }
    println!("skipped: {} is absent", path.display());
    None
}
