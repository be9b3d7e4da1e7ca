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

        type Refinement;

        /// Curves are `curve_points` up to each of `curve_ends`; those that
        /// end where they start are closed. Outside the box (lower and upper
        /// x, y, z) everything is outside.
        unsafe fn new_refinement<'a>(
            oracle: &Oracle<'a>,
            bounds: &[f64],
            curve_points: &[f64],
            curve_ends: &[u32],
            criteria: &Criteria,
        ) -> Result<UniquePtr<Refinement>>;

        /// Refines until all facets are as they must be. `seeds` are points
        /// on the surface to begin with, or to add to what is there; `sides`
        /// the two labels at each.
        fn refine(self: Pin<&mut Refinement>, seeds: &[f64], sides: &[u32]) -> Result<Facets>;
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

/// Curves where surfaces meet.
#[derive(Debug, Clone, Copy)]
pub struct Curves<'a> {
    /// Coordinates by threes.
    pub points: &'a [f64],
    /// Where each curve ends in `points`.
    pub ends: &'a [u32],
}

/// A triangulation that is refined step by step.
pub struct Refinement<'a> {
    refinement: cxx::UniquePtr<bridge::Refinement>,
    /// C++ asks it at every step.
    _oracle: &'a Oracle<'a>,
}

impl<'a> Refinement<'a> {
    /// With the vertices that protect the curves.
    ///
    /// # Errors
    /// CGAL's exceptions.
    pub fn new(
        oracle: &'a Oracle<'a>,
        bounds: &[f64; 6],
        curves: &Curves,
        criteria: &Criteria,
    ) -> Result<Self, cxx::Exception> {
        // SAFETY: C++ keeps a reference to the oracle, which outlives `Self`.
        let refinement = unsafe {
            bridge::new_refinement(oracle, bounds, curves.points, curves.ends, criteria)
        }?;
        Ok(Self { refinement, _oracle: oracle })
    }

    /// See the bridge.
    ///
    /// # Errors
    /// CGAL's exceptions, and more vertices than allowed.
    pub fn refine(&mut self, seeds: &[f64], sides: &[u32]) -> Result<Facets, cxx::Exception> {
        self.refinement.pin_mut().refine(seeds, sides)
    }
}
