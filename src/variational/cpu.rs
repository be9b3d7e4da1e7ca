//! Conjugate gradients on the CPU: rayon over leaves, vector instructions within.
//! Sums are taken leaf by leaf and then over the leaves in their order, so that
//! results do not depend on the number of threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Result;
use crate::grid::leaf_grid::{LeafGrid, NO_SLOT};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE};

use super::backend::{Backend, Correction, Limits};
use super::stencil::{
    Nodes, Patch, add_anchors, add_sample_diagonal, add_samples, stencil, stencil_at_boundary,
    stencil_diagonal,
};
use super::system::{PATCH, PATCH_NODES, REACH, SIDE, System};

/// Leaves that a thread takes at least.
const FEW: usize = 8;

/// The CPU.
#[derive(Debug, Clone, Copy)]
pub struct Cpu {
    fused: bool,
}

impl Cpu {
    /// With the best instructions that this processor has.
    pub fn new() -> Self {
        #[cfg(target_arch = "x86_64")]
        let fused = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
        #[cfg(not(target_arch = "x86_64"))]
        let fused = false;
        Self { fused }
    }

    /// With the instructions that every processor of its kind has.
    #[cfg(test)]
    pub fn baseline() -> Self {
        Self { fused: false }
    }

    /// A x in one leaf, for values of all leaves that are 0 where they are not free;
    /// returns its part of x · A x.
    pub fn apply_in(self, system: &System, leaf: usize, values: &[f32], out: &mut Nodes) -> f64 {
        #[cfg(target_arch = "x86_64")]
        if self.fused {
            // SAFETY: `new` found these instructions on this processor.
            return unsafe { apply_fused(system, leaf, values, out) };
        }
        let _ = self.fused;
        apply(system, leaf, values, out)
    }
}

impl Default for Cpu {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn apply_fused(system: &System, leaf: usize, values: &[f32], out: &mut Nodes) -> f64 {
    apply(system, leaf, values, out)
}

#[inline(always)]
fn apply(system: &System, leaf: usize, values: &[f32], out: &mut Nodes) -> f64 {
    let mut patch = [0.0; PATCH_NODES];
    gather(system, leaf, values, &mut patch);
    match system.domain_near(system.leaves[leaf]) {
        None => stencil(&patch, &system.directions, out),
        Some(domain) => {
            stencil_at_boundary(&patch, system.leaves[leaf], domain, &system.directions, out);
        }
    }
    add_samples(&patch, system.samples_of(leaf), |sample, value| sample.weight * value, out);
    if let Some(anchors) = &system.anchors {
        let [weights, _] = anchors.of(leaf);
        add_anchors(&patch, |node, value| weights[node] * value, out);
    }
    if system.hold > 0.0 {
        let values = &values.as_chunks::<LEAF_NODES>().0[leaf];
        out.iter_mut().zip(values).for_each(|(out, value)| *out += system.hold * value);
    }
    keep_free(&system.free[leaf], out);
    dot(&values.as_chunks::<LEAF_NODES>().0[leaf], out)
}

/// Sets what is not free to 0.
#[inline(always)]
fn keep_free(free: &[u64; 8], out: &mut Nodes) {
    if *free == [u64::MAX; 8] {
        return;
    }
    for (node, out) in out.iter_mut().enumerate() {
        if free[node / 64] >> (node % 64) & 1 == 0 {
            *out = 0.0;
        }
    }
}

/// The patch of a leaf of the system from values leaf by leaf.
#[inline(always)]
fn gather(system: &System, leaf: usize, values: &[f32], patch: &mut Patch) {
    let leaves = values.as_chunks::<LEAF_NODES>().0;
    let own = system.neighbours[leaf].map(|slot| match slot {
        NO_SLOT => &NOTHING,
        slot => &leaves[slot as usize],
    });
    fill_patch(&own, patch);
}

/// Values of a leaf that is not there.
const NOTHING: Nodes = [0.0; LEAF_NODES];

/// The patch from the 27 leaves around one.
#[inline(always)]
fn fill_patch(leaves: &[&Nodes; 27], patch: &mut Patch) {
    let rows = patch.as_chunks_mut::<PATCH>().0;
    for (step_x, layers_x, first_x) in LAYERS {
        for (step_y, layers_y, first_y) in LAYERS {
            let lines: [_; 3] = std::array::from_fn(|step_z| {
                leaves[step_x * 9 + step_y * 3 + step_z].as_chunks::<LEAF_SIDE>().0
            });
            for (x, row_x) in layers_x.clone().zip(first_x..) {
                for (y, row_y) in layers_y.clone().zip(first_y..) {
                    let row = &mut rows[row_x * PATCH + row_y];
                    let [before, here, after] = lines.map(|lines| &lines[x * LEAF_SIDE + y]);
                    row[..REACH].copy_from_slice(&before[LEAF_SIDE - REACH..]);
                    row[REACH..REACH + LEAF_SIDE].copy_from_slice(here);
                    row[REACH + LEAF_SIDE..].copy_from_slice(&after[..REACH]);
                }
            }
        }
    }
}

/// Of three leaves in a row which one, its layers that a patch takes, and the first of
/// the patch's that they become.
const LAYERS: [(usize, Range<usize>, usize); 3] = [
    (0, LEAF_SIDE - REACH..LEAF_SIDE, 0),
    (1, 0..LEAF_SIDE, REACH),
    (2, 0..REACH, REACH + LEAF_SIDE),
];

/// What is left of the right-hand side: b − A x in the free nodes, leaf by leaf,
/// for the values x of a grid that holds all that the stencil reaches; `starts` are the values
/// where nodes are held.
pub fn residual(system: &System, grid: &LeafGrid, starts: &LeafGrid) -> Vec<f32> {
    let mut residual = vec![0.0; system.leaves.len() * LEAF_NODES];
    let leaves = residual.as_chunks_mut::<LEAF_NODES>().0;
    leaves.par_iter_mut().enumerate().with_min_len(FEW).for_each(|(leaf, out)| {
        let at = system.leaves[leaf];
        let mut patch = [0.0; PATCH_NODES];
        grid.gather::<PATCH>(at.map(|along| along * SIDE - REACH as i32), &mut patch);
        match system.domain_near(at) {
            None => stencil(&patch, &system.directions, out),
            Some(domain) => stencil_at_boundary(&patch, at, domain, &system.directions, out),
        }
        let samples = system.samples_of(leaf);
        add_samples(&patch, samples, |one, value| one.weight * (value - one.target), out);
        if let Some(anchors) = &system.anchors {
            let [weights, targets] = anchors.of(leaf);
            add_anchors(&patch, |node, value| weights[node] * (value - targets[node]), out);
        }
        if let Some(starts) = starts.get(at).filter(|_| system.hold > 0.0) {
            add_anchors(&patch, |node, value| system.hold * (value - starts[node]), out);
        }
        out.iter_mut().for_each(|value| *value = -*value);
        keep_free(&system.free[leaf], out);
    });
    residual
}

/// One over the diagonal of A; 0 where a node is not free.
pub fn inverse_diagonal(system: &System) -> Vec<f32> {
    let mut diagonal = vec![0.0; system.leaves.len() * LEAF_NODES];
    let leaves = diagonal.as_chunks_mut::<LEAF_NODES>().0;
    leaves.par_iter_mut().enumerate().with_min_len(FEW).for_each(|(leaf, out)| {
        let at = system.leaves[leaf];
        stencil_diagonal(at, system.domain_near(at), &system.directions, out);
        add_sample_diagonal(system.samples_of(leaf), out);
        if let Some(anchors) = &system.anchors {
            let [weights, _] = anchors.of(leaf);
            out.iter_mut().zip(weights).for_each(|(out, weight)| *out += weight);
        }
        out.iter_mut().for_each(|value| *value += system.hold);
        out.iter_mut().for_each(|value| *value = if *value > 0.0 { 1.0 / *value } else { 0.0 });
        keep_free(&system.free[leaf], out);
    });
    diagonal
}

impl Backend for Cpu {
    fn name(&self) -> String {
        let threads = rayon::current_num_threads();
        let instructions = if self.fused { "avx2" } else { "baseline" };
        format!("cpu ({instructions}, threads: {threads})")
    }

    fn apply(&self, system: &System, values: &[f32]) -> Result<Vec<f32>> {
        let mut out = vec![0.0; values.len()];
        self.apply_all(system, values, &mut out);
        Ok(out)
    }

    fn correct(&self, system: &System, residual: Vec<f32>, limits: Limits) -> Result<Correction> {
        let inverse = inverse_diagonal(system);
        let mut state = State {
            correction: vec![0.0; residual.len()],
            product: vec![0.0; residual.len()],
            direction: residual.iter().zip(&inverse).map(|(r, by)| r * by).collect(),
            residual,
            inverse,
        };
        let mut size = size(&state.residual, &state.inverse);
        let first = size;
        let goal = limits.goal(first);
        let mut iterations = 0;
        while iterations < limits.iterations && size > goal {
            let curvature = self.apply_all(system, &state.direction, &mut state.product);
            if curvature <= 0.0 {
                break;
            }
            let length = (size / curvature) as f32;
            let next = state.reduce(length);
            state.turn(length, (next / size) as f32);
            size = next;
            iterations += 1;
        }
        Ok(Correction { values: state.correction, iterations, size: first })
    }
}

impl Cpu {
    /// A x, and the product x · A x.
    fn apply_all(&self, system: &System, values: &[f32], out: &mut [f32]) -> f64 {
        let leaves = out.as_chunks_mut::<LEAF_NODES>().0;
        let products: Vec<f64> = leaves
            .par_iter_mut()
            .enumerate()
            .with_min_len(FEW)
            .map(|(leaf, out)| self.apply_in(system, leaf, values, out))
            .collect();
        products.iter().sum()
    }
}

/// r · D⁻¹ r.
pub fn size(residual: &[f32], inverse: &[f32]) -> f64 {
    let leaves = residual.as_chunks::<LEAF_NODES>().0.par_iter();
    let inverse = inverse.as_chunks::<LEAF_NODES>().0;
    let sizes: Vec<f64> = leaves.zip(inverse).map(|(r, by)| weighted(r, by)).collect();
    sizes.iter().sum()
}

/// The vectors of conjugate gradients, leaf by leaf.
struct State {
    correction: Vec<f32>,
    residual: Vec<f32>,
    direction: Vec<f32>,
    product: Vec<f32>,
    inverse: Vec<f32>,
}

impl State {
    /// The residual after so long a step along the direction; returns r · D⁻¹ r.
    fn reduce(&mut self, length: f32) -> f64 {
        let residual = self.residual.as_chunks_mut::<LEAF_NODES>().0;
        let product = self.product.as_chunks::<LEAF_NODES>().0;
        let inverse = self.inverse.as_chunks::<LEAF_NODES>().0;
        let sizes: Vec<f64> = (residual.par_iter_mut().zip(product).zip(inverse))
            .with_min_len(FEW)
            .map(|((residual, product), inverse)| {
                for node in 0..LEAF_NODES {
                    residual[node] -= length * product[node];
                }
                weighted(residual, inverse)
            })
            .collect();
        sizes.iter().sum()
    }

    /// Goes that step, and turns to the next direction: D⁻¹ r and a part of the last
    /// one. Both in one go, since what takes time is to fetch the vectors.
    fn turn(&mut self, length: f32, part: f32) {
        let correction = self.correction.as_chunks_mut::<LEAF_NODES>().0;
        let direction = self.direction.as_chunks_mut::<LEAF_NODES>().0;
        let residual = self.residual.as_chunks::<LEAF_NODES>().0;
        let inverse = self.inverse.as_chunks::<LEAF_NODES>().0;
        (correction.par_iter_mut().zip(direction))
            .zip(residual.par_iter().zip(inverse))
            .with_min_len(FEW)
            .for_each(|((correction, direction), (residual, inverse))| {
                for node in 0..LEAF_NODES {
                    correction[node] += length * direction[node];
                    direction[node] = inverse[node] * residual[node] + part * direction[node];
                }
            });
    }
}

/// Lanes of partial sums, so that a sum becomes vector instructions.
const LANES: usize = 16;

#[inline(always)]
fn dot(one: &Nodes, other: &Nodes) -> f64 {
    let mut sums = [0.0f32; LANES];
    for (one, other) in one.as_chunks::<LANES>().0.iter().zip(other.as_chunks::<LANES>().0) {
        for lane in 0..LANES {
            sums[lane] += one[lane] * other[lane];
        }
    }
    sums.iter().map(|&sum| f64::from(sum)).sum()
}

/// Σ r² D⁻¹.
#[inline(always)]
fn weighted(residual: &Nodes, inverse: &Nodes) -> f64 {
    let mut sums = [0.0f32; LANES];
    let inverse = inverse.as_chunks::<LANES>().0;
    for (residual, inverse) in residual.as_chunks::<LANES>().0.iter().zip(inverse) {
        for lane in 0..LANES {
            sums[lane] += residual[lane] * residual[lane] * inverse[lane];
        }
    }
    sums.iter().map(|&sum| f64::from(sum)).sum()
}
