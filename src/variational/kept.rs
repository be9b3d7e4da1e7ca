//! What a field keeps from one change of its sections to the next.
//!
//! On every level a leaf's values are what was interpolated from the level below, its
//! *start*, and what solving added to that, its *correction*. This depends on the sections
//! nearby, and hardly on the start as long as that changes little. So after a change of the
//! sections all leaves add their correction to the new start but those that it concerns, near
//! which a section says something else: these begin at their start, as they do without a
//! past. They are solved for, and so are those whose start is another one by more than
//! [`TOLERANCE`] than when they were.
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

use glam::DVec3;
use rayon::prelude::*;

use crate::grid::leaf::LeafNodes;
use crate::grid::leaf_grid::{LeafGrid, LeafSet, leaf_of};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice};
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::section::Section;

use super::Space;
use super::label_field::{LabelField, Scene, node_of};
use super::level::{Level, leaves_between, near_points};
use super::metric::Metric;
use super::plane_samples::{PlaneSample, Region, plane_samples};
use super::system::System;

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
    /// What solving made of these starts.
    ends: LeafGrid,
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
        let without = |all: &[Section], others: &[Section]| -> Vec<Section> {
            all.iter().filter(|section| !others.contains(section)).cloned().collect()
        };
        let changed = [without(&self.sections, sections), without(sections, &self.sections)];
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

    /// The leaves of a level about which sections that went and others that came say something
    /// else, and those that solids now end in, or no longer do.
    fn concerned(&self, changed: &[Vec<Section>; 2], space: &Space, level: &Level) -> LeafSet {
        let Lattice { origin, voxel, .. } = level.lattice;
        let in_nodes = |at: DVec3| ((at - origin) / voxel).to_array();
        let places: Vec<[f64; 3]> =
            differences(changed, space.wide, voxel).into_iter().map(in_nodes).collect();
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

/// The places on planes, not farther apart than a spacing, at which only one of two lists of
/// sections has a contour or says what it does.
fn differences(changed: &[Vec<Section>; 2], bounds: Bounds, spacing: f64) -> Vec<DVec3> {
    let sampled = |own: &Section| {
        plane_samples(std::slice::from_ref(own), bounds, spacing, Region::Everywhere)
    };
    let [mut was, is] = changed.each_ref().map(|own| own.iter().collect::<Vec<_>>());
    let mut places = Vec::new();
    for section in is {
        let other = was.iter().position(|other| other.plane() == section.plane());
        let before = other.map_or_else(Vec::new, |other| sampled(was.swap_remove(other)));
        let now = sampled(section);
        let at = |sample: &PlaneSample| sample.at;
        // Where parts are unknown others are sampled.
        match before.iter().map(at).eq(now.iter().map(at)) {
            true => {
                let pairs = before.iter().zip(&now);
                let other = pairs.filter(|(before, now)| before.label != now.label);
                places.extend(other.map(|(_, now)| now.at));
            }
            false => places.extend(before.iter().chain(&now).map(at)),
        }
    }
    places.extend(was.into_iter().flat_map(sampled).map(|sample| sample.at));
    let bits = |at: DVec3| at.to_array().map(f64::to_bits);
    let place = |bits: [u64; 3]| DVec3::from_array(bits.map(f64::from_bits));
    let [was, is] = changed.each_ref().map(|sections| {
        let mut segments: Vec<[[u64; 3]; 2]> =
            sections.iter().flat_map(Section::segments).map(|ends| ends.map(bits)).collect();
        segments.iter_mut().for_each(|ends| ends.sort_unstable());
        segments.sort_unstable();
        segments
    });
    for [from, to] in not_common(&was, &is).into_iter().map(|ends| ends.map(place)) {
        let steps = (from.distance(to) / spacing).ceil().max(1.0) as u32;
        places.extend((0..=steps).map(|step| from.lerp(to, f64::from(step) / f64::from(steps))));
    }
    places
}

/// What only one of two sorted lists has.
fn not_common<T: Ord + Copy>(one: &[T], other: &[T]) -> Vec<T> {
    let without = |all: &[T], others: &[T]| -> Vec<T> {
        all.iter().filter(|own| others.binary_search(own).is_err()).copied().collect()
    };
    [without(one, other), without(other, one)].concat()
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
        let kept = before.and_then(|before| Some((before, before.level(label, &level.lattice)?)));
        let (tolerance, concerned) = match kept {
            Some((before, _)) => (before.tolerance, before.concerned[number].clone()),
            None => (0.0, settled.clone()),
        };
        let tolerance = (tolerance / level.lattice.voxel) as f32;
        let (before, drawn_to) = (kept.map(|(_, kept)| kept), drawn_to.cloned());
        let (changed, rests, seen) = (settled.clone(), starts.clone(), None);
        let size = before.map_or(0.0, |before| before.size);
        Self { before, tolerance, concerned, changed, starts, rests, seen, drawn_to, size, settled }
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
        for leaf in new {
            let (start, end) = (before.starts.get(leaf), self.of_before(leaf, &before.ends));
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

    /// The values by which samples are on the wrong side, for those of a level; `is_first`
    /// says whether samples were not looked at before.
    pub fn see<'g>(&mut self, grid: &'g LeafGrid, is_first: bool) -> Cow<'g, LeafGrid> {
        let mut seen = Cow::Borrowed(grid);
        if let Some(before) = self.before {
            let seen = seen.to_mut();
            for (slot, &leaf) in self.starts.leaves().iter().enumerate() {
                let has_past = self.of_before(leaf, &before.ends).is_some();
                let Some(own) = seen.get_mut(leaf).filter(|_| has_past) else { continue };
                let was = before.starts.get(leaf).filter(|_| self.settled.has(leaf));
                *own = *was.unwrap_or(self.starts.leaf(slot as u32));
                let by = before.seen.as_ref().and_then(|seen| seen.get(leaf));
                by.into_iter().for_each(|by| add(own, by));
            }
        }
        self.seen = (!is_first).then(|| seen.clone().into_owned());
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
    pub fn leave(&mut self, system: &System, left: &[f32], first: f64) {
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
        let mut ends = LeafGrid::new(level.domain.low, level.domain.high);
        ends.add(self.starts.leaves().iter().copied());
        for ((leaf, start), (_, end)) in self.starts.iter_mut().zip(ends.iter_mut()) {
            if let Some(own) = level.grid.get(leaf) {
                *end = *own;
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
        KeptLevel {
            lattice: level.lattice,
            starts: self.starts,
            ends,
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
