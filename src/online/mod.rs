//! Sections that come one by one: a model that lives as long as they do, and a journal of its
//! changes.
//!
//! ```text
//! command::parse ─► Session::act ─► Model::take ─► Journal::append ─► Answer
//! folder::Folder ───────┘  derive everything      on disk             acknowledged
//! ```
//!
//! What holds: a change that was answered is in the journal, on disk. What is applied is what
//! the journal says, read back; so a journal that is read again gives the same sections, to
//! the last bit.

pub mod answer;
pub mod command;
pub mod folder;
pub mod journal;

use std::path::Path;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::change::Step;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::mesh::patches::Patches;
use crate::model::{Model, Options};
use crate::progress::Silent;
use crate::section::{Findings, Rules};
use crate::stage::{Stage, Stages};

use answer::{Answer, Before, Listed};
use command::{Act, Command};
use journal::{Journal, Records};

/// A model, how sections are read into it, and where its changes are written down.
#[derive(Debug)]
pub struct Session {
    model: Model,
    rules: Rules,
    journal: Option<Journal>,
    /// The surface as whoever follows it knows it.
    patches: Option<Patches>,
    /// How many changes there were.
    changes: u64,
    /// Whether a change could not be written down.
    is_broken: bool,
}

/// What a journal held.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Resumed {
    /// How many changes, those that were taken back too.
    pub changes: u64,
    /// The sections that there are after them.
    pub sections: Vec<Listed>,
    /// What each stage took.
    pub stages: Vec<Stage>,
    /// What is not as it was.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
}

/// The record that says how the model is derived from then on.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Header {
    options: Value,
}

impl Session {
    /// A model without sections, whose changes are written down nowhere.
    pub fn new(options: Options, rules: Rules) -> Self {
        let model = Model::new(options);
        Self { model, rules, journal: None, patches: None, changes: 0, is_broken: false }
    }

    /// A model without sections, with a journal. `words` are the options as the user gave
    /// them, an object.
    ///
    /// # Errors
    /// When the journal holds changes already, and as [`Records::open`].
    pub fn begin(options: Options, rules: Rules, path: &Path, words: &Value) -> Result<Self> {
        let mut records = Records::open(path)?;
        for record in records.by_ref() {
            if header(&record?).is_none() {
                let what = "this journal holds changes: add --resume to go on from them, or name \
                            another file";
                return Err(Error::file(path, what));
            }
        }
        let (mut journal, _) = records.end()?;
        write_header(&mut journal, words)?;
        Ok(Self { journal: Some(journal), ..Self::new(options, rules) })
    }

    /// The model that a journal says, and what there is to say about it. A journal that is
    /// not there begins.
    ///
    /// # Errors
    /// When the journal is damaged, when its sections do not fit the options, and as
    /// [`Records::open`].
    pub fn resume(
        options: Options,
        rules: Rules,
        path: &Path,
        words: &Value,
        stages: &mut Stages,
    ) -> Result<(Self, Resumed)> {
        let mut records = Records::open(path)?;
        let (mut changes, mut before) = (0, None);
        let steps = std::iter::from_fn(|| {
            loop {
                let record = match records.next()? {
                    Ok(record) => record,
                    Err(error) => return Some(Err(error)),
                };
                match header(&record) {
                    Some(options) => before = Some(options),
                    None => {
                        changes += 1;
                        return Some(read_back(&record).map(Step::from));
                    }
                }
            }
        });
        let mut context =
            Context { stages: std::mem::take(stages), ..Context::new(rules, &Silent) };
        let model = Model::resume(options, steps, &mut context);
        *stages = context.stages;
        let placed = |error| match error {
            Error::File { .. } => error,
            other => Error::input(path, format!("after {changes} changes"), other),
        };
        let model = model.map_err(|error| error.map(placed))?;
        let (mut journal, torn) = records.end()?;
        let mut warnings = Vec::new();
        if let Some(torn) = torn {
            warnings.push(format!(
                "the last record of the journal is cut short or damaged: dropped ({} bytes at byte {})",
                torn.length, torn.byte
            ));
        }
        if before.as_ref() != Some(words) {
            warnings.extend(before.iter().flat_map(|before| differences(before, words)));
            write_header(&mut journal, words)?;
        }
        let sections = model.given().map(Listed::from).collect();
        let journal = Some(journal);
        let session = Self { model, rules, journal, patches: None, changes, is_broken: false };
        Ok((session, Resumed { changes, sections, stages: stages.stages.clone(), warnings }))
    }

    /// From now on answers say which patches of the surface are others than before.
    pub fn follow_patches(&mut self) {
        let now = self.model.derived();
        let patches = now.map(|now| Patches::new(&now.mesh, now.samples.lattice));
        self.patches = Some(patches.unwrap_or_default());
    }

    /// Changes the model; it stays as it was when that fails. When this returns the change is
    /// on disk, if there is a journal.
    ///
    /// # Errors
    /// As [`Model::apply`], when nothing is left to take back, and when the journal cannot be
    /// written: then [`Session::is_broken`].
    pub fn act(&mut self, act: Act, stages: &mut Stages) -> Result<Answer> {
        let (act, findings) = without_findings(act);
        let text = act.text()?;
        let step = Step::from(read_back(&text)?);
        let before = Before::of(&self.model);
        let (journal, is_broken) = (&mut self.journal, &mut self.is_broken);
        let mut kept = None;
        let keep = || {
            let Some(journal) = journal else { return Ok(()) };
            let start = Instant::now();
            journal.append(&text).inspect_err(|_| *is_broken = true)?;
            kept = Some(start.elapsed().as_secs_f64());
            Ok(())
        };
        let mut context =
            Context { stages: std::mem::take(stages), ..Context::new(self.rules, &Silent) };
        let taken = self.model.take(step, &mut context, keep);
        *stages = context.stages;
        let taken = taken?;
        if taken.is_none() {
            let what =
                "there is no change to take back: the last ones are remembered, and no others";
            return Err(Error::Option(what.to_owned()));
        }
        let journal = |seconds| Stage {
            name: "journal".to_owned(),
            seconds,
            peak_memory: 0,
            counts: [("bytes".to_owned(), text.len() as u64)].into(),
        };
        stages.stages.extend(kept.map(journal));
        self.changes += 1;
        let patches = match (&mut self.patches, self.model.derived()) {
            (Some(patches), Some(now)) => Some(
                stages.run("patches", |_| Ok(patches.follow(&now.mesh, now.samples.lattice)))?,
            ),
            (Some(patches), None) => Some(patches.clear()),
            (None, _) => None,
        };
        Ok(Answer::new(self.changes, &before, &self.model, findings, patches, stages))
    }

    /// Whether the journal could not be written: what is changed from then on would be lost.
    pub fn is_broken(&self) -> bool {
        self.is_broken
    }

    /// The model as it is now.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// How sections are read.
    pub fn rules(&self) -> &Rules {
        &self.rules
    }

    /// How many changes there were, those that were taken back too.
    pub fn changes(&self) -> u64 {
        self.changes
    }
}

fn without_findings(act: Act) -> (Act, Findings) {
    match act {
        Act::Edit(mut edit) => {
            let findings = edit.take_findings();
            (Act::Edit(edit), findings)
        }
        Act::Undo => (Act::Undo, Findings::default()),
    }
}

/// What a record says. Its sections have been read by the user's rules before they were
/// written.
fn read_back(record: &str) -> Result<Act> {
    match command::parse(record, Path::new("journal"), &Rules::default())? {
        Command::Act(act) => Ok(without_findings(act).0),
        Command::Save(_) | Command::Report(_) => {
            let what = "a record of the journal is no change".to_owned();
            Err(Error::Bug { stage: "journal", what })
        }
    }
}

impl From<Act> for Step {
    fn from(act: Act) -> Self {
        match act {
            Act::Edit(edit) => Self::Change(Box::new((*edit).into())),
            Act::Undo => Self::Undo,
        }
    }
}

/// The options of a record that holds some.
fn header(record: &str) -> Option<Value> {
    serde_json::from_str(record).ok().map(|Header { options }| options)
}

fn write_header(journal: &mut Journal, options: &Value) -> Result<()> {
    let header = Header { options: options.clone() };
    let text = serde_json::to_string(&header);
    journal.append(&text.map_err(|error| Error::Bug { stage: "journal", what: error.to_string() })?)
}

/// Options that are not what they were.
fn differences(before: &Value, now: &Value) -> Vec<String> {
    let members = |value: &Value| value.as_object().cloned().unwrap_or_default();
    let (before, now) = (members(before), members(now));
    let mut names: Vec<&String> = before.keys().chain(now.keys()).collect();
    names.sort();
    names.dedup();
    let of = |members: &serde_json::Map<String, Value>, name: &str| match members.get(name) {
        None | Some(Value::Null) => "not given".to_owned(),
        Some(Value::String(word)) => word.clone(),
        Some(value) => value.to_string(),
    };
    let differs = names.into_iter().filter(|&name| of(&before, name) != of(&now, name));
    differs
        .map(|name| format!("--{name} was {} and is {}", of(&before, name), of(&now, name)))
        .collect()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn options_that_changed_are_told_in_the_words_of_the_user() {
        let before = json!({"method": "mvc", "resolution": 48, "smooth": null});
        let now = json!({"method": "mvc", "resolution": 64, "smooth": null, "caps": "flat"});
        let told = ["--caps was not given and is flat", "--resolution was 48 and is 64"];
        assert_eq!(differences(&before, &now), told);
        assert!(differences(&now, &now).is_empty());
    }
}
