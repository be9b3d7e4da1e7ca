//! What is kept from one change to the next: the surfaces of cells, by what these show.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use crate::error::Result;
use crate::ffi::skeleton::{self as ffi, CellOutput, Watcher};
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::Section;

use super::{Options, Skeleton, failed, join, most_pieces, prepare};

/// Surfaces of cells. They are valid wherever a cell shows the same, so nothing needs to be
/// known of what changed in between, or of changes that failed.
#[derive(Debug, Default)]
pub struct Kept {
    surfaces: HashMap<Vec<u64>, Arc<CellOutput>>,
    computed: u32,
}

/// A cell with what is in it; without a surface where it shows one label.
pub(super) struct Cell {
    words: Vec<u64>,
    /// The scene's numbers of points and planes.
    pub(super) points: Vec<u32>,
    pub(super) planes: Vec<u32>,
    pub(super) surface: Arc<CellOutput>,
    is_new: bool,
}

impl Kept {
    /// Reconstructs as [`skeleton`](super::skeleton) does, and computes only surfaces of cells
    /// that show something else than last time. When it fails it keeps what it had.
    ///
    /// # Errors
    /// As `skeleton`, and when it is cancelled.
    pub fn follow(
        &mut self,
        sections: &[Section],
        bounds: Bounds,
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<Skeleton> {
        let prepared = prepare(sections, bounds, options, progress)?;
        progress.begin("skeleton", u64::from(prepared.cells()) * Watcher::STEPS);
        let most_pieces = most_pieces(prepared.cells());
        let cells = (0..prepared.cells())
            .into_par_iter()
            .map(|cell| self.cell(&prepared, cell, options.exact, most_pieces, progress))
            .collect::<Result<Vec<Option<Cell>>>>()?;
        let made = join(&prepared, &cells, sections, bounds, options)?;
        self.computed = cells.iter().flatten().filter(|cell| cell.is_new).count() as u32;
        let cells = cells.into_iter().flatten();
        self.surfaces = cells.map(|cell| (cell.words, cell.surface)).collect();
        Ok(made)
    }

    /// In how many cells the surface was computed last time.
    pub fn computed(&self) -> u32 {
        self.computed
    }

    /// `None` where there is no surface.
    fn cell(
        &self,
        prepared: &ffi::Skeleton,
        cell: u32,
        exact: bool,
        most_pieces: u32,
        progress: &dyn Progress,
    ) -> Result<Option<Cell>> {
        progress.go_on()?;
        let watcher = Watcher::new(progress);
        let ffi::CellKey { words, points, planes } =
            prepared.key(cell, exact, most_pieces).map_err(failed)?;
        let known = self.surfaces.get(&words).cloned();
        let is_new = known.is_none() && !words.is_empty();
        let surface = if is_new {
            let made = prepared.surface(cell, exact, most_pieces, &watcher);
            Some(Arc::new(made.map_err(failed)?))
        } else {
            known
        };
        watcher.reach(1.0);
        Ok(surface.map(|surface| Cell { words, points, planes, surface, is_new }))
    }
}
