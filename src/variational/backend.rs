//! What solves a system.

use crate::error::Result;

use super::system::System;

/// When conjugate gradients end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// After so many iterations.
    pub iterations: u32,
    /// When the residual, in the norm of the preconditioner, has become so many
    /// times smaller.
    pub tolerance: f64,
    /// The squared norm that is compared with, if it is larger than that of the residual
    /// given.
    pub of: f64,
}

impl Limits {
    /// So small r · D⁻¹ r is to become, from `first` on.
    pub fn goal(&self, first: f64) -> f64 {
        self.tolerance * self.tolerance * self.of.max(first)
    }
}

/// What is to be added to the values.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// For each leaf of the system a value for each node.
    pub values: Vec<f32>,
    /// How many iterations it took.
    pub iterations: u32,
    /// The squared norm of the residual that was given, r · D⁻¹ r.
    pub size: f64,
}

/// What every backend does, in f32. The vectors have 512 values for each leaf of
/// the system, those of nodes that are not free are 0.
pub trait Backend: Send + Sync {
    /// What it runs on, for people to read.
    fn name(&self) -> String;

    /// A x; what the contract asks for first.
    ///
    /// # Errors
    /// When the device fails.
    #[cfg_attr(not(test), allow(dead_code, reason = "the contract asks for it"))]
    fn apply(&self, system: &System, values: &[f32]) -> Result<Vec<f32>>;

    /// Solves A x = `residual` by conjugate gradients from x = 0, the diagonal of A
    /// as the preconditioner.
    ///
    /// # Errors
    /// When the device fails.
    fn correct(&self, system: &System, residual: Vec<f32>, limits: Limits) -> Result<Correction>;
}
