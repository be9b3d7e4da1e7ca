// What the mean-value indicator reads and writes. The host lays these out in
// the same order; every coordinate is in its cell's own units.

/// Invocations of a workgroup.
const GROUP: u32 = 64u;
/// Points of an invocation, one in each component of a vector: the edges are
/// read once for all of them.
const POINTS: u32 = 4u;
/// Labels that one pass over a cell adds up.
const WINDOW: u32 = 16u;
/// The right side of a chain on its face's border.
const BORDER: u32 = 0xffffffffu;

struct Cell {
    first_face: u32,
    end_face: u32,
    labels: u32,
    /// The smallest distance to a plane.
    clearance: f32,
}

/// A plane's frame. Every row is split into a part on a grid of 2^-12 and the
/// remainder; `normal.w` is the plane's offset.
struct Face {
    first_tangent: vec4<f32>,
    first_tangent_rest: vec4<f32>,
    second_tangent: vec4<f32>,
    second_tangent_rest: vec4<f32>,
    normal: vec4<f32>,
    normal_rest: vec4<f32>,
    first_chain: u32,
    end_chain: u32,
    first_ramp: u32,
    end_ramp: u32,
}

/// Consecutive edges with the same labels left and right.
struct Chain {
    /// The first vertex: the part on the grid, and the remainder.
    start: vec4<f32>,
    first_edge: u32,
    end_edge: u32,
    left: u32,
    right: u32,
}

/// An edge of a chain, without its start.
struct Edge {
    /// q: the part on the grid, and the remainder.
    end: vec4<f32>,
    /// d = q - p, and its squared length.
    span: vec4<f32>,
}

/// A point, split like a frame's rows.
struct Point {
    at: vec4<f32>,
    rest: vec4<f32>,
}

/// The points of one workgroup, all in one cell.
struct Job {
    cell: u32,
    first_point: u32,
    points: u32,
    first_value: u32,
}

@group(0) @binding(0) var<storage, read> cells: array<Cell>;
@group(0) @binding(1) var<storage, read> faces: array<Face>;
@group(0) @binding(2) var<storage, read> chains: array<Chain>;
@group(0) @binding(3) var<storage, read> edges: array<Edge>;
/// A ramp is three rows and one for each of its slopes: its ends, split; the
/// span, its squared length and the number of slopes; and for each slope its
/// label and what changes: a constant, along the edge, and across it. All but
/// the two integers are the bits of f32.
@group(0) @binding(4) var<storage, read> ramps: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> points: array<Point>;
@group(0) @binding(6) var<storage, read> jobs: array<Job>;
@group(0) @binding(7) var<storage, read_write> values: array<f32>;
