//! What a change of a model is made with.

use crate::progress::{Progress, Silent};
use crate::section::Rules;
use crate::stage::Stages;

/// By which rules a change is made, who watches, and what it took.
pub struct Context<'a> {
    /// How sections of one plane are merged, and files read.
    pub rules: Rules,
    /// Told how far a stage has come, and asked whether to go on.
    pub progress: &'a dyn Progress,
    /// What each stage took, those of the last change last.
    pub stages: Stages,
}

impl<'a> Context<'a> {
    /// With rules, watched, and without stages so far.
    pub fn new(rules: Rules, progress: &'a dyn Progress) -> Self {
        Self { rules, progress, stages: Stages::default() }
    }
}

/// The rules that files are read by when nobody asks for others; nobody watches.
impl Default for Context<'_> {
    fn default() -> Self {
        Self::new(Rules::default(), &Silent)
    }
}

impl std::fmt::Debug for Context<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { rules, stages, .. } = self;
        f.debug_struct("Context").field("rules", rules).field("stages", stages).finish()
    }
}
