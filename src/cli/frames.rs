//! The results of changes as numbered files: a sequence that can be played.

use std::fs;
use std::path::{Path, PathBuf};

use super::args::FrameKind;
use super::results::Results;
use super::targets::Target;
use crate::error::{Error, Result};
use crate::output::{Outputs, write_error};

/// What the names of all frames begin with.
const PREFIX: &str = "frame_";

/// A folder of frames.
pub struct Frames {
    folder: PathBuf,
    ending: &'static str,
}

impl Frames {
    /// A folder, which is made where there is none.
    ///
    /// # Errors
    /// When it cannot be made, and unless `goes_on` when frames are there that this run does
    /// not write.
    pub fn new(folder: &Path, kind: FrameKind, goes_on: bool) -> Result<Self> {
        fs::create_dir_all(folder).map_err(|error| write_error(folder, &error))?;
        let entries = fs::read_dir(folder).map_err(|error| write_error(folder, &error))?;
        let mut names = entries.flatten().map(|entry| entry.file_name());
        if !goes_on && names.any(|name| name.to_string_lossy().starts_with(PREFIX)) {
            let what = "there are frames in it already: remove them, or name another folder";
            return Err(Error::file(folder, what));
        }
        let ending = match kind {
            FrameKind::Ply => "ply",
            FrameKind::Vdb => "vdb",
        };
        Ok(Self { folder: folder.to_owned(), ending })
    }

    /// Writes the frame of a change, whole or not at all.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, number: u64, results: &Results) -> Result<PathBuf> {
        let path = self.folder.join(format!("{PREFIX}{number:06}.{}", self.ending));
        let mut outputs = Outputs::reserve([path.as_path()])?;
        results.write(&mut outputs, &Target::new(&path)?)?;
        outputs.commit()?;
        Ok(path)
    }
}
