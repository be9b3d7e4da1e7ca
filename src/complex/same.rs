//! Which cells of two complexes are the same.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::{Complex, Facet};
use crate::label::Label;

/// A facet's plane, corners and regions, to the bit and in an order of their own.
type Words = Vec<u64>;

impl Complex {
    /// The cells that another complex has, too, with the same regions on the same facets: from
    /// their numbers here to those there. The sections are drawn on the same sides of their
    /// planes.
    pub fn same_cells(&self, other: &Self) -> BTreeMap<u32, u32> {
        let there: HashMap<Vec<Words>, u32> =
            other.cells().ids().map(|cell| (other.content(cell), cell)).collect();
        let same = |cell: u32| Some((cell, *there.get(&self.content(cell))?));
        self.cells().ids().filter_map(same).collect()
    }

    fn content(&self, cell: u32) -> Vec<Words> {
        let mut facets: Vec<Words> =
            self.facets_of(cell).map(|(_, facet)| self.content_of(facet)).collect();
        facets.sort_unstable();
        facets
    }

    fn content_of(&self, facet: &Facet) -> Words {
        let words = |point: DVec3| point.to_array().map(f64::to_bits);
        let mut corners: Vec<[u64; 3]> =
            facet.outline.iter().map(|&corner| words(corner)).collect();
        corners.sort_unstable();
        let mut edges: Vec<[u64; 8]> = (facet.edges.iter())
            .map(|edge| {
                let ([a, b, c], [d, e, f]) = (words(edge.start), words(edge.end));
                // One more than a label, so that none is something else.
                let label = |label: Option<Label>| label.map_or(0, |label| u64::from(label.0) + 1);
                [a, b, c, d, e, f, label(Some(edge.left)), label(edge.right)]
            })
            .collect();
        edges.sort_unstable();
        let mut all = words(self.planes()[facet.plane].normal).to_vec();
        all.push(corners.len() as u64);
        all.extend(corners.as_flattened());
        all.extend(edges.as_flattened());
        all
    }
}
