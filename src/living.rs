//! The cells of sections that come and go, and what was sampled in them: what the mean-value
//! field keeps from one change of a model to the next (Bermano §7).

use std::collections::{BTreeMap, BTreeSet};

use crate::complex::{Complex, Editor};
use crate::error::{Error, Result};
use crate::grid::samples::Lattice;
use crate::grid::sampling::{Before, Kept};
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::Section;

/// A complex that follows sections, and samples that follow it.
pub(crate) struct Living {
    editor: Editor,
    /// The sections that are drawn, by plane.
    drawn: BTreeMap<u32, Section>,
    /// The last samples, where nothing was unknown.
    kept: Option<Kept>,
    /// The cells that changed since, or went.
    touched: BTreeSet<u32>,
}

impl Living {
    /// A box without sections.
    ///
    /// # Errors
    /// When it has no volume.
    pub fn new(bounds: Bounds, border: Label) -> Result<Self> {
        let (drawn, kept, touched) = Default::default();
        Ok(Self { editor: Editor::new(bounds, border)?, drawn, kept, touched })
    }

    /// Whether the box and the label of its faces are these.
    pub fn is_in(&self, bounds: Bounds, border: Label) -> bool {
        self.complex().bounds() == bounds && self.complex().border() == border
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
    pub fn follow(&mut self, sections: &[Section]) -> Result<usize> {
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

    /// What was sampled on a lattice, and where that does not hold any more.
    pub fn before(&self, lattice: &Lattice) -> Option<Before<'_>> {
        let kept = self.kept.as_ref().filter(|kept| kept.samples.lattice == *lattice)?;
        Some(Before { kept, touched: &self.touched })
    }

    /// Keeps what was sampled in the cells as they are now.
    pub fn keep(&mut self, kept: Option<Kept>) {
        self.kept = kept;
        self.touched.clear();
    }
}

impl std::fmt::Debug for Living {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Living").field("drawn", &self.drawn.len()).finish_non_exhaustive()
    }
}
