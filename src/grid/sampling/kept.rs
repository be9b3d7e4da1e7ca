//! What was sampled before, for sampling again when some cells have changed.

use std::collections::BTreeSet;

use crate::grid::leaf::{LeafOf, LeafValues, NewLeaf};
use crate::grid::leaf_grid::leaf_after;
use crate::grid::samples::{Lattice, Samples};
use crate::label::Label;

/// Samples with the cells that their nodes lie in.
#[derive(Debug, Clone, PartialEq)]
pub struct Kept {
    /// The samples as they were evaluated.
    pub samples: Samples,
    /// The cell of every leaf's node on the coarse lattice.
    pub(super) coarse: Vec<u32>,
    /// The cells that the nodes of every valued leaf lie in, in the order of the leaves.
    pub(super) cells: Vec<Vec<u32>>,
}

impl Kept {
    /// The same on another lattice, with whose leaves `by` says what these have in common:
    /// cells get other numbers, and leaves that were not there a cell that is `gone`.
    pub fn moved(
        &self,
        by: [i32; 3],
        lattice: &Lattice,
        number: impl Fn(u32) -> u32,
        gone: u32,
    ) -> Self {
        let old = &self.samples.lattice;
        let coarse = |index: usize| {
            let was = leaf_after(lattice.leaf_at(index), by.map(|along| -along));
            if old.has_leaf(was) { number(self.coarse[old.leaf_index(was)]) } else { gone }
        };
        let cells = self.samples.valued.iter().zip(&self.cells);
        let cells = cells.filter(|(leaf, _)| lattice.has_leaf(leaf_after(**leaf, by)));
        Self {
            coarse: (0..lattice.leaf_count() as usize).map(coarse).collect(),
            cells: cells
                .map(|(_, cells)| cells.iter().map(|&cell| number(cell)).collect())
                .collect(),
            samples: self.samples.moved(by, *lattice),
        }
    }
}

/// What is left of samples on the same lattice.
#[derive(Debug, Clone, Copy)]
pub struct Before<'a> {
    /// The samples.
    pub kept: &'a Kept,
    /// The cells that changed since, or went.
    pub touched: &'a BTreeSet<u32>,
}

impl Before<'_> {
    /// The cell and the label of a leaf's coarse node, if they are as they were.
    pub(super) fn coarse(&self, index: usize) -> Option<(u32, Label)> {
        let cell = self.kept.coarse[index];
        (!self.touched.contains(&cell)).then(|| (cell, self.kept.samples.tiles[index]))
    }

    /// A leaf and its cells, if its values are as they were.
    pub(super) fn leaf(&self, at: [i32; 3]) -> Option<(NewLeaf, &[u32])> {
        let place = self.kept.samples.valued.binary_search(&at).ok()?;
        let cells = &self.kept.cells[place];
        if cells.iter().any(|cell| self.touched.contains(cell)) {
            return None;
        }
        let leaf = self.kept.samples.leaf(at)?;
        let own =
            |own: &LeafValues<&_>| LeafValues { label: own.label, values: Box::new(*own.values) };
        Some((LeafOf { at, materials: leaf.materials.iter().map(own).collect() }, cells))
    }
}
