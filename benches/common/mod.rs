//! What benchmarks share.

use std::path::{Path, PathBuf};

/// The bundled example, and those real files that sections are added to.
pub fn files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("TRANSECT_DATA")
        .map_or_else(|| root.join("../shared/data"), PathBuf::from);
    let mut files = vec![root.join("examples/phantom.json")];
    for name in ["Elephant", "Heart-25-even-better", "Vetebrae", "Abdomen"] {
        let file = data.join("csl").join(name).with_extension("csl");
        match file.exists() {
            true => files.push(file),
            false => println!("skipped: {} is absent", file.display()),
        }
    }
    files
}

/// What a file is called.
pub fn name(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The one in the middle; of none 0.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
