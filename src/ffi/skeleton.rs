//! The exact reconstruction by straight skeletons, with CGAL's exact kernel
//! (`cpp/skeleton.cc` and `cpp/skeleton/`).

use std::sync::atomic::{AtomicU64, Ordering};

use crate::progress::Progress;

#[cxx::bridge(namespace = "transect::skeleton")]
mod bridge {
    /// Sections in the box. Labels are numbers; `u32::MAX` is unknown.
    #[derive(Debug, Default)]
    struct Input {
        /// Normal and offset of every section's plane.
        planes: Vec<f64>,
        /// For every plane the two kept axes and the dropped one.
        axes: Vec<u32>,
        /// Two kept coordinates per vertex.
        vertices: Vec<f64>,
        /// Those of section i are `vertex_starts[i]..vertex_starts[i + 1]`.
        vertex_starts: Vec<u32>,
        /// Start, end (vertices of the section), label left and right.
        edges: Vec<u32>,
        /// As `vertex_starts`.
        edge_starts: Vec<u32>,
        /// The label far away, for every section.
        backgrounds: Vec<u32>,
        /// 1 for sections of which a part is unknown.
        partial: Vec<u8>,
        /// Lower and upper x, y, z of the box.
        bounds: Vec<f64>,
        /// How far apart two sections' changes of label on their common line
        /// may be to be one, in world units.
        tolerance: f64,
        /// Relative accuracy of distances, to begin with.
        bits: u32,
    }

    /// What a cell's surfaces follow from, and what the scene has it as.
    #[derive(Debug, Default)]
    struct CellKey {
        /// Cells with the same words, of whatever scene, have the same surfaces. None where
        /// there is one label alone, and so no surface.
        words: Vec<u64>,
        /// The cell's points by their shared numbers.
        points: Vec<u32>,
        /// The planes of its walls and partial sections; those of the box follow the sections'.
        planes: Vec<u32>,
    }

    /// The surfaces in one cell, by the numbers that its key gives to points and planes.
    #[derive(Debug, Default)]
    struct CellOutput {
        /// Points that follow the key's, rounded.
        points: Vec<f64>,
        /// The same as fractions, when asked for.
        exact: Vec<String>,
        /// Three a triangle, counter-clockwise as seen from the front.
        corners: Vec<u32>,
        /// Back and front label of every triangle.
        labels: Vec<u32>,
        /// 1 for walls, 0 for roofs.
        walls: Vec<u8>,
        /// Two planes a triangle.
        planes: Vec<u32>,
        /// Ends of a contour's piece and a point between them that triangles
        /// here have, and those in the cell beyond may not.
        splits: Vec<u32>,
        /// Whether there are too many partial sections for a surface.
        is_left_out: bool,
        /// How many parts of the cell hold too many sites to be exact.
        inexact_parts: u32,
        /// Their volume, rounded.
        inexact_volume: f64,
        /// The middle of the largest one, rounded; empty without any.
        inexact_at: Vec<f64>,
    }

    /// Where two sections never say the same on their common line.
    #[derive(Debug, Default)]
    struct ContradictionOutput {
        /// The sections.
        sections: [u32; 2],
        /// The stretch of the line: two points, rounded.
        ends: Vec<f64>,
        /// What the first section says along it.
        first: Vec<u32>,
        /// What the second says.
        second: Vec<u32>,
    }

    extern "Rust" {
        type Watcher<'a>;
        /// This part of the cell is done, roughly. From any thread.
        unsafe fn reach<'a>(self: &Watcher<'a>, part: f64);
    }

    unsafe extern "C++" {
        include!("transect/cpp/skeleton.h");

        /// Sections cut by each other's planes, and the cells between them.
        type Skeleton;

        /// Cuts and reconciles the sections and makes the cells.
        fn prepare(input: &Input) -> Result<UniquePtr<Skeleton>>;

        /// The number of cells.
        fn cells(self: &Skeleton) -> u32;
        /// The accuracy of distances that was needed.
        fn bits(self: &Skeleton) -> u32;
        /// Ends of contours' pieces that were moved onto another section's.
        fn snapped(self: &Skeleton) -> u32;
        /// The points that cells share, rounded.
        fn points(self: &Skeleton) -> Result<Vec<f64>>;
        /// The same as fractions.
        fn exact_points(self: &Skeleton) -> Result<Vec<String>>;
        /// The pieces of contours between known labels, two shared points each.
        fn contours(self: &Skeleton) -> Vec<u32>;
        /// Where sections contradict each other.
        fn contradictions(self: &Skeleton) -> Result<Vec<ContradictionOutput>>;
        /// What the surfaces in a cell follow from. It has none where there are more pieces
        /// between known and unknown than `most_pieces`. Several threads may ask at once.
        fn key(self: &Skeleton, cell: u32, exact: bool, most_pieces: u32) -> Result<CellKey>;
        /// The surfaces in a cell whose key is not empty. Several threads may ask at once.
        fn surface(
            self: &Skeleton,
            cell: u32,
            exact: bool,
            most_pieces: u32,
            watcher: &Watcher,
        ) -> Result<CellOutput>;
    }
}

pub use bridge::*;

/// Passes on how far one cell has come.
pub struct Watcher<'a> {
    progress: &'a dyn Progress,
    done: AtomicU64,
}

impl<'a> Watcher<'a> {
    /// The steps of one cell.
    pub const STEPS: u64 = 1000;

    /// Nothing is done yet.
    pub fn new(progress: &'a dyn Progress) -> Self {
        Self { progress, done: AtomicU64::new(0) }
    }

    /// This part of the cell is done; less than before says nothing.
    pub fn reach(&self, part: f64) {
        let steps = (part.clamp(0.0, 1.0) * Self::STEPS as f64) as u64;
        let before = self.done.fetch_max(steps, Ordering::Relaxed);
        if steps > before {
            self.progress.advance(steps - before);
        }
    }
}

// SAFETY: after `prepare` nothing in a Skeleton is written but what CGAL's lazy
// numbers guard by themselves, and those that cells share are exact by then.
unsafe impl Send for Skeleton {}
// SAFETY: as above.
unsafe impl Sync for Skeleton {}
