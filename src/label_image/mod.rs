//! Images of labels: pixels on a plane in space, each with one label, and the section that they
//! show.
//!
//! ```text
//! pixels ─► outlines ─► mpu (fit) ─► curves ─► trace ─► simplify ─► Section
//! ```

mod changes;
mod curves;
mod fit;
mod mpu;
mod outline;
mod simplify;
#[cfg(test)]
mod tests;
mod trace;

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::plane::Plane;
use crate::section::{Findings, Rules, Section};

use curves::contours;
pub use mpu::CurveOptions;
pub(crate) use trace::Contours;
use trace::Pixels;

/// Below this part of what two steps would span at a right angle, pixels have no area.
const FLAT: f64 = 1e-6;
/// Points of a contour go where without them it moves by less than this, in pixels.
const STRAIGHT: f64 = 0.05;

/// Pixels with labels.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelImage {
    pixels: Pixels,
    placement: ImagePlacement,
}

/// Where pixels are: pixel (i, j) has its centre at `origin + i · steps[0] + j · steps[1]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImagePlacement {
    /// The centre of the first pixel, in world units.
    pub origin: DVec3,
    /// From a pixel to the next in its row, and from a row to the next, in world units.
    pub steps: [DVec3; 2],
}

impl LabelImage {
    /// From a label for each pixel, row by row; `size` is how many a row has, and how many rows
    /// there are.
    ///
    /// # Errors
    /// What is wrong: the number of labels, or steps that span no area.
    pub fn new(
        size: [usize; 2],
        labels: Vec<u32>,
        placement: ImagePlacement,
    ) -> std::result::Result<Self, String> {
        if size[0].checked_mul(size[1]) != Some(labels.len()) {
            return Err(format!("{} labels are given for {size:?} pixels", labels.len()));
        }
        let [right, down] = placement.steps;
        let area = right.cross(down).length();
        let spans = area > FLAT * right.length() * down.length() && area.is_normal();
        if !placement.origin.is_finite() || !spans {
            return Err(format!(
                "its rows and columns ({right}, {down}, from {}) span no area: correct its spacing",
                placement.origin
            ));
        }
        Ok(Self { pixels: Pixels { size, labels }, placement })
    }

    /// How many pixels a row has, and how many rows there are.
    pub fn size(&self) -> [usize; 2] {
        self.pixels.size
    }

    /// The label of every pixel, row by row.
    pub fn labels(&self) -> &[u32] {
        &self.pixels.labels
    }

    /// The section that the pixels show: the plane through their centres, with smooth contours
    /// between pixels of different labels, as closely as the rules say. Beyond the image is outside, so what reaches its border
    /// ends there, half a pixel beyond the last centres.
    ///
    /// # Errors
    /// When no section can be made of them.
    pub fn section(&self, name: &str, rules: &Rules) -> Result<(Section, Findings)> {
        let ImagePlacement { origin, steps } = self.placement;
        let normal = steps[0].cross(steps[1]).normalize();
        let plane = Plane { normal, offset: normal.dot(origin) };
        let [width, height] = self.pixels.size.map(|pixels| pixels as f64);
        let diagonal = (width * steps[0]).length().hypot((height * steps[1]).length());
        let section = |contours: &Contours, rules: &Rules| {
            let place = |at: &DVec2| origin + at.x * steps[0] + at.y * steps[1];
            let points: Vec<DVec3> = contours.points.iter().map(place).collect();
            Section::from_graph(name, plane, &points, &contours.edges, diagonal, rules)
        };
        let contours = contours(&self.pixels, &rules.images.curves);
        // Curves that nearly touch may cross when they have fewer points.
        let strict = Rules { strict: true, ..*rules };
        section(&contours.simplified(STRAIGHT), &strict).or_else(|_| section(&contours, rules))
    }

    /// The labels that pixels on the image's border have, but for outside; sorted.
    pub fn on_border(&self) -> Vec<u32> {
        let Pixels { size: [width, height], labels } = &self.pixels;
        let is_border = |index: usize| {
            let (x, y) = (index % width, index / width);
            x == 0 || y == 0 || x + 1 == *width || y + 1 == *height
        };
        let mut found: Vec<u32> = (labels.iter().enumerate())
            .filter(|&(index, &label)| label != 0 && is_border(index))
            .map(|(_, &label)| label)
            .collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}
