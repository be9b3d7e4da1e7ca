// The mean-value indicator's weights W_l, up to a common factor. A workgroup
// takes points of one cell, so that all its invocations read the same edges
// at the same time.

var<private> weights: array<vec4<f32>, WINDOW>;

/// Adds to a label's weight when the label lies in the window.
fn add(label: u32, window: u32, share: vec4<f32>) {
    let slot = label - window; // wraps around for labels below the window
    if slot < WINDOW {
        weights[slot] += share;
    }
}

fn chain_sum(chain: Chain, feet: Feet) -> vec4<f32> {
    var sum = vec4<f32>(0.0);
    var start = corner_of(chain.start, feet);
    for (var e = chain.first_edge; e < chain.end_edge; e++) {
        let edge = edges[e];
        let end = corner_of(edge.end, feet);
        let angle = angle_of(start, end, edge.span.xyz, feet.gamma);
        sum += angle.cross * angle.ratio;
        start = end;
    }
    return sum;
}

/// Adds what a face's ramps from `first` on say; src/field/ramps.rs has the
/// formula.
fn add_ramps(first: u32, end: u32, feet: Feet, window: u32) {
    var row = first;
    while row < end {
        let start = corner_of(bitcast<vec4<f32>>(ramps[row]), feet);
        let end_corner = corner_of(bitcast<vec4<f32>>(ramps[row + 1u]), feet);
        let d = bitcast<vec3<f32>>(ramps[row + 2u].xyz);
        let angle = angle_of(start, end_corner, d, feet.gamma);
        let constant = angle.cross * angle.ratio / feet.gamma;
        let along = -constant * (start.px * d.x + start.py * d.y);
        let across = angle.c_squared * angle.ratio / feet.gamma;
        let last = row + 2u + ramps[row + 2u].w;
        row += 3u;
        for (; row <= last; row++) {
            let slope = bitcast<vec3<f32>>(ramps[row].yzw);
            let share = constant * slope.x + along * slope.y + across * slope.z;
            add(ramps[row].x, window, share);
        }
    }
}

/// The weights of the labels from `window` on.
fn weigh(cell: Cell, x: Points, window: u32) {
    for (var slot = 0u; slot < WINDOW; slot++) {
        weights[slot] = vec4<f32>(0.0);
    }
    for (var f = cell.first_face; f < cell.end_face; f++) {
        let feet = feet_of(faces[f], x, cell.clearance);
        for (var c = faces[f].first_chain; c < faces[f].end_chain; c++) {
            let chain = chains[c];
            let share = chain_sum(chain, feet) / feet.gamma;
            add(chain.left, window, share);
            if chain.right != BORDER {
                add(chain.right, window, -share);
            }
        }
        add_ramps(faces[f].first_ramp, faces[f].end_ramp, feet, window);
    }
}

/// Four points of a job; beyond its end, the last one again.
fn points_of(job: Job, first: u32) -> Points {
    var x: Points;
    for (var i = 0u; i < POINTS; i++) {
        let point = points[job.first_point + min(first + i, job.points - 1u)];
        for (var axis = 0u; axis < 3u; axis++) {
            x.at[axis][i] = point.at[axis];
            x.rest[axis][i] = point.rest[axis];
        }
    }
    return x;
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
    let x = points_of(job, first);
    let own = min(job.points - first, POINTS);
    for (var window = 0u; window < cell.labels; window += WINDOW) {
        weigh(cell, x, window);
        let labels = min(cell.labels - window, WINDOW);
        for (var i = 0u; i < own; i++) {
            let value = job.first_value + (first + i) * cell.labels + window;
            for (var slot = 0u; slot < labels; slot++) {
                values[value + slot] = weights[slot][i];
            }
        }
    }
}
