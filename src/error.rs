//! The one error type. Every message says what is wrong and where, then what
//! to do about it.

use std::fmt;
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
    #[error("{what} would take about {} of memory, and {} are available",
            size(*needed), size(*available))]
    Memory {
        /// What would be built.
        what: String,
        /// Bytes it would take.
        needed: u64,
        /// Bytes there are.
        available: u64,
    },
    /// The GPU, or the way to it, failed.
    #[error("GPU: {0}; use the CPU")]
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
    /// An error that would not have been one with other options.
    #[error("{error}{remedy}")]
    Avoidable {
        /// The error.
        error: Box<Error>,
        /// What to ask for instead.
        remedy: Remedy,
    },
}

/// What to ask for instead: an option of the library, in plain words that follow what is
/// wrong. A program that has a name of its own for it may say that.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Remedy {
    /// Another [`Resolution`](crate::Resolution).
    CoarserLattice,
    /// A longer [`Fairing::edge_length`](crate::method::Fairing).
    LongerEdges,
    /// A larger size or distance in [`delaunay::Options`](crate::mesh::delaunay::Options).
    LargerTriangles,
    /// A larger [`MeanValue::spacing`](crate::MeanValue).
    LargerSpacing,
    /// No [`Rules::strict`](crate::Rules).
    NotStrict,
    /// A [`Rules::overlap`](crate::Rules).
    Overlap,
    /// Another [`Rules::unknown`](crate::Rules), or none.
    UnknownLabel,
    /// An [`ImageRules::spacing`](crate::section::ImageRules).
    ImageSpacing,
    /// One structure alone, or all made to exclude each other
    /// ([`Chosen`](crate::io::structures::Chosen)).
    Structures,
    /// Other [`VdbContents::grids`](crate::io::vdb::VdbContents).
    OtherGrids,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::CoarserLattice => "; use a lower resolution or larger voxels",
            Self::LongerEdges => "; use longer edges",
            Self::LargerTriangles => "; use a larger size or distance",
            Self::LargerSpacing => "; use a larger spacing",
            Self::NotStrict => " (an error because warnings are)",
            Self::Overlap => ", or say who wins",
            Self::UnknownLabel => "; give another label that means unknown, or none",
            Self::ImageSpacing => "; give the spacing",
            Self::Structures => ": choose one structure, or let them exclude each other",
            Self::OtherGrids => ", or leave the grid out",
        })
    }
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

    /// The same, with what to ask for instead.
    pub fn avoidable(self, remedy: Remedy) -> Self {
        Self::Avoidable { error: Box::new(self), remedy }
    }

    /// Another error, with the same to ask for instead.
    pub(crate) fn map(self, change: impl FnOnce(Self) -> Self) -> Self {
        match self {
            Self::Avoidable { error, remedy } => error.map(change).avoidable(remedy),
            own => change(own),
        }
    }

    /// An exception from C++.
    pub fn library(stage: &'static str, exception: &cxx::Exception) -> Self {
        Self::Library { stage, what: exception.what().to_owned() }
    }
}

fn size(bytes: u64) -> String {
    let gibibytes = bytes as f64 / (1u64 << 30) as f64;
    if gibibytes < 1.0 {
        format!("{:.0} MiB", 1024.0 * gibibytes)
    } else {
        format!("{gibibytes:.1} GiB")
    }
}
