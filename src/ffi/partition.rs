//! The exact subdivision of a plane by segments, from CGAL's `Arrangement_2`
//! (`cpp/partition.cc`).

#[cxx::bridge(namespace = "transect::partition")]
mod bridge {
    /// Vertices, edges and faces of a planar subdivision, flat. Face 0 is the
    /// unbounded one.
    struct Partition {
        /// x and y of every vertex, rounded.
        points: Vec<f64>,
        /// The input point that lies at the vertex exactly, or `u32::MAX` at a
        /// crossing.
        inputs: Vec<u32>,
        /// First vertex (the smaller one by exact x, then y), second vertex,
        /// left face, right face of every edge.
        edges: Vec<u32>,
        /// Where an edge's part of `covers` ends.
        cover_ends: Vec<u32>,
        /// The input segments that run along each edge.
        covers: Vec<u32>,
        /// How many faces there are.
        faces: u32,
        /// The face left of each boundary walk.
        walk_faces: Vec<u32>,
        /// Whether the walk is its face's outer boundary.
        walk_outer: Vec<bool>,
        /// Where a walk's part of `walks` ends.
        walk_ends: Vec<u32>,
        /// Half-edges: twice an edge from its first to its second vertex, one
        /// more the other way.
        walks: Vec<u32>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/partition.h");

        /// Subdivides the plane by segments, given as pairs of indices of
        /// points (x, y); a segment's ends must differ.
        fn partition(points: &[f64], segments: &[u32]) -> Result<Partition>;
    }
}

pub use bridge::*;
