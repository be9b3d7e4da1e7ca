//! How far a long stage has come, for whoever watches.

/// Told by the stages; the command line draws bars from it.
pub trait Progress: Sync {
    /// A stage begins that will take `total` steps (0: unknown).
    fn begin(&self, stage: &'static str, total: u64);
    /// `steps` more are done.
    fn advance(&self, steps: u64);
}

/// Nobody watches.
#[derive(Debug, Clone, Copy)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &'static str, _total: u64) {}
    fn advance(&self, _steps: u64) {}
}
