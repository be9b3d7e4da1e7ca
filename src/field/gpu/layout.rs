//! Cells and points as the shader reads them; the structures are those of
//! `shaders/field_types.wgsl` and `shaders/field_frame.wgsl`.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use crate::field::packing::{
    Chain, Frame, PackedCell, PackedCorner, PackedEdge, PackedFace, PackedRamp, split,
};

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
    first_ramp: u32,
    end_ramp: u32,
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

/// Cells, one after another.
#[derive(Default)]
pub struct Tables {
    cells: Vec<DeviceCell>,
    faces: Vec<DeviceFace>,
    chains: Vec<Chain>,
    edges: Vec<PackedEdge>,
    /// Ramps and their slopes, as rows of four numbers: p and q as edges have
    /// them, the span and the number of slopes, and then for each slope its
    /// label and three parts. One binding for both, because some devices have
    /// no more than eight; bits of integers, because a device may flush a
    /// small integer to zero where it takes it for a number.
    ramps: Vec<[u32; 4]>,
}

impl Tables {
    pub fn new<'a>(cells: impl Iterator<Item = &'a PackedCell>) -> Self {
        let mut tables = Self::default();
        for cell in cells {
            tables.add(cell);
        }
        // A binding must not be empty, even when nothing reads it.
        tables.cells.push(Zeroable::zeroed());
        tables.faces.push(Zeroable::zeroed());
        tables.chains.push(Zeroable::zeroed());
        tables.edges.push(Zeroable::zeroed());
        tables.ramps.push(Zeroable::zeroed());
        tables
    }

    fn add(&mut self, cell: &PackedCell) {
        let first_face = self.faces.len() as u32;
        let first_chain = self.chains.len() as u32;
        let first_edge = self.edges.len() as u32;
        for face in &cell.faces {
            let chains = [face.first_chain, face.end_chain].map(|chain| first_chain + chain);
            let first_ramp = self.ramps.len() as u32;
            for ramp in &cell.ramps[face.ramps()] {
                self.add_ramp(cell, face, ramp);
            }
            let ramps = [first_ramp, self.ramps.len() as u32];
            self.faces.push(DeviceFace::new(&face.frame, chains, ramps));
        }
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

    fn add_ramp(&mut self, cell: &PackedCell, face: &PackedFace, ramp: &PackedRamp) {
        let corners = &cell.corners[face.corners()];
        let row = |end: u32| {
            let PackedCorner { at, rest } = corners[end as usize];
            [at[0], at[1], rest[0], rest[1]].map(f32::to_bits)
        };
        let slopes = &cell.slopes[ramp.first_slope as usize..ramp.end_slope as usize];
        self.ramps.extend(ramp.ends.map(row));
        let [x, y] = ramp.span.map(f32::to_bits);
        self.ramps.push([x, y, ramp.span_squared.to_bits(), slopes.len() as u32]);
        self.ramps.extend(slopes.iter().map(|slope| {
            let [value, along, across] = [slope.value, slope.along, slope.across].map(f32::to_bits);
            [slope.label, value, along, across]
        }));
    }

    /// In the order of the bindings.
    pub fn contents(&self) -> [&[u8]; 5] {
        [
            bytemuck::cast_slice(&self.cells),
            bytemuck::cast_slice(&self.faces),
            bytemuck::cast_slice(&self.chains),
            bytemuck::cast_slice(&self.edges),
            bytemuck::cast_slice(&self.ramps),
        ]
    }
}

impl DeviceFace {
    /// A face's plane, with its chains or corners, and its ramps or triangles.
    pub fn new(
        frame: &Frame,
        [first_chain, end_chain]: [u32; 2],
        [first_ramp, end_ramp]: [u32; 2],
    ) -> Self {
        let [first, second] = frame.tangents;
        let [mut normal, mut normal_rest] = split_row(frame.normal);
        (normal[3], normal_rest[3]) = split(frame.offset);
        Self {
            first_tangent: split_row(first),
            second_tangent: split_row(second),
            normal: [normal, normal_rest],
            first_chain,
            end_chain,
            first_ramp,
            end_ramp,
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
