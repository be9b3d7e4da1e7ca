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
    let [width, height] = options.size.map(|side| side.max(1));
    let legend = overlay::Legend::new(&scene, [width, height]);
    let frame = legend.free_area([width, height]);
    let view = view::choose(&scene, frame);
    let mut image = band::draw(&scene, &view, [width, height], options.samples.clamp(1, 8));
    legend.draw(&mut image);
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

    #[test]
    fn scratch() {
        let (mesh, sections) = two_shapes();
        let t = std::time::Instant::now();
        let image = render(&mesh, &sections, &[], &PictureOptions::default());
        eprintln!("{:?}", t.elapsed());
        write_png(&image, &mut std::fs::File::create("/tmp/h6_a.png").unwrap()).unwrap();
        let mut b = sphere(DVec3::ZERO, 4.0, [Label(3), Label(0)]);
        b.append(view::tests::Builder { mesh });
        for s in &mut b.mesh.sides { if s[1] == Label(0) && s[0] != Label(3) { s[1] = Label(3); } }
        let image = render(&b.mesh, &sections, &[], &PictureOptions::default());
        write_png(&image, &mut std::fs::File::create("/tmp/h6_b.png").unwrap()).unwrap();
        let m = view::tests::turned(1000, 500, [Label(1), Label(0)], |t, a| { let r = 0.6 + 0.1 * (12.0 * t).sin() * (5.0 * a).cos(); let o = 2.0 + r * a.cos(); DVec3::new(o * t.cos(), o * t.sin(), r * a.sin()) });
        let t = std::time::Instant::now();
        let image = render(&m.mesh, &[], &[], &PictureOptions::default());
        eprintln!("1M {:?}", t.elapsed());
        write_png(&image, &mut std::fs::File::create("/tmp/h6_c.png").unwrap()).unwrap();
    }
}
