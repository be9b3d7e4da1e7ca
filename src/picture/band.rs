//! The picture band by band: rows of samples, shaded and averaged to pixels.

use std::ops::Range;

use glam::{Vec2, Vec3};
use image::RgbaImage;
use rayon::prelude::*;

use super::camera::Camera;
use super::occlusion::Occlusion;
use super::raster::{NOTHING, ScreenPoint, Target, edge_functions, rows};
use super::scene::{Layer, Scene, Stroke};
use super::shade;
use super::text::scale;
use crate::color::{encode, linear};

/// Rows of pixels in a band.
const BAND: u32 = 24;
/// The width of a contour, over the picture's [`scale`].
const STROKE: f32 = 1.0 / 700.0;
/// How much nearer than it is a contour is drawn, over the scene's diagonal:
/// a surface that misses its contour by a voxel still shows it.
const STROKE_LIFT: f32 = 0.006;

/// Draws the scene without legend and axes.
pub fn draw(scene: &Scene, camera: &Camera, size: [u32; 2], samples: u32) -> RgbaImage {
    let [width, height] = size;
    let canvas = Canvas::new(scene, camera, size, samples);
    let bands: Vec<Vec<u8>> = (0..height.div_ceil(BAND))
        .into_par_iter()
        .map(|number| canvas.band(number * BAND..((number + 1) * BAND).min(height)))
        .collect();
    RgbaImage::from_vec(width, height, bands.concat()).unwrap_or_default()
}

/// Everything projected.
struct Canvas<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    size: [u32; 2],
    /// Along a pixel's side.
    samples: u32,
    occlusion: Occlusion,
    /// The scene's points, in samples.
    screen: Vec<ScreenPoint>,
    /// The solid one first.
    layers: Vec<Projected<'a>>,
    /// Linear colours by material.
    albedo: Vec<Vec3>,
}

struct Projected<'a> {
    layer: &'a Layer,
    /// The rows of samples of each facet.
    spans: Vec<Range<i32>>,
    /// The strokes.
    quads: Vec<[ScreenPoint; 4]>,
}

impl<'a> Canvas<'a> {
    fn new(scene: &'a Scene, camera: &'a Camera, size: [u32; 2], samples: u32) -> Self {
        let project = |&point: &Vec3| camera.screen(camera.place(point), samples as f32);
        let screen: Vec<ScreenPoint> = scene.points.par_iter().map(project).collect();
        let quad = Quad { camera, samples: samples as f32, diagonal: scene.diagonal, size };
        let layers = scene
            .layers()
            .map(|layer| Projected {
                layer,
                spans: layer
                    .facets
                    .par_iter()
                    .map(|facet| rows(facet.corners.map(|vertex| screen[vertex as usize])))
                    .collect(),
                quads: layer.strokes.iter().map(|stroke| quad.around(stroke.ends)).collect(),
            })
            .collect();
        let occlusion = Occlusion::new(scene, camera, size);
        let albedo = scene.materials.iter().map(|paint| linear(paint.color)).collect();
        Self { scene, camera, size, samples, occlusion, screen, layers, albedo }
    }

    /// The pixels of some rows.
    fn band(&self, rows: Range<u32>) -> Vec<u8> {
        let [width, _] = self.size;
        let samples = self.samples;
        let sample_rows = rows.start * samples..rows.end * samples;
        let targets: Vec<Target> =
            self.layers.iter().map(|layer| self.fill(layer, sample_rows.clone())).collect();
        let mut pixels = Vec::with_capacity(rows.len() * width as usize * 4);
        let mut seen: Vec<(usize, Vec3)> = Vec::new();
        for row in rows.clone() {
            for column in 0..width {
                let light = self.pixel(&targets, [column, row], sample_rows.start, &mut seen);
                pixels.extend(encode(light));
            }
        }
        pixels
    }

    /// The mean light over a pixel. What several samples see alike is shaded
    /// once, where the first of them lies.
    fn pixel(
        &self,
        targets: &[Target],
        [column, row]: [u32; 2],
        first_row: u32,
        seen: &mut Vec<(usize, Vec3)>,
    ) -> Vec3 {
        let samples = self.samples;
        let pitch = (self.size[0] * samples) as usize;
        let alike = |one: usize, other: usize| {
            targets.iter().all(|target| target.id[one] == target.id[other])
        };
        seen.clear();
        let mut sum = Vec3::ZERO;
        for y in row * samples..(row + 1) * samples {
            for x in column * samples..(column + 1) * samples {
                let index = (y - first_row) as usize * pitch + x as usize;
                let known = seen.iter().find(|&&(other, _)| alike(index, other));
                let light = known.map_or_else(|| self.sample(targets, index, [x, y]), |&(_, l)| l);
                if known.is_none() {
                    seen.push((index, light));
                }
                sum += light;
            }
        }
        sum / (samples * samples) as f32
    }

    fn fill(&self, projected: &Projected, rows: Range<u32>) -> Target {
        let mut target = Target::new(self.size[0] * self.samples, rows.clone());
        let facets = &projected.layer.facets;
        for (number, span) in projected.spans.iter().enumerate() {
            if span.start < rows.end as i32 && span.end > rows.start as i32 {
                let corners = facets[number].corners.map(|vertex| self.screen[vertex as usize]);
                target.fill(number as u32, corners);
            }
        }
        for (number, &[a, b, c, d]) in projected.quads.iter().enumerate() {
            let id = (facets.len() + number) as u32;
            target.fill(id, [a, b, c]);
            target.fill(id, [a, c, d]);
        }
        target
    }

    /// The light at a sample.
    fn sample(&self, targets: &[Target], index: usize, at: [u32; 2]) -> Vec3 {
        let [_, height] = self.size;
        let samples = self.samples as f32;
        let mut light = match targets[0].id[index] {
            NOTHING => shade::background((at[1] as f32 / samples) / height as f32),
            id => self.solid(id, at, targets[0].near[index]),
        };
        let front = targets[0].near[index];
        let mut glass: Vec<(f32, usize)> = Vec::new();
        for (number, target) in targets.iter().enumerate().skip(1) {
            if target.id[index] != NOTHING && target.near[index] > front {
                glass.push((target.near[index], number));
            }
        }
        glass.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (_, number) in glass {
            let (color, cover) = self.glass(number, targets[number].id[index], at);
            light = light.lerp(color, cover);
        }
        light
    }

    fn solid(&self, id: u32, at: [u32; 2], near: f32) -> Vec3 {
        let layer = &self.scene.solid;
        let Some(facet) = layer.facets.get(id as usize) else {
            let stroke = &layer.strokes[id as usize - layer.facets.len()];
            return self.stroke(stroke);
        };
        let place = Vec2::new(at[0] as f32 + 0.5, at[1] as f32 + 0.5) / self.samples as f32;
        let to_eye = -self.camera.unproject(place, 1.0).normalize();
        let normal = self.normal(layer, id, at);
        let free = self.occlusion.at(place, near);
        shade::surface(self.albedo[usize::from(facet.material)], normal, to_eye, free)
    }

    fn glass(&self, number: usize, id: u32, at: [u32; 2]) -> (Vec3, f32) {
        let layer = &self.scene.glass[number - 1];
        let Some(facet) = layer.facets.get(id as usize) else {
            let stroke = &layer.strokes[id as usize - layer.facets.len()];
            return (self.stroke(stroke), shade::GLASS_STROKE);
        };
        let place = Vec2::new(at[0] as f32 + 0.5, at[1] as f32 + 0.5) / self.samples as f32;
        let to_eye = -self.camera.unproject(place, 1.0).normalize();
        let normal = self.normal(layer, id, at);
        shade::glass(self.albedo[usize::from(facet.material)], normal, to_eye)
    }

    fn stroke(&self, stroke: &Stroke) -> Vec3 {
        match stroke.material {
            Some(material) => shade::stroke(self.albedo[usize::from(material)]),
            None => shade::unknown_stroke(),
        }
    }

    /// The normal in the camera's space, linear over the facet in space.
    fn normal(&self, layer: &Layer, id: u32, [column, row]: [u32; 2]) -> Vec3 {
        let corners = layer.facets[id as usize].corners.map(|v| self.screen[v as usize]);
        let normals = layer.normals[id as usize];
        let edges = edge_functions(corners, column as i32, row as i32).map(|edge| edge as f32);
        let sum: Vec3 = (0..3).map(|i| normals[i] * (edges[i] * corners[i].near)).sum();
        let sign = edges.iter().sum::<f32>().signum();
        self.camera.rotation * (sum * sign).normalize_or(normals[0])
    }
}

/// Makes a contour's piece a thin quadrilateral that faces the viewer.
struct Quad<'a> {
    camera: &'a Camera,
    samples: f32,
    diagonal: f32,
    size: [u32; 2],
}

impl Quad<'_> {
    fn around(&self, ends: [Vec3; 2]) -> [ScreenPoint; 4] {
        let lift = self.diagonal * STROKE_LIFT;
        let [a, b] = ends.map(|end| self.camera.place(end));
        let [p, q] = [a, b].map(|place| self.camera.pixel(place));
        let half = (scale(self.size) * STROKE / 2.0).max(0.4);
        let along = (q - p).normalize_or(Vec2::X) * half;
        let across = along.perp();
        let corner = |at: Vec2, place: Vec3| {
            let distance = (-place.z - lift).max(f32::MIN_POSITIVE);
            ScreenPoint::new(at * self.samples, 1.0 / distance)
        };
        // Half a width longer at both ends, so that corners close.
        let (p, q) = (p - along * 0.5, q + along * 0.5);
        [corner(p - across, a), corner(q - across, b), corner(q + across, b), corner(p + across, a)]
    }
}
