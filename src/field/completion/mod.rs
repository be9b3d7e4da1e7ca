//! The completion of unknown regions (Bermano §5): what each label's share is
//! at every point of them.
//!
//! They are triangulated, and shares are linear on the triangles. The share of
//! a label at a corner is a mean of what is seen from there, weighted by the
//! integral of 1/distance over all directions: within the plane, of the known
//! regions around the unknown one (Bermano's second sum, in two dimensions);
//! and in space, of the faces of the cells on both sides but those on the
//! corner's own plane (the first sum). Both sums are divided by all their
//! weights together, so that constants are reproduced.
//!
//! Bermano's first sum has the known regions of the whole cell group, wherever
//! something else stands in between: with a little unknown on every section,
//! every section would weigh on every other one. Here a corner sees the faces
//! of its own, convex, cells. Where an unknown region is among them, its shares
//! are what is seen there; so the shares are the solution of a linear system,
//! and a group's cells see each other through their unknown regions. It is
//! solved by repeated insertion, which is accelerated (`mixing`). Corners that have not
//! seen anything known yet have no weight, and get shares first. Where
//! a complex had shares before a change, that is where it begins. With one unknown
//! region between known ones this is Bermano's formula.
//!
//! Corners on contours have the labels beyond them, where there are several
//! their mean (§5.1).

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use rayon::prelude::*;

use crate::complex::Complex;
use crate::error::{Error, Result};
use crate::label::Label;

mod groups;
mod mixing;
mod outline;
mod plane;
mod sweep;
#[cfg(test)]
mod tests;

use super::places;
use groups::{groups, has_unknown};
use mixing::Mixing;
use plane::UnknownPlane;
use sweep::Sweeper;

/// Shares that change by less from one sweep to the next are final.
const TOLERANCE: f32 = 1e-6;
/// So are those that change by less than this, if the largest change was not smaller for
/// [`PATIENCE`] sweeps: rounding is all that is left.
const ROUNDING: f32 = 1e-4;
const PATIENCE: u32 = 10;
/// More sweeps than any system in good order takes.
const SWEEPS: u32 = 500;

/// Triangles on unknown regions, and every label's share at their corners.
#[derive(Debug, Default)]
pub struct Completion {
    /// The known labels, sorted.
    labels: Vec<Label>,
    /// The corners, in world units. A point between two cell groups is a
    /// corner for each.
    points: Vec<DVec3>,
    /// For every corner one share per label.
    shares: Vec<f32>,
    /// For every face its triangles, counter-clockwise about the plane's
    /// normal; nothing at all when nothing is unknown.
    triangles: Vec<Vec<[u32; 3]>>,
    sweeps: u32,
}

/// What is said on the unknown regions of a cell's boundary, to be held against what is said
/// there after a change.
#[derive(Debug, Clone, PartialEq)]
pub struct CellShares {
    labels: Vec<Label>,
    /// The corners of all triangles, one after another.
    corners: Vec<DVec3>,
    /// For every corner the share of every label.
    shares: Vec<f32>,
}

impl CellShares {
    /// Whether the same labels have the same shares in the same places, but for a tolerance.
    pub fn is_near(&self, other: &Self, tolerance: f32) -> bool {
        let mut pairs = self.shares.iter().zip(&other.shares);
        self.labels == other.labels
            && self.corners == other.corners
            && pairs.all(|(one, other)| (one - other).abs() <= tolerance)
    }
}

/// A corner that is not on a contour.
struct Free {
    corner: u32,
    /// What it sees within its plane.
    weights: Vec<f64>,
}

impl Completion {
    /// Completes the unknown regions of a complex, triangulated with edges
    /// of about `spacing` (world units), beginning with the shares `before` a change.
    ///
    /// # Errors
    /// [`Error::Option`] where nothing is known.
    pub(super) fn new(
        complex: &Complex,
        clearance: f64,
        spacing: f64,
        before: Option<&Self>,
    ) -> Result<Self> {
        if !complex.facets().values().any(has_unknown) {
            return Ok(Self::default());
        }
        let mut completion = Self { labels: labels(complex), ..Self::default() };
        if completion.labels.is_empty() {
            return Err(nothing_known());
        }
        completion.triangles = vec![Vec::new(); complex.facets().end()];
        let groups = groups(complex);
        let mut free = Vec::new();
        for plane in planes(complex, spacing)? {
            free.append(&mut completion.add(complex, &plane, &groups));
        }
        if let Some(before) = before {
            completion.begin_at(before, &free, places::step(complex.bounds()));
        }
        completion.settle(Sweeper::new(complex, clearance, &completion, &free)?, &free);
        let shares = completion.shares.chunks_exact(completion.labels.len());
        if shares.into_iter().any(|shares| shares.iter().all(|&share| share == 0.0)) {
            return Err(nothing_known());
        }
        Ok(completion)
    }

    /// Adds a plane's triangles, and returns the corners whose shares are still
    /// to be found.
    fn add(&mut self, complex: &Complex, plane: &UnknownPlane, groups: &[u32]) -> Vec<Free> {
        let group = |face: u32| {
            let cell = complex.facets()[face].cells.into_iter().flatten().next();
            cell.map_or(0, |cell| groups[cell as usize])
        };
        let fixed = plane.fixed(&self.labels);
        let mut numbers: BTreeMap<(u32, u32), u32> = BTreeMap::new();
        let mut points = Vec::new();
        for &(face, corners) in &plane.triangles {
            let group = group(face);
            let corners = corners.map(|point| {
                let next = self.points.len() as u32;
                let number = *numbers.entry((point, group)).or_insert(next);
                if number == next {
                    self.points.push(plane.points[point as usize]);
                    points.push((number, point));
                }
                number
            });
            self.triangles[face as usize].push(corners);
        }
        let none = vec![0.0; self.labels.len()];
        for &(_, point) in &points {
            self.shares.extend(fixed[point as usize].as_ref().unwrap_or(&none));
        }
        let free = points.into_par_iter().filter(|&(_, point)| fixed[point as usize].is_none());
        free.map(|(corner, point)| Free { corner, weights: plane.weights(point, &self.labels) })
            .collect()
    }

    /// Gives free corners the shares that corners in their places had; `step` as in `outline`.
    fn begin_at(&mut self, before: &Self, free: &[Free], step: f64) {
        if before.labels != self.labels {
            return;
        }
        let count = self.labels.len();
        let place = |point: &DVec3| places::key(*point, step);
        let was: HashMap<[u64; 3], &[f32]> =
            before.points.iter().map(place).zip(before.shares.chunks_exact(count)).collect();
        for &Free { corner, .. } in free {
            if let Some(shares) = was.get(&place(&self.points[corner as usize])) {
                self.shares_mut(corner).copy_from_slice(shares);
            }
        }
    }

    /// Finds the shares of the free corners.
    fn settle(&mut self, mut sweeper: Sweeper, free: &[Free]) {
        let count = self.labels.len();
        let mut mixing = Mixing::default();
        let (mut least, mut least_at) = (f32::INFINITY, 0);
        let mut shares = self.shares_of(free);
        while self.sweeps < SWEEPS {
            self.sweeps += 1;
            let mut next = sweeper.sweep(self);
            let pairs = || shares.chunks_exact(count).zip(next.chunks_exact(count));
            let is_without = |shares: &[f32]| shares.iter().all(|&share| share == 0.0);
            if pairs().any(|(own, _)| is_without(own)) {
                let filled: Vec<f32> = pairs()
                    .flat_map(|(own, next)| if is_without(own) { next } else { own })
                    .copied()
                    .collect();
                if filled == shares {
                    return;
                }
                shares = filled;
                self.set_shares_of(free, &shares);
                continue;
            }
            let changes = next.iter().zip(&shares).map(|(next, share)| (next - share).abs());
            let largest = changes.fold(0.0, f32::max);
            if largest < least {
                (least, least_at) = (largest, self.sweeps);
            }
            let is_rounding = largest < ROUNDING && self.sweeps >= least_at + PATIENCE;
            let is_last = largest < TOLERANCE || is_rounding || self.sweeps == SWEEPS;
            if !is_last {
                mixing.mix(&shares, &mut next);
            }
            shares = next;
            self.set_shares_of(free, &shares);
            if is_last {
                return;
            }
        }
    }

    fn shares_mut(&mut self, corner: u32) -> &mut [f32] {
        let count = self.labels.len();
        &mut self.shares[corner as usize * count..][..count]
    }

    fn shares_of(&self, free: &[Free]) -> Vec<f32> {
        let count = self.labels.len();
        free.iter()
            .flat_map(|free| &self.shares[free.corner as usize * count..][..count])
            .copied()
            .collect()
    }

    fn set_shares_of(&mut self, free: &[Free], shares: &[f32]) {
        for (free, shares) in free.iter().zip(shares.chunks_exact(self.labels.len())) {
            self.shares_mut(free.corner).copy_from_slice(shares);
        }
    }

    /// The known labels, sorted.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// How many triangles the unknown regions have.
    pub fn triangle_count(&self) -> usize {
        self.triangles.iter().map(Vec::len).sum()
    }

    /// How many corners they have.
    pub fn corner_count(&self) -> usize {
        self.points.len()
    }

    /// How many sweeps it took.
    pub fn sweeps(&self) -> u32 {
        self.sweeps
    }

    /// A corner, in world units.
    pub fn point(&self, corner: u32) -> DVec3 {
        self.points[corner as usize]
    }

    /// A label's share at a corner, in [0, 1]; the label by its place among
    /// [`Completion::labels`].
    pub fn share(&self, corner: u32, slot: usize) -> f64 {
        self.shares[corner as usize * self.labels.len() + slot].into()
    }

    /// The triangles on a face.
    pub fn triangles(&self, face: u32) -> &[[u32; 3]] {
        self.triangles.get(face as usize).map_or(&[], Vec::as_slice)
    }

    /// What is said on some faces about some labels; `None` where nothing is unknown.
    pub(super) fn shares_on(&self, faces: &[u32], labels: &[Label]) -> Option<CellShares> {
        let triangles = || faces.iter().flat_map(|&face| self.triangles(face));
        triangles().next()?;
        let slots = self.slots(labels);
        let corners = || triangles().flatten().copied();
        let shares = |corner| slots.iter().map(move |&slot| self.share(corner, slot) as f32);
        Some(CellShares {
            labels: labels.to_vec(),
            corners: corners().map(|corner| self.point(corner)).collect(),
            shares: corners().flat_map(shares).collect(),
        })
    }

    /// The triangles on which the label with the largest share changes: where
    /// the surface passes though no contour does.
    pub fn changes(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let changes = |corners: &&[u32; 3]| {
            let [a, b, c] = corners.map(|corner| self.winner(corner));
            a != b || b != c
        };
        let place = |corners: &[u32; 3]| corners.map(|corner| self.point(corner));
        self.triangles.iter().flatten().filter(changes).map(place)
    }

    /// The label with the largest share, of equals the smallest.
    fn winner(&self, corner: u32) -> usize {
        let slots = (0..self.labels.len()).rev();
        slots.max_by(|&a, &b| self.share(corner, a).total_cmp(&self.share(corner, b))).unwrap_or(0)
    }

    /// Where some of the labels stand among the completion's; those that it
    /// does not know are left out.
    pub(super) fn slots(&self, labels: &[Label]) -> Vec<usize> {
        labels.iter().filter_map(|label| self.labels.binary_search(label).ok()).collect()
    }
}

/// The known labels on all faces.
fn labels(complex: &Complex) -> Vec<Label> {
    let mut labels: Vec<Label> =
        complex.cells().values().flat_map(|cell| &cell.labels).copied().collect();
    labels.sort();
    labels.dedup();
    labels.retain(|&label| label != Label::UNKNOWN);
    labels
}

/// The triangulated unknown regions of all planes that have any.
fn planes(complex: &Complex, spacing: f64) -> Result<Vec<UnknownPlane>> {
    let mut facets: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (id, facet) in complex.facets().iter() {
        facets.entry(facet.plane).or_default().push(id);
    }
    let mut planes: Vec<Vec<u32>> = facets.into_values().collect();
    let facet = |&id: &u32| &complex.facets()[id];
    planes.retain(|facets| facets.iter().map(facet).any(has_unknown));
    planes.par_iter().map(|facets| UnknownPlane::new(complex, facets, spacing)).collect()
}

fn nothing_known() -> Error {
    Error::Option("everything is unknown: there is nothing to reconstruct from".to_owned())
}
