//! How fast a device solves: the last system of a reconstruction, again and again.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::backend::{Backend, Correction, Limits};
use super::cpu::Cpu;
use super::label_field::LabelField;
use super::system::System;
use super::{Space, backend, labels, scene};
use crate::error::{Error, Result};
use crate::field::Device;
use crate::grid::frame::Frame;
use crate::method::Variational;
use crate::progress::Silent;
use crate::section::Section;

/// The system of the first label on the finest lattice, as a reconstruction has it.
#[derive(Debug)]
pub struct Trial {
    system: System,
    residual: Vec<f32>,
    limits: Limits,
}

/// How fast a device was.
#[derive(Debug, Clone, PartialEq)]
pub struct Rate {
    /// The device, for people to read.
    pub device: String,
    /// Unknowns times iterations a second, copying to and from the device included.
    pub updates: f64,
}

/// The CPU, which keeps what it was asked last.
struct Recorder {
    cpu: Cpu,
    last: Mutex<Option<Trial>>,
}

impl Trial {
    /// Reconstructs the first label to get there.
    ///
    /// # Errors
    /// When there is no label.
    pub fn new(sections: &[Section], frame: &Frame, method: &Variational) -> Result<Self> {
        let nothing = || Error::Option("there is nothing to solve for".to_owned());
        let recorder = Recorder { cpu: Cpu::new(), last: Mutex::new(None) };
        let space = Space::around(sections, method.border, frame)?;
        let scene = scene(sections, &space, method, &recorder, &Silent);
        let label = labels(sections).first().copied().ok_or_else(nothing)?;
        LabelField::new(&scene, None, label)?;
        let last = recorder.last.into_inner().unwrap_or_else(PoisonError::into_inner);
        last.ok_or_else(nothing)
    }

    /// How many unknowns there are.
    pub fn unknowns(&self) -> u64 {
        self.system.unknowns()
    }

    /// Solves `times` times, after once to warm up; the fastest counts.
    ///
    /// # Errors
    /// [`Error::Device`] when there is no such device or it fails.
    pub fn run(&self, device: Device, times: u32) -> Result<Rate> {
        let backend = backend(device)?;
        let mut fastest = 0.0_f64;
        for _ in 0..=times {
            let residual = self.residual.clone();
            let start = Instant::now();
            let solved = backend.correct(&self.system, residual, self.limits)?;
            let updates = (self.unknowns() * u64::from(solved.iterations)) as f64;
            fastest = fastest.max(updates / start.elapsed().as_secs_f64());
        }
        Ok(Rate { device: backend.name(), updates: fastest })
    }
}

impl Backend for Recorder {
    fn name(&self) -> String {
        self.cpu.name()
    }

    fn apply(&self, system: &System, values: &[f32]) -> Result<Vec<f32>> {
        self.cpu.apply(system, values)
    }

    fn correct(&self, system: &System, residual: Vec<f32>, limits: Limits) -> Result<Correction> {
        let trial = Trial { system: system.clone(), residual: residual.clone(), limits };
        *self.last.lock().unwrap_or_else(PoisonError::into_inner) = Some(trial);
        self.cpu.correct(system, residual, limits)
    }
}
