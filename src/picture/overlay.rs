//! What is written on a picture: the labels' names and the axes.

use glam::{Vec2, Vec3};
use image::RgbaImage;

use super::camera::{Camera, Frame};
use super::scene::{Paint, Scene};
use super::text::{Font, blend};

const INK: [u8; 3] = [58, 54, 50];
const AXES: [(&str, [u8; 3]); 3] =
    [("x", [178, 58, 52]), ("y", [62, 128, 62]), ("z", [48, 90, 168])];

/// Names beside their colours, on the right of the picture.
pub struct Legend<'a> {
    font: Font,
    paints: &'a [Paint],
    /// The width of the column, 0 without a legend.
    width: u32,
}

impl<'a> Legend<'a> {
    /// The legend of a scene: none for a single material, and at most a third
    /// of the picture.
    pub fn new(scene: &'a Scene, size: [u32; 2]) -> Self {
        let [width, _] = size;
        let font = Font::for_size(size);
        let paints: &[Paint] = if scene.materials.len() > 1 { &scene.materials } else { &[] };
        let longest = paints.iter().map(|paint| font.width(&paint.name)).max();
        let column = longest.map_or(0, |text| (text + 3 * font.line()).min(width / 3));
        Self { font, paints, width: column }
    }

    /// Where the shape goes.
    pub fn free_area(&self, [width, height]: [u32; 2]) -> Frame {
        let margin = 0.05 * width.min(height) as f32;
        let right = (width - self.width) as f32;
        Frame { min: Vec2::splat(margin), max: Vec2::new(right, height as f32) - margin }
    }

    /// Draws it in the middle of the right side; names too many for the height
    /// are left out, and the last line says how many.
    pub fn draw(&self, image: &mut RgbaImage) {
        let pitch = self.font.line() * 3 / 2;
        let room = (image.height() / pitch).saturating_sub(2) as usize;
        let shown =
            if self.paints.len() > room { room.saturating_sub(1) } else { self.paints.len() };
        let left = image.width().saturating_sub(self.width);
        let lines = shown + usize::from(shown < self.paints.len());
        let mut top = image.height().saturating_sub(pitch * lines as u32) / 2;
        let text_left = left + self.font.line() * 5 / 4;
        for paint in &self.paints[..shown] {
            let radius = self.font.line() as f32 * 0.36;
            let center =
                Vec2::new(left as f32 + radius, top as f32 + self.font.line() as f32 / 2.0);
            disc(image, center, radius, paint.color);
            self.font.draw(image, &self.fitting(&paint.name), [text_left, top], INK);
            top += pitch;
        }
        if shown < self.paints.len() {
            let rest = format!("and {} more", self.paints.len() - shown);
            self.font.draw(image, &self.fitting(&rest), [text_left, top], INK);
        }
    }

    /// The text, shortened to the column.
    fn fitting(&self, text: &str) -> String {
        let letter = self.font.width("x").max(1);
        let room = (self.width.saturating_sub(self.font.line() * 2) / letter).max(1) as usize;
        if text.chars().count() <= room {
            return text.to_owned();
        }
        text.chars().take(room.saturating_sub(2)).chain("..".chars()).collect()
    }
}

/// The directions of the axes, at the lower left.
pub fn draw_triad(image: &mut RgbaImage, camera: &Camera) {
    let font = Font::for_size(image.dimensions().into());
    let length = font.line() as f32 * 1.8;
    let corner = Vec2::new(length * 1.6, image.height() as f32 - length * 1.6);
    let mut axes: Vec<(Vec3, usize)> =
        (0..3).map(|axis| (camera.rotation * Vec3::AXES[axis], axis)).collect();
    // Those that point away are drawn first.
    axes.sort_by(|(one, _), (other, _)| one.z.total_cmp(&other.z));
    for (direction, axis) in axes {
        let (name, color) = AXES[axis];
        let arm = Vec2::new(direction.x, -direction.y) * length;
        segment(image, corner, corner + arm, font.line() as f32 / 9.0, color);
        let tip = corner + arm + arm.normalize_or_zero() * font.line() as f32 * 0.55;
        let origin = tip - Vec2::new(font.width(name) as f32, font.line() as f32) / 2.0;
        if origin.cmpge(Vec2::ZERO).all() {
            font.draw(image, name, [origin.x.round() as u32, origin.y.round() as u32], color);
        }
    }
}

fn disc(image: &mut RgbaImage, center: Vec2, radius: f32, color: [u8; 3]) {
    segment(image, center, center, radius * 2.0, color);
}

/// A line with round ends, smooth at its border.
fn segment(image: &mut RgbaImage, start: Vec2, end: Vec2, width: f32, color: [u8; 3]) {
    let low = (start.min(end) - width).max(Vec2::ZERO).as_uvec2();
    let high = (start.max(end) + width).max(Vec2::ZERO).as_uvec2();
    let along = end - start;
    for y in low.y..=high.y {
        for x in low.x..=high.x {
            let point = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let part = (point - start).dot(along) / along.length_squared().max(1e-9);
            let nearest = start + along * part.clamp(0.0, 1.0);
            let cover = width / 2.0 - point.distance(nearest) + 0.5;
            blend(image, [x, y], color, cover.clamp(0.0, 1.0));
        }
    }
}
