//! A scale of colours for values from 0 on, and the bar that explains it.

use glam::{Vec2, Vec3};
use image::RgbaImage;

use super::camera::Frame;
use super::scene::Paint;
use super::text::{Font, blend};
use crate::color::{encode, linear};

/// Steps of colour.
const STEPS: usize = 64;
/// From nothing to much: grey, yellow, orange, red, a dark purple.
const STOPS: [[u8; 3]; 5] =
    [[206, 204, 199], [250, 219, 106], [236, 130, 42], [190, 28, 45], [66, 8, 72]];
/// The part of all values that the scale reaches up to.
const COVERED: f64 = 0.99;
/// Intervals between the numbers beside the bar.
const TICKS: u32 = 4;
const INK: [u8; 3] = [58, 54, 50];

/// Which colour stands for which value.
pub struct Scale {
    colors: Vec<[u8; 3]>,
    /// The value of the last colour.
    top: f32,
    /// Whether there are larger values, which have the last colour, too.
    is_cut: bool,
    unit: String,
    font: Font,
    /// The width of the column that the bar stands in.
    width: u32,
}

impl Scale {
    /// A scale that covers nearly all values of a picture.
    pub fn new(values: &[f32], unit: &str, size: [u32; 2]) -> Self {
        let mut sorted: Vec<f32> =
            values.iter().copied().filter(|value| value.is_finite()).collect();
        sorted.sort_by(f32::total_cmp);
        let largest = sorted.last().copied().unwrap_or(0.0);
        let covered = sorted.get((COVERED * sorted.len() as f64) as usize).copied();
        let top = round_up(covered.unwrap_or(largest));
        let font = Font::for_size(size);
        let column = (font.width("in voxels") + font.line() * 2).min(size[0] / 3);
        let colors = (0..STEPS).map(|step| ramp(step as f32 / (STEPS - 1) as f32)).collect();
        let unit = unit.to_owned();
        Self { colors, top, is_cut: largest > top, unit, font, width: column }
    }

    /// The colours, by number.
    pub fn paints(&self) -> Vec<Paint> {
        self.colors.iter().map(|&color| Paint { name: String::new(), color }).collect()
    }

    /// The number of a value's colour.
    pub fn color(&self, value: f32) -> u16 {
        let part = (value / self.top).clamp(0.0, 1.0);
        (part * (STEPS - 1) as f32).round() as u16
    }

    /// Where the shape goes.
    pub fn free_area(&self, [width, height]: [u32; 2]) -> Frame {
        let margin = 0.05 * width.min(height) as f32;
        let right = width.saturating_sub(self.width) as f32;
        Frame { min: Vec2::splat(margin), max: Vec2::new(right, height as f32) - margin }
    }

    /// Draws the bar in the middle of the right side, the largest values on top.
    pub fn draw(&self, image: &mut RgbaImage) {
        let line = self.font.line();
        let left = image.width().saturating_sub(self.width);
        let height = image.height() / 2;
        let top = (image.height() - height) / 2;
        for row in 0..height {
            let part = 1.0 - row as f32 / height.saturating_sub(1).max(1) as f32;
            let color = self.colors[usize::from(self.color(part * self.top))];
            (0..line).for_each(|column| blend(image, [left + column, top + row], color, 1.0));
        }
        for tick in 0..=TICKS {
            let value = self.top * tick as f32 / TICKS as f32;
            let more = if tick == TICKS && self.is_cut { "+" } else { "" };
            let middle = top + height - height * tick / TICKS;
            let place = [left + line * 3 / 2, middle.saturating_sub(line / 2)];
            self.font.draw(image, &format!("{value}{more}"), place, INK);
        }
        let title = ["distance", &format!("in {}", self.unit)];
        for (words, above) in title.into_iter().zip([7, 4]) {
            self.font.draw(image, words, [left, top.saturating_sub(line * above / 2)], INK);
        }
    }
}

/// The next larger 1, 2, 4 or 8 · 10ⁿ: a quarter of it has few digits.
fn round_up(value: f32) -> f32 {
    if value <= 1e-6 {
        return 1.0;
    }
    let decade = 10f32.powi(value.log10().floor() as i32);
    let steps = [1.0, 2.0, 4.0, 8.0, 10.0];
    let step = steps.into_iter().find(|step| step * decade >= value);
    step.unwrap_or(10.0) * decade
}

/// The colour at a part of the scale, mixed in linear light.
fn ramp(part: f32) -> [u8; 3] {
    let place = part.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let stop = (place.floor() as usize).min(STOPS.len() - 2);
    let [one, other] = [STOPS[stop], STOPS[stop + 1]].map(linear);
    let mixed: Vec3 = one.lerp(other, place - stop as f32);
    let [r, g, b, _] = encode(mixed);
    [r, g, b]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_end_in_round_numbers() {
        for (value, expected) in
            [(0.0, 1.0), (0.9, 1.0), (1.0, 1.0), (1.1, 2.0), (3.0, 4.0), (9.0, 10.0), (47.0, 80.0)]
        {
            assert!((round_up(value) - expected).abs() < 1e-5, "{value}: {}", round_up(value));
        }
    }

    #[test]
    fn a_few_outliers_do_not_stretch_the_scale() {
        let mut values = vec![0.5; 1000];
        values[3] = 40.0;
        let scale = Scale::new(&values, "voxels", [640, 480]);
        assert!(scale.is_cut && scale.top == 0.8, "{}", scale.top);
        assert_eq!([0.0, 0.8, 40.0].map(|value| scale.color(value)), [0, 63, 63]);
        assert_eq!((ramp(0.0), ramp(1.0)), (STOPS[0], STOPS[4]));
    }
}
