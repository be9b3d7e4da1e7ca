//! Questions about triangle meshes, answered by CGAL's
//! Polygon_mesh_processing and AABB tree (`cpp/measure.cc`).

#[cxx::bridge(namespace = "transect::measure")]
mod bridge {
    /// One connected piece of a surface.
    #[derive(Debug, Clone)]
    struct Component {
        /// Cubic world units; negative where the surface faces inward.
        volume: f64,
        /// What rounding can have made of the volume, in cubic world units.
        rounding: f64,
        /// Vertices − edges + faces.
        euler: i64,
        /// The corner of its box with the smallest coordinates.
        min: [f64; 3],
        /// The corner of its box with the largest coordinates.
        max: [f64; 3],
    }

    /// What is known about a surface.
    #[derive(Debug, Clone)]
    struct Facts {
        /// Triangles that do not fit because an edge already has two others,
        /// or one that runs the same way.
        left_out: u64,
        /// Whether every triangle fits and every edge has two.
        closed: bool,
        /// Square world units.
        area: f64,
        /// The connected pieces.
        components: Vec<Component>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/measure.h");

        /// The versions of CGAL and OpenVDB that this program was built with.
        fn library_versions() -> String;

        /// Closedness, volume, area and topology of a triangle mesh.
        fn measure(points: &[f64], triangles: &[u32]) -> Result<Facts>;

        /// The pairs of triangles that intersect other than in a corner or an edge
        /// that both have at the same place, by their numbers: those with a triangle
        /// that is asked for, if any is.
        fn crossings(points: &[f64], triangles: &[u32], asked: &[u32]) -> Result<Vec<u32>>;

        /// Triangles arranged for distance queries, from any thread.
        type Tree;

        /// A tree over the triangles.
        fn new_tree(points: &[f64], triangles: &[u32]) -> Result<UniquePtr<Tree>>;

        /// For each point, by threes, the distance to the nearest triangle.
        fn distances(tree: &Tree, points: &[f64]) -> Result<Vec<f64>>;

        /// For each point, by threes, the number of the nearest triangle.
        fn nearest_triangles(tree: &Tree, points: &[f64]) -> Result<Vec<u32>>;
    }
}

pub use bridge::*;

/// A tree as it comes over the bridge.
pub type OwnedTree = cxx::UniquePtr<Tree>;

// SAFETY: a Tree is built in full, its search structure for distances
// included, before it is handed out, and has no method that changes it.
unsafe impl Send for Tree {}
// SAFETY: as above; CGAL allows concurrent queries of a tree that is built.
unsafe impl Sync for Tree {}
