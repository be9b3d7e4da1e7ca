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

/// The same near a natural boundary: every difference between nodes that exist, and
/// then what it does to them.
#[inline(always)]
pub fn stencil_at_boundary(patch: &Patch, leaf: [i32; 3], domain: Domain, out: &mut Nodes) {
    let exist = Existing::new(leaf, domain);
    let mut sums = [0.0; PATCH_NODES];
    add_second::<0>(patch, &exist, &mut sums);
    add_second::<1>(patch, &exist, &mut sums);
    add_second::<2>(patch, &exist, &mut sums);
    add_mixed::<0, 1>(patch, &exist, &mut sums);
    add_mixed::<0, 2>(patch, &exist, &mut sums);
    add_mixed::<1, 2>(patch, &exist, &mut sums);
    out.fill(0.0);
    add_inner(&sums, out);
}

/// From a node of a patch to the next along each axis.
const STEPS: [usize; 3] = [PATCH * PATCH, PATCH, 1];

/// δxxᵀ δxx along an axis.
#[inline(always)]
fn add_second<const AXIS: usize>(patch: &Patch, exist: &Existing, sums: &mut Patch) {
    let step = STEPS[AXIS];
    let range = |axis: usize| if axis == AXIS { 1..PATCH - 1 } else { 0..PATCH };
    for x in range(0) {
        for y in range(1) {
            for z in range(2) {
                let at = (x * PATCH + y) * PATCH + z;
                let second = patch[at - step] - 2.0 * patch[at] + patch[at + step];
                let own = second * exist.second[AXIS][[x, y, z][AXIS]];
                sums[at - step] += own;
                sums[at] -= 2.0 * own;
                sums[at + step] += own;
            }
        }
    }
}

/// 2 (δx δy)ᵀ δx δy along two axes.
#[inline(always)]
fn add_mixed<const A: usize, const B: usize>(patch: &Patch, exist: &Existing, sums: &mut Patch) {
    let (along_a, along_b) = (STEPS[A], STEPS[B]);
    let both = along_a + along_b;
    let range = |axis: usize| if axis == A || axis == B { 0..PATCH - 1 } else { 0..PATCH };
    for x in range(0) {
        for y in range(1) {
            for z in range(2) {
                let at = (x * PATCH + y) * PATCH + z;
                let place = [x, y, z];
                let mixed =
                    (patch[at] - patch[at + along_a]) - (patch[at + along_b] - patch[at + both]);
                let own = 2.0 * mixed * exist.first[A][place[A]] * exist.first[B][place[B]];
                sums[at] += own;
                sums[at + along_a] -= own;
                sums[at + along_b] -= own;
                sums[at + both] += own;
            }
        }
    }
}

/// For every axis and every layer of a patch 1 where the differences around it are
/// between nodes that exist, else 0.
struct Existing {
    /// δxx around a layer.
    second: [[f32; PATCH]; 3],
    /// δx from a layer to the next.
    first: [[f32; PATCH]; 3],
}

impl Existing {
    fn new(leaf: [i32; 3], Domain { low, high }: Domain) -> Self {
        let layers = |axis: usize, steps: [i32; 2]| {
            std::array::from_fn(|layer| {
                let node = leaf[axis] * SIDE - REACH as i32 + layer as i32;
                let range = low[axis]..high[axis];
                f32::from(u8::from(steps.iter().all(|step| range.contains(&(node + step)))))
            })
        };
        Self {
            second: std::array::from_fn(|axis| layers(axis, [-1, 1])),
            first: std::array::from_fn(|axis| layers(axis, [0, 1])),
        }
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
