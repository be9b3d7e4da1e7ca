//! Isotropic remeshing by CGAL's Polygon_mesh_processing (`cpp/fairing.cc`).

#[cxx::bridge(namespace = "transect::fairing")]
mod bridge {
    /// A remeshed patch.
    #[derive(Debug, Clone)]
    struct Patch {
        /// Coordinates by threes.
        points: Vec<f64>,
        /// For every vertex the number of the input vertex that it was, or
        /// `u32::MAX`.
        origins: Vec<u32>,
        /// Vertex numbers by threes.
        triangles: Vec<u32>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/fairing.h");

        /// Makes the edges of a patch about as long as `edge_length`. Edges of
        /// one triangle, and vertices that are pinned (not 0), stay as they are.
        /// Returns nothing when the triangles are no manifold.
        fn remesh(
            points: &[f64],
            triangles: &[u32],
            pinned: &[u8],
            edge_length: f64,
            iterations: u32,
        ) -> Result<Patch>;
    }
}

pub use bridge::*;
