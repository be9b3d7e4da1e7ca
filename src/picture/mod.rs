//! Pictures of results: the surface in its labels' colours with the section
//! contours on it, drawn on the CPU alone, so that every machine makes the
//! same one.
//!
//! ```text
//! mesh, sections ─► Scene ─► View (camera) ─► bands: raster ─► shade ─► resolve ─► overlay
//!                                        └─► Occlusion (whole picture, one sample a pixel)
//! ```
//!
//! A material that hides another one completely is drawn as glass, so that a
//! body shows its organs. Bands are rendered independently of each other and
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
mod shade;
mod text;
mod view;

use std::io::{self, Write};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbaImage};

use crate::label::Material;
use crate::mesh::Mesh;
use crate::section::Section;

use scene::Scene;

/// How a picture is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PictureOptions {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Samples along each side of a pixel, whose colours are averaged.
    pub samples: u32,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self { size: [1600, 1200], samples: 3 }
    }
}

/// Renders a network of surfaces, with the contours of the sections on it,
/// from a direction that shows much of its shape; *z* points up.
///
/// An empty mesh gives a picture of the contours, and no sections either an
/// empty picture.
pub fn render(
    mesh: &Mesh,
    sections: &[Section],
    materials: &[Material],
    options: &PictureOptions,
) -> RgbaImage {
    let scene = Scene::new(mesh, sections, materials);
    let size = options.size.map(|side| side.max(1));
    let legend = overlay::Legend::new(&scene, size);
    let view = view::choose(&scene, legend.free_area(size));
    let mut image = band::draw(&scene, &view, size, options.samples.clamp(1, 8));
    legend.draw(&mut image);
    overlay::draw_triad(&mut image, &view);
    image
}

/// Renders a network as [`render`] does, from the same direction, but coloured
/// by a value at each vertex that is 0 or more: a distance in `unit`. What the
/// colours mean is written beside it. A vertex without a value counts as 0.
pub fn render_values(
    mesh: &Mesh,
    values: &[f32],
    unit: &str,
    sections: &[Section],
    options: &PictureOptions,
) -> RgbaImage {
    let mut scene = Scene::new(mesh, sections, &[]);
    let size = options.size.map(|side| side.max(1));
    let scale = scale::Scale::new(values, unit, size);
    let view = view::choose(&scene, scale.free_area(size));
    scene.paint(scale.paints(), |corners| {
        let values = corners.map(|vertex| values.get(vertex as usize).copied().unwrap_or(0.0));
        scale.color(values.iter().sum::<f32>() / 3.0)
    });
    let mut image = band::draw(&scene, &view, size, options.samples.clamp(1, 8));
    scale.draw(&mut image);
    overlay::draw_triad(&mut image, &view);
    image
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
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::label::Label;
    use crate::plane::Plane;
    use crate::section::Edge;
    use view::tests::{sphere, torus};

    /// A circle on z = height.
    fn circle(center: DVec2, radius: f64, height: f64, label: Label) -> Section {
        let count = 64u32;
        let point = |i: u32| {
            center + radius * DVec2::from_angle(std::f64::consts::TAU * f64::from(i) / 64.0)
        };
        Section {
            name: format!("z = {height}"),
            plane: Plane { normal: DVec3::Z, offset: height },
            vertices: (0..count).map(point).collect(),
            edges: (0..count)
                .map(|i| Edge {
                    start: i,
                    end: (i + 1) % count,
                    left: label,
                    right: Label::OUTSIDE,
                })
                .collect(),
            background: Label::OUTSIDE,
        }
    }

    fn two_shapes() -> (Mesh, Vec<Section>) {
        let mut builder = torus(DVec3::ZERO, 2.0, 0.6, [Label(1), Label(0)]);
        builder.append(sphere(DVec3::new(0.0, 0.0, 0.3), 1.0, [Label(2), Label(0)]));
        let sections = vec![
            circle(DVec2::ZERO, 2.6, 0.0, Label(1)),
            circle(DVec2::ZERO, 1.0, 0.3, Label(2)),
            circle(DVec2::ZERO, 0.8, 0.9, Label(2)),
        ];
        (builder.mesh, sections)
    }

    const SMALL: PictureOptions = PictureOptions { size: [320, 240], samples: 2 };

    /// The part of the picture's pixels whose strongest channel is `channel`,
    /// by a margin.
    fn part(image: &RgbaImage, channel: usize) -> f64 {
        let is_strong = |pixel: &image::Rgba<u8>| {
            (0..3).all(|other| other == channel || pixel[channel] > pixel[other].saturating_add(25))
        };
        let count = image.pixels().filter(|&pixel| is_strong(pixel)).count();
        count as f64 / f64::from(image.width() * image.height())
    }

    #[test]
    fn labels_appear_in_their_colours() {
        let (mesh, sections) = two_shapes();
        let material = |id, color| Material { id, name: format!("part {id}"), color };
        let materials = [material(1, [200, 40, 40]), material(2, [40, 40, 200])];
        let image = render(&mesh, &sections, &materials, &SMALL);
        assert!(part(&image, 0) > 0.15, "{}", part(&image, 0));
        assert!(part(&image, 2) > 0.05, "{}", part(&image, 2));
        assert!(part(&image, 1) < 0.01, "only an axis is green: {}", part(&image, 1));
    }

    #[test]
    fn values_appear_in_the_colours_of_the_scale() {
        let (mesh, sections) = two_shapes();
        // The torus is far from something, the sphere is not.
        let torus = mesh.vertices.iter().map(|vertex| vertex.truncate().length() > 1.05);
        let values: Vec<f32> = torus.map(|far| if far { 3.0 } else { 0.0 }).collect();
        let image = render_values(&mesh, &values, "voxels", &sections, &SMALL);
        let none = render_values(&mesh, &[], "voxels", &sections, &SMALL);
        // Dark purple and light grey; a grey is nearly the same in all channels.
        let far = |image: &RgbaImage| {
            image.pixels().filter(|pixel| i32::from(pixel[0]) > i32::from(pixel[1]) + 30).count()
        };
        assert!(far(&image) > far(&none) + 5000, "{} {}", far(&image), far(&none));
    }

    #[test]
    fn contours_darken_the_surface() {
        let (mesh, sections) = two_shapes();
        let dark = |sections: &[Section]| {
            let image = render(&mesh, sections, &[], &SMALL);
            image.pixels().filter(|pixel| pixel.0[..3].iter().all(|&c| c < 110)).count()
        };
        assert!(dark(&sections) > dark(&[]) + 100);
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let (mesh, sections) = two_shapes();
        let with_threads = |count| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(count)
                .build()
                .map(|pool| pool.install(|| render(&mesh, &sections, &[], &SMALL)))
                .map_err(|error| error.to_string())
        };
        assert_eq!(with_threads(1), with_threads(5));
    }

    #[test]
    fn nothing_gives_an_empty_picture_of_the_right_size() {
        let image = render(&Mesh::default(), &[], &[], &SMALL);
        assert_eq!(image.dimensions(), (320, 240));
        assert!(image.pixels().all(|pixel| pixel[3] == 255));
    }

    #[test]
    fn a_picture_far_from_the_origin_looks_the_same() {
        // As with map coordinates: 500 km east.
        let (mut mesh, _) = two_shapes();
        let near = render(&mesh, &[], &[], &SMALL);
        mesh.vertices.iter_mut().for_each(|point| point.x += 500_000.0);
        let far = render(&mesh, &[], &[], &SMALL);
        let differing = near
            .pixels()
            .zip(far.pixels())
            .filter(|(a, b)| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > 8));
        assert!(differing.count() < 20);
    }

    #[test]
    fn the_written_file_is_that_picture() {
        let (mesh, sections) = two_shapes();
        let image = render(&mesh, &sections, &[], &SMALL);
        let mut file = Vec::new();
        write_png(&image, &mut file).expect("writing to memory");
        let read = image::load_from_memory(&file).expect("a valid PNG").to_rgba8();
        assert_eq!(read, image);
    }
}
