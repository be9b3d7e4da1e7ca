//! How far a long stage has come, for whoever watches, and whether it is to go on.

use crate::error::{Error, Result};

/// Told by the stages; the command line draws bars from it.
pub trait Progress: Sync {
    /// A stage begins that will take `total` steps (0: unknown).
    fn begin(&self, stage: &'static str, total: u64);
    /// `steps` more are done.
    fn advance(&self, steps: u64);
    /// Whether the work is to end: soon it does then, with [`Error::Cancelled`], and nothing
    /// has changed. Asked often, from any thread.
    fn is_cancelled(&self) -> bool {
        false
    }
}

impl dyn Progress + '_ {
    /// # Errors
    /// [`Error::Cancelled`] when the work is to end.
    pub(crate) fn go_on(&self) -> Result<()> {
        if self.is_cancelled() { Err(Error::Cancelled) } else { Ok(()) }
    }
}

/// Nobody watches.
#[derive(Debug, Clone, Copy)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &'static str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
}
