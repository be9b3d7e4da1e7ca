// Conjugate gradients for the variational field, the diagonal of A as the
// preconditioner: src/variational/gpu.rs has the order of the stages, system.rs
// the matrix. A workgroup takes a leaf. All sums are taken in a fixed order.

const GROUP: u32 = 256u; // invocations; each has two nodes of a leaf
const SIDE: u32 = 8u;
const NODES: u32 = 512u;
const PATCH: u32 = 12u; // a leaf with the two nodes that its stencil reaches
const PATCH_NODES: u32 = 1728u;
const INNER: u32 = 10u; // of these the ones with all neighbours in the patch
const INNER_NODES: u32 = 1000u;
const CELLS: u32 = 729u; // cells with a corner in the leaf: 9 along each axis
const NONE: u32 = 0xffffffffu;

struct Leaf {
    // The 27 leaves around it, x slowest; NONE where there is none.
    neighbours: array<u32, 27>,
    first_sample: u32,
    end_sample: u32,
    // Its first node.
    x: i32,
    y: i32,
    z: i32,
    // One bit a node.
    free: array<u32, 16>,
}

// Those of a leaf are sorted by their node.
struct Sample {
    x: f32,
    y: f32,
    z: f32,
    node: u32,
    weight: f32,
    goal: f32,
}

// Of second differences, from a node to the next.
struct Direction {
    x: i32,
    y: i32,
    z: i32,
    weight: f32,
}

struct State {
    leaves: u32,
    // The nodes that exist: from low up to, without, high.
    low_x: i32,
    low_y: i32,
    low_z: i32,
    high_x: i32,
    high_y: i32,
    high_z: i32,
    limit: u32,
    iterations: u32,
    is_done: u32,
    // The square of the tolerance.
    tolerance: f32,
    // r · D⁻¹ r, and where it is small enough; below 0 before the first.
    size: f32,
    goal: f32,
    // What the next stage multiplies by.
    factor: f32,
    // What is added to the diagonal.
    hold: f32,
    // So many of these there are.
    count: u32,
    directions: array<Direction, 6>,
}

@group(0) @binding(0) var<storage, read> leaves: array<Leaf>;
@group(0) @binding(1) var<storage, read> samples: array<Sample>;
// D⁻¹, 0 where a node is not free.
@group(0) @binding(2) var<storage, read> inverse: array<f32>;
@group(0) @binding(3) var<storage, read_write> direction: array<f32>;
// A times the direction.
@group(0) @binding(4) var<storage, read_write> product: array<f32>;
@group(0) @binding(5) var<storage, read_write> correction: array<f32>;
@group(0) @binding(6) var<storage, read_write> residual: array<f32>;
// A sum for each leaf.
@group(0) @binding(7) var<storage, read_write> parts: array<f32>;
// The same buffer: read by stages with a workgroup a leaf, written by the others.
@group(0) @binding(8) var<storage, read> state: State;
@group(0) @binding(9) var<storage, read_write> next: State;

var<workgroup> nearby: array<f32, PATCH_NODES>;
// L of that.
var<workgroup> bent: array<f32, INNER_NODES>;
// For each cell the first of its samples among those of the turn, or NONE.
var<workgroup> firsts: array<u32, CELLS>;
// By how much samples pull at their corners.
var<workgroup> strengths: array<f32, GROUP>;
var<workgroup> sums: array<f32, GROUP>;

// The sum of what all invocations have: halves are added up again and again.
fn sum_of_group(own: f32, local: u32) -> f32 {
    sums[local] = own;
    workgroupBarrier();
    for (var half = GROUP / 2u; half > 0u; half /= 2u) {
        if local < half {
            sums[local] += sums[local + half];
        }
        workgroupBarrier();
    }
    return sums[0];
}

// The node of a patch in the leaves around, 0 where there is none.
fn value_around(leaf: u32, index: u32) -> f32 {
    let at = vec3<u32>(index / (PATCH * PATCH), index / PATCH % PATCH, index % PATCH) + 6u;
    let step = at / SIDE;
    let slot = leaves[leaf].neighbours[(step.x * 3u + step.y) * 3u + step.z];
    if slot == NONE {
        return 0.0;
    }
    let node = at % SIDE;
    return direction[slot * NODES + (node.x * SIDE + node.y) * SIDE + node.z];
}

fn patch_index_of(at: vec3<u32>) -> u32 {
    return (at.x * PATCH + at.y) * PATCH + at.z;
}

// A leaf's node along the three axes.
fn place(node: u32) -> vec3<u32> {
    return vec3<u32>(node / 64u, node / 8u % 8u, node % 8u);
}

fn patch_index(node: u32) -> u32 {
    return patch_index_of(place(node) + 2u);
}

fn is_free(leaf: u32, node: u32) -> bool {
    return (leaves[leaf].free[node / 32u] >> (node % 32u) & 1u) == 1u;
}

const X: u32 = 144u;
const Y: u32 = 12u;

// From a node of a patch to the next in a direction; below 0 it wraps around.
fn step_in_patch(way: vec3<i32>) -> u32 {
    return u32((way.x * i32(PATCH) + way.y) * i32(PATCH) + way.z);
}

// The same among inner nodes.
fn step_inside(way: vec3<i32>) -> u32 {
    return u32((way.x * i32(INNER) + way.y) * i32(INNER) + way.z);
}

// L f = Σ weight (f before − 2 f + f after), at an inner node of a patch.
fn bending(index: u32) -> f32 {
    let at = patch_index_of(vec3<u32>(index / (INNER * INNER), index / INNER % INNER, index % INNER) + 1u);
    var sum = 0.0;
    for (var d = 0u; d < state.count; d++) {
        let step = step_in_patch(way(d));
        let ends = nearby[at - step] + nearby[at + step];
        sum += state.directions[d].weight * (ends - 2.0 * nearby[at]);
    }
    return sum;
}

// Half the gradient of Σ‖Hess f‖², inside: L of what L makes of f.
fn stencil(node: u32) -> f32 {
    let at = place(node) + 1u;
    let here = (at.x * INNER + at.y) * INNER + at.z;
    var sum = 0.0;
    for (var d = 0u; d < state.count; d++) {
        let step = step_inside(way(d));
        let ends = bent[here - step] + bent[here + step];
        sum += state.directions[d].weight * (ends - 2.0 * bent[here]);
    }
    return sum;
}

fn way(d: u32) -> vec3<i32> {
    return vec3<i32>(state.directions[d].x, state.directions[d].y, state.directions[d].z);
}

// Whether a node exists, as 0 or 1.
fn existing(node: vec3<i32>) -> f32 {
    let low = vec3<i32>(state.low_x, state.low_y, state.low_z);
    let high = vec3<i32>(state.high_x, state.high_y, state.high_z);
    return select(0.0, 1.0, all(node >= low) && all(node < high));
}

// δddᵀ δdd: of the second differences around the node before, here and after,
// those whose nodes all exist.
fn second(at: u32, node: vec3<i32>, one: vec3<i32>) -> f32 {
    let step = step_in_patch(one);
    let here = nearby[at];
    let before = nearby[at - step];
    let after = nearby[at + step];
    let has_before = existing(node - one);
    let has_after = existing(node + one);
    let first = existing(node - 2 * one) * has_before
        * (nearby[at - 2u * step] - 2.0 * before + here);
    let middle = has_before * has_after * (before - 2.0 * here + after);
    let last = has_after * existing(node + 2 * one)
        * (here - 2.0 * after + nearby[at + 2u * step]);
    return first - 2.0 * middle + last;
}

// (δd δe)ᵀ δd δe: of the four parallelograms at a node those whose nodes all exist.
fn mixed(at: u32, node: vec3<i32>, one: vec3<i32>, other: vec3<i32>) -> f32 {
    var sum = 0.0;
    for (var corner = 0u; corner < 4u; corner++) {
        let d = select(one, -one, (corner & 1u) != 0u);
        let e = select(other, -other, (corner & 2u) != 0u);
        let has = existing(node + d) * existing(node + e) * existing(node + d + e);
        let along = nearby[at + step_in_patch(d)] + nearby[at + step_in_patch(e)];
        sum += has * (nearby[at] - along + nearby[at + step_in_patch(d + e)]);
    }
    return sum;
}

// The same near a natural boundary.
fn stencil_at_boundary(leaf: u32, local: u32, at: u32) -> f32 {
    let first = vec3<i32>(leaves[leaf].x, leaves[leaf].y, leaves[leaf].z);
    let node = first + vec3<i32>(place(local));
    var sum = 0.0;
    for (var d = 0u; d < state.count; d++) {
        let weight = state.directions[d].weight;
        sum += weight * weight * second(at, node, way(d));
        for (var e = 0u; e < d; e++) {
            sum += 2.0 * weight * state.directions[e].weight * mixed(at, node, way(d), way(e));
        }
    }
    return sum;
}

fn reaches_beyond(first: i32, low: i32, high: i32) -> bool {
    return first - 2 < low || first + 10 > high;
}

fn is_at_boundary(leaf: u32) -> bool {
    return reaches_beyond(leaves[leaf].x, state.low_x, state.high_x)
        || reaches_beyond(leaves[leaf].y, state.low_y, state.high_y)
        || reaches_beyond(leaves[leaf].z, state.low_z, state.high_z);
}

// A corner, one bit an axis, x the highest, from a cell's first.
fn corner_offset(corner: u32) -> u32 {
    return (corner >> 2u) * X + (corner >> 1u & 1u) * Y + (corner & 1u);
}

fn share(sample: Sample, corner: u32) -> f32 {
    let x = select(1.0 - sample.x, sample.x, (corner & 4u) != 0u);
    let y = select(1.0 - sample.y, sample.y, (corner & 2u) != 0u);
    let z = select(1.0 - sample.z, sample.z, (corner & 1u) != 0u);
    return x * y * z;
}

// A cell's number, from the first of its nodes in the patch.
fn cell_of(node: u32) -> u32 {
    return (node / X - 1u) * 81u + (node / Y % PATCH - 1u) * 9u + node % PATCH - 1u;
}

// A sample times f there.
fn strength(sample: Sample) -> f32 {
    var value = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        value += share(sample, corner) * nearby[sample.node + corner_offset(corner)];
    }
    return sample.weight * value;
}

// What the samples from `first` up to `end` do to a node: those of the eight cells
// around it.
fn pull(at: u32, first: u32, end: u32) -> f32 {
    var sum = 0.0;
    for (var corner = 0u; corner < 8u; corner++) {
        let node = at - corner_offset(corner);
        var s = firsts[cell_of(node)];
        // NONE is no less than any end.
        while s < end {
            let sample = samples[s];
            if sample.node != node {
                break;
            }
            sum += share(sample, corner) * strengths[s - first];
            s += 1u;
        }
    }
    return sum;
}

// product = A direction, and for each leaf its part of direction · A direction.
@compute @workgroup_size(GROUP)
fn apply(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let leaf = group.y * groups.x + group.x;
    if leaf >= state.leaves || state.is_done != 0u {
        return;
    }
    for (var index = local; index < PATCH_NODES; index += GROUP) {
        nearby[index] = value_around(leaf, index);
    }
    workgroupBarrier();
    let nodes = array<u32, 2>(local, local + GROUP);
    let at = array<u32, 2>(patch_index(nodes[0]), patch_index(nodes[1]));
    var out: array<f32, 2>;
    if is_at_boundary(leaf) {
        out[0] = stencil_at_boundary(leaf, nodes[0], at[0]);
        out[1] = stencil_at_boundary(leaf, nodes[1], at[1]);
    } else {
        for (var index = local; index < INNER_NODES; index += GROUP) {
            bent[index] = bending(index);
        }
        workgroupBarrier();
        out[0] = stencil(nodes[0]);
        out[1] = stencil(nodes[1]);
    }
    // As many samples a turn as there are invocations.
    let end_sample = leaves[leaf].end_sample;
    for (var first = leaves[leaf].first_sample; first < end_sample; first += GROUP) {
        let end = min(first + GROUP, end_sample);
        for (var cell = local; cell < CELLS; cell += GROUP) {
            firsts[cell] = NONE;
        }
        workgroupBarrier();
        let s = first + local;
        if s < end {
            let sample = samples[s];
            strengths[local] = strength(sample);
            if local == 0u || samples[s - 1u].node != sample.node {
                firsts[cell_of(sample.node)] = s;
            }
        }
        workgroupBarrier();
        out[0] += pull(at[0], first, end);
        out[1] += pull(at[1], first, end);
        workgroupBarrier();
    }
    out[0] += state.hold * nearby[at[0]];
    out[1] += state.hold * nearby[at[1]];
    out[0] = select(0.0, out[0], is_free(leaf, nodes[0]));
    out[1] = select(0.0, out[1], is_free(leaf, nodes[1]));
    product[leaf * NODES + nodes[0]] = out[0];
    product[leaf * NODES + nodes[1]] = out[1];
    let sum = sum_of_group(nearby[at[0]] * out[0] + nearby[at[1]] * out[1], local);
    if local == 0u {
        parts[leaf] = sum;
    }
}

// Goes along the direction, and sums up r · D⁻¹ r for each leaf.
@compute @workgroup_size(GROUP)
fn advance(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let leaf = group.y * groups.x + group.x;
    if leaf >= state.leaves || state.is_done != 0u {
        return;
    }
    var own = 0.0;
    for (var node = leaf * NODES + local; node < (leaf + 1u) * NODES; node += GROUP) {
        correction[node] += state.factor * direction[node];
        let left = residual[node] - state.factor * product[node];
        residual[node] = left;
        own += left * left * inverse[node];
    }
    let sum = sum_of_group(own, local);
    if local == 0u {
        parts[leaf] = sum;
    }
}

// The next direction: D⁻¹ r and a part of the last one.
@compute @workgroup_size(GROUP)
fn turn(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let leaf = group.y * groups.x + group.x;
    if leaf >= state.leaves || state.is_done != 0u {
        return;
    }
    for (var node = leaf * NODES + local; node < (leaf + 1u) * NODES; node += GROUP) {
        direction[node] = inverse[node] * residual[node] + state.factor * direction[node];
    }
}

// The sum over all leaves.
fn sum_of_parts(local: u32) -> f32 {
    var own = 0.0;
    for (var leaf = local; leaf < next.leaves; leaf += GROUP) {
        own += parts[leaf];
    }
    return sum_of_group(own, local);
}

// After `apply`: how far to go.
@compute @workgroup_size(GROUP)
fn measure(@builtin(local_invocation_index) local: u32) {
    let curvature = sum_of_parts(local);
    if local != 0u || next.is_done != 0u {
        return;
    }
    if curvature > 0.0 {
        next.factor = next.size / curvature;
    } else {
        next.is_done = 1u;
    }
}

// After `advance`: how much of the last direction to keep, and whether to end.
@compute @workgroup_size(GROUP)
fn judge(@builtin(local_invocation_index) local: u32) {
    let size = sum_of_parts(local);
    if local != 0u || next.is_done != 0u {
        return;
    }
    if next.goal < 0.0 {
        next.goal = next.tolerance * size;
        next.factor = 0.0;
    } else {
        next.factor = size / next.size;
        next.iterations += 1u;
    }
    next.size = size;
    if size <= next.goal || next.iterations >= next.limit {
        next.is_done = 1u;
    }
}
