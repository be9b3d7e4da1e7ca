//! The exact cell complex of the planes in a box (`cpp/complex.cc` and `cpp/complex/`).

#[cxx::bridge(namespace = "transect::complex")]
mod bridge {
    /// Facets and cells in flat lists; what belongs to the i-th is in
    /// `starts[i]..starts[i + 1]` of a list. `u32::MAX` is no cell, and no label.
    #[derive(Debug, Default)]
    struct Parts {
        /// Cells by their numbers, ascending.
        cells: Vec<u32>,
        /// See above.
        cell_starts: Vec<u32>,
        /// The facets of each.
        cell_facets: Vec<u32>,
        /// Cells that are no more.
        removed_cells: Vec<u32>,
        /// Facets by their numbers, ascending.
        facets: Vec<u32>,
        /// Three a facet: its plane, the cell in front of it and the one behind.
        facet_ids: Vec<u32>,
        /// See above.
        corner_starts: Vec<u32>,
        /// The corners of each, counter-clockwise about the plane's normal, by numbers that
        /// facets share.
        corners: Vec<u32>,
        /// Three coordinates a corner, exact ones rounded.
        outlines: Vec<f64>,
        /// See above.
        edge_starts: Vec<u32>,
        /// Two points an edge, three coordinates each.
        edges: Vec<f64>,
        /// Left and right of each edge, seen with the normal pointing at the viewer.
        edge_labels: Vec<u32>,
        /// So many of each facet's edges, the first ones, are its border, whose right is
        /// beyond it.
        border_edges: Vec<u32>,
        /// Facets that are no more.
        removed_facets: Vec<u32>,
    }

    unsafe extern "C++" {
        include!("transect/cpp/complex.h");

        /// Cells, their facets and what is drawn on them, exact.
        type ExactComplex;

        /// A box (lower and upper x, y, z) whose faces have a label. Its planes have the
        /// numbers 0 to 5, in this order, their normals pointing outward.
        fn new_complex(bounds: &[f64], border: u32) -> Result<UniquePtr<ExactComplex>>;

        /// The number of the plane (normal and offset) that is the same set of points;
        /// `u32::MAX` without one.
        fn coincident(self: &ExactComplex, plane: &[f64]) -> Result<u32>;
        /// Cuts the cells that a plane crosses, and returns its number. No plane there must
        /// coincide with it.
        fn insert(self: Pin<&mut ExactComplex>, plane: &[f64]) -> Result<u32>;
        /// Removes a plane with what is drawn on it, and joins the cells on its sides. It
        /// must not be the box's.
        fn remove(self: Pin<&mut ExactComplex>, plane: u32) -> Result<()>;
        /// Draws on a plane, in place of what was there: vertices by their kept coordinates,
        /// edges by start, end (vertices), label left and right.
        fn draw(
            self: Pin<&mut ExactComplex>,
            plane: u32,
            vertices: &[f64],
            edges: &[u32],
            background: u32,
        ) -> Result<()>;
        /// Gives a plane of the box its label back.
        fn erase(self: Pin<&mut ExactComplex>, plane: u32) -> Result<()>;

        /// What is changed from now on can be taken back, until it is committed.
        fn begin(self: Pin<&mut ExactComplex>);
        /// All that was changed holds.
        fn commit(self: Pin<&mut ExactComplex>);
        /// Takes back what was changed since the beginning.
        fn rollback(self: Pin<&mut ExactComplex>);

        /// Fails when something does not hold that must.
        fn check(self: &ExactComplex) -> Result<()>;
        /// Fails when a corner or an end of something drawn is not on all planes that it is
        /// said to be on. Each is computed exactly, which takes a while.
        fn check_places(self: &ExactComplex) -> Result<()>;
        /// All facets and cells.
        fn parts(self: &ExactComplex) -> Result<Parts>;
        /// Those that changed since the beginning.
        fn changes(self: &ExactComplex) -> Result<Parts>;
    }
}

pub use bridge::*;

// SAFETY: it owns all it refers to but for CGAL's numbers, whose counts of references are
// atomic (`CGAL_HAS_THREADS`).
unsafe impl Send for ExactComplex {}
