//! The outlines of one label in an image: closed curves through the middles between its pixels
//! and their neighbours, with normals.
//!
//! Middles, not the centres of pixels on the border as Marker et al. (§2.1) have it: those are
//! half a pixel inside.

use std::collections::BTreeMap;

use glam::DVec2;

use super::trace::{At, Pixels, trace};
use crate::label::Label;

/// The Gaussian by which an image is smoothed for normals, in pixels.
const NORMALS: f64 = 2.0;
/// The same for what goes on through the middle of a square, and where pixels' outlines are kept.
const SHARES: f64 = 1.0;
/// Gaussians end at so many times their width.
const CUT: f64 = 3.0;

/// A closed curve with its label on its left, seen as [`super::trace`] has it.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// In pixels.
    pub points: Vec<DVec2>,
    /// Of length one, into the label.
    pub normals: Vec<DVec2>,
}

impl Pixels {
    /// The share of a label around a point, from 0 to 1.
    pub fn share(&self, label: u32, at: DVec2) -> f64 {
        let (mut own, mut all) = (0.0, 0.0);
        self.around(at, SHARES, |pixel, weight, _| {
            all += weight;
            own += if pixel == label { weight } else { 0.0 };
        });
        own / all
    }

    /// The direction in which the share of a label grows most; 0 where it does in none.
    fn growth(&self, label: u32, at: DVec2) -> DVec2 {
        let mut sum = DVec2::ZERO;
        self.around(at, NORMALS, |pixel, weight, offset| {
            sum += if pixel == label { weight * offset } else { DVec2::ZERO };
        });
        sum.normalize_or_zero()
    }

    /// Tells of every pixel near a point its label, its weight and where it is from there.
    fn around(&self, at: DVec2, width: f64, mut tell: impl FnMut(u32, f64, DVec2)) {
        let reach = CUT * width;
        let [low, high] = [at - reach, at + reach].map(|end| end.round().as_ivec2());
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let offset = DVec2::new(f64::from(x), f64::from(y)) - at;
                let weight = (-0.5 * offset.length_squared() / (width * width)).exp();
                tell(self.label([x, y]), weight, offset);
            }
        }
    }

    /// Which label goes on through the middle of a square whose opposite corners are alike: the
    /// one with the greater share around there.
    pub fn joined(&self, [x, y]: At) -> Option<u32> {
        let corner = |right: i32, up: i32| self.label([x + right, y + up]);
        let pairs = [[corner(0, 0), corner(1, 1)], [corner(1, 0), corner(0, 1)]];
        let alike = pairs.iter().filter(|[one, other]| one == other).map(|[label, _]| *label);
        let middle = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let shares = alike.map(|label| (self.share(label, middle), label));
        // Of equals the smallest, which apart from materials is outside.
        let more = |best: (f64, u32), next: (f64, u32)| {
            let is_more = (next.0, best.1) > (best.0, next.1);
            if is_more { next } else { best }
        };
        shares.reduce(more).map(|(_, label)| label)
    }

    /// The outlines of all labels that occur, and of outside.
    pub fn outlines(&self) -> Vec<(u32, Outline)> {
        let boxes = self.boxes().into_iter();
        boxes.flat_map(|(label, ends)| self.outlines_in(label, ends)).collect()
    }

    /// The first and the last pixel of each label along rows and columns. Outside has the image.
    fn boxes(&self) -> BTreeMap<u32, [At; 2]> {
        let [width, height] = self.size.map(|pixels| pixels as i32);
        let mut boxes = BTreeMap::from([(0, [[-1, -1], [width, height]])]);
        for (row, y) in self.labels.chunks(self.size[0].max(1)).zip(0..) {
            let mut x = 0;
            for run in row.chunk_by(|one, other| one == other) {
                let last = x + run.len() as i32 - 1;
                let [low, high] = boxes.entry(run[0]).or_insert([[x, y], [last, y]]);
                *low = [low[0].min(x), low[1].min(y)];
                *high = [high[0].max(last), high[1].max(y)];
                x = last + 1;
            }
        }
        boxes
    }

    /// The outlines of a label that occurs between two pixels alone.
    fn outlines_in(&self, label: u32, [low, high]: [At; 2]) -> Vec<(u32, Outline)> {
        // 1 for the label and 0 for all others; beyond this it is 0, so outside gets a ring of 1
        // around the image, whose own outline is none.
        let rows = low[1]..=high[1];
        let is_own = |at: At| u32::from(self.label(at) == label);
        let labels = rows.flat_map(|y| (low[0]..=high[0]).map(move |x| is_own([x, y]))).collect();
        let size = [0, 1].map(|axis| (high[axis] - low[axis] + 1) as usize);
        let mask = Self { size, labels };
        let joined = |[x, y]: At| {
            let at = [x + low[0], y + low[1]];
            Some(u32::from(self.joined(at) == Some(label)))
        };
        let contours = trace(&mask, |_, _| 0.5, joined);
        let mut next = vec![u32::MAX; contours.points.len()];
        for edge in &contours.edges {
            let [start, end] =
                if edge.left == Label(1) { [edge.start, edge.end] } else { [edge.end, edge.start] };
            next[start as usize] = end;
        }
        let offset = DVec2::new(f64::from(low[0]), f64::from(low[1]));
        let mut outlines = Vec::new();
        for first in 0..next.len() {
            let mut points = Vec::new();
            let mut at = first;
            while let Some(end) = next.get_mut(at).filter(|end| **end != u32::MAX) {
                points.push(contours.points[at] + offset);
                at = std::mem::replace(end, u32::MAX) as usize;
            }
            let is_ring = label == 0 && points.iter().any(|at| at.min_element() < -1.0);
            if !points.is_empty() && !is_ring {
                outlines.push((label, self.outline(label, points)));
            }
        }
        outlines
    }

    fn outline(&self, label: u32, points: Vec<DVec2>) -> Outline {
        let count = points.len();
        let normal = |index: usize| {
            let chord = points[(index + 1) % count] - points[(index + count - 1) % count];
            let inward = chord.perp().normalize_or_zero();
            let growth = self.growth(label, points[index]);
            // In parts thinner than the Gaussian it may be that of the other side.
            if growth.dot(inward) > 0.0 { growth } else { inward }
        };
        let normals = (0..count).map(normal).collect();
        Outline { points, normals }
    }
}
