//! Output files appear whole or not at all.
//!
//! Every file is first written beside its destination under a temporary name;
//! [`Outputs::commit`] renames them all once the last one is complete, and takes
//! back what it renamed if one of them cannot be. What is not a regular file (a
//! device, a pipe) cannot be renamed onto: its content is copied there, before
//! the others are renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use tempfile::{Builder, NamedTempFile, TempPath};

use crate::error::{Error, Result};

/// Temporary files that an interrupted program has to remove.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Held while files appear: an interrupt comes before all of them or after.
static APPEARING: Mutex<()> = Mutex::new(());

/// Removes the temporary files of every [`Outputs`] of the program; for a
/// handler of Ctrl-C, after which the program must end.
pub fn remove_temporary_files() {
    // No more files appear until the program has ended.
    std::mem::forget(APPEARING.lock());
    if let Ok(paths) = TEMPORARY.lock() {
        remove(&paths);
    }
}

/// The same without waiting for files that are just appearing, from any place in the program.
pub fn remove_temporary_files_without_waiting() {
    if let Ok(paths) = TEMPORARY.try_lock() {
        remove(&paths);
    }
}

fn remove(paths: &[PathBuf]) {
    for path in paths {
        // The program is ending: there is nobody left to tell.
        let _ = fs::remove_file(path);
    }
}

/// Files that will appear together.
#[derive(Debug, Default)]
pub struct Outputs {
    files: Vec<Output>,
}

#[derive(Debug)]
struct Output {
    /// As the user named it.
    path: PathBuf,
    /// Where the content goes: `path` with symbolic links followed.
    target: PathBuf,
    /// Whether `target` is a device or a pipe.
    special: bool,
    /// The folder that is made for it, if it is not there.
    new_folder: Option<PathBuf>,
    temporary: NamedTempFile,
    /// Dropped after the file itself.
    _listed: Listed,
}

/// A temporary file in the list of those to remove, for as long as it is there: a program
/// that writes files for hours lists no more of them than there are.
#[derive(Debug)]
struct Listed(PathBuf);

impl Listed {
    fn new(path: &Path) -> Self {
        if let Ok(mut paths) = TEMPORARY.lock() {
            paths.push(path.to_owned());
        }
        Self(path.to_owned())
    }
}

impl Drop for Listed {
    fn drop(&mut self) {
        if let Ok(mut paths) = TEMPORARY.lock() {
            paths.retain(|path| *path != self.0);
        }
    }
}

impl Outputs {
    /// Makes sure that every file can be written, before any work is done.
    ///
    /// # Errors
    /// When a folder is missing or not writable, a path is a folder, or a
    /// path is named twice.
    pub fn reserve<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Result<Self> {
        let mut outputs = Self::default();
        for path in paths {
            outputs.add(path)?;
        }
        Ok(outputs)
    }

    /// Makes sure that one more file can be written.
    ///
    /// # Errors
    /// As [`Outputs::reserve`].
    pub fn add(&mut self, path: &Path) -> Result<()> {
        self.push(Output::reserve(path, None)?)
    }

    /// The same for a file whose folder appears with it, if it is not there.
    ///
    /// # Errors
    /// As [`Outputs::reserve`].
    pub fn add_with_folder(&mut self, path: &Path) -> Result<()> {
        let folder = folder_of(path);
        let is_there = fs::metadata(&folder).is_ok();
        self.push(Output::reserve(path, (!is_there).then_some(folder))?)
    }

    fn push(&mut self, output: Output) -> Result<()> {
        let path = &output.path;
        if self.files.iter().any(|other| other.target == output.target && !output.special) {
            return Err(Error::file(path, "is named twice as an output"));
        }
        self.files.push(output);
        Ok(())
    }

    /// Writes the content of a reserved file through a buffer.
    ///
    /// # Errors
    /// When the content cannot be made or written.
    pub fn write(
        &mut self,
        path: &Path,
        content: impl FnOnce(&mut dyn Write) -> Result<()>,
    ) -> Result<()> {
        self.write_at(path, |temporary| {
            let file = File::create(temporary).map_err(|error| write_error(path, &error))?;
            let mut writer = BufWriter::with_capacity(1 << 20, file);
            content(&mut writer)?;
            writer.flush().map_err(|error| write_error(path, &error))
        })
    }

    /// Writes the content of a reserved file by the path of its temporary
    /// file, for libraries that open files themselves.
    ///
    /// # Errors
    /// When the content cannot be made or written.
    pub fn write_at<T>(
        &mut self,
        path: &Path,
        content: impl FnOnce(&Path) -> Result<T>,
    ) -> Result<T> {
        let output = self.files.iter().find(|output| output.path == path).ok_or_else(|| {
            Error::Bug { stage: "output", what: format!("{} was not reserved", path.display()) }
        })?;
        let temporary = output.temporary.path();
        content(temporary).map_err(|error| match error {
            Error::File { file, what } if file == temporary => Error::file(path, what),
            other => other,
        })
    }

    /// Lets all files appear, or none.
    ///
    /// # Errors
    /// When a device takes no more or a file cannot be renamed.
    pub fn commit(self) -> Result<()> {
        let (special, regular): (Vec<_>, Vec<_>) =
            self.files.into_iter().partition(|output| output.special);
        for output in special {
            output.copy()?;
        }
        let _appearing = APPEARING.lock();
        let is_alone = regular.len() == 1;
        let mut moved = Vec::with_capacity(regular.len());
        for output in regular {
            match output.rename(is_alone) {
                Ok(made) => moved.push(made),
                Err(error) => {
                    moved.into_iter().rev().for_each(Moved::undo);
                    return Err(error);
                }
            }
        }
        Ok(())
    }
}

impl Output {
    fn reserve(path: &Path, new_folder: Option<PathBuf>) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let special = match fs::metadata(&target) {
            Ok(about) if about.is_dir() => {
                return Err(Error::file(path, "is a folder; name a file in it"));
            }
            Ok(about) => !about.is_file(),
            Err(error) if error.kind() == io::ErrorKind::NotFound => false,
            // It could not be renamed to either: its name is too long, for one.
            Err(error) => return Err(write_error(path, &error)),
        };
        let folder = match &new_folder {
            _ if special => std::env::temp_dir(),
            Some(folder) => folder_of(folder),
            None => folder_of(&target),
        };
        let temporary = new_file(&folder).map_err(|error| write_error(path, &error))?;
        let listed = Listed::new(temporary.path());
        let path = path.to_owned();
        Ok(Self { path, target, special, new_folder, temporary, _listed: listed })
    }

    fn copy(self) -> Result<()> {
        let copied = File::open(self.temporary.path()).and_then(|mut content| {
            let mut device = fs::OpenOptions::new().write(true).open(&self.target)?;
            io::copy(&mut content, &mut device)?;
            device.flush()
        });
        copied.map_err(|error| write_error(&self.path, &error))
    }

    /// Puts the file in its place; what was there is kept aside unless it is the only one.
    fn rename(self, is_alone: bool) -> Result<Moved> {
        let Self { path, target, new_folder, temporary, .. } = self;
        let failed = |error| write_error(&path, &error);
        // It may have appeared with another file.
        let folder = new_folder.filter(|folder| !folder.is_dir());
        if let Some(folder) = &folder {
            fs::create_dir(folder).map_err(failed)?;
        }
        let is_there = fs::metadata(&target).is_ok_and(|about| about.is_file());
        let old = match is_there && !is_alone {
            true => Some(kept_aside(&target).map_err(failed)?),
            false => None,
        };
        match (temporary.persist(&target), old) {
            (Ok(_), old) => Ok(Moved { target, old, folder }),
            (Err(error), None) => {
                folder.iter().for_each(|folder| drop(fs::remove_dir(folder)));
                Err(failed(error.error))
            }
            (Err(error), old) => {
                Moved { target, old, folder }.undo();
                Err(failed(error.error))
            }
        }
    }
}

/// A file that has appeared.
struct Moved {
    target: PathBuf,
    /// What was there before; removed when it is dropped.
    old: Option<TempPath>,
    /// The folder that was made for it.
    folder: Option<PathBuf>,
}

impl Moved {
    /// As if nothing had been written, as far as possible.
    fn undo(self) {
        // There is an error to tell already.
        match self.old {
            Some(old) => drop(old.persist(&self.target)),
            None => drop(fs::remove_file(&self.target)),
        }
        if let Some(folder) = self.folder {
            let _ = fs::remove_dir(folder);
        }
    }
}

/// A file under another name beside it: under both where the system can do that, so that there
/// is no moment without it.
fn kept_aside(target: &Path) -> io::Result<TempPath> {
    let folder = folder_of(target);
    let second = builder().make_in(&folder, |path| fs::hard_link(target, path));
    let old = second.or_else(|_| builder().make_in(&folder, |path| fs::rename(target, path)));
    old.map(NamedTempFile::into_temp_path).map_err(without_path)
}

/// An ordinary file's permissions, less what the umask takes.
fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = builder();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(without_path)
}

/// Files that are not there for long.
fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(".transect-").suffix(".part");
    builder
}

/// An error that does not name a temporary file, which means nothing to a user.
fn without_path(error: io::Error) -> io::Error {
    io::Error::from(error.kind())
}

pub(crate) fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// What went wrong while writing, and what to do about it.
pub fn write_error(path: &Path, error: &io::Error) -> Error {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => "the folder does not exist; make it first",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "the folder cannot be written to; choose another"
        }
        io::ErrorKind::StorageFull => "the disk is full; nothing was written",
        io::ErrorKind::NotADirectory => "a part of the path is a file, not a folder",
        io::ErrorKind::InvalidFilename => "the name is too long; choose a shorter one",
        _ => "it cannot be written",
    };
    Error::file(path, format!("{hint} ({error})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(folder: &Path, names: &[&str]) -> Outputs {
        let paths: Vec<PathBuf> = names.iter().map(|name| folder.join(name)).collect();
        let mut outputs = Outputs::reserve(paths.iter().map(PathBuf::as_path)).unwrap();
        for path in &paths {
            outputs.write(path, |out| out.write_all(b"new").map_err(|_| Error::Cancelled)).unwrap();
        }
        outputs
    }

    fn content(folder: &Path) -> Vec<(String, String)> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let read = |path: PathBuf| {
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, fs::read_to_string(&path).unwrap_or_else(|_| "a folder".to_owned()))
        };
        let mut all: Vec<(String, String)> = entries.map(read).collect();
        all.sort();
        all
    }

    fn files(all: &[(&str, &str)]) -> Vec<(String, String)> {
        all.iter().map(|&(name, text)| (name.to_owned(), text.to_owned())).collect()
    }

    #[test]
    fn all_files_appear_or_none() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a"), "old").unwrap();
        let outputs = written(folder.path(), &["a", "b", "c"]);
        // What makes the last one impossible comes after it was reserved.
        fs::create_dir(folder.path().join("c")).unwrap();
        let error = outputs.commit().unwrap_err().to_string();
        assert!(error.contains("c: ") && !error.contains(".part"), "{error}");
        assert_eq!(content(folder.path()), files(&[("a", "old"), ("c", "a folder")]));
        fs::remove_dir(folder.path().join("c")).unwrap();
        written(folder.path(), &["a", "b", "c"]).commit().unwrap();
        assert_eq!(content(folder.path()), files(&[("a", "new"), ("b", "new"), ("c", "new")]));
    }

    #[test]
    fn a_folder_appears_with_its_files_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["b/1", "b/2", "c"].map(|name| folder.path().join(name));
        let reserved = || {
            let mut outputs = Outputs::default();
            paths[..2].iter().for_each(|path| outputs.add_with_folder(path).unwrap());
            outputs.add(&paths[2]).unwrap();
            outputs
        };
        let outputs = reserved();
        assert!(!folder.path().join("b").exists());
        fs::create_dir(&paths[2]).unwrap();
        outputs.commit().unwrap_err();
        assert_eq!(content(folder.path()), files(&[("c", "a folder")]));
        fs::remove_dir(&paths[2]).unwrap();
        reserved().commit().unwrap();
        assert_eq!(content(&folder.path().join("b")), files(&[("1", ""), ("2", "")]));
        // Then it is there, and nothing of the next time is elsewhere.
        let outputs = reserved();
        assert_eq!(content(&folder.path().join("b")).len(), 4);
        drop(outputs);
        assert_eq!(content(&folder.path().join("b")).len(), 2);
    }

    #[test]
    fn names_that_cannot_be_are_refused_at_once_without_a_temporary_name() {
        let folder = tempfile::tempdir().unwrap();
        let error = |path: &Path| Outputs::reserve([path]).unwrap_err().to_string();
        let long = error(&folder.path().join("x".repeat(300)));
        assert!(long.contains("too long"), "{long}");
        let missing = error(&folder.path().join("missing/a"));
        assert!(missing.contains("does not exist") && !missing.contains(".part"), "{missing}");
    }
}
