//! A part that moves from one slice to the next while it becomes another one.

use glam::DVec2;

use crate::label::Label;

use super::filter::Image;
use super::matching::{Pair, length};
use super::parts::Part;
use super::slices::Slices;

/// How thick it must be, across the way it goes, for the lattice to carry it: in voxels from
/// the middle to the surface.
const LEAST_DEPTH: f64 = 1.0;
/// Pixels around it, beyond what it passes through in half a leaf.
const MARGIN: f64 = 8.0;
/// Half a leaf, in voxels.
const HALF_LEAF: f64 = 4.0;

/// Between two slices the distances to a part of one and to one of the other, moved along and
/// blended.
#[derive(Debug)]
pub struct Tube {
    /// Its label.
    pub label: Label,
    /// All the way, in pixels.
    step: DVec2,
    /// The first pixel of both images, where they are on the first slice.
    first: [i32; 2],
    /// Inside positive, in pixels.
    images: [Image; 2],
    parts: [Part; 2],
}

impl Tube {
    /// Of two parts of a slice and the next one; `None` where it would be too thin for the
    /// lattice.
    pub fn new(slices: &Slices, lower: usize, parts: [&Part; 2], pair: &Pair) -> Option<Self> {
        let lean = length(pair.step) / (slices.heights[lower + 1] - slices.heights[lower]);
        let least = LEAST_DEPTH * lean.hypot(1.0);
        let widest = parts.iter().flat_map(|part| part.size).max().unwrap_or(0) as f64;
        // It is no deeper than half of its width. Slices may be so close that the images would
        // be as large as nothing could hold.
        if 2.0 * least > widest + 1.0 {
            return None;
        }
        let margin = (MARGIN + HALF_LEAF * lean).ceil() as i32;
        let back = pair.step.map(|along| -along);
        let ends = |axis: usize| {
            let of = |part: &Part, by: i32| {
                [part.first[axis] + by, part.first[axis] + by + part.size[axis] as i32]
            };
            let [one, other] = [of(parts[0], 0), of(parts[1], back[axis])];
            [one[0].min(other[0]) - margin, one[1].max(other[1]) + margin]
        };
        let [x, y] = [ends(0), ends(1)];
        let (first, size) = ([x[0], y[0]], [x, y].map(|[from, to]| (to - from) as usize));
        let moved = [0, 1].map(|axis| first[axis] + pair.step[axis]);
        let images = [
            slices.distances_of(lower, parts[0], first, size)?,
            slices.distances_of(lower + 1, parts[1], moved, size)?,
        ];
        let in_both = images[0].values.iter().zip(&images[1].values);
        let depth = in_both.map(|(one, other)| one.min(*other)).fold(f32::NEG_INFINITY, f32::max);
        let step = DVec2::from_array(pair.step.map(f64::from));
        let is_thick = f64::from(depth) >= least;
        is_thick.then_some(Self {
            label: parts[0].label,
            step,
            first,
            images,
            parts: parts.map(Part::clone),
        })
    }

    /// Whether a column passes through one of its parts. Of its label it passes through nothing
    /// else between the two slices: the parts overlap none of it.
    pub fn owns(&self, pixel: DVec2) -> bool {
        let nearest = pixel.round().to_array().map(|along| along as i32);
        self.parts.iter().any(|part| part.has(nearest))
    }

    /// How deep a pixel is in it, a part of the way from the first slice to the second; `None`
    /// far away.
    pub fn depth(&self, pixel: DVec2, part: f64) -> Option<f64> {
        let at = pixel - part * self.step - DVec2::from_array(self.first.map(f64::from));
        let [from, to] = &self.images;
        let (width, height) = (from.width, from.values.len() / from.width);
        let low = at.floor();
        let is_within = low.cmpge(DVec2::ZERO).all()
            && low.x + 1.0 < width as f64
            && low.y + 1.0 < height as f64;
        if !is_within {
            return None;
        }
        let (corner, DVec2 { x, y }) = (low.y as usize * width + low.x as usize, at - low);
        let between = |image: &Image| {
            let row = |start: usize| {
                let [left, right] = [start, start + 1].map(|at| f64::from(image.values[at]));
                left + x * (right - left)
            };
            let [lower, upper] = [row(corner), row(corner + width)];
            lower + y * (upper - lower)
        };
        Some((1.0 - part) * between(from) + part * between(to))
    }
}
