//! What each stage took: seconds, memory, counts.

use std::collections::BTreeMap;
use std::time::Instant;

use serde::Serialize;

use crate::error::Result;
use crate::memory;

/// What one stage took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Stage {
    /// `read`, `arrangement`, `field`, `grid`, `mesh`, `check` or a file.
    pub name: String,
    /// By the wall clock.
    pub seconds: f64,
    /// The largest resident size of the program up to the end of the stage, in bytes, as the
    /// operating system tells it; 0 where it does not.
    pub peak_memory: u64,
    /// How many of what.
    pub counts: BTreeMap<String, u64>,
}

/// Times the stages of a run.
#[derive(Debug, Clone, Default)]
pub struct Stages {
    /// In the order in which they ran.
    pub stages: Vec<Stage>,
}

impl Stages {
    /// Runs one stage and records what it took.
    ///
    /// # Errors
    /// Those of the stage, which is then not recorded.
    pub fn run<T>(
        &mut self,
        name: &str,
        stage: impl FnOnce(&mut BTreeMap<String, u64>) -> Result<T>,
    ) -> Result<T> {
        let start = Instant::now();
        let mut counts = BTreeMap::new();
        let value = stage(&mut counts)?;
        self.stages.push(Stage {
            name: name.to_owned(),
            seconds: start.elapsed().as_secs_f64(),
            peak_memory: memory::peak().unwrap_or(0),
            counts,
        });
        Ok(value)
    }

    /// The sum of the stages' seconds.
    pub fn seconds(&self) -> f64 {
        self.stages.iter().map(|stage| stage.seconds).sum()
    }

    /// The largest of the stages' peaks, in bytes.
    pub fn peak_memory(&self) -> u64 {
        self.stages.iter().map(|stage| stage.peak_memory).max().unwrap_or(0)
    }

    /// The seconds of the stages with this name.
    pub fn seconds_of(&self, name: &str) -> f64 {
        // A sum of nothing would be −0.
        let own = self.stages.iter().filter(|stage| stage.name == name);
        own.fold(0.0, |sum, stage| sum + stage.seconds)
    }

    /// The sum of a count over all stages.
    pub fn count_of(&self, what: &str) -> u64 {
        self.stages.iter().filter_map(|stage| stage.counts.get(what)).sum()
    }
}
