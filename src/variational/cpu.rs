//! Conjugate gradients on the CPU: rayon over leaves, vector instructions within.
//! Sums are taken leaf by leaf and then over the leaves in their order, so that
//! results do not depend on the number of threads.

use rayon::prelude::*;

use crate::error::Result;
use crate::grid::leaf_grid::{LeafGrid, NO_SLOT};
use crate::grid::samples::LEAF_NODES;

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

    /// A x in one leaf, x being 0 where it is not free.
    fn apply_leaf(self, system: &System, leaf: usize, patch: &Patch, out: &mut Nodes) {
        #[cfg(target_arch = "x86_64")]
        if self.fused {
            // SAFETY: `new` found these instructions on this processor.
            unsafe { apply_fused(system, leaf, patch, out) };
            return;
        }
        let _ = self.fused;
        apply(system, leaf, patch, out);
    }
}

impl Default for Cpu {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn apply_fused(system: &System, leaf: usize, patch: &Patch, out: &mut Nodes) {
    apply(system, leaf, patch, out);
}

#[inline(always)]
fn apply(system: &System, leaf: usize, patch: &Patch, out: &mut Nodes) {
    match system.domain_near(system.leaves[leaf]) {
        None => stencil(patch, out),
        Some(domain) => stencil_at_boundary(patch, system.leaves[leaf], domain, out),
    }
    add_samples(patch, system.samples_of(leaf), |sample, value| sample.weight * value, out);
    if let Some(anchors) = &system.anchors {
        let [weights, _] = anchors.of(leaf);
        add_anchors(patch, |node, value| weights[node] * value, out);
    }
    keep_free(&system.free[leaf], out);
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
fn gather(system: &System, leaf: usize, values: &[f32], patch: &mut Patch) {
    let leaves = values.as_chunks::<LEAF_NODES>().0;
    for (step, &slot) in system.neighbours[leaf].iter().enumerate() {
        let (to, from, count) = overlap([step / 9, step / 3 % 3, step % 3]);
        for x in 0..count[0] {
            for y in 0..count[1] {
                let row = ((to[0] + x) * PATCH + to[1] + y) * PATCH + to[2];
                let out = &mut patch[row..row + count[2]];
                if slot == NO_SLOT {
                    out.fill(0.0);
                } else {
                    let row = ((from[0] + x) * 8 + from[1] + y) * 8 + from[2];
                    out.copy_from_slice(&leaves[slot as usize][row..row + count[2]]);
                }
            }
        }
    }
}

/// Where in a patch the nodes of the neighbour at `step` (0, 1, 2 along each axis)
/// go, where in the neighbour they come from, and how many they are.
#[inline(always)]
fn overlap(step: [usize; 3]) -> ([usize; 3], [usize; 3], [usize; 3]) {
    let reach = REACH as usize;
    let side = SIDE as usize;
    let to = step.map(|step| [0, reach, reach + side][step]);
    let from = step.map(|step| [side - reach, 0, 0][step]);
    let count = step.map(|step| [reach, side, reach][step]);
    (to, from, count)
}

/// What is left of the right-hand side: b − A x in the free nodes, leaf by leaf,
/// for the values x of a grid that holds all that the stencil reaches.
pub fn residual(system: &System, grid: &LeafGrid) -> Vec<f32> {
    let mut residual = vec![0.0; system.leaves.len() * LEAF_NODES];
    let leaves = residual.as_chunks_mut::<LEAF_NODES>().0;
    leaves.par_iter_mut().enumerate().with_min_len(FEW).for_each(|(leaf, out)| {
        let at = system.leaves[leaf];
        let mut patch = [0.0; PATCH_NODES];
        grid.gather::<PATCH>(at.map(|along| along * SIDE - REACH), &mut patch);
        match system.domain_near(at) {
            None => stencil(&patch, out),
            Some(domain) => stencil_at_boundary(&patch, at, domain, out),
        }
        let samples = system.samples_of(leaf);
        add_samples(&patch, samples, |one, value| one.weight * (value - one.target), out);
        if let Some(anchors) = &system.anchors {
            let [weights, targets] = anchors.of(leaf);
            add_anchors(&patch, |node, value| weights[node] * (value - targets[node]), out);
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
        stencil_diagonal(at, system.domain_near(at), out);
        add_sample_diagonal(system.samples_of(leaf), out);
        if let Some(anchors) = &system.anchors {
            let [weights, _] = anchors.of(leaf);
            out.iter_mut().zip(weights).for_each(|(out, weight)| *out += weight);
        }
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
        let mut size = state.size();
        let goal = limits.tolerance * limits.tolerance * size;
        let mut iterations = 0;
        while iterations < limits.iterations && size > goal {
            let curvature = self.apply_all(system, &state.direction, &mut state.product);
            if curvature <= 0.0 {
                break;
            }
            let next = state.step((size / curvature) as f32);
            state.turn((next / size) as f32);
            size = next;
            iterations += 1;
        }
        Ok(Correction { values: state.correction, iterations })
    }
}

impl Cpu {
    /// A x, and the product x · A x.
    fn apply_all(&self, system: &System, values: &[f32], out: &mut [f32]) -> f64 {
        let leaves = out.as_chunks_mut::<LEAF_NODES>().0;
        let own = values.as_chunks::<LEAF_NODES>().0;
        let products: Vec<f64> = leaves
            .par_iter_mut()
            .enumerate()
            .with_min_len(FEW)
            .map(|(leaf, out)| {
                let mut patch = [0.0; PATCH_NODES];
                gather(system, leaf, values, &mut patch);
                self.apply_leaf(system, leaf, &patch, out);
                dot(&own[leaf], out)
            })
            .collect();
        products.iter().sum()
    }
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
    /// r · D⁻¹ r.
    fn size(&self) -> f64 {
        let leaves = self.residual.as_chunks::<LEAF_NODES>().0.par_iter();
        let inverse = self.inverse.as_chunks::<LEAF_NODES>().0;
        let sizes: Vec<f64> = leaves.zip(inverse).map(|(r, by)| weighted(r, by)).collect();
        sizes.iter().sum()
    }

    /// Goes along the direction; returns r · D⁻¹ r.
    fn step(&mut self, length: f32) -> f64 {
        let correction = self.correction.as_chunks_mut::<LEAF_NODES>().0;
        let residual = self.residual.as_chunks_mut::<LEAF_NODES>().0;
        let direction = self.direction.as_chunks::<LEAF_NODES>().0;
        let product = self.product.as_chunks::<LEAF_NODES>().0;
        let inverse = self.inverse.as_chunks::<LEAF_NODES>().0;
        let sizes: Vec<f64> = (correction.par_iter_mut().zip(residual))
            .zip(direction.par_iter().zip(product))
            .zip(inverse)
            .with_min_len(FEW)
            .map(|(((correction, residual), (direction, product)), inverse)| {
                for node in 0..LEAF_NODES {
                    correction[node] += length * direction[node];
                    residual[node] -= length * product[node];
                }
                weighted(residual, inverse)
            })
            .collect();
        sizes.iter().sum()
    }

    /// The next direction: D⁻¹ r and a part of the last one.
    fn turn(&mut self, part: f32) {
        let direction = self.direction.as_chunks_mut::<LEAF_NODES>().0;
        let residual = self.residual.as_chunks::<LEAF_NODES>().0;
        let inverse = self.inverse.as_chunks::<LEAF_NODES>().0;
        direction.par_iter_mut().zip(residual).zip(inverse).with_min_len(FEW).for_each(
            |((direction, residual), inverse)| {
                for node in 0..LEAF_NODES {
                    direction[node] = inverse[node] * residual[node] + part * direction[node];
                }
            },
        );
    }
}

/// Lanes of partial sums, so that a sum becomes vector instructions.
const LANES: usize = 16;

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
