//! What a program that sends sections is told: one JSON object a line, on standard output.

use std::io::{self, Write};
use std::path::Path;

use serde::Serialize;

use super::errors;
use crate::error::{Error, Result};
use crate::online::Resumed;
use crate::online::answer::Answer;
use crate::stage::Stage;

/// An answer to one command, file or start.
#[derive(Debug, Serialize)]
pub struct Reply<'a> {
    #[serde(flatten)]
    pub to: Cause<'a>,
    #[serde(flatten)]
    pub what: What<'a>,
    /// The frame that shows it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<&'a Path>,
}

/// What is answered.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Cause<'a> {
    /// The line of a command, counted from 1; 0 for the files to begin with.
    Line(u64),
    /// The name of a watched file.
    File(&'a str),
    /// The journal that is gone on with.
    Resumed(&'a Path),
}

/// The answer itself.
#[derive(Debug, Serialize)]
#[serde(untagged)]
pub enum What<'a> {
    /// A change was made, and is in the journal.
    Changed(Box<Answer>),
    /// A journal was read.
    Resumed(&'a Resumed),
    /// A file was written.
    Written { written: &'a Path, stages: &'a [Stage] },
    /// Nothing was done.
    Refused { error: String },
}

impl What<'_> {
    /// An error.
    pub fn refused(error: &Error) -> Self {
        Self::Refused { error: errors::line(error) }
    }
}

/// Answers at once.
///
/// # Errors
/// When nobody reads the answers: whoever sends sections is gone.
pub fn reply(reply: &Reply) -> Result<()> {
    let mut text = serde_json::to_string(reply)
        .map_err(|error| Error::Bug { stage: "output", what: error.to_string() })?;
    text.push('\n');
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes())
        .and_then(|()| out.flush())
        .map_err(|error| Error::Option(format!("the answer cannot be written: {error}")))
}
