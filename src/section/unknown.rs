//! What is not known, and how much of it there may be.

use super::subdivision::keep_used;
use super::{Edge, Rules, Section, Sections, Warning};
use crate::error::{Error, Remedy, Result};
use crate::label::Label;

impl Section {
    /// The same with other labels, one for each: edges between labels that
    /// become equal vanish.
    pub(crate) fn relabelled(self, meaning: impl Fn(Label) -> Label) -> Self {
        let mut edges: Vec<Edge> = self
            .edges
            .iter()
            .map(|edge| Edge { left: meaning(edge.left), right: meaning(edge.right), ..*edge })
            .filter(|edge| edge.left != edge.right)
            .collect();
        let vertices = keep_used(&self.vertices, &mut edges);
        Self { vertices, edges, background: meaning(self.background), ..self }
    }
}

impl Sections {
    /// Refuses sections of which nothing is known.
    ///
    /// # Errors
    /// Where everything on all sections is unknown.
    pub fn require_known(&self) -> Result<()> {
        if self.sections.iter().any(|section| section.labels() != [Label::UNKNOWN]) {
            return Ok(());
        }
        let what = format!(
            "{}everything is unknown: no section says of any place what is there: add what is known",
            self.called()
        );
        Err(Error::Option(what).avoidable(Remedy::UnknownLabel))
    }

    /// Tells of a label that should mean *unknown* but does not occur.
    pub(crate) fn expect_unknown(&mut self, rules: &Rules) -> Result<()> {
        let Some(label) = rules.unknown.filter(|_| !self.unknown_occurs) else { return Ok(()) };
        let what = format!("label {} is given as unknown but does not occur", label.0);
        if rules.strict {
            let error = Error::Option(format!("{}{what}", self.called()));
            return Err(error.avoidable(Remedy::UnknownLabel).avoidable(Remedy::NotStrict));
        }
        self.warnings.push(Warning { section: String::new(), what });
        Ok(())
    }

    /// The files, as messages begin with them.
    fn called(&self) -> String {
        let files: Vec<String> = self.files.iter().map(|file| file.display().to_string()).collect();
        if files.is_empty() { String::new() } else { format!("{}: ", files.join(", ")) }
    }
}
