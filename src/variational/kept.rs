//! What a field keeps from one change of its sections to the next.
//!
//! On every level a leaf's values are what was interpolated from the level below, its
//! *start*, and what solving added to that, its *correction*. This depends on the sections
//! nearby, and hardly on the start as long as that changes little. So after a change of the
//! sections only those leaves are solved for that it concerns, or whose start is another one
//! by more than [`TOLERANCE`] than when they were; the others add their correction to the new
//! start. A field whose leaves began at old values instead would never be again where one
//! without a past is: its band and its active set would remember.

use glam::DVec3;
use rayon::prelude::*;

use crate::grid::leaf::LeafNodes;
use crate::grid::leaf_grid::{LeafGrid, LeafSet, leaf_of};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice};
use crate::label::Label;
use crate::plane::Plane;
use crate::section::Section;

use super::Space;
use super::label_field::{LabelField, Scene, node_of};
use super::level::{Level, leaves_between, near_points};
use super::metric::Metric;
use super::plane_samples::{Region, plane_samples};

/// How much the start of a leaf may change before it is solved for again, in voxels of the
/// finest level, on whatever level it is.
const TOLERANCE: f64 = 0.03;
/// A change concerns leaves within so many nodes.
const REACH: i32 = 3;

/// What the fields of all labels keep.
#[derive(Debug)]
pub struct Kept {
    /// What they were made from.
    sections: Vec<Section>,
    metric: Metric,
    /// Where solids end, on the given box and on the wide one.
    ends: [Vec<Plane>; 2],
    fields: Vec<KeptField>,
}

/// What the field of one label keeps.
#[derive(Debug)]
struct KeptField {
    label: Label,
    /// Those that were solved for.
    levels: Vec<KeptLevel>,
}

/// The leaves of one level that were solved for.
#[derive(Debug)]
pub struct KeptLevel {
    lattice: Lattice,
    starts: LeafGrid,
    /// The corrections of these starts.
    corrections: LeafGrid,
    /// What the values were drawn to.
    drawn_to: Option<LeafGrid>,
}

/// What fields keep, as other sections see it.
#[derive(Debug)]
pub struct Before<'a> {
    kept: &'a Kept,
    /// For every lattice the leaves that the sections say something else about.
    concerned: Vec<LeafSet>,
    /// In world units.
    tolerance: f64,
}

impl Kept {
    /// What holds for other sections; `None` where lengths are measured in another way.
    pub fn before(&self, scene: &Scene) -> Option<Before<'_>> {
        let &Scene { sections, space, metric, is_open, .. } = scene;
        if !self.metric.is_near(metric) {
            return None;
        }
        let came = sections.iter().filter(|section| !self.sections.contains(section));
        let went = self.sections.iter().filter(|section| !sections.contains(section));
        let changed: Vec<Section> = came.chain(went).cloned().collect();
        let concerned = (space.lattices.par_iter())
            .map(|lattice| self.concerned(&changed, space, &Level::new(*lattice, is_open)))
            .collect();
        let finest = space.lattices.last().map_or(0.0, |finest| finest.voxel);
        Some(Before { kept: self, concerned, tolerance: TOLERANCE * finest })
    }

    /// What is to be kept of fields, which give it away; `metric` is the one that lengths were
    /// measured by when the oldest of it was solved for.
    pub fn new(scene: &Scene, metric: Metric, fields: &mut [LabelField]) -> Self {
        let keep = |field: &mut LabelField| KeptField {
            label: field.label,
            levels: std::mem::take(&mut field.kept),
        };
        Self {
            sections: scene.sections.to_vec(),
            metric,
            ends: scene.space.ends().map(<[_]>::to_vec),
            fields: fields.iter_mut().map(keep).collect(),
        }
    }

    /// The leaves of a level that changed sections say something about, and those that solids
    /// now end in, or no longer do.
    fn concerned(&self, changed: &[Section], space: &Space, level: &Level) -> LeafSet {
        let Lattice { origin, voxel, .. } = level.lattice;
        let in_nodes = |at: DVec3| ((at - origin) / voxel).to_array();
        let samples = plane_samples(changed, space.wide, voxel, Region::Everywhere);
        // Where there are contours there are samples, but for those shorter than a voxel.
        let corners = changed.iter().flat_map(Section::segments).flatten();
        let places: Vec<[f64; 3]> =
            samples.iter().map(|sample| sample.at).chain(corners).map(in_nodes).collect();
        let mut concerned = LeafSet::new(&level.grid);
        for leaf in near_points(&places, REACH) {
            concerned.insert(leaf);
        }
        let which = usize::from(space.is_wide(&level.lattice));
        let [was, is] = [&self.ends[which][..], space.ends()[which]];
        if was != is {
            let [was, is] = [was, is].map(|ends| Space::beyond_ends(ends, &level.lattice));
            for leaf in level.grid.all_places() {
                let last = LEAF_SIDE as i32 - 1;
                let corner = |number: i32| {
                    let step = [number >> 2 & 1, number >> 1 & 1, number & 1];
                    std::array::from_fn(|axis| leaf[axis] * (last + 1) + step[axis] * last)
                };
                let first = is(corner(0));
                let is_same = |number| was(corner(number)) == first && is(corner(number)) == first;
                if !(0..8).all(is_same) {
                    concerned.insert(leaf);
                }
            }
        }
        concerned
    }
}

impl Before<'_> {
    /// How lengths were measured when the oldest of it was solved for.
    pub fn metric(&self) -> Metric {
        self.kept.metric
    }

    /// What a level of a label's field keeps.
    fn level(&self, label: Label, lattice: &Lattice) -> Option<&KeptLevel> {
        let field = self.kept.fields.iter().find(|field| field.label == label)?;
        field.levels.iter().find(|level| level.lattice == *lattice)
    }
}

/// The leaves of a level that are solved for, and those that keep their correction.
pub struct Making<'a> {
    before: Option<&'a KeptLevel>,
    /// In voxels of the level.
    tolerance: f32,
    /// What is not to be kept: leaves near to a change.
    changed: LeafSet,
    starts: LeafGrid,
    drawn_to: Option<LeafGrid>,
    /// Those that keep their correction.
    settled: LeafSet,
}

impl<'a> Making<'a> {
    /// None yet, on the level with a number, whose values may be drawn to others.
    pub fn new(
        before: Option<&'a Before<'a>>,
        label: Label,
        number: usize,
        level: &Level,
        drawn_to: Option<&LeafGrid>,
    ) -> Self {
        let starts = LeafGrid::new(level.domain.low, level.domain.high);
        let settled = LeafSet::new(&starts);
        let kept = before.and_then(|before| Some((before, before.level(label, &level.lattice)?)));
        let (tolerance, changed) = match kept {
            Some((before, _)) => (before.tolerance, before.concerned[number].clone()),
            None => (0.0, settled.clone()),
        };
        let tolerance = (tolerance / level.lattice.voxel) as f32;
        let (before, drawn_to) = (kept.map(|(_, kept)| kept), drawn_to.cloned());
        Self { before, tolerance, changed, starts, drawn_to, settled }
    }

    /// Leaves are to be solved for. The new ones among them that may keep their correction
    /// get it. Returns the others.
    pub fn enter(&mut self, leaves: &[[i32; 3]], grid: &mut LeafGrid) -> Vec<[i32; 3]> {
        let is_new = |leaf: &[i32; 3]| self.starts.get(*leaf).is_none();
        let new: Vec<[i32; 3]> = leaves.iter().copied().filter(is_new).collect();
        for &leaf in &new {
            if let Some(values) = grid.get(leaf) {
                self.starts.insert(leaf, values);
            }
        }
        let Some(before) = self.before else { return leaves.to_vec() };
        let changes: Vec<[[i32; 3]; 2]> =
            new.par_iter().filter_map(|&leaf| self.change(before, leaf)).collect();
        for leaf in changes.into_iter().flat_map(leaves_between) {
            self.changed.insert(leaf);
        }
        for leaf in new {
            let correction = before.corrections.get(leaf).filter(|_| !self.changed.has(leaf));
            if let (Some(correction), Some(own)) = (correction, grid.get_mut(leaf)) {
                own.iter_mut().zip(correction).for_each(|(own, by)| *own += by);
                self.settled.insert(leaf);
            }
        }
        leaves.iter().copied().filter(|&leaf| !self.settled.has(leaf)).collect()
    }

    /// The first and the last leaf that a change of a leaf's start concerns.
    fn change(&self, before: &KeptLevel, leaf: [i32; 3]) -> Option<[[i32; 3]; 2]> {
        let [was, is] = [before.starts.get(leaf)?, self.starts.get(leaf)?];
        let drawn_to = |grid: &Option<LeafGrid>, node: usize| {
            grid.as_ref().and_then(|grid| Some(grid.get(leaf)?[node]))
        };
        let differs = |&node: &usize| {
            let draws = [&before.drawn_to, &self.drawn_to].map(|grid| drawn_to(grid, node));
            let is_drawn_elsewhere = match draws {
                [Some(was), Some(is)] => (was - is).abs() > self.tolerance,
                [was, is] => was.is_some() != is.is_some(),
            };
            is_drawn_elsewhere || (was[node] - is[node]).abs() > self.tolerance
        };
        let nodes = (0..LEAF_NODES).filter(differs).map(|node| node_of(leaf, node));
        let [low, high] = nodes.map(|node| [node; 2]).reduce(|[low, high], [node, _]| {
            let choose = |own: [i32; 3], of: fn(i32, i32) -> i32| {
                std::array::from_fn(|axis| of(own[axis], node[axis]))
            };
            [choose(low, i32::min), choose(high, i32::max)]
        })?;
        let ends = [low.map(|along| along - REACH), high.map(|along| along + REACH)];
        Some(ends.map(leaf_of))
    }

    /// What is to be kept of the level when it is done.
    pub fn keep(mut self, level: &Level) -> KeptLevel {
        let mut corrections = LeafGrid::new(level.domain.low, level.domain.high);
        corrections.add(self.starts.leaves().iter().copied());
        let old = |leaf| {
            let before = self.before.filter(|_| self.settled.has(leaf))?;
            Some((before.starts.get(leaf)?, before.corrections.get(leaf)?))
        };
        let pairs = self.starts.iter_mut().zip(corrections.iter_mut());
        for ((leaf, start), (_, correction)) in pairs {
            if let Some(kept) = old(leaf) {
                // All as it was when it was solved for: what is compared with does not drift.
                (*start, *correction) = (*kept.0, *kept.1);
                let was = self.before.and_then(|before| before.drawn_to.as_ref()?.get(leaf));
                let own = self.drawn_to.as_mut().and_then(|grid| grid.get_mut(leaf));
                own.zip(was).into_iter().for_each(|(own, was)| *own = *was);
            } else if let Some(end) = level.grid.get(leaf) {
                *correction = difference(end, start);
            }
        }
        KeptLevel {
            lattice: level.lattice,
            starts: self.starts,
            corrections,
            drawn_to: self.drawn_to,
        }
    }
}

fn difference(end: &LeafNodes, start: &LeafNodes) -> LeafNodes {
    std::array::from_fn(|node| end[node] - start[node])
}
