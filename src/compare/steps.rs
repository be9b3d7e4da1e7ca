//! Progress in small steps, by parts of equal weight.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::error::Result;
use crate::progress::Progress;

/// Steps of a part.
const STEPS: u64 = 200;

/// A stage of several parts.
pub(super) struct Steps<'a> {
    progress: &'a dyn Progress,
    done: AtomicU64,
}

/// One of them.
pub(super) struct Part<'a> {
    steps: &'a Steps<'a>,
    first: u64,
}

impl<'a> Steps<'a> {
    /// Begins a stage.
    pub fn new(stage: &'static str, parts: usize, progress: &'a dyn Progress) -> Self {
        progress.begin(stage, parts.max(1) as u64 * STEPS);
        Self { progress, done: AtomicU64::new(0) }
    }

    /// A part by its place.
    pub fn part(&self, place: usize) -> Part<'_> {
        Part { steps: self, first: place as u64 * STEPS }
    }
}

impl Part<'_> {
    /// So much of it is done, from 0 to 1.
    ///
    /// # Errors
    /// When the work is to end.
    pub fn reach(&self, share: f64) -> Result<()> {
        let wanted = self.first + (share.clamp(0.0, 1.0) * STEPS as f64) as u64;
        let before = self.steps.done.fetch_max(wanted, Ordering::Relaxed);
        if wanted > before {
            self.steps.progress.advance(wanted - before);
        }
        self.steps.progress.go_on()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    #[derive(Default)]
    struct Heard(Mutex<Vec<u64>>);

    impl Progress for Heard {
        fn begin(&self, _: &'static str, total: u64) {
            self.0.lock().expect("one thread").push(total);
        }

        fn advance(&self, steps: u64) {
            self.0.lock().expect("one thread").push(steps);
        }
    }

    #[test]
    fn what_was_reached_is_told_once() {
        let heard = Heard::default();
        let steps = Steps::new("test", 2, &heard);
        for (place, share) in [(0, 0.5), (0, 0.25), (0, 1.0), (1, 0.0), (1, 2.0)] {
            steps.part(place).reach(share).expect("nobody cancels");
        }
        assert_eq!(*heard.0.lock().expect("one thread"), [400, 100, 100, 200]);
    }
}
