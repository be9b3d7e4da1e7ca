//! Text on pictures, from a pre-rendered font.

use image::{Rgba, RgbaImage};
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

const WEIGHT: FontWeight = FontWeight::Regular;

/// How large a picture is to what is written and drawn on it, in pixels: the
/// height, but of a narrow picture less.
pub fn scale([width, height]: [u32; 2]) -> f32 {
    (width as f32 * 0.75).min(height as f32)
}

/// A size of text.
#[derive(Debug, Clone, Copy)]
pub struct Font(RasterHeight);

impl Font {
    /// The size that fits a picture of this width and height.
    pub fn for_size(size: [u32; 2]) -> Self {
        Self(match scale(size) as u32 {
            0..700 => RasterHeight::Size16,
            700..1600 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        })
    }

    /// The height of a line, in pixels.
    pub fn line(self) -> u32 {
        self.0.val() as u32
    }

    /// The width of some text, in pixels.
    pub fn width(self, text: &str) -> u32 {
        (text.chars().count() * get_raster_width(WEIGHT, self.0)) as u32
    }

    /// Draws a line of text, its top left at a pixel; what lies beyond the
    /// picture is cut off.
    pub fn draw(self, image: &mut RgbaImage, text: &str, [left, top]: [u32; 2], color: [u8; 3]) {
        for (number, letter) in text.chars().enumerate() {
            let glyph =
                get_raster(letter, WEIGHT, self.0).or_else(|| get_raster('?', WEIGHT, self.0));
            let Some(glyph) = glyph else { continue };
            let start = left + (number * glyph.width()) as u32;
            for (row, line) in glyph.rows().enumerate() {
                for (column, &cover) in line.iter().enumerate() {
                    let at = [start + column as u32, top + row as u32];
                    blend(image, at, color, f32::from(cover) / 255.0);
                }
            }
        }
    }
}

/// Mixes a colour into a pixel, if there is one.
pub fn blend(image: &mut RgbaImage, [x, y]: [u32; 2], color: [u8; 3], cover: f32) {
    let Some(Rgba(pixel)) = image.get_pixel_mut_checked(x, y) else { return };
    for (channel, target) in pixel.iter_mut().zip(color) {
        let mixed = f32::from(*channel) + (f32::from(target) - f32::from(*channel)) * cover;
        *channel = mixed.round() as u8;
    }
}
