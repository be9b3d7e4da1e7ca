//! A system as the shader reads it; the structures are those of
//! `shaders/variational.wgsl`.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use crate::grid::samples::LEAF_NODES;
use crate::variational::backend::Limits;
use crate::variational::metric::{DIRECTIONS, Direction};
use crate::variational::system::{Domain, SIDE, Sample, System};

/// Numbers of the shader's bindings.
pub const LEAVES: usize = 0;
pub const SAMPLES: usize = 1;
pub const INVERSE: usize = 2;
pub const DIRECTION: usize = 3;
pub const PRODUCT: usize = 4;
pub const CORRECTION: usize = 5;
pub const RESIDUAL: usize = 6;
pub const PARTS: usize = 7;
pub const STATE: usize = 8;
/// The state again, for those who write it.
pub const NEXT: usize = 9;

/// Bytes of a vector's values in a leaf.
pub const LEAF_BYTES: u64 = (LEAF_NODES * size_of::<f32>()) as u64;

#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct DeviceLeaf {
    neighbours: [u32; 27],
    first_sample: u32,
    end_sample: u32,
    at: [i32; 3],
    free: [[u32; 2]; 8],
}

/// Where conjugate gradients have got.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct State {
    leaves: u32,
    low: [i32; 3],
    high: [i32; 3],
    limit: u32,
    pub iterations: u32,
    pub is_done: u32,
    tolerance: f32,
    size: f32,
    goal: f32,
    factor: f32,
    hold: f32,
    count: u32,
    directions: [DeviceDirection; DIRECTIONS],
}

#[derive(Debug, Clone, Copy, Default, Pod, Zeroable)]
#[repr(C)]
pub struct DeviceDirection {
    step: [i32; 3],
    weight: f32,
}

/// The leaves, and their samples sorted by the cell they lie in.
pub struct Tables {
    pub leaves: Vec<DeviceLeaf>,
    pub samples: Vec<Sample>,
}

impl Tables {
    pub fn new(system: &System) -> Self {
        let leaves = (0..system.leaves.len())
            .into_par_iter()
            .map(|leaf| DeviceLeaf {
                neighbours: system.neighbours[leaf],
                first_sample: system.starts[leaf],
                end_sample: system.starts[leaf + 1],
                at: system.leaves[leaf].map(|along| along * SIDE),
                free: system.free[leaf].map(|word| [word as u32, (word >> 32) as u32]),
            })
            .collect();
        let mut samples = system.samples.clone();
        let mut rest = samples.as_mut_slice();
        let mut own = Vec::with_capacity(system.leaves.len());
        for ends in system.starts.windows(2) {
            let (first, others) = rest.split_at_mut((ends[1] - ends[0]) as usize);
            own.push(first);
            rest = others;
        }
        own.into_par_iter().for_each(|own| own.sort_by_key(|sample| sample.node));
        Self { leaves, samples }
    }
}

impl State {
    /// Before the first iteration, `size` being r · D⁻¹ r then.
    pub fn new(system: &System, limits: Limits, size: f64) -> Self {
        // As good as without an end: no lattice has so many nodes.
        const FAR: i32 = 1 << 29;
        let endless = Domain { low: [-FAR; 3], high: [FAR; 3] };
        let domain = system.domain.unwrap_or(endless);
        let mut directions = [DeviceDirection::default(); DIRECTIONS];
        for (to, &Direction { step, weight }) in directions.iter_mut().zip(&system.directions) {
            *to = DeviceDirection { step, weight };
        }
        Self {
            leaves: system.leaves.len() as u32,
            low: domain.low,
            high: domain.high,
            limit: limits.iterations,
            iterations: 0,
            is_done: 0,
            tolerance: if size > 0.0 { (limits.goal(size) / size) as f32 } else { 0.0 },
            size: 0.0,
            goal: -1.0,
            factor: 0.0,
            hold: system.hold,
            count: system.directions.len() as u32,
            directions,
        }
    }
}
