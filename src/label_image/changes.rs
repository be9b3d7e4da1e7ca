//! Images of another size, at another place, with other labels.

use glam::DVec3;

use super::trace::Pixels;
use super::{ImagePlacement, LabelImage};

impl LabelImage {
    /// The same without what is empty around all materials but for one pixel, which takes less
    /// memory; what is on the border stays there.
    pub fn cropped(self) -> Self {
        let Pixels { size: [width, height], labels } = &self.pixels;
        let is_filled = |index: &usize| labels[*index] != 0;
        let (mut low, mut high) = ([*width, *height], [0, 0]);
        for index in (0..labels.len()).filter(is_filled) {
            let at = [index % width, index / width];
            low = [0, 1].map(|axis| low[axis].min(at[axis]));
            high = [0, 1].map(|axis| high[axis].max(at[axis]));
        }
        if low[0] > high[0] {
            low = [0, 0];
        }
        let low = low.map(|index| index.saturating_sub(1));
        let high = [(high[0] + 2).min(*width), (high[1] + 2).min(*height)];
        let rows = (low[1]..high[1]).map(|y| &labels[y * width..][low[0]..high[0]]);
        let cropped: Vec<u32> = rows.flatten().copied().collect();
        let ImagePlacement { origin, steps } = self.placement;
        let origin = origin + low[0] as f64 * steps[0] + low[1] as f64 * steps[1];
        let size = [high[0] - low[0], high[1] - low[1]];
        let placement = ImagePlacement { origin, steps };
        Self { pixels: Pixels { size, labels: cropped }, placement }
    }

    /// The same with so many more pixels on every side, like those on the border.
    pub fn extended(self, margin: usize) -> Self {
        let Pixels { size: [width, height], labels } = &self.pixels;
        let within = |index: usize, count: usize| index.saturating_sub(margin).min(count - 1);
        let size = [width + 2 * margin, height + 2 * margin];
        let rows = (0..size[1]).map(|y| within(y, *height) * width);
        let wider = rows.flat_map(|row| (0..size[0]).map(move |x| row + within(x, *width)));
        let labels = wider.map(|index| labels[index]).collect();
        let ImagePlacement { origin, steps } = self.placement;
        let origin = origin - margin as f64 * (steps[0] + steps[1]);
        Self { pixels: Pixels { size, labels }, placement: ImagePlacement { origin, steps } }
    }

    /// The same with other labels, each by the one that it was.
    pub fn relabelled(mut self, label: impl Fn(u32) -> u32) -> Self {
        self.pixels.labels.iter_mut().for_each(|pixel| *pixel = label(*pixel));
        self
    }

    /// The same, lengths multiplied by three factors, and moved along z.
    ///
    /// # Errors
    /// When its pixels have no area then.
    pub fn scaled(self, [x, y, _]: [f64; 3], z: f64) -> std::result::Result<Self, String> {
        let Self { pixels: Pixels { size, labels }, placement } = self;
        let ImagePlacement { origin, steps } = placement;
        let factors = DVec3::new(x, y, 1.0);
        let origin = origin * factors + DVec3::new(0.0, 0.0, z);
        let steps = steps.map(|step| step * factors);
        Self::new(size, labels, ImagePlacement { origin, steps })
    }

    /// Whether no pixel has a label.
    pub fn is_empty(&self) -> bool {
        self.pixels.labels.iter().all(|&label| label == 0)
    }
}
