// The closed form of one edge, for four points at a time;
// src/field/kernel.rs is its twin.

const PI: f32 = 3.14159265358979;

/// Four points, split; an array holds x, y and z.
struct Points {
    at: array<vec4<f32>, 3>,
    rest: array<vec4<f32>, 3>,
}

/// Their feet on a plane, split like the vertices, and the distances.
struct Feet {
    at_u: vec4<f32>,
    at_v: vec4<f32>,
    rest_u: vec4<f32>,
    rest_v: vec4<f32>,
    gamma: vec4<f32>,
}

/// A vertex as seen from the feet.
struct Corner {
    px: vec4<f32>,
    py: vec4<f32>,
    /// |p|^2 + gamma^2
    r_squared: vec4<f32>,
    r: vec4<f32>,
}

fn along(row: vec4<f32>, x: array<vec4<f32>, 3>) -> vec4<f32> {
    return row.x * x[0] + row.y * x[1] + row.z * x[2];
}

/// row . x without its leading part: small, so that it needs no splitting.
fn along_rest(row: vec4<f32>, row_rest: vec4<f32>, x: Points) -> vec4<f32> {
    return along(row_rest, x.at) + along(row, x.rest) + along(row_rest, x.rest);
}

/// The products of the parts on the grid are exact, and so are their sums:
/// there is no f64 here, and close to a plane gamma is a small difference of
/// large numbers.
fn feet_of(face: Face, x: Points, clearance: f32) -> Feet {
    let height = along(face.normal, x.at) + face.normal.w;
    let height_rest = along_rest(face.normal, face.normal_rest, x) + face.normal_rest.w;
    return Feet(
        along(face.first_tangent, x.at),
        along(face.second_tangent, x.at),
        along_rest(face.first_tangent, face.first_tangent_rest, x),
        along_rest(face.second_tangent, face.second_tangent_rest, x),
        max(abs(height + height_rest), vec4<f32>(clearance)),
    );
}

/// `vertex`: the part on the grid, and the remainder.
fn corner_of(vertex: vec4<f32>, feet: Feet) -> Corner {
    let px = (vertex.x - feet.at_u) + (vertex.z - feet.rest_u);
    let py = (vertex.y - feet.at_v) + (vertex.w - feet.rest_v);
    let r_squared = px * px + (py * py + feet.gamma * feet.gamma);
    return Corner(px, py, r_squared, sqrt(r_squared));
}

/// atan(t) / t for t^2 in [0, 1], to 1.7e-7 relative.
fn arctangent_ratio(s: vec4<f32>) -> vec4<f32> {
    var sum = vec4<f32>(-4.6932735e-3);
    sum = sum * s + 2.4252394e-2;
    sum = sum * s - 5.948638e-2;
    sum = sum * s + 9.914292e-2;
    sum = sum * s - 0.1401948;
    sum = sum * s + 0.19969724;
    sum = sum * s - 0.3333199;
    return sum * s + 0.9999999;
}

/// What an edge is to four points.
struct Angle {
    /// theta / c
    ratio: vec4<f32>,
    /// cross(p, q)
    cross: vec4<f32>,
    c_squared: vec4<f32>,
}

/// With D = p.q + gamma^2, theta / c is g = 2 (atan t / t) / (r_p r_q + |D|),
/// t = c / (r_p r_q + |D|), or pi / c - g where D < 0. `d` is q - p and its
/// squared length.
fn angle_of(start: Corner, end: Corner, d: vec3<f32>, gamma: vec4<f32>) -> Angle {
    let cross = start.px * d.y - start.py * d.x;
    let cosine = start.px * d.x + (start.py * d.y + start.r_squared);
    let c_squared = cross * cross + gamma * gamma * d.z;
    let inverse = 1.0 / (start.r * end.r + abs(cosine));
    let ratio = 2.0 * arctangent_ratio((c_squared * inverse) * inverse) * inverse;
    let obtuse = cosine < vec4<f32>(0.0);
    if any(obtuse) {
        return Angle(select(ratio, PI / sqrt(c_squared) - ratio, obtuse), cross, c_squared);
    }
    return Angle(ratio, cross, c_squared);
}
