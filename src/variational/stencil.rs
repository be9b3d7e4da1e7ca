//! The energy's gradient in one leaf, from the leaf's patch: the stencil and the
//! samples. Written so that a compiler makes vector instructions of it.

use crate::grid::samples::{LEAF_NODES, LEAF_SIDE};

use super::metric::Direction;
use super::system::{CORNERS, Domain, PATCH, PATCH_NODES, REACH, SIDE, Sample};

/// A leaf's values and what its stencil reaches.
pub type Patch = [f32; PATCH_NODES];
/// A value for each node of a leaf.
pub type Nodes = [f32; LEAF_NODES];

/// Half the gradient of Σ‖Hess f‖², inside.
#[inline(always)]
pub fn stencil(patch: &Patch, directions: &[Direction], out: &mut Nodes) {
    match axes(directions) {
        Some(weights) => stencil_along_axes(patch, weights, out),
        None => stencil_along(patch, directions, out),
    }
}

/// The axes' weights, where they are all the directions there are.
fn axes(directions: &[Direction]) -> Option<[f32; 3]> {
    let [x, y, z] = directions else { return None };
    let steps = [x, y, z].map(|direction| direction.step);
    (steps == [[1, 0, 0], [0, 1, 0], [0, 0, 1]]).then_some([x.weight, y.weight, z.weight])
}

/// With the axes for directions: what L L has on 25 nodes.
#[inline(always)]
fn stencil_along_axes(patch: &Patch, [a, b, c]: [f32; 3], out: &mut Nodes) {
    let sum = a + b + c;
    let middle = 4.0 * sum * sum + 2.0 * (a * a + b * b + c * c);
    let faces = [a, b, c].map(|weight| -4.0 * sum * weight);
    let edges = [2.0 * a * b, 2.0 * a * c, 2.0 * b * c];
    let far = [a * a, b * b, c * c];
    let rows = patch.as_chunks::<PATCH>().0;
    for (index, out) in out.as_chunks_mut::<LEAF_SIDE>().0.iter_mut().enumerate() {
        let (x, y) = (index / LEAF_SIDE + 2, index % LEAF_SIDE + 2);
        let row = |x: usize, y: usize| &rows[x * PATCH + y];
        let here = row(x, y);
        let (along_x, along_y) = ([row(x - 1, y), row(x + 1, y)], [row(x, y - 1), row(x, y + 1)]);
        let corners = [row(x - 1, y - 1), row(x - 1, y + 1), row(x + 1, y - 1), row(x + 1, y + 1)];
        let (far_x, far_y) = ([row(x - 2, y), row(x + 2, y)], [row(x, y - 2), row(x, y + 2)]);
        for (z, out) in out.iter_mut().enumerate() {
            let sum = |rows: [&[f32; PATCH]; 2], z: usize| rows[0][z] + rows[1][z];
            let z = z + 2;
            let face = faces[0] * sum(along_x, z)
                + faces[1] * sum(along_y, z)
                + faces[2] * (here[z - 1] + here[z + 1]);
            let across = (corners[0][z] + corners[1][z]) + (corners[2][z] + corners[3][z]);
            let edge = edges[0] * across
                + edges[1] * (sum(along_x, z - 1) + sum(along_x, z + 1))
                + edges[2] * (sum(along_y, z - 1) + sum(along_y, z + 1));
            let beyond = far[0] * sum(far_x, z)
                + far[1] * sum(far_y, z)
                + far[2] * (here[z - 2] + here[z + 2]);
            *out = (middle * here[z] + face) + (edge + beyond);
        }
    }
}

/// With any directions: L, and L once more.
#[inline(always)]
fn stencil_along(patch: &Patch, directions: &[Direction], out: &mut Nodes) {
    let twice = bent::<2>(&bent::<1>(patch, directions), directions);
    out.fill(0.0);
    add_inner(&twice, out);
}

/// L f where all it takes is in a patch but for some layers.
#[inline(always)]
fn bent<const MARGIN: usize>(patch: &Patch, directions: &[Direction]) -> Patch {
    let mut bent = [0.0; PATCH_NODES];
    for direction in directions {
        let step = offset(direction.step);
        for x in MARGIN..PATCH - MARGIN {
            for y in MARGIN..PATCH - MARGIN {
                for z in MARGIN..PATCH - MARGIN {
                    let at = node([x, y, z]);
                    let ends = patch[at.wrapping_sub(step)] + patch[at.wrapping_add(step)];
                    bent[at] += direction.weight * (ends - 2.0 * patch[at]);
                }
            }
        }
    }
    bent
}

/// The number of a patch's node.
fn node([x, y, z]: [usize; 3]) -> usize {
    (x * PATCH + y) * PATCH + z
}

/// From a node's number to another's; below 0 it wraps around.
fn offset([x, y, z]: [i32; 3]) -> usize {
    ((x * PATCH as i32 + y) * PATCH as i32 + z) as isize as usize
}

/// The same near a natural boundary: every difference between nodes that exist, and
/// then what it does to them.
#[inline(always)]
pub fn stencil_at_boundary(
    patch: &Patch,
    leaf: [i32; 3],
    domain: Domain,
    directions: &[Direction],
    out: &mut Nodes,
) {
    let mut sums = [0.0; PATCH_NODES];
    for_each_difference(leaf, domain, directions, |weight, nodes| {
        let difference: f32 = nodes.iter().map(|&(node, factor)| factor * patch[node]).sum();
        nodes.iter().for_each(|&(node, factor)| sums[node] += weight * difference * factor);
    });
    out.fill(0.0);
    add_inner(&sums, out);
}

/// What the stencil has on its diagonal.
pub fn stencil_diagonal(
    leaf: [i32; 3],
    domain: Option<Domain>,
    directions: &[Direction],
    out: &mut Nodes,
) {
    let Some(domain) = domain else {
        let sum: f32 = directions.iter().map(|direction| direction.weight).sum();
        let squares: f32 = directions.iter().map(|d| d.weight * d.weight).sum();
        out.fill(4.0 * sum * sum + 2.0 * squares);
        return;
    };
    let mut sums = [0.0; PATCH_NODES];
    for_each_difference(leaf, domain, directions, |weight, nodes| {
        nodes.iter().for_each(|&(node, factor)| sums[node] += weight * factor * factor);
    });
    out.fill(0.0);
    add_inner(&sums, out);
}

/// All differences between nodes of a patch that exist: what the square of each counts,
/// and the nodes with the factors it has them by.
#[inline(always)]
fn for_each_difference(
    leaf: [i32; 3],
    domain: Domain,
    directions: &[Direction],
    mut visit: impl FnMut(f32, [(usize, f32); 4]),
) {
    for (number, &Direction { step, weight }) in directions.iter().enumerate() {
        let back = step.map(|along| -along);
        let second = [([0; 3], -2.0), (step, 1.0), (back, 1.0), ([0; 3], 0.0)];
        for_each_place(leaf, domain, second, |nodes| visit(weight * weight, nodes));
        for other in &directions[..number] {
            let both = std::array::from_fn(|axis| step[axis] + other.step[axis]);
            let mixed = [([0; 3], 1.0), (step, -1.0), (other.step, -1.0), (both, 1.0)];
            let weight = 2.0 * weight * other.weight;
            for_each_place(leaf, domain, mixed, |nodes| visit(weight, nodes));
        }
    }
}

/// A difference at all places of a patch where its nodes are in the patch and exist.
#[inline(always)]
fn for_each_place(
    leaf: [i32; 3],
    domain: Domain,
    difference: [([i32; 3], f32); 4],
    mut visit: impl FnMut([(usize, f32); 4]),
) {
    let range = |axis: usize| {
        let first = leaf[axis] * SIDE - REACH as i32;
        let low = (domain.low[axis] - first).max(0);
        let high = (domain.high[axis] - first).min(PATCH as i32);
        let before = difference.iter().map(|(step, _)| -step[axis]).fold(0, i32::max);
        let behind = difference.iter().map(|(step, _)| step[axis]).fold(0, i32::max);
        (low + before).max(0) as usize..(high - behind).max(0) as usize
    };
    let offsets = difference.map(|(step, factor)| (offset(step), factor));
    for x in range(0) {
        for y in range(1) {
            for z in range(2) {
                let at = node([x, y, z]);
                visit(offsets.map(|(step, factor)| (at.wrapping_add(step), factor)));
            }
        }
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
