//! Cells and points as the shader reads them; the structures are those of
//! `shaders/field_types.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::field::packing::{Chain, Frame, PackedCell, PackedEdge, split};

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DeviceCell {
    first_face: u32,
    end_face: u32,
    labels: u32,
    clearance: f32,
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DeviceFace {
    first_tangent: [[f32; 4]; 2],
    second_tangent: [[f32; 4]; 2],
    normal: [[f32; 4]; 2],
    first_chain: u32,
    end_chain: u32,
    padding: [u32; 2],
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DevicePoint {
    at: [f32; 4],
    rest: [f32; 4],
}

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DeviceJob {
    pub cell: u32,
    pub first_point: u32,
    pub points: u32,
    pub first_value: u32,
}

/// All cells, one after another.
#[derive(Default)]
pub struct Tables {
    cells: Vec<DeviceCell>,
    faces: Vec<DeviceFace>,
    chains: Vec<Chain>,
    edges: Vec<PackedEdge>,
}

impl Tables {
    pub fn new(cells: &[PackedCell]) -> Self {
        let mut tables = Self::default();
        for cell in cells {
            tables.add(cell);
        }
        // A binding must not be empty, even when nothing reads it.
        tables.faces.push(Zeroable::zeroed());
        tables.chains.push(Zeroable::zeroed());
        tables.edges.push(Zeroable::zeroed());
        tables
    }

    fn add(&mut self, cell: &PackedCell) {
        let first_face = self.faces.len() as u32;
        let first_chain = self.chains.len() as u32;
        let first_edge = self.edges.len() as u32;
        self.faces.extend(cell.faces.iter().map(|face| {
            let chains = [face.first_chain, face.end_chain].map(|chain| first_chain + chain);
            DeviceFace::new(&face.frame, chains)
        }));
        self.chains.extend(cell.chains.iter().map(|chain| Chain {
            first_edge: first_edge + chain.first_edge,
            end_edge: first_edge + chain.end_edge,
            ..*chain
        }));
        self.edges.extend_from_slice(&cell.edges);
        self.cells.push(DeviceCell {
            first_face,
            end_face: self.faces.len() as u32,
            labels: cell.labels.len() as u32,
            clearance: cell.clearance,
        });
    }

    /// In the order of the bindings.
    pub fn contents(&self) -> [&[u8]; 4] {
        [
            bytemuck::cast_slice(&self.cells),
            bytemuck::cast_slice(&self.faces),
            bytemuck::cast_slice(&self.chains),
            bytemuck::cast_slice(&self.edges),
        ]
    }
}

impl DeviceFace {
    fn new(frame: &Frame, [first_chain, end_chain]: [u32; 2]) -> Self {
        let [first, second] = frame.tangents;
        let [mut normal, mut normal_rest] = split_row(frame.normal);
        (normal[3], normal_rest[3]) = split(frame.offset);
        Self {
            first_tangent: split_row(first),
            second_tangent: split_row(second),
            normal: [normal, normal_rest],
            first_chain,
            end_chain,
            padding: [0; 2],
        }
    }
}

impl DevicePoint {
    /// A point in its cell's coordinates.
    pub fn new(local: DVec3) -> Self {
        let [at, rest] = split_row(local);
        Self { at, rest }
    }
}

/// Components rounded to a grid of 2⁻¹², and the remainders. Products of two
/// such parts lie on a grid of 2⁻²⁴; while their sum is below one, f32 holds
/// it exactly.
fn split_row(row: DVec3) -> [[f32; 4]; 2] {
    const GRID: f64 = 4096.0;
    let coarse = (row * GRID).round() / GRID;
    [coarse, row - coarse].map(|part| part.as_vec3().extend(0.0).to_array())
}
