//! Queries cut into dispatches.

use super::layout::{DeviceJob, DevicePoint};
use crate::field::Queries;
use crate::field::packing::PackedCell;
use crate::gpu::Connection;

/// Points of one workgroup: GROUP · POINTS of `shaders/field_types.wgsl`.
const GROUP: usize = 256;

/// WINDOW of `shaders/field_types.wgsl`.
const WINDOW: usize = 16;

/// Points of 32 invocations.
const WAVE: usize = 128;

/// What one dispatch may take.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Edges × points. Integrated GPUs do some 1e10 a second, a software
    /// adapter 1e8.
    pub work: u64,
    /// Workgroups along one dimension.
    pub groups: usize,
    /// Bytes of points, and of values.
    pub bytes: u64,
    /// Turns of all loops of one invocation together.
    pub turns: u64,
}

/// One dispatch.
#[derive(Default)]
pub struct Batch {
    pub points: Vec<DevicePoint>,
    pub jobs: Vec<DeviceJob>,
    /// For every job, where its values belong.
    pub targets: Vec<Target>,
    pub value_count: usize,
    work: u64,
}

/// A job's place in the query.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    pub cell: u32,
    /// Labels of the cell.
    pub labels: usize,
    /// Its first point.
    pub point: usize,
    /// The first of its values.
    pub value: usize,
}

impl Limits {
    pub fn of(connection: &Connection) -> Self {
        let limits = connection.limits();
        Self {
            work: if connection.is_software() { 20_000_000 } else { 1_000_000_000 },
            groups: limits.max_compute_workgroups_per_dimension as usize,
            bytes: limits.max_storage_buffer_binding_size.min(64 << 20),
            // Mesa's software driver leaves all loops after 65,535 turns.
            turns: if connection.is_software() { 60_000 } else { u64::MAX },
        }
    }

    /// Whether the device can evaluate a cell, and there is something to.
    pub fn allow(&self, cell: &PackedCell) -> bool {
        let passes = cell.labels.len().div_ceil(WINDOW);
        let turns = cell.chains.len() + cell.edges.len() + cell.ramps.len() + cell.slopes.len();
        cell.labels.len() > 1 && (passes * turns) as u64 <= self.turns
    }
}

/// Cuts a query into batches; cells that the limits do not allow take part in
/// none.
pub fn batches(
    cells: &[PackedCell],
    queries: &Queries,
    limits: Limits,
) -> impl Iterator<Item = Batch> {
    let targets = targets(cells, queries);
    let allowed = move |(target, _): &(Target, usize)| limits.allow(&cells[target.cell as usize]);
    let mut targets = targets.filter(allowed).peekable();
    std::iter::from_fn(move || {
        let mut batch = Batch::default();
        while let Some((target, end)) = targets.next_if(|_| batch.has_room(limits)) {
            batch.push(&cells[target.cell as usize], target, &queries.points[target.point..end]);
        }
        (!batch.jobs.is_empty()).then_some(batch)
    })
}

/// The points of every workgroup, in order, with the end of each.
fn targets(cells: &[PackedCell], queries: &Queries) -> impl Iterator<Item = (Target, usize)> {
    let mut value = 0;
    let runs = queries.runs.iter().map(move |run| {
        let first_value = value;
        let labels = cells[run.cell as usize].labels.len();
        value += run.points.len() * labels;
        (run, labels, first_value)
    });
    runs.flat_map(|(run, labels, first_value)| {
        run.points.clone().step_by(GROUP).map(move |point| {
            let value = first_value + (point - run.points.start) * labels;
            let target = Target { cell: run.cell, labels, point, value };
            (target, run.points.end.min(point + GROUP))
        })
    })
}

impl Batch {
    fn has_room(&self, limits: Limits) -> bool {
        let largest = self.value_count * size_of::<f32>();
        let largest = largest.max(self.points.len() * size_of::<DevicePoint>()) as u64;
        self.work < limits.work && self.jobs.len() < limits.groups && largest < limits.bytes / 2
    }

    fn push(&mut self, cell: &PackedCell, target: Target, points: &[glam::DVec3]) {
        self.jobs.push(DeviceJob {
            cell: target.cell,
            first_point: self.points.len() as u32,
            points: points.len() as u32,
            first_value: self.value_count as u32,
        });
        self.targets.push(target);
        self.points.extend(points.iter().map(|&point| DevicePoint::new(cell.localize(point))));
        self.value_count += points.len() * target.labels;
        // Invocations work in waves: a few points cost as much as a wave does.
        self.work += points.len().next_multiple_of(WAVE) as u64 * cell.edge_count();
    }
}
