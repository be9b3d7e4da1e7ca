//! A folder into which files of sections come, in which they change and from which they go.
//!
//! The folder is looked at again and again. That works everywhere, on network drives too,
//! and a listing takes less than a millisecond. A file is read once its size and time stay the
//! same for a while; one that cannot be read then may still be being written, and is told of
//! when it has stayed the same for longer.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

use super::command::{Edit, Replacement};
use crate::change::SectionId;
use crate::error::{Error, Result};
use crate::model::Model;
use crate::section::{Section, Sections};

/// How long a file must have stayed the same before it is read.
const SETTLED: Duration = Duration::from_millis(150);
/// How long a file must have stayed the same before it is told that it cannot be read.
const PATIENCE: Duration = Duration::from_secs(1);
/// What names of sections from the folder begin with, so that after a crash it is known which
/// file each is from: `watched/FILE/NAME`.
const PREFIX: &str = "watched/";

/// The files of a folder, as far as they are known.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    files: BTreeMap<String, Known>,
}

/// What is known of a file.
#[derive(Debug)]
struct Known {
    /// None when it is gone.
    stamp: Option<Stamp>,
    /// Since when it has been so.
    since: Instant,
    /// Whether the model has followed, or was told why it cannot.
    is_done: bool,
    /// Why it was refused.
    refused: Option<String>,
}

/// What changes when a file does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
}

/// A file that is to be looked at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found {
    /// Its name in the folder.
    pub name: String,
    /// Where it is; `None` when it is gone.
    pub path: Option<PathBuf>,
}

impl Folder {
    /// A folder, and what a model holds of its files.
    ///
    /// # Errors
    /// When it cannot be listed.
    pub fn new(path: &Path, model: &Model) -> Result<Self> {
        let mut folder = Self { path: path.to_owned(), files: BTreeMap::new() };
        folder.list()?;
        for (_, section) in model.given() {
            if let Some(file) = file_of(section.name()) {
                folder.files.insert(file.to_owned(), Known::new(None, Instant::now()));
            }
        }
        Ok(folder)
    }

    /// The files that changed since they were looked at last, and have settled: those that
    /// are gone first, then by name.
    ///
    /// # Errors
    /// When the folder cannot be listed.
    pub fn look(&mut self) -> Result<Vec<Found>> {
        let (there, now) = (self.list()?, Instant::now());
        for (name, known) in &mut self.files {
            known.be(there.get(name).copied(), now);
        }
        for (name, stamp) in there {
            self.files.entry(name).or_insert_with(|| Known::new(Some(stamp), now));
        }
        let ready = self.files.iter().filter(|(_, known)| known.is_ready(now));
        let mut found: Vec<Found> = ready
            .map(|(name, known)| Found {
                name: name.clone(),
                path: known.stamp.map(|_| self.path.join(name)),
            })
            .collect();
        found.sort_by_key(|file| file.path.is_some());
        Ok(found)
    }

    /// Whether nothing that is known of is left to be looked at.
    pub fn is_settled(&self) -> bool {
        self.files.values().all(|known| known.is_done)
    }

    /// The files that may hold sections. Names that begin with a dot or end in another way
    /// are somebody's temporary files.
    fn list(&self) -> Result<BTreeMap<String, Stamp>> {
        let failed =
            |error| Error::file(&self.path, format!("the folder cannot be watched: {error}"));
        let mut files = BTreeMap::new();
        for entry in fs::read_dir(&self.path).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            // A name that is no UTF-8 is not found again under what is left of it, which is told.
            let Some(name) = path.file_name().map(|name| name.to_string_lossy()) else { continue };
            if name.starts_with('.') || !is_kind(&name) {
                continue;
            }
            // It may be gone by now.
            let Ok(about) = fs::metadata(&path) else { continue };
            if about.is_file() {
                let stamp = Stamp { length: about.len(), modified: about.modified().ok() };
                files.insert(name.into_owned(), stamp);
            }
        }
        Ok(files)
    }

    /// The model has followed a file; those that were refused may fit by now.
    pub fn accept(&mut self, name: &str) {
        self.settle(name);
        for known in self.files.values_mut().filter(|known| known.refused.is_some()) {
            known.is_done = false;
        }
    }

    /// The model is what a file says.
    pub fn settle(&mut self, name: &str) {
        match self.files.get_mut(name) {
            Some(Known { stamp: None, .. }) => drop(self.files.remove(name)),
            Some(known) => (known.is_done, known.refused) = (true, None),
            None => (),
        }
    }

    /// The model cannot follow a file. Returns whether that is to be told: it has not been
    /// told yet, and the file is not likely to be half-written.
    pub fn refuse(&mut self, name: &str, why: &Refusal) -> bool {
        let Some(known) = self.files.get_mut(name) else { return true };
        let (why, may_be_unfinished) = match why {
            Refusal::Unread(error) => (error.to_string(), known.since.elapsed() < PATIENCE),
            Refusal::Unfit(error) => (error.to_string(), false),
        };
        if may_be_unfinished {
            return false;
        }
        known.is_done = true;
        let is_new = known.refused.as_ref() != Some(&why);
        known.refused = Some(why);
        is_new
    }
}

/// Why the model does not follow a file.
#[derive(Debug, Clone, PartialEq)]
pub enum Refusal {
    /// The file cannot be read.
    Unread(Error),
    /// Its sections do not fit the others.
    Unfit(Error),
}

impl Known {
    fn new(stamp: Option<Stamp>, since: Instant) -> Self {
        Self { stamp, since, is_done: false, refused: None }
    }

    fn be(&mut self, stamp: Option<Stamp>, now: Instant) {
        if self.stamp != stamp {
            *self = Self { refused: self.refused.take(), ..Self::new(stamp, now) };
        }
    }

    fn is_ready(&self, now: Instant) -> bool {
        !self.is_done && now.duration_since(self.since) >= SETTLED
    }
}

fn is_kind(name: &str) -> bool {
    let ending = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ["csl", "contour", "json"].contains(&ending.as_str())
}

/// The file that a section is from, by its name; no file has a slash in its own.
fn file_of(section: &str) -> Option<&str> {
    section.strip_prefix(PREFIX)?.split_once('/').map(|(file, _)| file)
}

/// What must be done to a model for its sections of a file to be these, if anything; sections
/// that are there keep their numbers.
pub fn edit(model: &Model, file: &str, sections: Option<Sections>) -> Option<Edit> {
    let mut edits = Vec::new();
    let own = model.given().filter(|(_, section)| file_of(section.name()) == Some(file));
    let mut old: Vec<(SectionId, &Section)> = own.collect();
    if let Some(mut sections) = sections {
        sections.begin_names(&format!("{PREFIX}{file}/"));
        let mut added = Vec::new();
        for section in std::mem::take(&mut sections.sections) {
            match old.iter().position(|(_, known)| known.name() == section.name()) {
                Some(place) => {
                    let (id, known) = old.remove(place);
                    if *known != section {
                        edits.push(Edit::Replace(id, Replacement::of(section, &sections)));
                    }
                }
                None => added.push(section),
            }
        }
        if !added.is_empty() {
            edits.push(Edit::Add(Sections { sections: added, ..sections }));
        }
    }
    edits.extend(old.into_iter().map(|(id, _)| Edit::Remove(id)));
    match edits.len() {
        0 => None,
        1 => edits.pop(),
        _ => Some(Edit::All(edits)),
    }
}
