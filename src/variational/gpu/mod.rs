//! Conjugate gradients on a GPU: `shaders/variational.wgsl` through wgpu.
//!
//! ```text
//! advance, judge, turn                       once, going nowhere: the first direction
//! apply, measure, advance, judge, turn       an iteration
//! ```
//!
//! `apply`, `advance` and `turn` take a workgroup a leaf. The first two leave a sum a
//! leaf, from which `measure` and `judge`, one workgroup each, make the next factor
//! without anything being read back. Iterations are submitted several at a time,
//! so many that a submission is short; those after the end do nothing. All sums
//! are taken in a fixed order: the same device gives the same bytes again.
//!
//! The state that comes back says how many iterations there were, so that a driver
//! which ended its work early (wgpu#5000) is found out; and in a few leaves b − A x
//! by the CPU is compared with what the GPU says is left.

mod buffers;
mod layout;

#[cfg(test)]
mod tests;

use std::sync::{Mutex, PoisonError};

use bytemuck::cast_slice;

use self::buffers::{Buffers, Recording, Stages};
use self::layout::{
    CORRECTION, DIRECTION, INVERSE, LEAF_BYTES, LEAVES, PARTS, PRODUCT, RESIDUAL, SAMPLES, STATE,
    State, Tables,
};
use super::backend::{Backend, Correction, Limits};
use super::cpu::{Cpu, inverse_diagonal, size};
use super::system::{Sample, System};
use crate::error::Result;
use crate::gpu::{Adapter, Connection};
use crate::grid::samples::LEAF_NODES;

const SHADER: &str = include_str!("../../../shaders/variational.wgsl");

/// Iterations of a submission at most.
const ITERATIONS: usize = 32;
/// Leaves where the result is checked.
const PROBES: usize = 8;
/// Of what b − A x is made of, how much it may be off: f32 has 6e-8, and the error
/// of every iteration stays.
const TOLERANCE: f32 = 1e-4;

/// A GPU.
pub struct Gpu {
    cpu: Cpu,
    /// Systems with fewer unknowns are left to the CPU.
    few: u64,
    /// Workgroups along one axis of a dispatch at most.
    widest: u32,
    connection: Connection,
    stages: Stages,
    /// Held while a system is solved: one at a time. Who holds it must not wait for
    /// rayon, which might have this thread begin another label, that waits for it.
    buffers: Mutex<Buffers>,
}

/// What came back.
struct Outcome {
    values: Vec<f32>,
    /// What is left in the leaves that are checked.
    left: Vec<f32>,
    state: State,
}

impl Gpu {
    /// Opens a GPU.
    ///
    /// # Errors
    /// [`Error::Device`](crate::error::Error::Device) when there is no such adapter.
    pub fn new(adapter: Adapter) -> Result<Self> {
        let connection = Connection::open(adapter)?;
        let stages = Stages::new(&connection, SHADER);
        let buffers = Mutex::new(Buffers::new(&connection));
        connection.check()?;
        let widest = connection.limits().max_compute_workgroups_per_dimension;
        Ok(Self { cpu: Cpu::new(), few: 0, widest, connection, stages, buffers })
    }

    /// The same, but systems with fewer unknowns are left to the CPU.
    pub fn sparing(self, few: u64) -> Self {
        Self { few, ..self }
    }

    /// Whether the GPU is for a system, and can hold it: its shader knows no anchors.
    fn is_for(&self, system: &System) -> bool {
        let leaves = system.leaves.len() as u64;
        let samples = size_of_val(system.samples.as_slice()) as u64;
        let largest = (leaves * LEAF_BYTES).max(samples);
        let is_known = leaves > 0 && system.anchors.is_none();
        is_known && system.unknowns() >= self.few && self.connection.require_room(largest).is_ok()
    }

    /// How many iterations are submitted at once.
    fn iterations_at_once(&self, system: &System) -> u32 {
        // An integrated GPU has some 1e9 updates a second, a software adapter 5e5.
        let updates = if self.connection.is_software() { 1 << 20 } else { 1 << 27 };
        (updates / (system.leaves.len() * LEAF_NODES)).clamp(1, ITERATIONS) as u32
    }

    fn record<'a>(&'a self, buffers: &'a Buffers, system: &System) -> Recording<'a> {
        Recording {
            connection: &self.connection,
            buffers,
            leaves: system.leaves.len() as u32,
            widest: self.widest,
            encoder: self.connection.encoder(),
        }
    }

    /// Puts a system into the buffers.
    fn upload(&self, buffers: &mut Buffers, tables: &Tables, state: State) -> Result<()> {
        let connection = &self.connection;
        let leaves = tables.leaves.len() as u64;
        let least = size_of::<Sample>() as u64;
        buffers.write(connection, LEAVES, cast_slice(&tables.leaves))?;
        buffers.reserve(connection, SAMPLES, least)?;
        buffers.write(connection, SAMPLES, cast_slice(&tables.samples))?;
        buffers.write(connection, STATE, bytemuck::bytes_of(&state))?;
        buffers.reserve(connection, PARTS, leaves * size_of::<f32>() as u64)?;
        for vector in [DIRECTION, PRODUCT, CORRECTION, RESIDUAL] {
            buffers.reserve(connection, vector, leaves * LEAF_BYTES)?;
        }
        let size = (leaves + PROBES as u64 + 1) * LEAF_BYTES + size_of::<State>() as u64;
        buffers.reserve_readable(connection, size);
        Ok(())
    }

    /// Runs conjugate gradients in the buffers.
    fn iterate(&self, buffers: &Buffers, system: &System, limit: u32) -> Result<()> {
        let Stages { apply, measure, advance, judge, turn } = &self.stages;
        let mut recording = self.record(buffers, system);
        for vector in [DIRECTION, PRODUCT, CORRECTION] {
            recording.clear(vector);
        }
        recording.add(&[advance, judge, turn]);
        let mut begun = 0;
        loop {
            let end = limit.min(begun + self.iterations_at_once(system));
            for _ in begun..end {
                recording.add(&[apply, measure, advance, judge, turn]);
            }
            begun = end;
            let size = size_of::<State>() as u64;
            recording.copy(STATE, 0, 0, size);
            recording.submit()?;
            let state = buffers.read::<State>(&self.connection, size)?;
            if begun == limit || state.iter().all(|state| state.is_done != 0) {
                return Ok(());
            }
            recording = self.record(buffers, system);
        }
    }

    /// Copies out what came of it.
    fn download(&self, buffers: &Buffers, system: &System, probes: &[usize]) -> Result<Outcome> {
        let mut recording = self.record(buffers, system);
        let size = system.leaves.len() as u64 * LEAF_BYTES;
        recording.copy(CORRECTION, 0, 0, size);
        for (&leaf, to) in probes.iter().zip(0u64..) {
            recording.copy(RESIDUAL, leaf as u64 * LEAF_BYTES, size + to * LEAF_BYTES, LEAF_BYTES);
        }
        let size = size + probes.len() as u64 * LEAF_BYTES;
        recording.copy(STATE, 0, size, size_of::<State>() as u64);
        recording.submit()?;
        let all: Vec<f32> = buffers.read(&self.connection, size + size_of::<State>() as u64)?;
        let (values, rest) = all.split_at(system.leaves.len() * LEAF_NODES);
        let (left, state) = rest.split_at(probes.len() * LEAF_NODES);
        let state = bytemuck::pod_read_unaligned(cast_slice(state));
        Ok(Outcome { values: values.to_vec(), left: left.to_vec(), state })
    }

    /// Compares what is left with b − A x by the CPU.
    fn check(
        &self,
        system: &System,
        residual: &[f32],
        probes: &[usize],
        outcome: &Outcome,
    ) -> Result<()> {
        let largest = |values: &[f32]| values.iter().fold(0.0f32, |sum, one| sum.max(one.abs()));
        if outcome.state.is_done == 0 || outcome.values.iter().any(|value| !value.is_finite()) {
            return Err(self.connection.garbage("an unfinished result"));
        }
        // The absolute values of what L has add up to this, and those of the stencil to its
        // square: 144 with three directions.
        let sum: f32 = system.directions.iter().map(|direction| 4.0 * direction.weight).sum();
        let allowed = TOLERANCE * (largest(residual) + sum * sum * largest(&outcome.values));
        for (&leaf, left) in probes.iter().zip(outcome.left.as_chunks::<LEAF_NODES>().0) {
            let mut product = [0.0; LEAF_NODES];
            self.cpu.apply_in(system, leaf, &outcome.values, &mut product);
            let own = &residual[leaf * LEAF_NODES..][..LEAF_NODES];
            let off = own.iter().zip(&product).zip(left).any(|((b, product), left)| {
                let difference = (b - product - left).abs();
                difference.is_nan() || difference > allowed
            });
            if off {
                return Err(self.connection.garbage("values unlike the CPU's"));
            }
        }
        Ok(())
    }
}

/// Leaves spread evenly, and the one where the residual is largest.
fn probes(system: &System, residual: &[f32]) -> Vec<usize> {
    let step = system.leaves.len().div_ceil(PROBES).max(1);
    let node = (0..residual.len())
        .max_by(|&one, &other| residual[one].abs().total_cmp(&residual[other].abs()));
    let spread = (0..system.leaves.len()).step_by(step);
    spread.chain(node.map(|node| node / LEAF_NODES)).collect()
}

impl Backend for Gpu {
    fn name(&self) -> String {
        format!("gpu ({})", self.connection.name())
    }

    fn apply(&self, system: &System, values: &[f32]) -> Result<Vec<f32>> {
        if !self.is_for(system) {
            return self.cpu.apply(system, values);
        }
        let tables = Tables::new(system);
        let state = State::new(system, Limits { iterations: 1, tolerance: 0.0, of: 0.0 }, 0.0);
        let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        self.upload(&mut buffers, &tables, state)?;
        buffers.write(&self.connection, DIRECTION, cast_slice(values))?;
        let size = size_of_val(values) as u64;
        let mut recording = self.record(&buffers, system);
        recording.clear(PRODUCT);
        recording.add(&[&self.stages.apply]);
        recording.copy(PRODUCT, 0, 0, size);
        recording.submit()?;
        buffers.read(&self.connection, size)
    }

    fn correct(&self, system: &System, residual: Vec<f32>, limits: Limits) -> Result<Correction> {
        if !self.is_for(system) {
            return self.cpu.correct(system, residual, limits);
        }
        let tables = Tables::new(system);
        let inverse = inverse_diagonal(system);
        let size = size(&residual, &inverse);
        let probes = probes(system, &residual);
        let outcome = {
            let mut buffers = self.buffers.lock().unwrap_or_else(PoisonError::into_inner);
            self.upload(&mut buffers, &tables, State::new(system, limits, size))?;
            buffers.write(&self.connection, INVERSE, cast_slice(&inverse))?;
            buffers.write(&self.connection, RESIDUAL, cast_slice(&residual))?;
            self.iterate(&buffers, system, limits.iterations)?;
            self.download(&buffers, system, &probes)?
        };
        self.check(system, &residual, &probes, &outcome)?;
        Ok(Correction { values: outcome.values, iterations: outcome.state.iterations, size })
    }
}
