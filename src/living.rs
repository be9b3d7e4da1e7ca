//! The cells of sections that come and go, and what was sampled in them: what the mean-value
//! field keeps from one change of a model to the next (Bermano §7).

use std::collections::{BTreeMap, BTreeSet};

use crate::complex::{Complex, Editor};
use crate::error::{Error, Result};
use crate::field::{CellShares, Completion};
use crate::grid::samples::Lattice;
use crate::grid::sampling::{Before, Kept};
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::Section;

/// In place of a cell that there is no more, or was not.
const GONE: u32 = u32::MAX - 1;

/// By so much of a whole a share may be another one than a cell was sampled with; what is
/// sampled then differs by less than four times as much.
const SHARES_ALIKE: f32 = 5e-5;

/// A complex that follows sections, and samples that follow it.
pub(crate) struct Living {
    editor: Editor,
    /// The sections that are drawn, by plane.
    drawn: BTreeMap<u32, Section>,
    /// The last samples.
    kept: Option<Kept>,
    /// The cells that changed since, or went.
    touched: BTreeSet<u32>,
    /// What completed the unknown regions last.
    completion: Completion,
    /// What was said on those of every cell when it was sampled.
    shares: BTreeMap<u32, CellShares>,
}

/// What is kept follows sections in a box, on a lattice over it. Returns it with the number of
/// cells that are others than before.
///
/// # Errors
/// When the box has no volume, or as [`Editor::add`]; then all is as it was.
pub(crate) fn follow<'a>(
    kept: &'a mut Option<Living>,
    sections: &[Section],
    (bounds, border): (Bounds, Label),
    lattice: &Lattice,
) -> Result<(&'a mut Living, usize)> {
    let is_there = |living: &Living| {
        living.complex().bounds() == bounds && living.complex().border() == border
    };
    if let Some(living) = kept.take_if(|living| is_there(living)) {
        let living = kept.insert(living);
        let touched = living.follow(sections)?;
        return Ok((living, touched));
    }
    let mut living = Living::new(bounds, border)?;
    let all = living.follow(sections)?;
    let same = kept.take().map_or(0, |was| living.take_over(was, lattice));
    Ok((kept.insert(living), all - same))
}

impl Living {
    /// A box without sections.
    ///
    /// # Errors
    /// When it has no volume.
    fn new(bounds: Bounds, border: Label) -> Result<Self> {
        let (drawn, kept, touched, completion, shares) = Default::default();
        let editor = Editor::new(bounds, border)?;
        Ok(Self { editor, drawn, kept, touched, completion, shares })
    }

    /// Takes over what was sampled in cells of another box that are here, too, and returns how
    /// many these are.
    fn take_over(&mut self, was: Self, lattice: &Lattice) -> usize {
        let same = was.complex().same_cells(self.complex());
        let by = was
            .kept
            .as_ref()
            .and_then(|kept| Some((kept, kept.samples.lattice.leaves_to(lattice)?)));
        let Some((kept, by)) = by else { return same.len() };
        let number = |cell: u32| match same.get(&cell) {
            Some(&cell_here) if !was.touched.contains(&cell) => cell_here,
            _ => GONE,
        };
        self.kept = Some(kept.moved(by, lattice, number, GONE));
        self.touched = BTreeSet::from([GONE]);
        let shares =
            was.shares.into_iter().filter_map(|(cell, own)| Some((*same.get(&cell)?, own)));
        self.shares = shares.collect();
        self.completion = was.completion;
        same.len()
    }

    /// The cells.
    pub fn complex(&self) -> &Complex {
        self.editor.complex()
    }

    /// Adds, draws anew and removes sections until these are there and no others. What is
    /// already there is left alone. Returns how many cells that concerned.
    ///
    /// # Errors
    /// As [`Editor::add`]; then all is as it was.
    fn follow(&mut self, sections: &[Section]) -> Result<usize> {
        let is_first = self.drawn.is_empty();
        let edited = self.edit(sections).and_then(|drawn| Ok((drawn, self.editor.commit()?)));
        let (drawn, touched) = edited.inspect_err(|_| self.editor.rollback())?;
        self.drawn = drawn;
        self.touched.extend(touched.cells.iter().chain(&touched.removed_cells));
        if is_first || cfg!(feature = "assertions") {
            let sound = self.editor.sanity_check();
            sound.map_err(|what| Error::Bug { stage: "arrangement", what })?;
        }
        Ok(touched.cells.len())
    }

    fn edit(&mut self, sections: &[Section]) -> Result<BTreeMap<u32, Section>> {
        let mut drawn = self.drawn.clone();
        drawn.retain(|_, known| sections.iter().any(|section| section.plane() == known.plane()));
        for &plane in self.drawn.keys().filter(|plane| !drawn.contains_key(plane)) {
            self.editor.remove(plane)?;
        }
        for section in sections {
            let known = drawn.iter_mut().find(|(_, known)| known.plane() == section.plane());
            match known {
                Some((_, known)) if known == section => (),
                Some((&plane, known)) => {
                    self.editor.replace(plane, section)?;
                    known.clone_from(section);
                }
                None => {
                    drawn.insert(self.editor.add(section)?, section.clone());
                }
            }
        }
        Ok(drawn)
    }

    /// What completed the unknown regions last.
    pub fn completion(&self) -> &Completion {
        &self.completion
    }

    /// The cells that are others than when samples were taken, or are gone, or on whose unknown
    /// regions something else is said now.
    pub fn changed(&self, now: &BTreeMap<u32, CellShares>) -> BTreeSet<u32> {
        let is_near = |cell: &u32, now: &CellShares| {
            self.shares.get(cell).is_some_and(|was| was.is_near(now, SHARES_ALIKE))
        };
        let mut changed = self.touched.clone();
        changed.extend(now.iter().filter(|(cell, now)| !is_near(cell, now)).map(|(&cell, _)| cell));
        changed
    }

    /// What was sampled on a lattice, where it still holds: not in cells that changed.
    pub fn before<'a>(
        &'a self,
        lattice: &Lattice,
        changed: &'a BTreeSet<u32>,
    ) -> Option<Before<'a>> {
        let kept = self.kept.as_ref().filter(|kept| kept.samples.lattice == *lattice)?;
        Some(Before { kept, touched: changed })
    }

    /// Keeps what was sampled in the cells as they are now, what completed their unknown regions,
    /// and what is said there. What cells were sampled with that have not changed is told as it
    /// was, so that many small differences do not become a large one.
    pub fn keep(
        &mut self,
        kept: Kept,
        completion: Completion,
        mut shares: BTreeMap<u32, CellShares>,
        changed: &BTreeSet<u32>,
    ) {
        for (cell, own) in std::mem::take(&mut self.shares) {
            if let Some(now) = shares.get_mut(&cell).filter(|_| !changed.contains(&cell)) {
                *now = own;
            }
        }
        (self.shares, self.completion, self.kept) = (shares, completion, Some(kept));
        self.touched.clear();
    }
}

impl std::fmt::Debug for Living {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Living").field("drawn", &self.drawn.len()).finish_non_exhaustive()
    }
}
