//! The exact subdivision of one plane of the box, by CGAL's Arrangement_2
//! (`cpp/arrangement.cc`). Every call owns all its CGAL objects, so planes can
//! be subdivided at the same time.

#[cxx::bridge(namespace = "transect::arrangement")]
mod bridge {
    /// The vertices, edges and faces of the planar subdivision made by the
    /// outline of the box on a plane, by the other planes, and by the edges of
    /// the section on it. Faces are numbers; 0 is the unbounded one.
    #[derive(Debug, Default)]
    struct Subdivision {
        /// Two coordinates per vertex, exact ones rounded.
        points: Vec<f64>,
        /// How many faces there are.
        faces: u32,
        /// Four numbers per edge: the vertex that is lexicographically smaller
        /// (exactly), the other one, the face left of the edge from the one to
        /// the other, and the face right of it.
        edges: Vec<u32>,
        /// What lies on edge i, in ascending order, is
        /// `curves[curve_starts[i]..curve_starts[i + 1]]`: the index of a
        /// plane, or the number of planes plus the index of a section's edge.
        curve_starts: Vec<u32>,
        /// See `curve_starts`.
        curves: Vec<u32>,
        /// The vertices where other planes meet on this one.
        corners: Vec<u32>,
        /// For each corner, for each plane, the side on which it lies (−1, 0,
        /// 1); 0 for the plane itself and for planes that are not `distinct`.
        sides: Vec<i8>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/arrangement.h");

        /// For every plane (normal and offset) the index of the first one that
        /// is the same set of points.
        fn first_coincident(planes: &[f64]) -> Result<Vec<u32>>;

        /// Subdivides the plane `own`. Of all planes (normal and offset; the
        /// last six are the box's: lower and upper x, y, z, their normals
        /// pointing outward) only the `distinct` ones count. `axes` are the
        /// two kept axes and the dropped one, `bounds` the box's six numbers
        /// (lower and upper x, y, z), `vertices` the section's in kept
        /// coordinates, `edges` pairs of indices into them.
        fn subdivide(
            planes: &[f64],
            distinct: &[u32],
            own: u32,
            axes: &[u32],
            bounds: &[f64],
            vertices: &[f64],
            edges: &[u32],
        ) -> Result<Subdivision>;
    }
}

pub use bridge::*;
