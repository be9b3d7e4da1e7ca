//! The one error type. Every message says what is wrong and where, then what
//! to do about it.

use std::path::{Path, PathBuf};

/// Why something could not be done.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be opened, read or written.
    #[error("{}: {what}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// The operating system's words, and what to do.
        what: String,
    },
    /// The content of a file is not what its kind promises.
    #[error("{}: {place}: {what}", file.display())]
    Input {
        /// The file.
        file: PathBuf,
        /// The section, line or vertex.
        place: String,
        /// What is wrong there, and what to do.
        what: String,
    },
    /// A section breaks a rule of [`Section`](crate::section::Section).
    #[error("section {section}: {what}")]
    Section {
        /// The section's name.
        section: String,
        /// What is wrong, where, and what to do.
        what: String,
    },
    /// A mesh is not what an operation needs.
    #[error("the mesh {0}")]
    Mesh(String),
    /// An option has no meaning here.
    #[error("{0}")]
    Option(String),
    /// The result would not fit into memory.
    #[error("{what} would take about {} of memory, and {} are available: {hint}",
            gibibytes(*needed), gibibytes(*available))]
    Memory {
        /// What would be built.
        what: String,
        /// Bytes it would take.
        needed: u64,
        /// Bytes there are.
        available: u64,
        /// What to do.
        hint: String,
    },
    /// The GPU, or the way to it, failed.
    #[error("GPU: {0}")]
    Device(String),
    /// [`Progress::is_cancelled`](crate::progress::Progress::is_cancelled) said so.
    #[error("cancelled")]
    Cancelled,
    /// A C++ library gave up.
    #[error("{stage}: {what}")]
    Library {
        /// The stage that called it.
        stage: &'static str,
        /// The library's words.
        what: String,
    },
    /// A check of our own that must always hold did not: a bug in transect.
    #[error("{stage}: {what} (this is a bug in transect)")]
    Bug {
        /// The stage.
        stage: &'static str,
        /// What did not hold.
        what: String,
    },
}

/// The result of anything that can fail.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// A failed operation on a file.
    pub fn file(file: &Path, what: impl ToString) -> Self {
        Self::File { file: file.to_owned(), what: what.to_string() }
    }

    /// Wrong content of a file, at a place.
    pub fn input(file: &Path, place: impl ToString, what: impl ToString) -> Self {
        Self::Input { file: file.to_owned(), place: place.to_string(), what: what.to_string() }
    }

    /// An exception from C++.
    pub fn library(stage: &'static str, exception: &cxx::Exception) -> Self {
        Self::Library { stage, what: exception.what().to_owned() }
    }
}

fn gibibytes(bytes: u64) -> String {
    format!("{:.1} GiB", bytes as f64 / (1u64 << 30) as f64)
}
