//! What a field keeps from one change of its sections to the next.
//!
//! On every level a leaf's values are what was interpolated from the level below, its
//! *start*, and what solving added to that, its *correction*. This depends on the sections
//! nearby, and hardly on the start as long as that changes little. So after a change of the
//! sections a leaf that it concerns, near which a section says something else, begins at its
//! start, as it does without a past. One whose start is another one by more than [`TOLERANCE`]
//! than when it was solved for goes on from the new start and its correction. These are solved
//! for; all others keep their values, to the bit.
//!
//! Solving stops long before there is nothing left to mend. What was left of the right-hand
//! side, the *rest*, is kept too, and where a leaf is solved for because of its start alone,
//! only for what is left beyond that: else it would go on where it stopped, change what no
//! section says anything about, and pass that on to finer levels. For the same reason
//! samples there are on the wrong side by the values by which they were when it stopped.
//!
//! A field whose leaves began at old values instead would never be again where one without a
//! past is: its band and its active set would remember.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::grid::frame::Frame;
use crate::grid::invariant::node_of;
use crate::grid::leaf::LeafNodes;
use crate::grid::leaf_grid::{LeafGrid, LeafSet, leaf_of};
use crate::grid::samples::{LEAF_NODES, Lattice};
use crate::label::Label;
use crate::plane::Plane;
use crate::section::Section;

use super::Space;
use super::differences::mark_differences;
use super::label_field::{LabelField, Scene};
use super::level::{Level, leaves_between};
use super::metric::Metric;
use super::system::System;

/// How much the start of a leaf may change before it is solved for again, in voxels of the
/// finest level, on whatever level it is.
const TOLERANCE: f64 = 0.03;
/// By how much, in voxels of its own level, for nothing to hold of what was solved for: what
/// was left then was left of another surface.
const MUCH: f32 = 0.5;
/// A change concerns leaves within so many nodes.
pub const REACH: i32 = 3;

/// What the fields of all labels keep.
#[derive(Debug)]
pub struct Kept {
    /// What they were made from, and where.
    sections: Vec<Section>,
    frame: Frame,
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
#[derive(Debug, Clone)]
pub struct KeptLevel {
    /// Which level it was; how it was solved hangs on that.
    number: usize,
    lattice: Lattice,
    starts: LeafGrid,
    /// What solving made of these starts.
    values: LeafGrid,
    /// What was left of the right-hand side when they had been made.
    rests: LeafGrid,
    /// The values by which samples were last found to be on the wrong side, without the
    /// starts; `None` where these were the starts themselves.
    seen: Option<LeafGrid>,
    /// What the values were drawn to.
    drawn_to: Option<LeafGrid>,
    /// How far an unknown was from its solution when all began: its share of the squared norm
    /// of the residual.
    size: f64,
}

/// What fields keep, as other sections see it.
#[derive(Debug)]
pub struct Before<'a> {
    metric: Metric,
    /// Every label's levels that are there again, their leaves named as they are now.
    levels: Vec<(Label, Cow<'a, KeptLevel>)>,
    /// For every lattice the leaves that the sections say something else about.
    concerned: Vec<LeafSet>,
    /// Whether they say the same everywhere.
    is_same: bool,
    /// In world units.
    tolerance: f64,
}

impl Kept {
    /// What holds for other sections; `None` in another frame that does not continue this one,
    /// where lengths are measured in another way, and where as many sections changed as stayed.
    pub fn before(&self, scene: &Scene) -> Option<Before<'_>> {
        let &Scene { sections, space, metric, is_open, .. } = scene;
        if !self.metric.is_near(metric) || !space.frame.continues(&self.frame) {
            return None;
        }
        let without = |all: &[Section], others: &[Section]| -> Vec<Section> {
            all.iter().filter(|section| !others.contains(section)).cloned().collect()
        };
        let changed = [without(&self.sections, sections), without(sections, &self.sections)];
        let [went, came] = changed.each_ref().map(Vec::len);
        if 2 * went >= self.sections.len() || 2 * came >= sections.len() {
            return None;
        }
        let concerned = |(number, lattice): (usize, &Lattice)| {
            let level = Level::new(*lattice, is_open);
            let mut concerned = LeafSet::new(&level.grid);
            if let Some((was, by)) = self.level(number, lattice) {
                mark_differences(&changed, space.sampled(lattice), &level, &mut concerned);
                self.mark_ends(space, &level, &mut concerned);
                mark_borders(&was.lattice, by, &level, &mut concerned);
            }
            concerned
        };
        let concerned = space.lattices.par_iter().enumerate().map(concerned).collect();
        let is_same = went + came == 0
            && self.frame == space.frame
            && self.ends.iter().map(Vec::as_slice).eq(space.ends());
        let tolerance = TOLERANCE * space.frame.lattice.voxel;
        let levels = self.levels_on(&space.lattices, is_open);
        Some(Before { metric: self.metric, levels, concerned, is_same, tolerance })
    }

    /// A level that some field keeps and that has leaves in common with a lattice, and what
    /// leads from its leaves to those of the lattice.
    fn level(&self, number: usize, lattice: &Lattice) -> Option<(&KeptLevel, [i32; 3])> {
        let mut levels = self.fields.iter().flat_map(|field| &field.levels);
        levels.find_map(|level| Some((level, level.way_to(number, lattice)?)))
    }

    /// What all fields keep, on lattices.
    fn levels_on<'a>(
        &'a self,
        lattices: &[Lattice],
        is_open: bool,
    ) -> Vec<(Label, Cow<'a, KeptLevel>)> {
        let on_lattice = |level: &'a KeptLevel| {
            let lattice = lattices.get(level.number)?;
            let by = level.way_to(level.number, lattice)?;
            Some(match level.lattice == *lattice {
                true => Cow::Borrowed(level),
                false => Cow::Owned(level.moved(by, Level::new(*lattice, is_open))),
            })
        };
        let of_field = |field: &'a KeptField| {
            let levels = field.levels.iter().filter_map(on_lattice);
            levels.map(|level| (field.label, level)).collect::<Vec<_>>()
        };
        self.fields.iter().flat_map(of_field).collect()
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
            frame: scene.space.frame,
            metric,
            ends: scene.space.ends().map(<[_]>::to_vec),
            fields: fields.iter_mut().map(keep).collect(),
        }
    }

    /// The leaves of a level that solids now end in, or no longer do.
    fn mark_ends(&self, space: &Space, level: &Level, marked: &mut LeafSet) {
        let which = usize::from(space.is_wide(&level.lattice));
        let [was, is] = [&self.ends[which][..], space.ends()[which]];
        if was == is {
            return;
        }
        let [was, is] = [was, is].map(|ends| Space::beyond_ends(ends, &level.lattice));
        for leaf in level.grid.all_places() {
            // What is beyond the ends has edges, which may miss all corners of a leaf.
            let first = is(node_of(leaf, 0));
            let is_same = |node: usize| {
                let node = node_of(leaf, node);
                was(node) == first && is(node) == first
            };
            if !(0..LEAF_NODES).all(is_same) {
                marked.insert(leaf);
            }
        }
    }
}

impl KeptLevel {
    /// What leads from its leaves to those of a lattice, if that is the one of the same level.
    fn way_to(&self, number: usize, lattice: &Lattice) -> Option<[i32; 3]> {
        self.lattice.leaves_to(lattice).filter(|_| self.number == number)
    }

    /// The same for another box: leaves are named as there, and those beyond it left out.
    fn moved(&self, by: [i32; 3], Level { lattice, domain, .. }: Level) -> Self {
        let moved = |grid: &LeafGrid| grid.moved(by, domain.low, domain.high);
        Self {
            number: self.number,
            lattice,
            starts: moved(&self.starts),
            values: moved(&self.values),
            rests: moved(&self.rests),
            seen: self.seen.as_ref().map(moved),
            drawn_to: self.drawn_to.as_ref().map(moved),
            size: self.size,
        }
    }
}

impl Before<'_> {
    /// How lengths were measured when the oldest of it was solved for.
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// What a level of a label's field keeps.
    fn level(&self, label: Label, number: usize) -> Option<&KeptLevel> {
        let level = self.levels.iter().find(|(own, level)| *own == label && level.number == number);
        level.map(|(_, level)| level.as_ref())
    }
}

/// The leaves of a level with nodes that are inside the box and were not on another lattice of
/// the level, or the other way round; `by` leads from that one's leaves to the level's.
fn mark_borders(was: &Lattice, by: [i32; 3], level: &Level, marked: &mut LeafSet) {
    if *was == level.lattice {
        return;
    }
    for leaf in level.grid.all_places() {
        let before = std::array::from_fn(|axis| leaf[axis] - by[axis]);
        let are_inner = |node: usize| {
            [was.is_inner(node_of(before, node)), level.lattice.is_inner(node_of(leaf, node))]
        };
        let is_inside = [0, LEAF_NODES - 1].into_iter().all(|node| are_inner(node) == [true; 2]);
        let differs = |node: usize| are_inner(node)[0] != are_inner(node)[1];
        if !is_inside && (0..LEAF_NODES).any(differs) {
            marked.insert(leaf);
        }
    }
}

/// The leaves of a level that are solved for, and those that keep their correction.
pub struct Making<'a> {
    /// Which level it is.
    number: usize,
    before: Option<&'a KeptLevel>,
    /// In voxels of the level.
    tolerance: f32,
    /// Leaves that begin at their start.
    concerned: LeafSet,
    /// Leaves near to those whose start is another one.
    changed: LeafSet,
    starts: LeafGrid,
    /// Of leaves that were solved for.
    rests: LeafGrid,
    /// The values by which samples were found to be on the wrong side the last time, where
    /// that was not the first.
    seen: Option<LeafGrid>,
    drawn_to: Option<LeafGrid>,
    /// Of an unknown, when all began.
    size: f64,
    /// Those that are not solved for.
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
        // On the first level everything hangs together, and nothing is interpolated.
        let before = before.filter(|before| number > 0 || before.is_same);
        let kept = before.and_then(|before| Some((before, before.level(label, number)?)));
        let (tolerance, concerned) = match kept {
            Some((before, _)) => (before.tolerance, before.concerned[number].clone()),
            None => (0.0, settled.clone()),
        };
        let tolerance = (tolerance / level.lattice.voxel) as f32;
        let (before, drawn_to) = (kept.map(|(_, kept)| kept), drawn_to.cloned());
        let (changed, rests, seen) = (settled.clone(), starts.clone(), None);
        let size = before.map_or(0.0, |before| before.size);
        Self {
            number,
            before,
            tolerance,
            concerned,
            changed,
            starts,
            rests,
            seen,
            drawn_to,
            size,
            settled,
        }
    }

    /// Leaves are to be solved for. The new ones among them that no change of the sections
    /// concerns get their correction. Returns those that are solved for all the same.
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
        let differs_much = |leaf: &&[i32; 3]| {
            let starts = before.starts.get(**leaf).zip(self.starts.get(**leaf));
            starts.is_some_and(|(was, is)| was.iter().zip(is).any(|(a, b)| (a - b).abs() > MUCH))
        };
        let elsewhere: Vec<[i32; 3]> = new.par_iter().filter(differs_much).copied().collect();
        for leaf in elsewhere {
            self.concerned.insert(leaf);
        }
        for leaf in new {
            let (start, end) = (before.starts.get(leaf), self.of_before(leaf, &before.values));
            let Some(((start, end), own)) = start.zip(end).zip(grid.get_mut(leaf)) else {
                continue;
            };
            if self.changed.has(leaf) {
                add(own, &difference(end, start));
            } else {
                *own = *end;
                self.settled.insert(leaf);
            }
        }
        leaves.iter().copied().filter(|&leaf| !self.settled.has(leaf)).collect()
    }

    /// What a leaf has that did not begin anew.
    fn of_before<'g>(&self, leaf: [i32; 3], grid: &'g LeafGrid) -> Option<&'g LeafNodes> {
        grid.get(leaf).filter(|_| !self.concerned.has(leaf))
    }

    /// What was interpolated.
    pub fn starts(&self) -> &LeafGrid {
        &self.starts
    }

    /// The values by which samples are on the wrong side, for those of a level. They are to be
    /// kept if this is the last time but not the first.
    pub fn see<'g>(&mut self, grid: &'g LeafGrid, is_kept: bool) -> Cow<'g, LeafGrid> {
        let mut seen = Cow::Borrowed(grid);
        if let Some(before) = self.before {
            let seen = seen.to_mut();
            for (slot, &leaf) in self.starts.leaves().iter().enumerate() {
                let has_past = self.of_before(leaf, &before.values).is_some();
                let Some(own) = seen.get_mut(leaf).filter(|_| has_past) else { continue };
                let was = before.starts.get(leaf).filter(|_| self.settled.has(leaf));
                *own = *was.unwrap_or(self.starts.leaf(slot as u32));
                let by = before.seen.as_ref().and_then(|seen| seen.get(leaf));
                by.into_iter().for_each(|by| add(own, by));
            }
        }
        self.seen = is_kept.then(|| seen.clone().into_owned());
        seen
    }

    /// Takes from what is wanted of a system what was left of it before.
    pub fn spare(&self, system: &System, wanted: &mut [f32]) {
        let Some(before) = self.before else { return };
        for (leaf, wanted) in wanted.as_chunks_mut::<LEAF_NODES>().0.iter_mut().enumerate() {
            let rest = self.of_before(system.leaves[leaf], &before.rests);
            for node in (0..LEAF_NODES).filter(|&node| system.is_free(leaf, node)) {
                wanted[node] -= rest.map_or(0.0, |rest| rest[node]);
            }
        }
    }

    /// How far a system usually is from its solution: what is nearer is not worth as many
    /// iterations.
    pub fn usual(&self, system: &System) -> f64 {
        self.size * system.unknowns() as f64
    }

    /// A system was solved, whose residual had a squared norm when the level was begun, and so
    /// much is left of it now.
    pub fn solved(&mut self, system: &System, left: &[f32], first: f64) {
        if self.before.is_none() {
            self.size = first / system.unknowns().max(1) as f64;
        }
        self.rests.add(system.leaves.iter().copied());
        for (&leaf, left) in system.leaves.iter().zip(left.as_chunks().0) {
            let before = self.before.and_then(|before| self.of_before(leaf, &before.rests));
            let rest = *before.unwrap_or(left);
            self.rests.get_mut(leaf).into_iter().for_each(|own| *own = rest);
        }
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
        let mut values = LeafGrid::new(level.domain.low, level.domain.high);
        values.add(self.starts.leaves().iter().copied());
        for ((leaf, start), (_, value)) in self.starts.iter_mut().zip(values.iter_mut()) {
            if let Some(own) = level.grid.get(leaf) {
                *value = *own;
            }
            let before = self.before.filter(|_| self.settled.has(leaf));
            let Some((before, was)) = before.and_then(|own| Some((own, own.starts.get(leaf)?)))
            else {
                continue;
            };
            // All as it was when it was solved for: what is compared with does not drift.
            *start = *was;
            let was = before.drawn_to.as_ref().and_then(|before| before.get(leaf));
            let own = self.drawn_to.as_mut().and_then(|grid| grid.get_mut(leaf));
            own.zip(was).into_iter().for_each(|(own, was)| *own = *was);
            if let Some(rest) = before.rests.get(leaf) {
                self.rests.insert(leaf, rest);
            }
        }
        let seen = self.seen.map(|seen| {
            let mut without = self.starts.clone();
            for (leaf, own) in without.iter_mut() {
                *own = seen.get(leaf).map_or([0.0; LEAF_NODES], |seen| difference(seen, own));
            }
            without
        });
        // Where nothing was solved for nothing was seen.
        let seen = seen.or_else(|| self.before?.seen.clone());
        KeptLevel {
            number: self.number,
            lattice: level.lattice,
            starts: self.starts,
            values,
            rests: self.rests,
            seen,
            drawn_to: self.drawn_to,
            size: self.size,
        }
    }
}

fn difference(end: &LeafNodes, start: &LeafNodes) -> LeafNodes {
    std::array::from_fn(|node| end[node] - start[node])
}

fn add(own: &mut LeafNodes, by: &LeafNodes) {
    own.iter_mut().zip(by).for_each(|(own, by)| *own += by);
}
