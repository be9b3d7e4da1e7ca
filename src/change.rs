//! An edit of a model, as one value, and the sections that it edits.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::section::{Rules, Section, Sections};

/// The number of a section in a model: no other section of it ever has the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct SectionId(pub u64);

/// What [`Model::apply`](crate::model::Model::apply) does.
#[derive(Debug, Clone)]
pub enum Change {
    /// Sections join those that are there; the offline run is one such change.
    Add(Sections),
    /// A section takes the place of another one, and its number.
    Replace(SectionId, Section),
    /// A section goes.
    Remove(SectionId),
    /// Several changes one after the other: all of them, or none.
    All(Vec<Change>),
}

/// A step in the life of a model.
#[derive(Debug, Clone)]
pub enum Step {
    /// Its sections change.
    Change(Box<Change>),
    /// The last change that was not taken back yet is taken back.
    Undo,
}

/// Sections as they were given, each by its number: the ground state of a model, from which
/// all else follows.
#[derive(Debug, Clone, Default)]
pub(crate) struct Given {
    sections: BTreeMap<SectionId, Arc<Section>>,
    /// What their files say besides: units, materials, warnings; no sections.
    about: Sections,
    /// How many numbers were given away.
    numbers: u64,
}

/// What a change replaced.
#[derive(Debug)]
pub(crate) struct Replaced {
    /// In the order of the changes; `None` for sections that were not there.
    sections: Vec<(SectionId, Option<Arc<Section>>)>,
    about: Sections,
}

impl Given {
    /// Changes the sections. Returns the numbers of those that were added, and what was
    /// replaced.
    ///
    /// # Errors
    /// When a number is no section's, and when files do not fit together. Then the sections
    /// are not to be used any more.
    pub fn change(&mut self, change: Change, rules: &Rules) -> Result<(Vec<SectionId>, Replaced)> {
        let mut replaced = Replaced { sections: Vec::new(), about: self.about.clone() };
        let mut added = Vec::new();
        self.edit(change, rules, &mut added, &mut replaced)?;
        Ok((added, replaced))
    }

    fn edit(
        &mut self,
        change: Change,
        rules: &Rules,
        added: &mut Vec<SectionId>,
        replaced: &mut Replaced,
    ) -> Result<()> {
        match change {
            Change::Add(mut sections) => {
                for section in std::mem::take(&mut sections.sections) {
                    let id = SectionId(self.numbers);
                    self.numbers += 1;
                    self.put(id, Some(Arc::new(section)), replaced);
                    added.push(id);
                }
                self.about.learn(sections, rules)
            }
            Change::Replace(id, section) => {
                self.require(id)?;
                self.put(id, Some(Arc::new(section)), replaced);
                Ok(())
            }
            Change::Remove(id) => {
                self.require(id)?;
                self.put(id, None, replaced);
                Ok(())
            }
            Change::All(changes) => {
                changes.into_iter().try_for_each(|change| self.edit(change, rules, added, replaced))
            }
        }
    }

    /// Takes a change back.
    pub fn restore(&mut self, replaced: &Replaced) {
        for (id, section) in replaced.sections.iter().rev() {
            self.set(*id, section.clone());
        }
        self.about = replaced.about.clone();
    }

    /// All sections, with those of one plane merged; `None` without any.
    ///
    /// # Errors
    /// Where sections of one plane disagree.
    pub fn merged(&self, rules: &Rules) -> Result<Option<Sections>> {
        if self.sections.is_empty() {
            return Ok(None);
        }
        let sections = self.sections.values().map(|section| Section::clone(section));
        self.about.clone().with(sections, rules).map(Some)
    }

    /// The sections by number.
    pub fn iter(&self) -> impl Iterator<Item = (SectionId, &Section)> {
        self.sections.iter().map(|(&id, section)| (id, section.as_ref()))
    }

    fn require(&self, id: SectionId) -> Result<()> {
        match self.sections.contains_key(&id) {
            true => Ok(()),
            false => Err(Error::Option(format!("there is no section with the number {}", id.0))),
        }
    }

    fn put(&mut self, id: SectionId, section: Option<Arc<Section>>, replaced: &mut Replaced) {
        let before = self.set(id, section);
        replaced.sections.push((id, before));
    }

    fn set(&mut self, id: SectionId, section: Option<Arc<Section>>) -> Option<Arc<Section>> {
        match section {
            Some(section) => self.sections.insert(id, section),
            None => self.sections.remove(&id),
        }
    }
}
