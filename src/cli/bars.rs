//! Progress bars on a terminal, for stages that take over a second.

use std::sync::Mutex;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::progress::{Progress, Silent};

/// How long a stage may take before a bar is shown.
const PATIENCE: Duration = Duration::from_secs(1);

/// Whoever watches a command: bars, or nobody.
pub enum Watcher {
    /// On a terminal.
    Bars(Bars),
    /// With `--quiet`.
    Nobody,
}

impl Watcher {
    /// Bars unless `quiet`.
    pub fn new(quiet: bool) -> Self {
        if quiet { Self::Nobody } else { Self::Bars(Bars::new()) }
    }

    /// What the stages tell.
    pub fn progress(&self) -> &dyn Progress {
        match self {
            Self::Bars(bars) => bars,
            Self::Nobody => &Silent,
        }
    }

    /// Takes the present bar from the screen.
    pub fn finish(&self) {
        if let Self::Bars(bars) = self {
            bars.clear();
        }
    }
}

/// One bar at a time, on stderr.
pub struct Bars {
    bar: Mutex<ProgressBar>,
}

impl Bars {
    /// No stage has begun.
    fn new() -> Self {
        Self { bar: Mutex::new(ProgressBar::hidden()) }
    }

    /// Takes the present bar from the screen.
    fn clear(&self) {
        if let Ok(bar) = self.bar.lock() {
            bar.finish_and_clear();
        }
    }
}

impl Progress for Bars {
    fn begin(&self, stage: &'static str, total: u64) {
        self.clear();
        let bar = ProgressBar::hidden().with_message(stage);
        bar.set_style(style(total));
        bar.set_length(total);
        if let Ok(mut current) = self.bar.lock() {
            *current = bar.clone();
        }
        // Shown only if this stage is still the present one by then.
        let shown = bar.downgrade();
        // Where no thread can be had there is no bar.
        let _ = std::thread::Builder::new().spawn(move || {
            std::thread::sleep(PATIENCE);
            if let Some(bar) = shown.upgrade().filter(|bar| !bar.is_finished()) {
                // Draws nothing unless stderr is a terminal.
                bar.set_draw_target(ProgressDrawTarget::stderr());
                bar.enable_steady_tick(Duration::from_millis(100));
            }
        });
    }

    fn advance(&self, steps: u64) {
        if let Ok(bar) = self.bar.lock() {
            bar.inc(steps);
        }
    }
}

fn style(total: u64) -> ProgressStyle {
    let template = if total == 0 {
        "{msg:>12} {spinner} {elapsed}"
    } else {
        "{msg:>12} [{bar:40}] {percent:>3} %  {eta}"
    };
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
