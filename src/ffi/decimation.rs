//! Edge collapse by CGAL's Surface_mesh_simplification (`cpp/decimation.cc`).

#[cxx::bridge(namespace = "transect::decimation")]
mod bridge {
    /// A manifold with fewer triangles.
    #[derive(Debug, Clone)]
    struct Simplified {
        /// Coordinates by threes.
        points: Vec<f64>,
        /// For every vertex its name, or `u32::MAX`.
        names: Vec<u32>,
        /// For every vertex how far it is from what became part of it, by the sum of steps; 0
        /// where nothing did.
        reached: Vec<f64>,
        /// For every vertex that was given the one that it is part of.
        places: Vec<u32>,
        /// Vertex numbers by threes.
        triangles: Vec<u32>,
        /// For every triangle the number that it was given with.
        origins: Vec<u32>,
    }

    extern "Rust" {
        type Watch<'a>;
        /// Whether to go on.
        unsafe fn goes_on<'a>(self: &Watch<'a>) -> bool;
    }

    unsafe extern "C++" {
        include!("transect/cpp/decimation.h");

        /// Collapses edges, the least quadric error first, until no more than `wanted` triangles
        /// are left, no edge can be collapsed, or nobody wants more. Vertices with a name (not
        /// `u32::MAX`) stay, as do edges between two; no new edge joins two names. A vertex comes
        /// no farther from what becomes part of it, beginning with how far it has come, than the
        /// least of its limits. An error where the triangles are no manifold.
        unsafe fn simplify<'a>(
            points: &[f64],
            triangles: &[u32],
            names: &[u32],
            limits: &[f64],
            reached: &[f64],
            wanted: usize,
            watch: &Watch<'a>,
        ) -> Result<Simplified>;
    }
}

pub use bridge::Simplified;

use crate::progress::Progress;

/// Tells whoever watches how far it has come.
pub struct Watch<'a>(pub &'a dyn Progress);

impl Watch<'_> {
    fn goes_on(&self) -> bool {
        self.0.advance(1);
        !self.0.is_cancelled()
    }
}

/// As the bridge's function.
///
/// # Errors
/// As there.
pub fn simplify(
    points: &[f64],
    triangles: &[u32],
    names: &[u32],
    [limits, reached]: [&[f64]; 2],
    wanted: usize,
    watch: &Watch,
) -> std::result::Result<Simplified, cxx::Exception> {
    // SAFETY: the watch is asked during the call alone.
    unsafe { bridge::simplify(points, triangles, names, limits, reached, wanted, watch) }
}
