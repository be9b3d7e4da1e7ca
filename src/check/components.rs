//! The connected parts of a solid's materials on its lattice between the
//! sections of a stack.

use glam::DVec3;

use crate::grid::labels::LabelGrid;
use crate::grid::runs::{Neighbors, Run, Runs};
use crate::grid::samples::{LEAF_SIDE, Lattice};
use crate::label::Label;
use crate::section::Stack;

/// What nodes of a part have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kind {
    /// The material.
    pub label: Label,
    /// How many sections of the stack lie below.
    pub slab: u32,
}

/// Nodes of one kind that are neighbours, if only by their corners: what is
/// apart here is apart in any surface between the nodes.
pub struct Components {
    lattice: Lattice,
    runs: Runs<Kind>,
    /// The part of each run.
    part_of: Vec<u32>,
}

impl Components {
    /// The solid's parts between neighbouring sections.
    pub fn between(labels: &LabelGrid, stack: &Stack) -> Self {
        let lattice = labels.lattice;
        let step = stack.direction.z * lattice.voxel;
        Self::of(labels, |[x, y], run, runs| {
            let foot = stack.height(lattice.position([x, y, 0]));
            runs.extend(cut(run, &stack.heights, foot, step));
        })
    }

    fn of(
        labels: &LabelGrid,
        mut add: impl FnMut([i32; 2], Run<Kind>, &mut Vec<Run<Kind>>),
    ) -> Self {
        let lattice = labels.lattice;
        let [x, y, _] = lattice.dims.map(|nodes| nodes as usize);
        let runs = Runs::new([x, y], |row, runs| {
            let row = row.map(|at| at as i32);
            for run in materials(labels, row) {
                add(row, run, runs);
            }
        });
        let part_of = runs.parts(Neighbors::All);
        Self { lattice, runs, part_of }
    }

    /// How many parts there are.
    pub fn count(&self) -> usize {
        self.part_of.iter().max().map_or(0, |&last| last as usize + 1)
    }

    /// The parts of the nodes at the corners of a point's voxel.
    pub fn around(&self, point: DVec3) -> impl Iterator<Item = (Kind, u32)> {
        let base = ((point - self.lattice.origin) / self.lattice.voxel).floor();
        let base = [base.x, base.y, base.z].map(|at| at as i32);
        (0..8).filter_map(move |corner| {
            let offset = [corner >> 2, corner >> 1 & 1, corner & 1];
            self.at(std::array::from_fn(|axis| base[axis].saturating_add(offset[axis])))
        })
    }

    /// The part of a node, where it is a material's.
    fn at(&self, node: [i32; 3]) -> Option<(Kind, u32)> {
        if (0..3).any(|axis| node[axis] < 0 || node[axis] >= self.lattice.dims[axis]) {
            return None;
        }
        let row = self.runs.row(node[0] as usize * self.runs.dims[1] + node[1] as usize);
        let own = &self.runs.runs[row.clone()];
        let place = own.partition_point(|run| run.end <= node[2]);
        let run = own.get(place).filter(|run| run.start <= node[2])?;
        Some((run.label, self.part_of[row.start + place]))
    }
}

/// The runs of materials in a row along z.
fn materials(labels: &LabelGrid, [x, y]: [i32; 2]) -> Vec<Run<Kind>> {
    let (side, end) = (LEAF_SIDE as i32, labels.lattice.dims[2]);
    let mut runs: Vec<Run<Kind>> = Vec::new();
    let mut add = |start: i32, end: i32, label: Label| match runs.last_mut() {
        _ if !label.is_material() => {}
        Some(run) if run.label.label == label && run.end == start => run.end = end,
        _ => runs.push(Run { start, end, label: Kind { label, slab: 0 } }),
    };
    for first in (0..end).step_by(LEAF_SIDE) {
        let last = (first + side).min(end);
        match labels.tile(labels.lattice.leaf_index([x / side, y / side, first / side])) {
            Some(label) => add(first, last, label),
            None => (first..last).for_each(|z| add(z, z + 1, labels.at([x, y, z]))),
        }
    }
    runs
}

/// A run along z in pieces, one for each slab that it passes. Node z is at the
/// height `foot + step z`.
fn cut(run: Run<Kind>, heights: &[f64], foot: f64, step: f64) -> Vec<Run<Kind>> {
    let slab = |z: i32| {
        let height = foot + step * f64::from(z);
        heights.partition_point(|&section| section <= height) as u32
    };
    let mut pieces = Vec::new();
    let mut start = run.start;
    while start < run.end {
        let own = slab(start);
        // Heights rise or fall along the row, so that each slab is one range.
        let (mut low, mut high) = (start + 1, run.end);
        while low < high {
            let middle = low.midpoint(high);
            (low, high) = if slab(middle) == own { (middle + 1, high) } else { (low, middle) };
        }
        let label = Kind { slab: own, ..run.label };
        pieces.push(Run { start, end: low, label });
        start = low;
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::section;
    use crate::mesh::shapes::samples;
    use crate::plane::Plane;

    const KIND: Kind = Kind { label: Label(3), slab: 0 };

    #[test]
    fn a_run_is_cut_where_it_passes_sections() {
        // Nodes 2 to 11 at heights z/2 − 1: 0, ½, … 4½; sections at ½ and 3.
        let run = Run { start: 2, end: 12, label: KIND };
        let pieces = cut(run, &[0.5, 3.0], -1.0, 0.5);
        let found: Vec<_> =
            pieces.iter().map(|piece| (piece.start, piece.end, piece.label.slab)).collect();
        assert_eq!(found, [(2, 3, 0), (3, 8, 1), (8, 12, 2)]);
        // Downward, node z is at 4 − z/2: 3, 2½, … −1½.
        let pieces = cut(run, &[0.5, 3.0], 4.0, -0.5);
        let found: Vec<_> =
            pieces.iter().map(|piece| (piece.start, piece.end, piece.label.slab)).collect();
        assert_eq!(found, [(2, 3, 2), (3, 8, 1), (8, 12, 0)]);
        assert_eq!(cut(run, &[0.5, 3.0], 1.0, 0.0).len(), 1);
    }

    #[test]
    fn a_bar_is_one_and_cut_by_three_sections_four() {
        // A bar along z of 4 × 4 × 20 nodes and a cube of 3³ apart from it.
        let lattice =
            Lattice { origin: DVec3::new(5.0, 0.0, -1.0), voxel: 0.5, dims: [20, 17, 30] };
        let within = |at: i32, range: std::ops::Range<i32>| range.contains(&at);
        let inside = |[x, y, z]: [i32; 3]| {
            (within(x, 2..6) && within(y, 2..6) && within(z, 4..24))
                || (within(x, 9..12) && within(y, 9..12) && within(z, 9..12))
        };
        let samples = samples(lattice, |node| vec![if inside(node) { 0.5 } else { -0.5 }]);
        let labels = LabelGrid::new(&samples);
        // Node z is at −1 + z/2: sections between nodes 8 and 9, 14 and 15, 27 and
        // 28, the last beyond the bar.
        let sections = [3.25, 6.25, 12.75]
            .map(|z| section(Plane { normal: DVec3::Z, offset: z }, &[], Label::OUTSIDE));
        let stack = Stack::new(&sections).expect("they are parallel");
        let parts = Components::between(&labels, &stack);
        let mut nodes = vec![0; parts.count()];
        for (run, &part) in parts.runs.runs.iter().zip(&parts.part_of) {
            nodes[part as usize] += run.len();
        }
        assert_eq!(nodes, [16 * 5, 16 * 6, 16 * 9, 27]);
        // At the lowest section both sides are seen, in the bar's middle.
        let found: Vec<(u32, u32)> = parts
            .around(lattice.position([3, 3, 8]) + 0.25)
            .map(|(kind, part)| (kind.slab, part))
            .collect();
        assert_eq!(found.len(), 8);
        assert!(found.iter().all(|seen| [(0, 0), (1, 1)].contains(seen)));
        assert!(parts.around(DVec3::splat(1e300)).next().is_none());
    }
}
