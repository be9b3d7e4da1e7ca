//! Queries cut into dispatches.

use super::layout::{DeviceJob, DevicePoint};
use crate::field::Queries;
use crate::field::packing::PackedCell;
use crate::gpu::Connection;
use glam::DVec3;

/// Points of one workgroup: GROUP · POINTS of `shaders/field_frame.wgsl`.
pub const GROUP: usize = 256;

/// WINDOW of `shaders/field_types.wgsl`.
pub const WINDOW: usize = 16;

/// Points of 32 invocations.
pub const WAVE: usize = 128;

/// A cell as batches see it.
pub trait LaidOut: Sync {
    /// How many labels it has.
    fn label_count(&self) -> usize;
    /// How many edges are evaluated for a point; nothing is without.
    fn edge_count(&self) -> u64;
    /// Turns of all loops of one invocation together.
    fn turns(&self) -> u64;
    /// Bytes that a workgroup needs on the way.
    fn scratch(&self) -> u64;
    /// A point in the cell's coordinates.
    fn localize(&self, point: DVec3) -> DVec3;
}

impl LaidOut for PackedCell {
    fn label_count(&self) -> usize {
        self.labels.len()
    }

    fn edge_count(&self) -> u64 {
        self.edge_count()
    }

    fn turns(&self) -> u64 {
        let passes = self.labels.len().div_ceil(WINDOW);
        let turns = self.chains.len() + self.edges.len() + self.ramps.len() + self.slopes.len();
        (passes * turns) as u64
    }

    fn scratch(&self) -> u64 {
        0
    }

    fn localize(&self, point: DVec3) -> DVec3 {
        self.localize(point)
    }
}

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
    /// Bytes that its jobs need on the way.
    scratch: u64,
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
    pub fn allow(&self, cell: &impl LaidOut) -> bool {
        cell.edge_count() > 0 && cell.turns() <= self.turns && cell.scratch() <= self.bytes
    }
}

/// Cuts a query into batches; cells that the limits do not allow take part in
/// none.
pub fn batches<C: LaidOut>(
    cells: &[C],
    queries: &Queries,
    limits: Limits,
) -> impl Iterator<Item = Batch> {
    let targets = targets(cells, queries);
    let allowed = move |(target, _): &(Target, usize)| limits.allow(&cells[target.cell as usize]);
    let mut targets = targets.filter(allowed).peekable();
    std::iter::from_fn(move || {
        let mut batch = Batch::default();
        let has_room = |batch: &Batch, target: &Target| {
            batch.has_room(limits, cells[target.cell as usize].scratch())
        };
        while let Some((target, end)) = targets.next_if(|next| has_room(&batch, &next.0)) {
            batch.push(&cells[target.cell as usize], target, &queries.points[target.point..end]);
        }
        (!batch.jobs.is_empty()).then_some(batch)
    })
}

/// The points of every workgroup, in order, with the end of each.
fn targets<C: LaidOut>(cells: &[C], queries: &Queries) -> impl Iterator<Item = (Target, usize)> {
    let mut value = 0;
    let runs = queries.runs.iter().map(move |run| {
        let first_value = value;
        let labels = cells[run.cell as usize].label_count();
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
    /// Whether a job may be added that needs some bytes on the way.
    fn has_room(&self, limits: Limits, scratch: u64) -> bool {
        if self.jobs.is_empty() {
            return true;
        }
        let largest = self.value_count * size_of::<f32>();
        let largest = largest.max(self.points.len() * size_of::<DevicePoint>()) as u64;
        self.work < limits.work
            && self.jobs.len() < limits.groups
            && largest < limits.bytes / 2
            && self.scratch + scratch <= limits.bytes
    }

    fn push(&mut self, cell: &impl LaidOut, target: Target, points: &[DVec3]) {
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
        self.scratch += cell.scratch();
    }
}
