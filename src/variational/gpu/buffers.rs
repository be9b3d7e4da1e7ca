//! The buffers of one solve after another, and the stages that run on them.

use wgpu::{BufferUsages, CommandEncoder, ComputePipeline};

use super::layout::{
    CORRECTION, DIRECTION, INVERSE, LEAF_BYTES, LEAVES, NEXT, PARTS, PRODUCT, RESIDUAL, SAMPLES,
    STATE,
};
use crate::error::Result;
use crate::gpu::Connection;

/// What the GPU runs, each with the bindings that it uses.
pub struct Stages {
    pub apply: Stage,
    pub measure: Stage,
    pub advance: Stage,
    pub judge: Stage,
    pub turn: Stage,
}

/// One entry point of the shader.
pub struct Stage {
    pipeline: ComputePipeline,
    bindings: &'static [usize],
    /// Whether it takes a workgroup a leaf, or one alone.
    is_leafwise: bool,
}

/// Kept from one solve to the next, larger ones in place of those too small.
pub struct Buffers {
    /// By the number of the binding, but for [`NEXT`].
    bound: [wgpu::Buffer; NEXT],
    readable: wgpu::Buffer,
}

/// Stages recorded for the leaves of a system.
pub struct Recording<'a> {
    pub connection: &'a Connection,
    pub buffers: &'a Buffers,
    pub leaves: u32,
    /// Workgroups along one axis at most.
    pub widest: u32,
    pub encoder: CommandEncoder,
}

impl Stages {
    pub fn new(connection: &Connection, shader: &str) -> Self {
        let stage = |entry: &str, is_leafwise, bindings| Stage {
            pipeline: connection.pipeline("variational", shader, entry),
            bindings,
            is_leafwise,
        };
        Self {
            apply: stage("apply", true, &[LEAVES, SAMPLES, DIRECTION, PRODUCT, PARTS, STATE]),
            measure: stage("measure", false, &[PARTS, NEXT]),
            advance: stage(
                "advance",
                true,
                &[INVERSE, DIRECTION, PRODUCT, CORRECTION, RESIDUAL, PARTS, STATE],
            ),
            judge: stage("judge", false, &[PARTS, NEXT]),
            turn: stage("turn", true, &[INVERSE, DIRECTION, RESIDUAL, STATE]),
        }
    }
}

const BOUND: BufferUsages =
    BufferUsages::STORAGE.union(BufferUsages::COPY_SRC).union(BufferUsages::COPY_DST);
const READABLE: BufferUsages = BufferUsages::MAP_READ.union(BufferUsages::COPY_DST);
/// Bytes of a buffer at least.
const LEAST: u64 = 256;

impl Buffers {
    pub fn new(connection: &Connection) -> Self {
        let bound = std::array::from_fn(|_| connection.buffer(LEAST, BOUND));
        Self { bound, readable: connection.buffer(LEAST, READABLE) }
    }

    /// Sees to it that a buffer has some size at least.
    pub fn reserve(&mut self, connection: &Connection, binding: usize, size: u64) -> Result<()> {
        connection.require_room(size)?;
        let limit = connection.limits().max_storage_buffer_binding_size;
        if self.bound[binding].size() < size {
            self.bound[binding] = connection.buffer(roomy(size).min(limit), BOUND);
        }
        Ok(())
    }

    /// The same for the one that is read from here.
    pub fn reserve_readable(&mut self, connection: &Connection, size: u64) {
        if self.readable.size() < size {
            self.readable = connection.buffer(roomy(size), READABLE);
        }
    }

    /// Puts bytes into a buffer.
    pub fn write(&mut self, connection: &Connection, binding: usize, bytes: &[u8]) -> Result<()> {
        self.reserve(connection, binding, bytes.len() as u64)?;
        connection.write(self.bound(binding), bytes);
        Ok(())
    }

    /// The first bytes of the readable buffer, when all work is done.
    pub fn read<T: bytemuck::Pod>(&self, connection: &Connection, size: u64) -> Result<Vec<T>> {
        connection.read(&self.readable, size)
    }

    fn bound(&self, binding: usize) -> &wgpu::Buffer {
        &self.bound[if binding == NEXT { STATE } else { binding }]
    }
}

/// A quarter more than is asked for, so that it lasts.
fn roomy(size: u64) -> u64 {
    (size + size / 4).next_multiple_of(LEAST)
}

impl Recording<'_> {
    /// Adds stages, each after the one before.
    pub fn add(&mut self, stages: &[&Stage]) {
        let groups: Vec<_> = stages.iter().map(|stage| self.bindings(stage)).collect();
        let [x, y] = self.grid();
        let mut pass = self.encoder.begin_compute_pass(&Default::default());
        for (stage, bindings) in stages.iter().zip(&groups) {
            let [x, y] = if stage.is_leafwise { [x, y] } else { [1, 1] };
            pass.set_pipeline(&stage.pipeline);
            pass.set_bind_group(0, bindings, &[]);
            pass.dispatch_workgroups(x, y, 1);
        }
    }

    /// Workgroups along two axes, since there is a limit along one.
    fn grid(&self) -> [u32; 2] {
        let x = self.leaves.min(self.widest);
        [x, self.leaves.div_ceil(x.max(1))]
    }

    fn bindings(&self, stage: &Stage) -> wgpu::BindGroup {
        let buffers = stage.bindings.iter().map(|&at| (at as u32, self.buffers.bound(at)));
        self.connection.bindings(&stage.pipeline, buffers)
    }

    /// Sets a vector to 0.
    pub fn clear(&mut self, binding: usize) {
        let size = u64::from(self.leaves) * LEAF_BYTES;
        self.encoder.clear_buffer(self.buffers.bound(binding), 0, Some(size));
    }

    /// Copies to the readable buffer.
    pub fn copy(&mut self, binding: usize, from: u64, to: u64, size: u64) {
        let Buffers { readable, .. } = self.buffers;
        let bound = self.buffers.bound(binding);
        self.encoder.copy_buffer_to_buffer(bound, from, readable, to, size);
    }

    pub fn submit(self) -> Result<()> {
        self.connection.submit(self.encoder)
    }
}
