//! The way to a GPU, for all that run on one: choosing an adapter, buffers and
//! dispatches.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, mpsc};

use bytemuck::Pod;
use wgpu::{BufferUsages, DeviceType};

use crate::error::{Error, Result};

#[cfg(test)]
pub mod shader;

/// How many storage buffers an entry point of a shader has at most: what every adapter that
/// WebGPU knows must offer.
const STORAGE_BUFFERS: u32 = 8;

/// Which adapters will do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Adapter {
    /// Real GPUs only.
    Hardware,
    /// Software adapters only.
    Software,
    /// A real GPU when there is one, else a software adapter.
    Any,
}

/// Whether real GPUs were looked for in vain: that takes a while, and is asked at every
/// change of a model.
static NO_HARDWARE: AtomicBool = AtomicBool::new(false);

/// An open device.
pub(crate) struct Connection {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    /// What went wrong outside a call that could say so.
    complaints: Arc<Mutex<Vec<String>>>,
}

impl Adapter {
    /// How much an adapter of some type is wanted, the smallest first; `None`
    /// where it is not.
    fn rank(self, device: DeviceType) -> Option<u32> {
        let software = device == DeviceType::Cpu;
        if (self == Self::Hardware && software) || (self == Self::Software && !software) {
            return None;
        }
        Some(match device {
            DeviceType::DiscreteGpu => 0,
            DeviceType::IntegratedGpu => 1,
            DeviceType::VirtualGpu => 2,
            DeviceType::Other => 3,
            DeviceType::Cpu => 4,
        })
    }
}

impl Connection {
    /// Opens the best adapter that will do, with all the limits it has.
    pub fn open(kind: Adapter) -> Result<Self> {
        let adapter = choose(kind)?;
        let descriptor =
            wgpu::DeviceDescriptor { required_limits: adapter.limits(), ..Default::default() };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| Error::Device(error.to_string()))?;
        let complaints = Arc::new(Mutex::new(Vec::new()));
        let book = Arc::clone(&complaints);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            book.lock().unwrap_or_else(PoisonError::into_inner).push(error.to_string());
        }));
        Ok(Self { device, queue, info: adapter.get_info(), complaints })
    }

    pub fn name(&self) -> &str {
        &self.info.name
    }

    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    pub fn limits(&self) -> wgpu::Limits {
        self.device.limits()
    }

    /// Whether anything went wrong since the last question.
    pub fn check(&self) -> Result<()> {
        let mut complaints = self.complaints.lock().unwrap_or_else(PoisonError::into_inner);
        match complaints.drain(..).next() {
            None => Ok(()),
            Some(first) => Err(self.failed(first)),
        }
    }

    /// The error for results that cannot be right.
    pub fn garbage(&self, what: &str) -> Error {
        let name = self.name();
        Error::Device(format!("{name} returned {what}; its driver may have ended the work early"))
    }

    fn failed(&self, what: impl std::fmt::Display) -> Error {
        Error::Device(format!("{}: {what}", self.info.name))
    }

    pub fn pipeline(&self, name: &str, shader: &str, entry: &str) -> wgpu::ComputePipeline {
        let module = self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(shader.into()),
        });
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    }

    /// A read-only storage buffer with some content.
    pub fn upload(&self, bytes: &[u8]) -> Result<wgpu::Buffer> {
        let size = bytes.len() as u64;
        self.require_room(size)?;
        let buffer = self.buffer(size, BufferUsages::STORAGE | BufferUsages::COPY_DST);
        self.write(&buffer, bytes);
        Ok(buffer)
    }

    /// Whether one binding can have so many bytes.
    pub fn require_room(&self, size: u64) -> Result<()> {
        let limit = self.limits().max_storage_buffer_binding_size;
        if size <= limit {
            return Ok(());
        }
        let (size, limit) = (size >> 20, limit >> 20);
        Err(self.failed(format_args!("a table of {size} MiB is over its limit of {limit} MiB")))
    }

    pub fn buffer(&self, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        let descriptor =
            wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false };
        self.device.create_buffer(&descriptor)
    }

    /// Before all that is submitted later.
    pub fn write(&self, buffer: &wgpu::Buffer, bytes: &[u8]) {
        self.queue.write_buffer(buffer, 0, bytes);
    }

    pub fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&Default::default())
    }

    pub fn submit(&self, encoder: wgpu::CommandEncoder) -> Result<()> {
        self.queue.submit([encoder.finish()]);
        self.check()
    }

    /// Runs a pipeline whose bindings are `inputs` and then a buffer of
    /// `value_count` numbers, zero before, and returns those.
    pub fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        inputs: &[&wgpu::Buffer],
        groups: u32,
        value_count: usize,
    ) -> Result<Vec<f32>> {
        let size = (value_count * size_of::<f32>()) as u64;
        let output = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let values = self.buffer(size, output);
        let readable = self.buffer(size, BufferUsages::MAP_READ | BufferUsages::COPY_DST);
        let buffers = (0..).zip(inputs.iter().copied().chain([&values]));
        let bindings = self.bindings(pipeline, buffers);

        let mut encoder = self.encoder();
        encoder.clear_buffer(&values, 0, None);
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(groups, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&values, 0, &readable, 0, size);
        self.submit(encoder)?;
        self.read(&readable, size)
    }

    /// Buffers for a pipeline, each with the number of its binding.
    pub fn bindings<'a>(
        &self,
        pipeline: &wgpu::ComputePipeline,
        buffers: impl Iterator<Item = (u32, &'a wgpu::Buffer)>,
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = buffers
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        })
    }

    /// Waits for all work and copies the first bytes of a buffer out.
    pub fn read<T: Pod>(&self, buffer: &wgpu::Buffer, size: u64) -> Result<Vec<T>> {
        let (sender, receiver) = mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, ..size, move |result| {
            // Nobody listens once polling has failed.
            let _ = sender.send(result);
        });
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| self.failed(error))?;
        self.check()?;
        receiver.recv().map_err(|error| self.failed(error))?.map_err(|error| self.failed(error))?;
        let view = buffer.get_mapped_range(..size).map_err(|error| self.failed(error))?;
        let values = bytemuck::pod_collect_to_vec(&view);
        drop(view);
        buffer.unmap();
        Ok(values)
    }
}

fn choose(kind: Adapter) -> Result<wgpu::Adapter> {
    if kind == Adapter::Hardware && NO_HARDWARE.load(Ordering::Relaxed) {
        return Err(no_adapter());
    }
    let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    let instance = wgpu::Instance::new(descriptor);
    let found = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()))
        .into_iter()
        .filter(is_capable)
        .filter_map(|adapter| Some((kind.rank(adapter.get_info().device_type)?, adapter)))
        .min_by_key(|&(rank, _)| rank);
    if kind == Adapter::Hardware && found.is_none() {
        NO_HARDWARE.store(true, Ordering::Relaxed);
    }
    found.map(|(_, adapter)| adapter).ok_or_else(no_adapter)
}

fn no_adapter() -> Error {
    let what = "no usable GPU adapter was found: install a driver (mesa-vulkan-drivers has a \
                software adapter)";
    Error::Device(what.to_owned())
}

/// Whether the adapter runs our compute shaders.
fn is_capable(adapter: &wgpu::Adapter) -> bool {
    let flags = adapter.get_downlevel_capabilities().flags;
    flags.contains(wgpu::DownlevelFlags::COMPUTE_SHADERS)
        && adapter.limits().max_storage_buffers_per_shader_stage >= STORAGE_BUFFERS
}
