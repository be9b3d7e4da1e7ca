// What the mean-value indicator reads and writes. The host lays these out in
// the same order; every coordinate is in its cell's own units.

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
