//! The field of one label, from the coarsest level to the finest.

use std::borrow::Cow;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::grid::assembly::NodeField;
use crate::grid::distance::HALF_WIDTH;
use crate::grid::invariant::{node_index, node_of};
use crate::grid::leaf::LeafNodes;
use crate::grid::leaf_grid::{LeafGrid, LeafSet, around, leaf_of, node_below};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice};
use crate::label::Label;
use crate::progress::Progress;
use crate::section::Section;
use crate::segments::Hint;

use super::anchor::{Anchor, Original};
use super::backend::{Backend, Limits};
use super::cpu::residual;
use super::kept::{Before, KeptLevel, Making};
use super::level::{Level, ensure, leaves_between, near_changes, near_points};
use super::metric::{Direction, Metric};
use super::outline::Outline;
use super::plane_samples::{PlaneSample, Region, SAMPLES_PER_EVEN, plane_samples};
use super::system::{Domain, Pull, SIDE, System};
use super::{Effort, Space, Weights};

/// What a sample on a contour counts, and one that is on the wrong side.
const FIRM: f32 = 10.0;
/// What holds a field at a contour.
const ON_CONTOUR: Pull = Pull { at: [0.0; 3], weight: FIRM, target: 0.0 };
/// How far on its side a sample is wanted to be, in voxels.
const MARGIN: f64 = 0.5;
/// Contour samples are so far apart, in voxels.
const CONTOUR_SPACING: f64 = 0.5;
/// Unknowns reach so many nodes beyond changes of sign and contours.
const BAND: i32 = 2;
/// The same beyond changes of sign on the coarse levels but the first, where it is still decided
/// how parts hang together. Surfaces are those that solving for all nodes gives, but for a few
/// hundredths of a voxel, and a small label among many costs what is near to it.
const WIDE_BAND: i32 = 8;
/// Times that the samples on the wrong side are looked for.
const PASSES: u32 = 3;
/// On the coarse levels.
const WHOLE: Limits = Limits { iterations: 200, tolerance: 1e-3, of: 0.0 };
/// In the band of the coarsest level that has one. What is solved there is all that
/// finer levels know of the shape between sections, whatever their voxels.
const FIRST_NARROW: Limits = Limits { iterations: 100, tolerance: 1e-3, of: 0.0 };
/// In the band of the others, whose values are drawn to what is interpolated.
const NARROW: Limits = Limits { iterations: 100, tolerance: 5e-3, of: 0.0 };
/// What is shorter than this is solved for there, in voxels, as λ = ℓ⁻⁴ has it (`anchor`): what
/// is longer, coarser levels have seen to. So there is one solution, soon found, that depends on
/// what is near alone. Without it, walls as thin as sections are apart would shrink with every
/// iteration more, and the surface would be another one whenever solving began elsewhere.
const NARROW_LENGTH: f32 = 2.0;
/// The same on the finest level: what is wrong with the interpolated values is as short there as
/// the voxels.
const FINEST_LENGTH: f32 = 0.8;

/// What all labels' fields are made from.
pub struct Scene<'a> {
    pub sections: &'a [Section],
    pub space: &'a Space,
    pub metric: Metric,
    /// In which second differences are taken.
    pub directions: Vec<Direction>,
    pub is_open: bool,
    /// What the sections say on each of the lattices over the whole box.
    pub samples: Vec<Vec<PlaneSample>>,
    /// The voxels for which the soft values' weight is given, in world units.
    pub unit: f64,
    pub weights: &'a Weights,
    /// What is smoothed, in place of soft values.
    pub original: Option<Original<'a>>,
    /// Whether fields keep anything for other sections.
    pub keeps: bool,
    pub backend: &'a dyn Backend,
    /// Told of every label that is done.
    pub progress: &'a dyn Progress,
}

/// The field of a label on all levels.
pub struct LabelField {
    /// The label.
    pub label: Label,
    /// From the coarsest to the finest.
    pub levels: Vec<Level>,
    /// The leaves of the finest level that were solved for, sorted.
    pub band: Vec<[i32; 3]>,
    /// What it took.
    pub effort: Effort,
    /// What it keeps.
    pub kept: Vec<KeptLevel>,
}

/// A field in the making.
struct Solver<'a> {
    scene: &'a Scene<'a>,
    before: Option<&'a Before<'a>>,
    label: Label,
    outline: Outline,
    levels: Vec<Level>,
    /// Where the contours are sampled on the present level, in nodes.
    contours: Vec<[f64; 3]>,
    /// What it is drawn to, and the signed distances from it on the levels that are solved to
    /// the end, up to the first in a band. On finer ones it would draw waves that are much
    /// longer than what is still to be mended there.
    anchor: Option<Anchor<'a>>,
    anchored: Vec<LeafGrid>,
    effort: Effort,
    kept: Vec<KeptLevel>,
    /// How far the present level was from its solution when it began: the squared norm of the
    /// residual.
    first: f64,
}

impl LabelField {
    /// Solves for a label, but for what holds from before.
    ///
    /// # Errors
    /// When the backend fails.
    pub fn new(scene: &Scene, before: Option<&Before>, label: Label) -> Result<Self> {
        let outline = Outline::new(scene.sections, label, scene.metric);
        let finest = scene.space.lattices[scene.space.lattices.len() - 1].voxel;
        let anchor =
            scene.original.as_ref().and_then(|original| Anchor::new(original, label, finest));
        let mut solver = Solver {
            scene,
            before,
            label,
            outline,
            levels: Vec::new(),
            contours: Vec::new(),
            anchor,
            anchored: Vec::new(),
            effort: Effort::default(),
            kept: Vec::new(),
            first: 0.0,
        };
        let mut band = solver.add_first_level()?;
        for number in 1..scene.space.lattices.len() {
            band = solver.add_narrow_level(number)?;
        }
        let Solver { levels, effort, kept, .. } = solver;
        Ok(Self { label, levels, band, effort, kept })
    }

    fn finest(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }
}

impl NodeField for LabelField {
    fn label(&self) -> Label {
        self.label
    }

    fn rough(&self, node: [i32; 3]) -> f32 {
        let finest = self.finest();
        let at = finest.lattice.position(node);
        for level in self.levels.iter().rev() {
            let place = ((at - level.lattice.origin) / level.lattice.voxel).round();
            if let Some(value) = level.grid.value(place.to_array().map(|along| along as i32)) {
                return value * (level.lattice.voxel / finest.lattice.voxel) as f32;
            }
        }
        0.0
    }

    /// Those beyond the box, which play no role for who reads labels, as they are interpolated.
    fn ensure(&mut self, leaves: Vec<[i32; 3]>) {
        ensure(&mut self.levels, leaves, &|_, _, _, _| ());
    }

    fn grid(&self) -> &LeafGrid {
        &self.finest().grid
    }

    fn grid_mut(&mut self) -> &mut LeafGrid {
        let finest = self.levels.len() - 1;
        &mut self.levels[finest].grid
    }

    fn into_grid(mut self) -> LeafGrid {
        let finest = self.levels.len() - 1;
        self.levels.swap_remove(finest).grid
    }

    fn has(&self, node: [i32; 3]) -> bool {
        self.finest().domain.has(node)
    }
}

impl<'a> Solver<'a> {
    /// The coarsest level, on all of the box.
    fn add_first_level(&mut self) -> Result<Vec<[i32; 3]>> {
        let level = Level::new(self.scene.space.lattices[0], self.scene.is_open);
        let all: Vec<[i32; 3]> = level.grid.all_places().collect();
        self.push(level)?;
        self.ensure(all.iter().copied());
        if self.is_solved(0) {
            self.solve_first(all.clone())?;
        }
        Ok(all)
    }

    /// Adds a level without values.
    fn push(&mut self, level: Level) -> Result<()> {
        let number = self.levels.len();
        let is_drawn = number <= self.scene.space.whole || self.starts_at_anchor(number);
        if let Some(anchor) = self.anchor.as_ref().filter(|_| is_drawn) {
            self.anchored.push(match self.levels.is_empty() {
                true => anchor.everywhere(&level, self.scene.is_open)?,
                false => anchor.band(&level),
            });
        }
        let Lattice { origin, voxel, .. } = level.lattice;
        let points = self.outline.points(CONTOUR_SPACING * voxel);
        let in_nodes = |at: DVec3| ((at - origin) / voxel).to_array();
        self.contours = points.into_par_iter().map(in_nodes).collect();
        self.levels.push(level);
        self.first = 0.0;
        Ok(())
    }

    /// Whether a level has a solution, and not only what it is drawn to.
    fn is_solved(&self, number: usize) -> bool {
        let original = self.scene.original.as_ref().filter(|_| self.anchor.is_some());
        let voxel = self.scene.space.lattices[number].voxel;
        original.is_none_or(|original| original.is_solved(voxel))
    }

    fn solve_first(&mut self, all: Vec<[i32; 3]>) -> Result<()> {
        let mut making = self.making(0);
        let leaves = enter(&mut making, all, &mut self.levels[0].grid);
        if leaves.is_empty() {
            self.keep(making);
            return Ok(());
        }
        let near = self.leaves_before(0, &leaves);
        let samples = self.samples_near(0, &near);
        let targets = self.anchor.is_none().then(|| self.soft_targets(0, &samples));
        for pass in 0..PASSES {
            let seen = self.seen(0, &mut making, pass + 1 == PASSES);
            let pulls = self.pulls(0, &near, &seen, &samples, targets.as_deref());
            self.solve(0, leaves.clone(), &pulls, (WHOLE, None), making.as_mut())?;
        }
        self.keep(making);
        Ok(())
    }

    /// What is to be kept of a level, if anything is. Where nothing was solved for on a
    /// coarser one a change reaches as far as ℓ, and all is solved for.
    fn making(&self, number: usize) -> Option<Making<'a>> {
        let drawn_to = self.anchored.get(number);
        let new = || Making::new(self.before, self.label, number, &self.levels[number], drawn_to);
        (self.scene.keeps && !self.starts_at_anchor(number)).then(new)
    }

    /// Keeps what there is of the last level.
    fn keep(&mut self, making: Option<Making>) {
        let level = making.zip(self.levels.last());
        self.kept.extend(level.map(|(making, level)| making.keep(level)));
    }

    /// Where samples of a coarse level, in nodes, are on the wrong side: what is known there the
    /// levels below were too coarse for.
    fn unheard(&self, number: usize) -> Vec<[f64; 3]> {
        let Level { lattice, grid, .. } = &self.levels[number];
        let wrong = |sample: &PlaneSample| {
            let at = ((sample.at - lattice.origin) / lattice.voxel).to_array();
            let is_inside = trilinear(grid, at)? > 0.0;
            (is_inside != (sample.label == self.label)).then_some(at)
        };
        self.scene.samples[number].par_iter().filter_map(wrong).collect()
    }

    /// Those samples of a coarse level that are in some of its leaves.
    fn samples_near(&self, number: usize, near: &LeafSet) -> Vec<PlaneSample> {
        let Lattice { origin, voxel, .. } = self.levels[number].lattice;
        let is_near = |sample: &&PlaneSample| {
            near.has(leaf_of(node_below(((sample.at - origin) / voxel).to_array())))
        };
        self.scene.samples[number].iter().copied().filter(|sample| is_near(&sample)).collect()
    }

    /// Leaves, and those before them along the axes, which the cells between belong to: what
    /// is in these bears on the leaves.
    fn leaves_before(&self, number: usize, leaves: &[[i32; 3]]) -> LeafSet {
        let mut near = LeafSet::new(&self.levels[number].grid);
        for &leaf in leaves {
            for leaf in leaves_between([leaf.map(|along| along - 1), leaf]) {
                near.insert(leaf);
            }
        }
        near
    }

    /// The next level, near the surface and the contours alone.
    fn add_narrow_level(&mut self, number: usize) -> Result<Vec<[i32; 3]>> {
        let lattice = self.scene.space.lattices[number];
        let level = Level::new(lattice, self.scene.is_open);
        self.push(level)?;
        let contours = near_points(&self.contours, BAND);
        let starts_at_anchor = self.starts_at_anchor(number);
        let mut band = match starts_at_anchor {
            true => self.anchored[number].leaves().to_vec(),
            false => self.refined(number, &self.levels[number]),
        };
        let is_coarse = number < self.scene.space.whole;
        self.ensure(contours.iter().chain(&band).copied());
        if is_coarse {
            let all: Vec<[i32; 3]> = self.levels[number].grid.all_places().collect();
            self.ensure(all);
        }
        if !self.is_solved(number) {
            return Ok(band);
        }
        let is_first = number == self.scene.space.whole || starts_at_anchor;
        let is_last = number + 1 == self.scene.space.lattices.len();
        let (passes, limits, length) = match (is_coarse, is_first, is_last) {
            (true, _, _) => (PASSES, WHOLE, None),
            (false, true, _) => (PASSES, FIRST_NARROW, None),
            (false, false, true) => (1, NARROW, Some(FINEST_LENGTH)),
            (false, false, false) => (1, NARROW, Some(NARROW_LENGTH)),
        };
        let reach = if is_coarse { WIDE_BAND } else { BAND };
        let mut making = self.making(number);
        for pass in 0..passes {
            band = near_changes(&self.levels[number].grid, reach);
            band.extend(&contours);
            if is_coarse {
                band.extend(near_points(&self.unheard(number), BAND));
            }
            band.sort_unstable();
            band.dedup();
            band.retain(|&leaf| self.levels[number].grid.may_hold(leaf));
            self.ensure(band.iter().flat_map(|&leaf| around(leaf)));
            let leaves = enter(&mut making, band.clone(), &mut self.levels[number].grid);
            if leaves.is_empty() {
                continue;
            }
            let near = self.leaves_before(number, &leaves);
            let samples = match is_coarse {
                true => self.samples_near(number, &near),
                false => self.samples_in(number, &near, &band),
            };
            let is_soft = (is_coarse || is_first || !is_last) && self.anchor.is_none();
            let targets = is_soft.then(|| self.soft_targets(number, &samples));
            let seen = self.seen(number, &mut making, pass > 0 && pass + 1 == passes);
            let pulls = self.pulls(number, &near, &seen, &samples, targets.as_deref());
            self.solve(number, leaves, &pulls, (limits, length), making.as_mut())?;
        }
        self.keep(making);
        Ok(band)
    }

    /// The leaves of a level in leaves of the level below that hold a change of
    /// sign.
    fn refined(&self, number: usize, level: &Level) -> Vec<[i32; 3]> {
        let (below, lattice) = (&self.levels[number - 1], &level.lattice);
        let ratio = below.lattice.voxel / lattice.voxel;
        let shift = (below.lattice.origin - lattice.origin) / lattice.voxel;
        let side = f64::from(SIDE);
        let mut refined = LeafSet::new(&level.grid);
        for leaf in near_changes(&below.grid, 0) {
            // One node more, for changes between this leaf and the next.
            let low: [f64; 3] =
                std::array::from_fn(|axis| shift[axis] + ratio * side * f64::from(leaf[axis]));
            let ends = [low, low.map(|along| along + ratio * side)];
            let ends = ends.map(|end| end.map(|along| (along / side).floor() as i32));
            for leaf in leaves_between(ends) {
                refined.insert(leaf);
            }
        }
        refined.sorted()
    }

    /// Interpolates leaves of the last level, and sets what the box fixes.
    fn ensure(&mut self, leaves: impl IntoIterator<Item = [i32; 3]>) {
        let mut levels = std::mem::take(&mut self.levels);
        let settle = |lattice: &Lattice, domain: &Domain, leaf, values: &mut LeafNodes| {
            self.settle(lattice, domain, leaf, values);
        };
        ensure(&mut levels, leaves, &settle);
        self.levels = levels;
    }

    /// Whether a level is not started from the one below it but from what it is
    /// drawn to.
    fn starts_at_anchor(&self, number: usize) -> bool {
        self.anchor.is_some() && (number == 0 || !self.is_solved(number - 1))
    }

    /// What is not interpolated from below.
    fn settle(&self, lattice: &Lattice, domain: &Domain, leaf: [i32; 3], values: &mut LeafNodes) {
        if self.anchor.is_none() {
            self.settle_free(lattice, domain, leaf, values);
            return;
        }
        let is_own = |own: &Lattice| own.voxel == lattice.voxel;
        let number = self.scene.space.lattices.iter().position(is_own);
        let Some(number) = number.filter(|&number| self.starts_at_anchor(number)) else { return };
        for (node, value) in values.iter_mut().enumerate() {
            let at = node_of(leaf, node);
            let is_end = self.scene.is_open && !lattice.is_inner(at);
            let Some(distance) = self.anchored[number].value(at) else { continue };
            if number == 0 || f64::from(distance.abs()) < HALF_WIDTH && !is_end {
                *value = distance;
            }
        }
    }

    /// Without anything to be drawn to: on the coarsest level all nodes, and on those on
    /// the wide box the ones beyond it or an end, are as far outside as the nearest
    /// contour is away. On the others nodes beyond an end are as they are, and those
    /// beyond the given box outside, at least by the margin.
    fn settle_free(
        &self,
        lattice: &Lattice,
        domain: &Domain,
        leaf: [i32; 3],
        values: &mut LeafNodes,
    ) {
        let Scene { space, is_open, .. } = self.scene;
        let is_first = lattice.voxel == space.lattices[0].voxel;
        let (is_wide, is_beyond) = (space.is_wide(lattice), space.beyond(lattice));
        let sign = if self.label == Label::OUTSIDE { 1.0 } else { -1.0 };
        let mut hint = Hint::default();
        for (node, value) in values.iter_mut().enumerate() {
            let at = node_of(leaf, node);
            let is_outer = !is_open && !lattice.is_inner(at);
            if is_first || is_wide && (is_outer || is_beyond(at)) {
                if domain.has(at) {
                    *value = sign * self.distance(lattice, lattice.position(at), &mut hint);
                }
            } else if is_outer {
                *value = sign * (sign * *value).max(MARGIN as f32);
            }
        }
    }

    /// To the nearest contour, in voxels.
    fn distance(&self, lattice: &Lattice, point: DVec3, hint: &mut Hint) -> f32 {
        let distance = self.outline.distance(point, hint);
        (distance.min(self.scene.space.frame.bounds.diagonal()) / lattice.voxel) as f32
    }

    /// For each even sample how far inside it should be, in voxels.
    fn soft_targets(&self, number: usize, samples: &[PlaneSample]) -> Vec<Option<f32>> {
        const CHUNK: usize = 512;
        let level = &self.levels[number];
        samples
            .par_chunks(CHUNK)
            .flat_map_iter(|samples| {
                let mut hint = Hint::default();
                samples.iter().map(move |sample| {
                    let distance = || self.distance(&level.lattice, sample.at, &mut hint);
                    let side = if sample.label == self.label { 1.0 } else { -1.0 };
                    sample.is_even.then(distance).map(|distance| side * distance)
                })
            })
            .collect()
    }

    /// The plane samples in a band that are in some leaves.
    fn samples_in(&self, number: usize, near: &LeafSet, band: &[[i32; 3]]) -> Vec<PlaneSample> {
        let Lattice { origin, voxel, .. } = self.levels[number].lattice;
        let mut inside = LeafSet::new(&self.levels[number].grid);
        for &leaf in band.iter().filter(|leaf| near.has(**leaf)) {
            inside.insert(leaf);
        }
        let region = Region::Leaves { leaves: &inside, origin, side: f64::from(SIDE) * voxel };
        let space = self.scene.space.sampled(&self.levels[number].lattice);
        plane_samples(self.scene.sections, space, voxel, region)
    }

    /// The values by which samples are on the wrong side.
    fn seen(&self, number: usize, making: &mut Option<Making>, is_kept: bool) -> Cow<'_, LeafGrid> {
        let grid = &self.levels[number].grid;
        match making {
            Some(making) => making.see(grid, is_kept),
            None => Cow::Borrowed(grid),
        }
    }

    /// What pulls at a field with some values: the contours in some leaves, and samples.
    fn pulls(
        &self,
        number: usize,
        near: &LeafSet,
        values: &LeafGrid,
        samples: &[PlaneSample],
        targets: Option<&[Option<f32>]>,
    ) -> Vec<Pull> {
        let Lattice { origin, voxel, .. } = self.levels[number].lattice;
        let soft = SAMPLES_PER_EVEN * self.scene.weights.soft_weight(voxel, self.scene.unit);
        let is_near = |at: &[f64; 3]| near.has(leaf_of(node_below(*at)));
        let contour = |at: &[f64; 3]| is_near(at).then_some(Pull { at: *at, ..ON_CONTOUR });
        let mut pulls: Vec<Pull> = self.contours.par_iter().filter_map(contour).collect();
        let pull = |(index, sample): (usize, &PlaneSample)| {
            let at = ((sample.at - origin) / voxel).to_array();
            let value = trilinear(values, at)?;
            let side = if sample.label == self.label { 1.0 } else { -1.0 };
            let target = targets.and_then(|targets| targets[index]);
            let margin = match target {
                Some(target) => target.abs().min(MARGIN as f32),
                None if side * value >= MARGIN as f32 => 0.0,
                None => {
                    let near = self.outline.distance_below(MARGIN * voxel, sample.at);
                    near.map_or(MARGIN, |distance| distance / voxel) as f32
                }
            };
            let firm = if side * value < margin { FIRM } else { 0.0 };
            let soft = if target.is_some() { soft } else { 0.0 };
            let weight = firm + soft;
            let sum = firm * side * margin + soft * target.unwrap_or(0.0);
            (weight > 0.0).then(|| Pull { at, weight, target: sum / weight })
        };
        pulls.par_extend(samples.par_iter().enumerate().filter_map(pull));
        pulls
    }

    /// Solves for the free nodes of leaves; with a length, in voxels, only for what is shorter
    /// than that.
    fn solve(
        &mut self,
        number: usize,
        mut leaves: Vec<[i32; 3]>,
        pulls: &[Pull],
        (limits, length): (Limits, Option<f32>),
        making: Option<&mut Making>,
    ) -> Result<()> {
        self.scene.progress.go_on()?;
        let level = &self.levels[number];
        let is_beyond = self.scene.space.beyond(&level.lattice);
        let is_free = |node: [i32; 3]| match self.scene.is_open {
            true => level.domain.has(node),
            false => level.lattice.is_inner(node) && !is_beyond(node),
        };
        leaves.retain(|&leaf| (0..LEAF_NODES).any(|node| is_free(node_of(leaf, node))));
        leaves.par_sort_by_cached_key(|&leaf| along_curve(leaf));
        let domain = self.scene.is_open.then_some(level.domain);
        let mut system = System::new(leaves, is_free, domain, pulls, &self.scene.directions);
        if let (Some(anchor), Some(distances)) = (&self.anchor, self.anchored.get(number)) {
            let is_open = self.scene.is_open;
            system.anchors = Some(anchor.anchors(level, distances, &system.leaves, is_open));
        }
        if let Some(length) = length {
            system.hold = length.powi(-4);
        }
        let starts = making.as_ref().map_or(&level.grid, |making| making.starts());
        let mut wanted = residual(&system, &level.grid, starts);
        if let Some(making) = &making {
            making.spare(&system, &mut wanted);
        }
        let usual = making.as_ref().map_or(0.0, |making| making.usual(&system));
        let limits = Limits { of: self.first.max(usual), ..limits };
        let correction = self.scene.backend.correct(&system, wanted, limits)?;
        self.first = self.first.max(correction.size);
        self.effort.add(system.unknowns(), correction.iterations);
        let grid = &mut self.levels[number].grid;
        for (leaf, values) in system.leaves.iter().zip(correction.values.chunks(LEAF_NODES)) {
            let own = grid.leaf_mut(grid.slot(*leaf));
            own.iter_mut().zip(values).for_each(|(own, by)| *own += by);
        }
        if let Some(making) = making {
            let left = residual(&system, grid, making.starts());
            making.solved(&system, &left, self.first);
        }
        Ok(())
    }
}

/// The leaves that are to be solved for among those that would be.
fn enter(making: &mut Option<Making>, leaves: Vec<[i32; 3]>, grid: &mut LeafGrid) -> Vec<[i32; 3]> {
    match making {
        Some(making) => making.enter(&leaves, grid),
        None => leaves,
    }
}

/// Where a leaf lies on the curve of Morton: what is near to each other in space is so
/// there, and neighbours are found in the processor's cache.
fn along_curve(leaf: [i32; 3]) -> u64 {
    // A leaf beyond the box has the number −1.
    leaf.map(|along| spread((along + 1) as u64)).iter().fold(0, |sum, along| sum << 1 | along)
}

/// The lower 21 bits, two zeros between each and the next.
fn spread(number: u64) -> u64 {
    [(32, 0x001f_0000_0000_ffff), (16, 0x001f_0000_ff00_00ff), (8, 0x100f_00f0_0f00_f00f)]
        .into_iter()
        .chain([(4, 0x10c3_0c30_c30c_30c3), (2, 0x1249_2492_4924_9249)])
        .fold(number & 0x1f_ffff, |bits, (by, mask)| (bits | bits << by) & mask)
}

/// The value at a place given in nodes, where all nodes around it have one.
fn trilinear(grid: &LeafGrid, at: [f64; 3]) -> Option<f32> {
    let low = node_below(at);
    let [x, y, z] = std::array::from_fn(|axis| {
        let high = (at[axis] - f64::from(low[axis])) as f32;
        [1.0 - high, high]
    });
    let first = low.map(|along| along.rem_euclid(SIDE) as usize);
    let is_within = first.iter().all(|&along| along + 1 < LEAF_SIDE);
    let leaf = if is_within { Some(grid.get(leaf_of(low))?) } else { None };
    let mut sum = 0.0;
    for corner in 0..8 {
        let step = [corner >> 2, corner >> 1 & 1, corner & 1];
        let value = match leaf {
            Some(leaf) => leaf[node_index(std::array::from_fn(|axis| first[axis] + step[axis]))],
            None => grid.value(std::array::from_fn(|axis| low[axis] + step[axis] as i32))?,
        };
        sum += x[step[0]] * y[step[1]] * z[step[2]] * value;
    }
    Some(sum)
}
