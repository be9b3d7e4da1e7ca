//! What can be asked of a model whose sections come one by one: a command is one JSON value
//! on one line (docs/online.md).
//!
//! A journal holds the same lines, with the sections themselves in place of files' names.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use crate::change::{Change, SectionId};
use crate::error::{Error, Result};
use crate::io::{json, read_part};
use crate::section::{Findings, Rules, Section, Sections};

/// A command, understood, with its sections read.
#[derive(Debug, Clone)]
pub enum Command {
    /// The model changes.
    Act(Act),
    /// The whole result goes to a file, its kind given by its name.
    Save(PathBuf),
    /// The report goes to a file.
    Report(PathBuf),
}

/// What changes the model.
#[derive(Debug, Clone)]
pub enum Act {
    /// Sections come, go, or are replaced.
    Edit(Box<Edit>),
    /// The last change that was not taken back yet is taken back.
    Undo,
}

/// A change, with what its sections' files say besides the sections.
#[derive(Debug, Clone)]
pub enum Edit {
    /// Sections join those that are there.
    Add(Sections),
    /// One section takes the place of another.
    Replace(SectionId, Replacement),
    /// A section goes.
    Remove(SectionId),
    /// All of them, or none.
    All(Vec<Edit>),
}

/// The one section of a file.
#[derive(Debug, Clone)]
pub struct Replacement {
    section: Section,
    /// What the file says besides: no sections.
    about: Sections,
}

/// A command as it is written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum Line {
    Add(Box<RawValue>),
    Replace { id: u64, with: Box<RawValue> },
    Remove(u64),
    All(Vec<Line>),
    Undo,
    Save(PathBuf),
    Report(PathBuf),
}

/// Reads a command; `place` stands for a file's name in errors about sections that are in the
/// line itself.
///
/// # Errors
/// When the text is no command, and when its sections break a rule.
pub fn parse(text: &str, place: &Path, rules: &Rules) -> Result<Command> {
    let line: Line = serde_json::from_str(text).map_err(|error| {
        let what = error.to_string();
        // There is one line, and the answer tells which.
        let what = what.replace(" at line 1 column ", " at column ");
        Error::Option(format!("this is no command: {what}; docs/online.md says what there is"))
    })?;
    Ok(match line {
        Line::Undo => Command::Act(Act::Undo),
        Line::Save(path) => Command::Save(path),
        Line::Report(path) => Command::Report(path),
        line => Command::Act(Act::Edit(Box::new(line.edit(place, rules)?))),
    })
}

impl Line {
    fn edit(self, place: &Path, rules: &Rules) -> Result<Edit> {
        Ok(match self {
            Self::Add(source) => Edit::Add(read(&source, place, rules)?),
            Self::Replace { id, with } => {
                let replacement = Replacement::new(read(&with, place, rules)?)?;
                Edit::Replace(SectionId(id), replacement)
            }
            Self::Remove(id) => Edit::Remove(SectionId(id)),
            Self::All(lines) => {
                let edits = lines.into_iter().map(|line| line.edit(place, rules));
                Edit::All(edits.collect::<Result<_>>()?)
            }
            Self::Undo | Self::Save(_) | Self::Report(_) => {
                let what = "\"all\" takes add, replace, remove and all: the others stand alone";
                return Err(Error::Option(what.to_owned()));
            }
        })
    }
}

/// The sections of a file that is named, or those written here.
fn read(source: &RawValue, place: &Path, rules: &Rules) -> Result<Sections> {
    match serde_json::from_str::<PathBuf>(source.get()) {
        Ok(path) => read_part(&path, rules),
        Err(_) if source.get().starts_with('{') => json::read(source.get(), place, rules),
        Err(_) => {
            let what = "sections are given as a file's name, or as what a .json file of them holds";
            Err(Error::Option(what.to_owned()))
        }
    }
}

impl Replacement {
    /// Refuses all but one section.
    fn new(mut about: Sections) -> Result<Self> {
        match <[Section; 1]>::try_from(std::mem::take(&mut about.sections)) {
            Ok([section]) => Ok(Self { section, about }),
            Err(sections) => Err(Error::Option(format!(
                "\"replace\" needs one section, and here are {}",
                sections.len()
            ))),
        }
    }

    /// Of a section of a file.
    pub fn of(section: Section, file: &Sections) -> Self {
        let about = Sections { sections: Vec::new(), ..file.clone() };
        Self { section, about }
    }
}

impl Act {
    /// As a line, the sections in it.
    ///
    /// # Errors
    /// When a number has no JSON.
    pub fn text(&self) -> Result<String> {
        let line = match self {
            Self::Edit(edit) => edit.line()?,
            Self::Undo => Line::Undo,
        };
        serde_json::to_string(&line).map_err(unwritable)
    }
}

fn unwritable(error: serde_json::Error) -> Error {
    Error::Bug { stage: "journal", what: error.to_string() }
}

impl Edit {
    fn line(&self) -> Result<Line> {
        Ok(match self {
            Self::Add(sections) => Line::Add(raw(sections)?),
            Self::Replace(id, Replacement { section, about }) => {
                let sections = Sections { sections: vec![section.clone()], ..about.clone() };
                Line::Replace { id: id.0, with: raw(&sections)? }
            }
            Self::Remove(id) => Line::Remove(id.0),
            Self::All(edits) => Line::All(edits.iter().map(Self::line).collect::<Result<_>>()?),
        })
    }

    /// What was doubtful about the sections and what was left out, and no longer stands in
    /// them: it is told once.
    pub fn take_findings(&mut self) -> Findings {
        let mut findings = Findings::default();
        match self {
            Self::Add(about) | Self::Replace(_, Replacement { about, .. }) => {
                findings.warnings = std::mem::take(&mut about.warnings);
                findings.left_out = std::mem::take(&mut about.left_out);
                about.files.clear();
            }
            Self::Remove(_) => (),
            Self::All(edits) => {
                edits.iter_mut().for_each(|edit| findings.append(edit.take_findings()));
            }
        }
        findings
    }
}

impl From<Edit> for Change {
    fn from(edit: Edit) -> Self {
        match edit {
            Edit::Add(sections) => Self::Add(sections),
            // Units and names of materials are learned as from sections that are added.
            Edit::Replace(id, Replacement { section, about }) => {
                Self::All(vec![Self::Add(about), Self::Replace(id, section)])
            }
            Edit::Remove(id) => Self::Remove(id),
            Edit::All(edits) => Self::All(edits.into_iter().map(Self::from).collect()),
        }
    }
}

fn raw(sections: &Sections) -> Result<Box<RawValue>> {
    RawValue::from_string(json::line(sections)?).map_err(unwritable)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = r#"{"transect":"sections","version":1,"units":"mm","labels":[{"id":3,"name":"liver"}],"sections":[{"name":"a","normal":[0.1,0.3,-0.7],"offset":0.30000000000000004,"loops":[{"label":"liver","points":[[0,1,0],[1,1,0.14285714285714285],[1,2,0.5714285714285714]]}]}]}"#;

    fn act(text: &str) -> Result<Act> {
        match parse(text, Path::new("line 1"), &Rules::default())? {
            Command::Act(act) => Ok(act),
            other => panic!("{other:?}"),
        }
    }

    fn refused(text: &str) -> String {
        parse(text, Path::new("line 1"), &Rules::default()).expect_err(text).to_string()
    }

    #[test]
    fn what_is_written_is_read_bit_for_bit() {
        let replace = format!(r#"{{"replace":{{"id":7,"with":{SQUARE}}}}}"#);
        let all = format!(r#"{{"all":[{{"remove":2}},{{"add":{SQUARE}}},{replace}]}}"#);
        for text in ["\"undo\"", r#"{"remove":5}"#, &replace, &all] {
            let once = act(text).expect(text);
            let written = once.text().expect("a line");
            let again = act(&written).expect("the same");
            // Debug tells doubles apart to the last bit.
            assert_eq!(format!("{once:?}"), format!("{again:?}"));
            assert_eq!(again.text().expect("a line"), written);
            assert!(!written.contains('\n'));
        }
    }

    #[test]
    fn what_is_no_command_is_refused_with_the_reason() {
        let two =
            SQUARE.replace(r#""sections":["#, r#""sections":[{"normal":[0,0,1],"offset":5},"#);
        for (text, words) in [
            ("", "EOF"),
            ("{", "EOF"),
            (r#"{"ad": 3}"#, "unknown variant `ad`"),
            (r#"{"remove": 3, "undo": 1}"#, "column"),
            (r#"{"remove": -1}"#, "invalid value"),
            (r#"{"replace": {"id": 1}}"#, "missing field `with`"),
            (r#"{"replace": {"id": 1, "with": "a.csl", "by": 2}}"#, "unknown field `by`"),
            (r#"{"add": 3}"#, "a file's name"),
            (r#"{"add": "missing.csl"}"#, "missing.csl: there is no such file"),
            (r#"{"add": {"transect": "sections", "version": 1, "sektions": []}}"#, "line 1"),
            (r#"{"all": ["undo"]}"#, "the others stand alone"),
            (&format!(r#"{{"replace":{{"id":7,"with":{two}}}}}"#), "here are 2"),
        ] {
            let error = refused(text);
            assert!(error.contains(words), "{words:?} is not in {error:?}");
        }
    }
}
