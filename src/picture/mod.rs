//! Pictures of results: the surface in its labels' colours with the section
//! contours on it, drawn on the CPU alone, so that every machine makes the
//! same one.
//!
//! ```text
//! mesh, sections ─► Scene ─► Camera ─► bands: raster ─► shade ─► resolve ─► overlay
//!                                 └─► Occlusion (whole picture, one sample a pixel)
//! ```
//!
//! A material that hides another one completely is drawn as glass, so that a
//! body shows its organs. What is up and which side is the front follows from the
//! sections (`sides`). Bands are rendered independently of each other and
//! triangles within a band in their order: the picture does not depend on the
//! number of threads.

mod band;
mod camera;
mod normals;
mod occlusion;
mod overlay;
mod raster;
mod scale;
mod scene;
mod selection;
mod shade;
mod text;
mod view;
mod viewpoint;

use std::io::{self, Write};
use std::ops::RangeInclusive;

use glam::DVec3;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, Rgba, RgbaImage};

use crate::direction;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::section::Sections;
use crate::sides::Sides;

use camera::{Camera, Frame};
use scene::Scene;
use selection::Selection;

pub use viewpoint::{Side, Viewpoint, parse_direction};

/// The sides that a picture may have, in pixels.
pub const SIDES: RangeInclusive<u32> = 16..=16_384;
/// The most pixels that a picture may have: some 20 bytes are needed for each.
pub const MOST_PIXELS: u64 = 40_000_000;

/// How a picture is made.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureOptions {
    /// Width and height in pixels, within [`SIDES`] and [`MOST_PIXELS`].
    pub size: [u32; 2],
    /// Samples along each side of a pixel, whose colours are averaged.
    pub samples: u32,
    /// From where; `None` for a direction that shows much of the shape.
    pub view: Option<Viewpoint>,
    /// Which way is up; `None` for what the sections call so: what their file
    /// says, superior in an anatomical frame ("LPS"), the axis of parallel
    /// sections whose pile is taller than wide, or else z.
    pub up: Option<DVec3>,
    /// The materials that are drawn, with their contours; `None` for all.
    pub labels: Option<Vec<Label>>,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { size: [1600, 1200], samples: 3, view: None, up: None, labels: None }
    }
}

impl PictureOptions {
    /// The sides of what is drawn.
    pub(crate) fn sides(&self, sections: &Sections) -> Sides {
        let sides = Sides::of(sections);
        self.up.map_or(sides, |up| sides.standing(up))
    }

    fn camera(&self, scene: &Scene, sections: &Sections, frame: Frame) -> Camera {
        let sides = self.sides(sections);
        let direction = self.view.as_ref().map(|view| view.direction(&sides));
        match direction.and_then(direction::unit) {
            Some(direction) => view::look(scene, &sides, direction.as_vec3(), frame),
            None => view::choose(scene, &sides, frame),
        }
    }
}

/// Renders a network of surfaces, with the contours of the sections on it.
///
/// An empty mesh gives a picture of the contours, and no sections either an
/// empty picture.
///
/// # Panics
/// Where `options` ask for more pixels than memory holds.
pub fn render(mesh: &Mesh, sections: &Sections, options: &PictureOptions) -> RgbaImage {
    let selection = Selection(options.labels.as_deref());
    let scene = Scene::new(mesh, &sections.sections, &sections.materials, selection);
    let size = options.size.map(|side| side.max(1));
    let legend = overlay::Legend::new(&scene, size);
    let camera = options.camera(&scene, sections, legend.free_area(size));
    let mut image = band::draw(&scene, &camera, size, options.samples.clamp(1, 8));
    legend.draw(&mut image);
    overlay::draw_triad(&mut image, &camera);
    image
}

/// Renders a network as [`render`] does, all labels alike, but coloured by a
/// value at each vertex that is 0 or more: a distance in `unit`. What the
/// colours mean is written beside it. A vertex without a value counts as 0.
pub fn render_values(
    mesh: &Mesh,
    values: &[f32],
    unit: &str,
    sections: &Sections,
    options: &PictureOptions,
) -> RgbaImage {
    let mut scene = Scene::new(mesh, &sections.sections, &[], Selection::default());
    let size = options.size.map(|side| side.max(1));
    let scale = scale::Scale::new(values, unit, size);
    let camera = options.camera(&scene, sections, scale.free_area(size));
    scene.paint(scale.paints(), |corners| {
        let values = corners.map(|vertex| values.get(vertex as usize).copied().unwrap_or(0.0));
        scale.color(values.iter().sum::<f32>() / 3.0)
    });
    let mut image = band::draw(&scene, &camera, size, options.samples.clamp(1, 8));
    scale.draw(&mut image);
    overlay::draw_triad(&mut image, &camera);
    image
}

/// From where [`render`] looks, to look at other results the same way.
pub fn viewpoint(mesh: &Mesh, sections: &Sections, options: &PictureOptions) -> Viewpoint {
    let selection = Selection(options.labels.as_deref());
    let scene = Scene::new(mesh, &sections.sections, &sections.materials, selection);
    let size = options.size.map(|side| side.max(1));
    let legend = overlay::Legend::new(&scene, size);
    let camera = options.camera(&scene, sections, legend.free_area(size));
    Viewpoint::Direction(camera.towards().as_dvec3())
}

/// The materials of a network that pictures draw as glass, since they hide others.
pub(crate) fn glass(mesh: &Mesh) -> Vec<Label> {
    scene::glass_of(mesh)
}

/// Pictures of one size with their titles, in rows.
pub fn side_by_side(pictures: &[(String, RgbaImage)]) -> RgbaImage {
    let Some((_, first)) = pictures.first() else { return RgbaImage::default() };
    let [width, height] = [first.width(), first.height()];
    let columns = (pictures.len() as f64).sqrt().ceil() as usize;
    let rows = pictures.len().div_ceil(columns);
    let size = [columns as u32 * width, rows as u32 * height];
    let mut all = RgbaImage::from_pixel(size[0], size[1], Rgba([255; 4]));
    let font = text::Font::for_size([width, height]);
    for (number, (title, picture)) in pictures.iter().enumerate() {
        let [x, y] = [number % columns, number / columns].map(|place| place as u32);
        image::imageops::replace(&mut all, picture, (x * width).into(), (y * height).into());
        let margin = font.line() / 2;
        font.draw(&mut all, title, [x * width + margin, y * height + margin], [40; 3]);
    }
    all
}

/// Writes a picture as PNG.
///
/// # Errors
/// When `out` does.
pub fn write_png(image: &RgbaImage, out: &mut dyn Write) -> io::Result<()> {
    PngEncoder::new(out)
        .write_image(image.as_raw(), image.width(), image.height(), ExtendedColorType::Rgba8)
        .map_err(io::Error::other)
}

#[cfg(test)]
mod tests;
