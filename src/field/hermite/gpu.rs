//! The GPU backend: `shaders/hermite.wgsl`, in batches as the mean-value field's. What a node
//! weighs is kept in memory between triangles and values, for every point.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::Cpu;
use super::packing::{HermiteCell, HermiteEdge};
use crate::error::Result;
use crate::field::gpu::batch::{Batch, GROUP, LaidOut, batches};
use crate::field::gpu::layout::DeviceFace;
use crate::field::gpu::{Opened, Uploaded};
use crate::field::{Field, Queries};
use crate::gpu::Adapter;
use crate::grid::samples::Values;
use crate::label::Label;

const SHADER: &str = concat!(
    include_str!("../../../shaders/field_frame.wgsl"),
    include_str!("../../../shaders/field_edge.wgsl"),
    include_str!("../../../shaders/hermite.wgsl"),
);

/// Invocations of a workgroup: GROUP of the shader.
const INVOCATIONS: usize = 64;
/// How far values may be from the CPU's, as a part of the cell's size.
const TOLERANCE: f64 = 1e-3;

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct DeviceCell {
    first_face: u32,
    end_face: u32,
    labels: u32,
    nodes: u32,
    first_tangent: u32,
    clearance: f32,
    padding: [u32; 2],
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct DeviceJob {
    cell: u32,
    first_point: u32,
    points: u32,
    first_value: u32,
    first_weight: u32,
    padding: [u32; 3],
}

/// Cells as the shader reads them.
#[derive(Default)]
struct Tables {
    cells: Vec<DeviceCell>,
    faces: Vec<DeviceFace>,
    rows: Vec<[u32; 4]>,
    tangents: Vec<[f32; 4]>,
}

/// The f32 backend on a GPU.
pub struct Gpu {
    /// The same cells, for spot checks and for those that are too large.
    cpu: Cpu,
    opened: Arc<Opened>,
}

/// Opens a GPU.
///
/// # Errors
/// [`Error::Device`](crate::error::Error::Device) when there is no such adapter.
pub fn open(adapter: Adapter) -> Result<Opened> {
    Opened::with(adapter, SHADER)
}

impl Gpu {
    /// The field of a CPU backend on a GPU.
    pub fn on(opened: Arc<Opened>, cpu: Cpu) -> Self {
        Self { cpu, opened }
    }

    fn upload(&self, queries: &Queries) -> Result<Uploaded> {
        let all = self.cpu.cells();
        let cells = self.opened.wanted(all, queries);
        let mut tables = Tables::default();
        cells.iter().for_each(|&cell| tables.add(&all[cell as usize]));
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
        let mut weights = 0;
        let mut jobs = Vec::with_capacity(batch.jobs.len());
        for job in &batch.jobs {
            jobs.push(DeviceJob {
                cell: uploaded.place(job.cell),
                first_point: job.first_point,
                points: job.points,
                first_value: job.first_value,
                first_weight: weights,
                padding: [0; 3],
            });
            let nodes = self.cpu.cells()[job.cell as usize].densities.len();
            weights += (nodes * INVOCATIONS) as u32;
        }
        let connection = &self.opened.connection;
        let points = connection.upload(bytemuck::cast_slice(&batch.points))?;
        let jobs = connection.upload(bytemuck::cast_slice(&jobs))?;
        let size = u64::from(weights) * size_of::<[f32; 4]>() as u64;
        connection.require_room(size)?;
        let weights = connection.buffer(size, wgpu::BufferUsages::STORAGE);
        let mut inputs: Vec<&wgpu::Buffer> = uploaded.tables.iter().collect();
        inputs.extend([&points, &jobs, &weights]);
        let groups = batch.jobs.len() as u32;
        let found =
            connection.dispatch(&self.opened.pipeline, &inputs, groups, batch.value_count)?;
        for (job, target) in batch.jobs.iter().zip(&batch.targets) {
            let count = job.points as usize * target.labels;
            let first = job.first_value as usize;
            values[target.value..target.value + count]
                .copy_from_slice(&found[first..first + count]);
        }
        self.spot_check(queries, batch, values)
    }

    /// Compares a few points with the CPU.
    fn spot_check(&self, queries: &Queries, batch: &Batch, values: &[f32]) -> Result<()> {
        let cells = self.cpu.cells();
        let sizes = batch.targets.iter().map(|target| 1.0 / cells[target.cell as usize].scale);
        let largest = sizes.fold(0.0, f64::max) / self.cpu.unit();
        let tolerance = (TOLERANCE * largest) as f32;
        self.opened.spot_check(batch, values, tolerance, |target, expected| {
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
        format!("gpu ({})", self.opened.connection.name())
    }

    fn values(&self) -> Values {
        self.cpu.values()
    }

    fn is_single(&self) -> bool {
        self.cpu.is_single()
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        let mut values = self.cpu.room_for(queries)?;
        let (cells, limits) = (self.cpu.cells(), self.opened.limits);
        let uploaded = self.upload(queries)?;
        for batch in batches(cells, queries, limits) {
            self.run(queries, &uploaded, &batch, &mut values)?;
        }
        self.cpu.evaluate_where(queries, &mut values, |cell| !limits.allow(cell));
        Ok(values)
    }
}

impl LaidOut for HermiteCell {
    fn label_count(&self) -> usize {
        self.labels.len()
    }

    fn edge_count(&self) -> u64 {
        self.edge_count()
    }

    fn turns(&self) -> u64 {
        (self.triangles.len() + (3 + self.labels.len()) * self.densities.len()) as u64
    }

    fn scratch(&self) -> u64 {
        // A workgroup has GROUP points, a number for each at every node.
        (self.densities.len() * GROUP * size_of::<f32>()) as u64
    }

    fn localize(&self, point: DVec3) -> DVec3 {
        self.localize(point)
    }
}

impl Tables {
    fn add(&mut self, cell: &HermiteCell) {
        let first_face = self.faces.len() as u32;
        for face in &cell.faces {
            let first_corner = self.rows.len() as u32;
            self.rows.extend(cell.corners[face.corners.clone()].iter().map(|corner| {
                [corner.at[0], corner.at[1], corner.rest[0], corner.rest[1]].map(f32::to_bits)
            }));
            let first_triangle = self.rows.len() as u32;
            let edges = &cell.edges[face.edges.clone()];
            for triangle in &cell.triangles[face.triangles.clone()] {
                let [a, b, c] = triangle.corners.map(|corner| first_corner + corner);
                self.rows.push([a, b, c, triangle.quarter.to_bits()]);
                let clockwise = (0..3).filter(|&own| triangle.signs[own] < 0.0);
                let [a, b, c] = triangle.nodes;
                self.rows.push([a, b, c, clockwise.fold(0, |bits, own| bits | 1 << own)]);
                let more = [triangle.far, triangle.sixth, 0.0];
                self.rows.extend(triangle.edges.iter().zip(more).map(|(&own, more)| {
                    let HermiteEdge { span: [u, v], span_squared, .. } = edges[own as usize];
                    [u, v, span_squared, more].map(f32::to_bits)
                }));
            }
            let triangles = [first_triangle, self.rows.len() as u32];
            self.faces.push(DeviceFace::new(
                &face.frame,
                [first_corner, first_triangle],
                triangles,
            ));
        }
        let first_tangent = self.tangents.len() as u32;
        let labels = cell.labels.len();
        for (node, &density) in cell.densities.iter().enumerate() {
            self.tangents.push([density, 0.0, 0.0, 0.0]);
            self.tangents.extend(&cell.tangents[node * labels..(node + 1) * labels]);
        }
        self.cells.push(DeviceCell {
            first_face,
            end_face: self.faces.len() as u32,
            labels: labels as u32,
            nodes: cell.densities.len() as u32,
            first_tangent,
            clearance: cell.clearance,
            padding: [0; 2],
        });
    }

    /// In the order of the bindings; none is empty.
    fn contents(&mut self) -> [&[u8]; 4] {
        self.cells.push(Zeroable::zeroed());
        self.faces.push(Zeroable::zeroed());
        self.rows.push(Zeroable::zeroed());
        self.tangents.push(Zeroable::zeroed());
        [
            bytemuck::cast_slice(&self.cells),
            bytemuck::cast_slice(&self.faces),
            bytemuck::cast_slice(&self.rows),
            bytemuck::cast_slice(&self.tangents),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::gpu::layout::DevicePoint;
    use crate::gpu::shader::Shader;

    #[test]
    fn the_shader_is_valid_and_its_layouts_are_the_hosts() {
        let shader = Shader::new(SHADER);
        shader.require_sizes(&[
            ("Cell", size_of::<DeviceCell>()),
            ("Face", size_of::<DeviceFace>()),
            ("Point", size_of::<DevicePoint>()),
            ("Job", size_of::<DeviceJob>()),
        ]);
        assert_eq!(shader.constant("GROUP"), INVOCATIONS);
        assert_eq!(shader.workgroups(), [INVOCATIONS as u32]);
    }
}
