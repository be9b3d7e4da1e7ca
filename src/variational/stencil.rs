//! The energy's gradient in one leaf, from the leaf's patch: the stencil and the
//! samples. Written so that a compiler makes vector instructions of it.

use crate::grid::samples::{LEAF_NODES, LEAF_SIDE};

use super::system::{
    CORNERS, Domain, First, PATCH, PATCH_NODES, REACH, SIDE, Sample, Second, coefficients,
};

/// A leaf's values and what its stencil reaches.
pub type Patch = [f32; PATCH_NODES];
/// A value for each node of a leaf.
pub type Nodes = [f32; LEAF_NODES];

/// Half the gradient of Σ‖Hess f‖², inside.
#[inline(always)]
pub fn stencil(patch: &Patch, out: &mut Nodes) {
    let rows = patch.as_chunks::<PATCH>().0;
    for (index, out) in out.as_chunks_mut::<LEAF_SIDE>().0.iter_mut().enumerate() {
        let (x, y) = (index / LEAF_SIDE + 2, index % LEAF_SIDE + 2);
        let row = |x: usize, y: usize| &rows[x * PATCH + y];
        let here = row(x, y);
        let sides = [row(x - 1, y), row(x + 1, y), row(x, y - 1), row(x, y + 1)];
        let corners = [row(x - 1, y - 1), row(x - 1, y + 1), row(x + 1, y - 1), row(x + 1, y + 1)];
        let far = [row(x - 2, y), row(x + 2, y), row(x, y - 2), row(x, y + 2)];
        for (z, out) in out.iter_mut().enumerate() {
            let sum = |rows: [&[f32; PATCH]; 4], z: usize| {
                (rows[0][z] + rows[1][z]) + (rows[2][z] + rows[3][z])
            };
            let z = z + 2;
            let faces = sum(sides, z) + (here[z - 1] + here[z + 1]);
            let edges = sum(corners, z) + (sum(sides, z - 1) + sum(sides, z + 1));
            let beyond = sum(far, z) + (here[z - 2] + here[z + 2]);
            *out = (42.0 * here[z] - 12.0 * faces) + (2.0 * edges + beyond);
        }
    }
}

/// The same near a natural boundary.
pub fn stencil_at_boundary(patch: &Patch, leaf: [i32; 3], domain: Domain, out: &mut Nodes) {
    let axes = Axes::new(leaf, domain);
    let steps = [PATCH * PATCH, PATCH, 1];
    for (index, out) in out.iter_mut().enumerate() {
        let node = [index / 64, index / 8 % 8, index % 8];
        let [x, y, z] = node.map(|along| along + REACH);
        let center = (x * PATCH + y) * PATCH + z;
        let at = |offset: isize| patch[center.wrapping_add_signed(offset)];
        let mut sum = 0.0;
        for axis in 0..3 {
            let own = axes.0[axis].0[node[axis]].iter().zip(-2isize..);
            sum += own.map(|(by, step)| by * at(step * steps[axis] as isize)).sum::<f32>();
        }
        for [a, b] in [[0, 1], [0, 2], [1, 2]] {
            for (by_a, step_a) in axes.0[a].1[node[a]].iter().zip(-1isize..) {
                for (by_b, step_b) in axes.0[b].1[node[b]].iter().zip(-1isize..) {
                    let offset = step_a * steps[a] as isize + step_b * steps[b] as isize;
                    sum += 2.0 * by_a * by_b * at(offset);
                }
            }
        }
        *out = sum;
    }
}

/// The coefficients along every axis.
struct Axes([(Second, First); 3]);

impl Axes {
    fn new(leaf: [i32; 3], Domain { low, high }: Domain) -> Self {
        Self(std::array::from_fn(|axis| coefficients(leaf[axis] * SIDE, low[axis]..high[axis])))
    }
}

/// What the stencil has on its diagonal.
pub fn stencil_diagonal(leaf: [i32; 3], domain: Option<Domain>, out: &mut Nodes) {
    let Some(domain) = domain else {
        out.fill(42.0);
        return;
    };
    let axes = Axes::new(leaf, domain);
    for (index, out) in out.iter_mut().enumerate() {
        let node = [index / 64, index / 8 % 8, index % 8];
        let second = (0..3).map(|axis| axes.0[axis].0[node[axis]][2]).sum::<f32>();
        let first: [f32; 3] = std::array::from_fn(|axis| axes.0[axis].1[node[axis]][1]);
        let mixed = first[0] * first[1] + first[0] * first[2] + first[1] * first[2];
        *out = second + 2.0 * mixed;
    }
}

/// Adds what samples do to a leaf's nodes: `strength` gives for each, from f at
/// its place, by how much its corners are moved.
#[inline(always)]
pub fn add_samples(
    patch: &Patch,
    samples: &[Sample],
    strength: impl Fn(&Sample, f32) -> f32,
    out: &mut Nodes,
) {
    if samples.is_empty() {
        return;
    }
    let mut sums = [0.0; PATCH_NODES];
    for sample in samples {
        let shares = sample.shares();
        let node = sample.node as usize;
        let mut value = 0.0;
        for (share, corner) in shares.iter().zip(CORNERS) {
            value += share * patch[node + corner];
        }
        let strength = strength(sample, value);
        for (share, corner) in shares.iter().zip(CORNERS) {
            sums[node + corner] += strength * share;
        }
    }
    add_inner(&sums, out);
}

/// Adds what samples have on the diagonal.
pub fn add_sample_diagonal(samples: &[Sample], out: &mut Nodes) {
    let mut sums = [0.0; PATCH_NODES];
    for sample in samples {
        for (share, corner) in sample.shares().iter().zip(CORNERS) {
            sums[sample.node as usize + corner] += sample.weight * share * share;
        }
    }
    add_inner(&sums, out);
}

/// Adds what draws single nodes of a leaf: `strength` gives for each, from its
/// value, by how much it is moved.
#[inline(always)]
pub fn add_anchors(patch: &Patch, strength: impl Fn(usize, f32) -> f32, out: &mut Nodes) {
    for (index, out) in out.as_chunks_mut::<LEAF_SIDE>().0.iter_mut().enumerate() {
        let (x, y) = (index / LEAF_SIDE + 2, index % LEAF_SIDE + 2);
        let row = &patch[(x * PATCH + y) * PATCH + 2..][..LEAF_SIDE];
        for (z, out) in out.iter_mut().enumerate() {
            *out += strength(index * LEAF_SIDE + z, row[z]);
        }
    }
}

/// Adds a patch's values at the leaf's own nodes.
#[inline(always)]
fn add_inner(patch: &Patch, out: &mut Nodes) {
    let rows = patch.as_chunks::<PATCH>().0;
    for (index, out) in out.as_chunks_mut::<LEAF_SIDE>().0.iter_mut().enumerate() {
        let (x, y) = (index / LEAF_SIDE + 2, index % LEAF_SIDE + 2);
        let row = &rows[x * PATCH + y];
        for (z, out) in out.iter_mut().enumerate() {
            *out += row[z + 2];
        }
    }
}
