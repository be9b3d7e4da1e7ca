//! The GPU backend: `shaders/field*.wgsl` through wgpu.
//!
//! Points go out in batches, each a dispatch well under a second, sorted by
//! cell; raw weights come back and are normalised here. Some drivers end a
//! dispatch without an error and hand back an empty or stale buffer
//! (wgpu#5000), so the buffer is cleared before, where no weight sum can be
//! zero after, and a few points of every batch are evaluated on the CPU too.

use std::sync::Arc;

use self::batch::{Batch, LaidOut, Limits, Target, batches};
use self::layout::{DeviceJob, Tables};
use super::cpu::{Cpu, indicator, value_count};
use super::{Boundaries, Field, Queries};
use crate::error::Result;
use crate::gpu::{Adapter, Connection};
use crate::label::Label;

pub(super) mod batch;
pub(super) mod layout;

/// The shader's parts in one module.
const SHADER: &str = concat!(
    include_str!("../../../shaders/field_frame.wgsl"),
    include_str!("../../../shaders/field_types.wgsl"),
    include_str!("../../../shaders/field_edge.wgsl"),
    include_str!("../../../shaders/field.wgsl"),
);

/// A GPU with what it runs, for one field after another.
pub struct Opened {
    pub(super) connection: Connection,
    pub(super) pipeline: wgpu::ComputePipeline,
    pub(super) limits: Limits,
}

impl Opened {
    /// Opens a GPU.
    ///
    /// # Errors
    /// [`Error::Device`](crate::error::Error::Device) when there is no such adapter.
    pub fn new(adapter: Adapter) -> Result<Self> {
        Self::with(adapter, SHADER)
    }

    /// The same for a shader of another field.
    pub(super) fn with(adapter: Adapter, shader: &str) -> Result<Self> {
        let connection = Connection::open(adapter)?;
        let pipeline = connection.pipeline("field", shader, "evaluate");
        connection.check()?;
        let limits = Limits::of(&connection);
        Ok(Self { connection, pipeline, limits })
    }

    /// The numbers of the cells that queries ask for and a device can do, sorted: after a change
    /// of some sections these are few of all.
    pub(super) fn wanted<Cell: LaidOut>(&self, all: &[Cell], queries: &Queries) -> Vec<u32> {
        let mut cells: Vec<u32> = queries.runs.iter().map(|run| run.cell).collect();
        cells.sort_unstable();
        cells.dedup();
        cells.retain(|&cell| self.limits.allow(&all[cell as usize]));
        cells
    }

    /// Cells by their numbers on the device, laid out in tables in the order of the bindings.
    pub(super) fn upload(&self, cells: Vec<u32>, tables: &[&[u8]]) -> Result<Uploaded> {
        let upload = |bytes: &&[u8]| self.connection.upload(bytes);
        let tables = tables.iter().map(upload).collect::<Result<_>>()?;
        self.connection.check()?;
        Ok(Uploaded { cells, tables })
    }

    /// Compares a few points of a batch with what is expected of them. Right at a contour two
    /// correct results can differ, so it takes a majority to complain.
    pub(super) fn spot_check(
        &self,
        batch: &Batch,
        values: &[f32],
        tolerance: f32,
        expect: impl Fn(&Target, &mut [f32]),
    ) -> Result<()> {
        const PROBES: usize = 8;
        let step = batch.targets.len().div_ceil(PROBES).max(1);
        let is_alike = |target: &Target| {
            let found = &values[target.value..target.value + target.labels];
            let mut expected = vec![0.0; target.labels];
            expect(target, &mut expected);
            found.iter().zip(&expected).all(|(f, e)| (f - e).abs() <= tolerance)
        };
        let probes: Vec<bool> = batch.targets.iter().step_by(step).map(is_alike).collect();
        if 2 * probes.iter().filter(|is_alike| !**is_alike).count() > probes.len() {
            return Err(self.connection.garbage("values unlike the CPU's"));
        }
        Ok(())
    }
}

/// The f32 backend on a GPU.
pub struct Gpu {
    /// The same cells, for spot checks.
    cpu: Cpu,
    opened: Arc<Opened>,
}

/// Cells on the device.
pub(super) struct Uploaded {
    /// Their numbers, sorted.
    cells: Vec<u32>,
    pub tables: Vec<wgpu::Buffer>,
}

impl Uploaded {
    /// Which of them a cell is; it must be one.
    pub fn place(&self, cell: u32) -> u32 {
        self.cells.partition_point(|&other| other < cell) as u32
    }
}

impl Gpu {
    /// The field inside some boundaries.
    ///
    /// # Errors
    /// As [`field::new`](super::new); [`Error::Device`](crate::error::Error::Device) when there is no such
    /// adapter.
    pub fn new(boundaries: &Boundaries, adapter: Adapter) -> Result<Self> {
        Self::on(Arc::new(Opened::new(adapter)?), boundaries)
    }

    /// The same on a GPU that is open.
    ///
    /// # Errors
    /// As [`Gpu::new`].
    pub fn on(opened: Arc<Opened>, boundaries: &Boundaries) -> Result<Self> {
        Ok(Self { cpu: Cpu::new(boundaries)?, opened })
    }

    /// What the driver calls the device.
    pub fn adapter_name(&self) -> &str {
        self.opened.connection.name()
    }

    /// The cells of queries that the device evaluates.
    fn upload(&self, queries: &Queries) -> Result<Uploaded> {
        let all = self.cpu.cells();
        let cells = self.opened.wanted(all, queries);
        let tables = Tables::new(cells.iter().map(|&cell| &all[cell as usize]));
        self.opened.upload(cells, &tables.contents())
    }

    /// Evaluates one batch into the values of the whole query.
    fn run(
        &self,
        queries: &Queries,
        uploaded: &Uploaded,
        batch: &Batch,
        values: &mut [f32],
    ) -> Result<()> {
        let place = |job: &DeviceJob| DeviceJob { cell: uploaded.place(job.cell), ..*job };
        let jobs: Vec<DeviceJob> = batch.jobs.iter().map(place).collect();
        let points = self.opened.connection.upload(bytemuck::cast_slice(&batch.points))?;
        let jobs = self.opened.connection.upload(bytemuck::cast_slice(&jobs))?;
        let mut inputs: Vec<&wgpu::Buffer> = uploaded.tables.iter().collect();
        inputs.extend([&points, &jobs]);
        let groups = batch.jobs.len() as u32;
        let weights = self.opened.connection.dispatch(
            &self.opened.pipeline,
            &inputs,
            groups,
            batch.value_count,
        )?;
        if let Err(total) = normalise(&weights, batch, values) {
            return Err(self
                .opened
                .connection
                .garbage(&format!("an empty result (weights of {total})")));
        }
        self.spot_check(queries, batch, values)
    }

    /// Compares a few points with the CPU.
    fn spot_check(&self, queries: &Queries, batch: &Batch, values: &[f32]) -> Result<()> {
        const TOLERANCE: f32 = 0.01;
        self.opened.spot_check(batch, values, TOLERANCE, |target, expected| {
            let point = target.point..target.point + 1;
            self.cpu.evaluate_in(target.cell, &queries.points[point], expected);
        })
    }
}

impl Field for Gpu {
    fn labels(&self, cell: u32) -> &[Label] {
        self.cpu.labels(cell)
    }

    fn edges(&self, cell: u32) -> u64 {
        self.cpu.edges(cell)
    }

    fn name(&self) -> String {
        format!("gpu ({})", self.adapter_name())
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        queries.check(self.cpu.cells().len())?;
        let cells = self.cpu.cells();
        let mut values = vec![0.0; value_count(cells, queries)];
        let uploaded = self.upload(queries)?;
        for batch in batches(cells, queries, self.opened.limits) {
            self.run(queries, &uploaded, &batch, &mut values)?;
        }
        self.cpu.evaluate_where(queries, &mut values, |cell| !self.opened.limits.allow(cell));
        Ok(values)
    }
}

/// f from W for all points of a batch; fails with a sum W that cannot be one.
fn normalise(weights: &[f32], batch: &Batch, values: &mut [f32]) -> std::result::Result<(), f32> {
    for (job, target) in batch.jobs.iter().zip(&batch.targets) {
        let count = job.points as usize * target.labels;
        let first = job.first_value as usize;
        let weights = weights[first..first + count].chunks_exact(target.labels);
        let values = values[target.value..target.value + count].chunks_exact_mut(target.labels);
        for (weights, values) in weights.zip(values) {
            let total: f32 = weights.iter().sum();
            if !(total.is_finite() && total > 0.0) {
                return Err(total);
            }
            values.copy_from_slice(weights);
            indicator(values);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::batch::{Batch, Limits, batches};
    use std::sync::Arc;

    use super::{Adapter, Boundaries, Cpu, Gpu, normalise};
    use crate::error::Error;
    use crate::field::Field;
    use crate::field::fixture::{Stack, busy_stack};
    use crate::field::{Device, Evaluator, Queries, Run};
    use crate::gpu::shader::Shader;
    use crate::random::Random;

    /// What the host writes is what the shader reads.
    #[test]
    fn the_shader_is_valid_and_its_layouts_are_the_hosts() {
        use super::batch::{GROUP, WAVE, WINDOW};
        use super::layout::{DeviceCell, DeviceFace, DeviceJob, DevicePoint};
        use crate::field::packing::{Chain, PackedEdge};
        let shader = Shader::new(super::SHADER);
        shader.require_sizes(&[
            ("Cell", size_of::<DeviceCell>()),
            ("Face", size_of::<DeviceFace>()),
            ("Chain", size_of::<Chain>()),
            ("Edge", size_of::<PackedEdge>()),
            ("Point", size_of::<DevicePoint>()),
            ("Job", size_of::<DeviceJob>()),
        ]);
        let (invocations, points) = (shader.constant("GROUP"), shader.constant("POINTS"));
        assert_eq!((GROUP, WAVE), (invocations * points, 32 * points));
        assert_eq!(WINDOW, shader.constant("WINDOW"));
        assert_eq!(shader.workgroups(), [invocations as u32]);
    }

    fn stack_batches(limits: Limits) -> (Queries, Vec<Batch>) {
        let mut random = Random::new(30);
        let stack: Stack = busy_stack(&mut random, 3, 10);
        let mut queries = stack.queries(&mut random, 1000);
        queries.runs.push(Run { cell: 0, points: 2000..2000 });
        let complex = stack.complex();
        let cpu = Cpu::new(&Boundaries::new(&complex, 1e-6, None).unwrap()).unwrap();
        let batches = batches(cpu.cells(), &queries, limits).collect();
        (queries, batches)
    }

    /// Every point is in one job, and no batch is over its limits.
    #[test]
    fn batches_cover_the_query() {
        let generous = Limits { work: u64::MAX, groups: 65_535, bytes: 1 << 27, turns: u64::MAX };
        let (queries, whole) = stack_batches(generous);
        assert_eq!(whole.len(), 1);
        assert_eq!(whole[0].points.len(), queries.points.len());
        for limits in [
            Limits { groups: 3, ..generous },
            Limits { work: 1, ..generous },
            Limits { bytes: 1 << 14, ..generous },
        ] {
            let (_, batches) = stack_batches(limits);
            assert!(batches.len() > 1);
            assert!(batches.iter().all(|batch| batch.jobs.len() <= limits.groups));
            let targets = batches.iter().flat_map(|batch| &batch.targets);
            let jobs = batches.iter().flat_map(|batch| &batch.jobs);
            let mut next = 0;
            for (target, job) in targets.zip(jobs) {
                assert_eq!((target.point, target.value), (next, 4 * next));
                next += job.points as usize;
            }
            assert_eq!(next, queries.points.len());
        }
    }

    /// A device that did nothing leaves zeros, which no point can have.
    #[test]
    fn empty_results_are_noticed() {
        let (queries, batches) = stack_batches(Limits {
            work: u64::MAX,
            groups: 65_535,
            bytes: 1 << 27,
            turns: u64::MAX,
        });
        let mut values = vec![1.0; queries.points.len() * 4];
        let mut weights = vec![0.5; batches[0].value_count];
        assert!(normalise(&weights, &batches[0], &mut values).is_ok());
        assert!(values.iter().all(|&f| f == -0.5));
        weights[4..8].fill(0.0);
        assert!(normalise(&weights, &batches[0], &mut values).is_err());
        weights[4..8].fill(f32::NAN);
        assert!(normalise(&weights, &batches[0], &mut values).is_err());
    }

    #[test]
    fn a_gpu_is_opened_once() {
        let mut random = Random::new(32);
        let mut evaluator = Evaluator::default();
        let mut opened = Vec::new();
        for count in [3, 5] {
            let stack = busy_stack(&mut random, count, 10);
            let complex = stack.complex();
            let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
            let gpu = match evaluator.field(&boundaries, Device::Gpu) {
                Ok(gpu) => gpu,
                Err(Error::Device(_)) => return crate::skipped::skipped("no wgpu adapter"),
                Err(other) => panic!("{other}"),
            };
            // What it evaluates is the field of these cells, whatever was before.
            let queries = stack.queries(&mut random, 300);
            let cpu = Cpu::new(&boundaries).unwrap().evaluate(&queries).unwrap();
            let pairs = gpu.evaluate(&queries).unwrap().into_iter().zip(cpu);
            assert!(
                pairs.into_iter().filter(|(one, other)| (one - other).abs() > 1e-3).count() < 9
            );
            opened.push(evaluator.gpu.clone().unwrap());
        }
        assert!(Arc::ptr_eq(&opened[0], &opened[1]));
    }

    /// A GPU, or without an adapter none.
    fn any_gpu(boundaries: &Boundaries) -> Option<Gpu> {
        match Gpu::new(boundaries, Adapter::Any) {
            Ok(gpu) => Some(gpu),
            Err(Error::Device(_)) => {
                crate::skipped::skipped("no wgpu adapter");
                None
            }
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn only_cells_that_are_asked_for_are_uploaded() {
        let mut random = Random::new(33);
        let stack = busy_stack(&mut random, 5, 10);
        let complex = stack.complex();
        let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
        let Some(gpu) = any_gpu(&boundaries) else { return };
        let all = stack.queries(&mut random, 200);
        let mut some = Queries::default();
        for run in all.runs.iter().filter(|run| run.cell % 2 == 1) {
            let start = some.points.len();
            some.points.extend(&all.points[run.points.clone()]);
            some.runs.push(Run { cell: run.cell, points: start..some.points.len() });
        }
        let uploaded = gpu.upload(&some).unwrap();
        assert!(!uploaded.cells.is_empty());
        assert!(uploaded.cells.iter().all(|&cell| cell % 2 == 1), "{:?}", uploaded.cells);
        let expected = gpu.cpu.evaluate(&some).unwrap();
        let found = gpu.evaluate(&some).unwrap();
        let far = found.iter().zip(&expected).filter(|(one, other)| (*one - *other).abs() > 1e-3);
        assert!(far.count() < 9);
    }

    /// Plausible numbers that are not the field's are noticed too.
    #[test]
    fn stale_results_are_noticed() {
        let mut random = Random::new(31);
        let stack = busy_stack(&mut random, 3, 10);
        let complex = stack.complex();
        let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
        let Some(gpu) = any_gpu(&boundaries) else { return };
        let queries = stack.queries(&mut random, 3000);
        let right = gpu.evaluate(&queries).unwrap();
        let stale: Vec<f32> = right.iter().map(|f| f * 0.5).collect();
        for batch in batches(gpu.cpu.cells(), &queries, gpu.opened.limits) {
            gpu.spot_check(&queries, &batch, &right).unwrap();
            let error = gpu.spot_check(&queries, &batch, &stale).unwrap_err();
            assert!(error.to_string().contains("use the CPU"), "{error}");
        }
    }
}
