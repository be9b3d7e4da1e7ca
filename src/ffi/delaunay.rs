//! Delaunay refinement of a labelled domain, by CGAL's Mesh_3
//! (`cpp/delaunay.cc`).
//!
//! The one bridge that is crossed once for every point: refinement decides
//! from each answer where it asks next, so the questions cannot be batched.

#[cxx::bridge(namespace = "transect::delaunay")]
mod bridge {
    /// What the facets between labels must be like. Lengths are in the
    /// domain's units.
    #[derive(Debug, Clone, Copy)]
    struct Criteria {
        /// The smallest angle, in degrees.
        angle: f64,
        /// The largest radius of a ball around a facet, centred on the
        /// surface.
        size: f64,
        /// How far the centre of that ball may be from the facet's.
        distance: f64,
        /// The longest edge along a curve.
        edge: f64,
        /// Facets with balls smaller than this are left as they are.
        smallest: f64,
        /// How exactly a point on the surface is found.
        error: f64,
        /// More vertices than this are an error.
        most_vertices: usize,
    }

    /// Facets of a triangulation between tetrahedra of different labels.
    #[derive(Debug)]
    struct Facets {
        /// Three coordinates each.
        points: Vec<f64>,
        /// Three corners each.
        triangles: Vec<u32>,
        /// Two labels each: behind the triangle, and where its normal points.
        sides: Vec<u32>,
        /// The edges around which a label occurs more than once: the two
        /// ends, the number of facets, and of each facet in turn around the
        /// edge its index.
        rings: Vec<u32>,
    }

    extern "Rust" {
        type Oracle<'a>;
        /// The label at a point; outside is 0.
        unsafe fn label_at<'a>(self: &Oracle<'a>, x: f64, y: f64, z: f64) -> u32;
    }

    unsafe extern "C++" {
        include!("transect/cpp/delaunay.h");

        /// Refines until all facets are as they must be. Outside the box
        /// (lower and upper x, y, z) everything is outside. `seeds` are points
        /// on the surface, `seed_sides` the two labels at each. Curves are
        /// `curve_points` up to each of `curve_ends`; those that end where
        /// they start are closed.
        unsafe fn refine<'a>(
            oracle: &Oracle<'a>,
            bounds: &[f64],
            seeds: &[f64],
            seed_sides: &[u32],
            curve_points: &[f64],
            curve_ends: &[u32],
            criteria: &Criteria,
        ) -> Result<Facets>;
    }
}

pub use bridge::{Criteria, Facets};

/// Says which label is where. Pure, so that it may be asked from any thread.
pub struct Oracle<'a>(pub &'a (dyn Fn([f64; 3]) -> u32 + Sync));

impl Oracle<'_> {
    fn label_at(&self, x: f64, y: f64, z: f64) -> u32 {
        (self.0)([x, y, z])
    }
}

/// Points on surfaces, and curves where surfaces meet.
#[derive(Debug, Clone, Copy)]
pub struct Features<'a> {
    /// Coordinates by threes.
    pub seeds: &'a [f64],
    /// Two labels for each seed.
    pub seed_sides: &'a [u32],
    /// Coordinates by threes.
    pub curve_points: &'a [f64],
    /// Where each curve ends in `curve_points`.
    pub curve_ends: &'a [u32],
}

/// See the bridge.
///
/// # Errors
/// CGAL's exceptions, and more vertices than allowed.
pub fn refine(
    oracle: &Oracle,
    bounds: &[f64; 6],
    features: &Features,
    criteria: &Criteria,
) -> Result<Facets, cxx::Exception> {
    let Features { seeds, seed_sides, curve_points, curve_ends } = features;
    // SAFETY: C++ keeps no reference to the oracle beyond the call.
    unsafe { bridge::refine(oracle, bounds, seeds, seed_sides, curve_points, curve_ends, criteria) }
}
