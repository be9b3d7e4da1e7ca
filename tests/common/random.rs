//! Random numbers that are the same everywhere.

use std::ops::Range;

/// The library's generator, and what tests draw with it.
pub struct Random(transect::random::Random);

impl Random {
    /// The numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self(transect::random::Random::new(seed))
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f64 {
        self.0.bits() as f64 / 2f64.powi(64)
    }

    /// Between two numbers.
    pub fn between(&mut self, range: Range<f64>) -> f64 {
        range.start + (range.end - range.start) * self.unit()
    }

    /// Below a number.
    pub fn below(&mut self, count: usize) -> usize {
        (self.0.bits() % count as u64) as usize
    }

    /// In so many of a hundred cases.
    pub fn percent(&mut self, share: usize) -> bool {
        self.below(100) < share
    }
}
