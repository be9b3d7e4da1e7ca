//! Output files appear whole or not at all.
//!
//! Every file is first written beside its destination under a temporary name;
//! [`Outputs::commit`] renames them all once the last one is complete. What is
//! not a regular file (a device, a pipe) cannot be renamed onto: its content
//! is copied there, before the others are renamed.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use tempfile::{Builder, NamedTempFile};

use crate::error::{Error, Result};

/// Temporary files that an interrupted program has to remove.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Removes the temporary files of every [`Outputs`] of the program; for a
/// handler of Ctrl-C, after which the program must end.
pub fn remove_temporary_files() {
    if let Ok(paths) = TEMPORARY.lock() {
        for path in paths.iter() {
            // The program is ending: there is nobody left to tell.
            let _ = fs::remove_file(path);
        }
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
        let output = Output::reserve(path)?;
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
    pub fn write_at(
        &mut self,
        path: &Path,
        content: impl FnOnce(&Path) -> Result<()>,
    ) -> Result<()> {
        let output = self.files.iter().find(|output| output.path == path).ok_or_else(|| {
            Error::Bug { stage: "output", what: format!("{} was not reserved", path.display()) }
        })?;
        let temporary = output.temporary.path();
        content(temporary).map_err(|error| match error {
            Error::File { file, what } if file == temporary => Error::file(path, what),
            other => other,
        })
    }

    /// Lets all files appear.
    ///
    /// # Errors
    /// When a device takes no more or a file cannot be renamed.
    pub fn commit(self) -> Result<()> {
        let (special, regular): (Vec<_>, Vec<_>) =
            self.files.into_iter().partition(|output| output.special);
        for output in special {
            output.copy()?;
        }
        regular.into_iter().try_for_each(Output::rename)
    }
}

impl Output {
    fn reserve(path: &Path) -> Result<Self> {
        let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        let kind = fs::metadata(&target).map(|metadata| metadata.file_type());
        if kind.as_ref().is_ok_and(|kind| kind.is_dir()) {
            return Err(Error::file(path, "is a folder; name a file in it"));
        }
        let special = kind.is_ok_and(|kind| !kind.is_file());
        let folder = if special { std::env::temp_dir() } else { folder_of(&target) };
        let temporary = new_file(&folder).map_err(|error| write_error(path, &error))?;
        let listed = Listed::new(temporary.path());
        Ok(Self { path: path.to_owned(), target, special, temporary, _listed: listed })
    }

    fn copy(self) -> Result<()> {
        let copied = File::open(self.temporary.path()).and_then(|mut content| {
            let mut device = fs::OpenOptions::new().write(true).open(&self.target)?;
            io::copy(&mut content, &mut device)?;
            device.flush()
        });
        copied.map_err(|error| write_error(&self.path, &error))
    }

    fn rename(self) -> Result<()> {
        match self.temporary.persist(&self.target) {
            Ok(_) => Ok(()),
            Err(error) => Err(write_error(&self.path, &error.error)),
        }
    }
}

/// An ordinary file's permissions, less what the umask takes.
fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = Builder::new();
    builder.prefix(".transect-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
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
        _ => "it cannot be written",
    };
    Error::file(path, format!("{hint} ({error})"))
}
