// The Hermite field's values; src/field/hermite/kernel.rs is its twin. A workgroup takes points of
// one cell. The host lays everything out in this order.

struct Cell {
    first_face: u32,
    end_face: u32,
    labels: u32,
    nodes: u32,
    /// The first of its nodes' rows in `tangents`.
    first_tangent: u32,
    /// The smallest distance to a plane.
    clearance: f32,
    padding_0: u32,
    padding_1: u32,
}

/// The points of one workgroup, all in one cell.
struct Job {
    cell: u32,
    first_point: u32,
    points: u32,
    first_value: u32,
    /// Where its nodes' weights are: GROUP for each node.
    first_weight: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<storage, read> cells: array<Cell>;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
/// Corners, one row each: the part on the grid, and the remainder. Triangles, five rows each:
/// the rows of their corners and 1 / 4 A; their nodes and one bit for every edge that runs
/// clockwise; and for the edge opposite to each corner its span and that one's square, in the
/// first of these the square of the distance from which on a triangle is far, in the second A / 6.
/// All but numbers and bits are the bits of f32.
@group(0) @binding(2) var<storage, read> rows: array<vec4<u32>>;
/// For every node how much it counts, and for every label a constant and a gradient.
@group(0) @binding(3) var<storage, read> tangents: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> points: array<Point>;
@group(0) @binding(5) var<storage, read> jobs: array<Job>;
@group(0) @binding(6) var<storage, read_write> weights: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> values: array<f32>;

/// What an edge is to four points, as a triangle sees it: counter-clockwise.
struct Side {
    ratio: vec4<f32>,
    cross: vec4<f32>,
    span: vec2<f32>,
}

/// Triangles on both sides of an edge must take the same angle, else what is wrong with it does
/// not cancel between them: so it runs the way it is laid out, and is turned afterwards.
fn side_of(ends: array<Corner, 2>, row: vec4<u32>, clockwise: bool, gamma: vec4<f32>) -> Side {
    let span = bitcast<vec3<f32>>(row.xyz);
    if clockwise {
        let angle = angle_of(ends[1], ends[0], span, gamma);
        return Side(angle.ratio, -angle.cross, -span.xy);
    }
    let angle = angle_of(ends[0], ends[1], span, gamma);
    return Side(angle.ratio, angle.cross, span.xy);
}

fn add(weight: u32, node: u32, share: vec4<f32>) {
    weights[weight + node * GROUP] += share;
}

/// 1 / r⁴ in the middle of an edge.
fn middle_of(start: Corner, end: Corner, row: vec4<u32>) -> vec4<f32> {
    let middle = 0.5 * (start.r_squared + end.r_squared) - 0.25 * bitcast<f32>(row.z);
    return 1.0 / (middle * middle);
}

/// Adds the weights of a triangle's corners to those of its nodes.
fn add_triangle(row: u32, feet: Feet, weight: u32) {
    let corners = rows[row];
    let nodes = rows[row + 1u];
    let a = corner_of(bitcast<vec4<f32>>(rows[corners.x]), feet);
    let b = corner_of(bitcast<vec4<f32>>(rows[corners.y]), feet);
    let c = corner_of(bitcast<vec4<f32>>(rows[corners.z]), feet);
    let gamma = feet.gamma;
    let ma = middle_of(b, c, rows[row + 2u]);
    let mb = middle_of(c, a, rows[row + 3u]);
    let mc = middle_of(a, b, rows[row + 4u]);
    let quarter = bitcast<f32>(corners.w);
    let share = gamma * bitcast<f32>(rows[row + 3u].w);
    var found = array(share * (mb + mc), share * (mc + ma), share * (ma + mb));
    let far = bitcast<f32>(rows[row + 2u].w);
    let near = min(a.r_squared, min(b.r_squared, c.r_squared)) < vec4<f32>(far);
    if any(near) {
        let sa = side_of(array(b, c), rows[row + 2u], (nodes.w & 1u) != 0u, gamma);
        let sb = side_of(array(c, a), rows[row + 3u], (nodes.w & 2u) != 0u, gamma);
        let sc = side_of(array(a, b), rows[row + 4u], (nodes.w & 4u) != 0u, gamma);
        let all = sa.ratio * sa.cross + sb.ratio * sb.cross + sc.ratio * sc.cross;
        let u = sa.ratio * sa.span.x + sb.ratio * sb.span.x + sc.ratio * sc.span.x;
        let v = sa.ratio * sa.span.y + sb.ratio * sb.span.y + sc.ratio * sc.span.y;
        let across = all / gamma * quarter;
        let along = gamma * quarter;
        found[0] = select(found[0], sa.cross * across + along * (sa.span.x * u + sa.span.y * v), near);
        found[1] = select(found[1], sb.cross * across + along * (sb.span.x * u + sb.span.y * v), near);
        found[2] = select(found[2], sc.cross * across + along * (sc.span.x * u + sc.span.y * v), near);
    }
    add(weight, nodes.x, found[0]);
    add(weight, nodes.y, found[1]);
    add(weight, nodes.z, found[2]);
}

/// g(λ) of a node, times how much it counts.
fn part_of(share: vec4<f32>, density: f32) -> vec4<f32> {
    return density * share * share * (3.0 - 2.0 * share);
}

@compute @workgroup_size(GROUP)
fn evaluate(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let job = jobs[group.x];
    let first = lane * POINTS;
    if first >= job.points {
        return;
    }
    let cell = cells[job.cell];
    let weight = job.first_weight + lane;
    for (var node = 0u; node < cell.nodes; node++) {
        weights[weight + node * GROUP] = vec4<f32>(0.0);
    }
    // Four points; beyond the job's end, the last one again.
    var x: Points;
    for (var i = 0u; i < POINTS; i++) {
        let point = points[job.first_point + min(first + i, job.points - 1u)];
        for (var axis = 0u; axis < 3u; axis++) {
            x.at[axis][i] = point.at[axis];
            x.rest[axis][i] = point.rest[axis];
        }
    }
    for (var f = cell.first_face; f < cell.end_face; f++) {
        let feet = feet_of(faces[f], x, cell.clearance);
        for (var row = faces[f].first_ramp; row < faces[f].end_ramp; row += 5u) {
            add_triangle(row, feet, weight);
        }
    }
    var total = vec4<f32>(0.0);
    for (var node = 0u; node < cell.nodes; node++) {
        total += weights[weight + node * GROUP];
    }
    let inverse = 1.0 / total;
    let stride = cell.labels + 1u;
    var sum = vec4<f32>(0.0);
    for (var node = 0u; node < cell.nodes; node++) {
        let share = weights[weight + node * GROUP] * inverse;
        sum += part_of(share, tangents[cell.first_tangent + node * stride].x);
    }
    let own = min(job.points - first, POINTS);
    for (var label = 0u; label < cell.labels; label++) {
        var value = vec4<f32>(0.0);
        for (var node = 0u; node < cell.nodes; node++) {
            let share = weights[weight + node * GROUP] * inverse;
            let row = cell.first_tangent + node * stride;
            let tangent = tangents[row + 1u + label];
            let height = tangent.x + tangent.y * (x.at[0] + x.rest[0])
                + tangent.z * (x.at[1] + x.rest[1]) + tangent.w * (x.at[2] + x.rest[2]);
            value += part_of(share, tangents[row].x) * height;
        }
        value /= sum;
        for (var i = 0u; i < own; i++) {
            values[job.first_value + (first + i) * cell.labels + label] = value[i];
        }
    }
}
