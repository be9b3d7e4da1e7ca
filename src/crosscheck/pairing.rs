//! Which regions on a cell's walls are joined through its inside: the field
//! and the skeleton may bridge different ones.
//!
//! A *region* is a connected part of one label along the cell's walls: of its
//! nodes with a neighbour that is not in it. Such a node is so near to a wall
//! that the nearest known point lies on it, so the skeleton's label there is
//! the wall's own. Two regions of a label count as joined by one
//! reconstruction and apart in the other only if they are joined across the
//! sides of voxels in the one, and not even across their corners in the other:
//! what the lattice cannot decide is no difference.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::agreement::Pair;
use super::rows::Rows;
use crate::complex::Complex;
use crate::grid::labels::LabelGrid;
use crate::grid::runs::{Neighbors, Run, Runs};
use crate::grid::samples::Lattice;
use crate::label::Label;
use crate::progress::Progress;
use crate::sets::components;

/// Regions of fewer nodes are too small for the lattice to say what they are
/// joined to.
const SMALLEST: u64 = 8;
/// How many differences are listed.
const LISTED: usize = 32;

/// Differences in what is joined, over all cells.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Pairing {
    /// Cells with several labels on their walls: in the others there is
    /// nothing to decide.
    pub cells: usize,
    /// Those of them that have no node away from their walls.
    pub thin: usize,
    /// Those in which other regions are joined.
    pub differ: usize,
    /// What differs, the largest first, at most 32.
    pub differences: Vec<Difference>,
}

/// Two regions that one of the two joins.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Difference {
    /// The cell's number.
    pub cell: u32,
    /// The names of the sections that bound it.
    pub sections: Vec<String>,
    /// The label of both regions.
    pub label: u32,
    /// Who joins them.
    pub joined_by: Reconstruction,
    /// The regions, the larger first.
    pub regions: [Region; 2],
}

/// One of the two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reconstruction {
    /// The mean-value field.
    Field,
    /// The straight skeleton.
    Skeleton,
}

/// A part of one label along a cell's walls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Region {
    /// A node of it.
    pub at: [f64; 3],
    /// How many nodes it has.
    pub nodes: u64,
}

/// Compares all cells.
pub fn pairing(complex: &Complex, pair: &Pair, progress: &dyn Progress) -> Pairing {
    let several = |cell: &u32| complex.cells()[*cell].labels.len() > 1;
    let cells: Vec<u32> = complex.cells().ids().filter(several).collect();
    progress.begin("pairing", cells.len() as u64);
    let found: Vec<Option<Vec<Joined>>> = cells
        .par_iter()
        .map(|&cell| {
            let found = Walls::new(complex, cell, pair).map(|walls| walls.differences(pair));
            progress.advance(1);
            found
        })
        .collect();
    let thin = found.iter().filter(|found| found.is_none()).count();
    let differ = found.iter().flatten().filter(|found| !found.is_empty()).count();
    let mut all: Vec<(u32, Joined)> = (cells.iter().zip(found))
        .flat_map(|(&cell, found)| found.into_iter().flatten().map(move |joined| (cell, joined)))
        .collect();
    // Stable: of equals the first cell.
    all.sort_by_key(|(_, joined)| std::cmp::Reverse(joined.regions[1].nodes));
    all.truncate(LISTED);
    let differences = all.into_iter().map(|(cell, joined)| Difference {
        cell,
        sections: sections_around(complex, cell),
        label: joined.label.0,
        joined_by: joined.by,
        regions: joined.regions,
    });
    Pairing { cells: cells.len(), thin, differ, differences: differences.collect() }
}

/// The names of the sections on whose planes a cell has facets.
fn sections_around(complex: &Complex, cell: u32) -> Vec<String> {
    let mut planes: Vec<u32> = complex.facets_of(cell).map(|(_, facet)| facet.plane).collect();
    planes.sort_unstable();
    let mut names: Vec<String> =
        planes.into_iter().filter_map(|plane| complex.name(plane)).map(str::to_owned).collect();
    names.dedup();
    names
}

/// Two regions that are joined by one reconstruction alone.
struct Joined {
    label: Label,
    by: Reconstruction,
    regions: [Region; 2],
}

/// The nodes of a cell, and its regions.
struct Walls {
    rows: Rows,
    /// The runs of nodes at walls, by the skeleton's labels.
    runs: Runs<Label>,
    /// The region of each run.
    region_of: Vec<u32>,
    /// What is known of each region, and its label.
    regions: Vec<(Label, Region)>,
}

impl Walls {
    /// `None` for a cell without a node away from its walls.
    fn new(complex: &Complex, cell: u32, pair: &Pair) -> Option<Self> {
        let lattice = &pair.skeleton.lattice;
        let rows = Rows::new(complex, cell, lattice)?;
        let mut inside = false;
        let runs = Runs::new(rows.dims, |row, runs| {
            let [range, inner] = [rows.range(row), rows.inner(row)];
            inside |= !inner.is_empty();
            for part in [range.start..inner.start, inner.end..range.end] {
                add_runs(&pair.skeleton, rows.node(row, 0), part.start, part.end, runs);
            }
        });
        let region_of = runs.parts(Neighbors::All);
        let regions = regions(&runs, &region_of, &rows, lattice);
        inside.then_some(Self { rows, runs, region_of, regions })
    }

    /// The regions that are joined differently.
    fn differences(&self, pair: &Pair) -> Vec<Joined> {
        if self.regions.len() < 2 {
            return Vec::new();
        }
        let [field, skeleton] = [&pair.field, &pair.skeleton].map(|labels| self.groups(labels));
        let mut found = Vec::new();
        for (by, one, other) in [
            (Reconstruction::Field, &field, &skeleton),
            (Reconstruction::Skeleton, &skeleton, &field),
        ] {
            found.extend(self.joined_by(by, &one.surely, &other.perhaps, &field.present));
        }
        found
    }

    /// How a reconstruction joins the regions.
    fn groups(&self, labels: &LabelGrid) -> Groups {
        let all = Runs::new(self.rows.dims, |row, runs| {
            let range = self.rows.range(row);
            add_runs(labels, self.rows.node(row, 0), range.start, range.end, runs);
        });
        let mut touching = Vec::new();
        for row in 0..self.rows.dims[0] * self.rows.dims[1] {
            touching.extend(self.runs.touching(self.runs.row(row), &all, all.row(row), 0));
        }
        let count = self.regions.len() as u32;
        let joined = |neighbors| {
            let parts = all.parts(neighbors);
            let last = parts.iter().max().map_or(0, |&last| last + 1);
            let pair = |&[own, other]: &[u32; 2]| {
                [self.region_of[own as usize], count + parts[other as usize]]
            };
            let mut groups = components(count + last, touching.iter().map(pair));
            groups.truncate(count as usize);
            groups
        };
        let mut present = vec![false; count as usize];
        touching.iter().for_each(|&[own, _]| present[self.region_of[own as usize] as usize] = true);
        Groups { surely: joined(Neighbors::Six), perhaps: joined(Neighbors::All), present }
    }

    /// Where one joins what the other does not: for every part of the one
    /// that holds several parts of the other, the largest region of the
    /// largest two of these.
    fn joined_by(
        &self,
        by: Reconstruction,
        one: &[u32],
        other: &[u32],
        present: &[bool],
    ) -> Vec<Joined> {
        // By the one's part and then the other's, the largest region.
        let mut largest: BTreeMap<u32, BTreeMap<u32, usize>> = BTreeMap::new();
        let counts = |&region: &usize| present[region] && self.regions[region].1.nodes >= SMALLEST;
        for region in (0..one.len()).filter(counts) {
            let best = largest.entry(one[region]).or_default().entry(other[region]);
            let best = best.or_insert(region);
            if self.regions[region].1.nodes > self.regions[*best].1.nodes {
                *best = region;
            }
        }
        let several = largest.into_values().filter(|parts| parts.len() > 1);
        let joined = several.map(|parts| {
            let mut regions: Vec<usize> = parts.into_values().collect();
            regions.sort_by_key(|&region| std::cmp::Reverse(self.regions[region].1.nodes));
            let label = self.regions[regions[0]].0;
            Joined { label, by, regions: [0, 1].map(|i| self.regions[regions[i]].1) }
        });
        joined.collect()
    }
}

/// How regions are joined: the number of each one's group.
struct Groups {
    /// Across sides alone.
    surely: Vec<u32>,
    /// Across corners, too.
    perhaps: Vec<u32>,
    /// Whether the reconstruction has any node of the region.
    present: Vec<bool>,
}

/// Adds the runs of the nodes `start..end` of a row through a node.
fn add_runs(
    labels: &LabelGrid,
    [x, y, _]: [i32; 3],
    start: i32,
    end: i32,
    runs: &mut Vec<Run<Label>>,
) {
    let first = runs.len();
    for z in start..end {
        let label = labels.at([x, y, z]);
        match runs[first..].last_mut() {
            Some(run) if run.label == label => run.end = z + 1,
            _ => runs.push(Run { start: z, end: z + 1, label }),
        }
    }
}

/// For every region its label, its size and the middle of its longest run.
fn regions(
    runs: &Runs<Label>,
    region_of: &[u32],
    rows: &Rows,
    lattice: &Lattice,
) -> Vec<(Label, Region)> {
    let count = region_of.iter().max().map_or(0, |&last| last as usize + 1);
    let mut sizes = vec![0; count];
    let mut longest: Vec<Option<usize>> = vec![None; count];
    for (index, &region) in region_of.iter().enumerate() {
        sizes[region as usize] += runs.runs[index].len();
        let best = longest[region as usize].get_or_insert(index);
        if runs.runs[index].len() > runs.runs[*best].len() {
            *best = index;
        }
    }
    let region = |(nodes, longest): (u64, Option<usize>)| {
        let index = longest?;
        let run = &runs.runs[index];
        let node = rows.node(runs.row_of(index), run.start.midpoint(run.end));
        Some((run.label, Region { at: lattice.position(node).to_array(), nodes }))
    };
    sizes.into_iter().zip(longest).filter_map(region).collect()
}
