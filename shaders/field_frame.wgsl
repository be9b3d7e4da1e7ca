// What all fields in cells have in common: planes and points. Every coordinate is in its
// cell's own units.

/// Invocations of a workgroup.
const GROUP: u32 = 64u;
/// Points of an invocation, one in each component of a vector: the edges are
/// read once for all of them.
const POINTS: u32 = 4u;

/// A plane's frame. Every row is split into a part on a grid of 2^-12 and the
/// remainder; `normal.w` is the plane's offset.
struct Face {
    first_tangent: vec4<f32>,
    first_tangent_rest: vec4<f32>,
    second_tangent: vec4<f32>,
    second_tangent_rest: vec4<f32>,
    normal: vec4<f32>,
    normal_rest: vec4<f32>,
    /// Chains of the mean-value field, corners of the Hermite field.
    first_chain: u32,
    end_chain: u32,
    /// Ramps of the mean-value field, triangles of the Hermite field.
    first_ramp: u32,
    end_ramp: u32,
}

/// A point, split like a frame's rows.
struct Point {
    at: vec4<f32>,
    rest: vec4<f32>,
}
