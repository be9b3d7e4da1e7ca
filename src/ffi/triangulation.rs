//! Triangulations of polygonal regions of a plane, from CGAL's constrained
//! Delaunay triangulation (`cpp/triangulation.cc`).

#[cxx::bridge(namespace = "transect::triangulation")]
mod bridge {
    /// Triangles that together cover regions; those on both sides of a border
    /// share its vertices.
    #[derive(Debug, Default)]
    struct Triangulation {
        /// x and y of every vertex.
        points: Vec<f64>,
        /// The input point that a vertex is, or `u32::MAX` for one that was
        /// added inside a region.
        inputs: Vec<u32>,
        /// Three vertices a triangle, counter-clockwise.
        triangles: Vec<u32>,
        /// The region that each triangle lies in.
        regions: Vec<u32>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/triangulation.h");

        /// Triangulates regions with edges of about `spacing` inside them.
        /// `segments` are pairs of indices of points (x, y); those with the
        /// same number in `regions` close around that region, which is the
        /// part of the plane that an odd number of them separates from
        /// infinity. Regions do not overlap.
        fn triangulate(
            points: &[f64],
            segments: &[u32],
            regions: &[u32],
            spacing: f64,
        ) -> Result<Triangulation>;
    }
}

pub use bridge::*;
