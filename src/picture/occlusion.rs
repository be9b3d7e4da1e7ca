//! How much of the sky each place sees: ambient occlusion from a depth buffer
//! with one sample for 2 × 2 pixels.

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::camera::Camera;
use super::raster::{NOTHING, Target, edge_functions};
use super::scene::Scene;

/// Points looked at around each pixel.
const PROBES: usize = 24;
/// How far away something can occlude, over the scene's diagonal.
const REACH: f32 = 0.14;

/// The size of the depth buffer over that of the picture.
const SCALE: f32 = 0.5;

/// The part of the sky that is free, pixel by pixel of the smaller buffer.
pub struct Occlusion {
    width: usize,
    height: usize,
    near: Vec<f32>,
    free: Vec<f32>,
}

impl Occlusion {
    /// Looks at the solid layer alone, in a picture of this size.
    pub fn new(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Self {
        let camera = &camera.scaled(SCALE);
        let [width, height] = size.map(|side| (side as f32 * SCALE).ceil() as u32);
        let (depth, normals) = depth_and_normals(scene, camera, [width, height]);
        let probing =
            Probing { camera, width, height, near: &depth, reach: scene.diagonal * REACH };
        let rough: Vec<f32> = (0..depth.len())
            .into_par_iter()
            .map(|pixel| if depth[pixel] > 0.0 { probing.free(pixel, normals[pixel]) } else { 1.0 })
            .collect();
        let [width, height] = [width as usize, height as usize];
        let mut occlusion = Self { width, height, near: depth, free: rough };
        occlusion.free = occlusion.smoothed();
        occlusion
    }

    /// The free part at a place in the picture's pixels, from the neighbouring pixel whose
    /// distance fits best, so that nothing bleeds over silhouettes.
    pub fn at(&self, place: Vec2, near: f32) -> f32 {
        let corner = place * SCALE - 0.5;
        let mut sum = (0.0, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let column = (corner.x.floor() as i64 + dx).clamp(0, self.width as i64 - 1);
            let row = (corner.y.floor() as i64 + dy).clamp(0, self.height as i64 - 1);
            let pixel = row as usize * self.width + column as usize;
            let apart = (Vec2::new(column as f32, row as f32) - corner).abs().min(Vec2::ONE);
            let fit = 1.0 / (1e-4 + (self.near[pixel] / near - 1.0).abs());
            let weight = ((1.0 - apart.x) * (1.0 - apart.y) + 0.01) * fit * fit;
            sum = (sum.0 + weight * self.free[pixel], sum.1 + weight);
        }
        sum.0 / sum.1
    }

    /// The mean over the 4 × 4 pixels in which every turn of the probes occurs
    /// once, over those at about the same distance.
    fn smoothed(&self) -> Vec<f32> {
        let mean = |pixel: usize| {
            let (column, row) = (pixel % self.width, pixel / self.width);
            let mut sum = (0.0, 0.0);
            for y in row.saturating_sub(2)..(row + 2).min(self.height) {
                for x in column.saturating_sub(2)..(column + 2).min(self.width) {
                    let other = y * self.width + x;
                    if (self.near[other] / self.near[pixel] - 1.0).abs() < 0.02 {
                        sum = (sum.0 + self.free[other], sum.1 + 1.0);
                    }
                }
            }
            if sum.1 > 0.0 { sum.0 / sum.1 } else { 1.0 }
        };
        (0..self.free.len()).into_par_iter().map(mean).collect()
    }
}

/// One over the distance and the normal in the camera's space at each pixel.
fn depth_and_normals(
    scene: &Scene,
    camera: &Camera,
    [width, height]: [u32; 2],
) -> (Vec<f32>, Vec<Vec3>) {
    let screen: Vec<_> =
        scene.points.par_iter().map(|&point| camera.screen(camera.place(point), 1.0)).collect();
    let mut target = Target::new(width, 0..height);
    let facets = &scene.solid.facets;
    for (number, facet) in facets.iter().enumerate() {
        target.fill(number as u32, facet.corners.map(|vertex| screen[vertex as usize]));
    }
    let normal_at = |pixel: usize| {
        let id = target.id[pixel];
        if id == NOTHING {
            return Vec3::Z;
        }
        let corners = facets[id as usize].corners.map(|vertex| screen[vertex as usize]);
        let (column, row) = (pixel as u32 % width, pixel as u32 / width);
        let edges = edge_functions(corners, column as i32, row as i32);
        let normals = scene.solid.normals[id as usize];
        let sum: Vec3 = (0..3).map(|i| normals[i] * (edges[i] as f32 * corners[i].near)).sum();
        let sign = if edges.iter().sum::<i64>() < 0 { -1.0 } else { 1.0 };
        camera.rotation * (sum * sign).normalize_or(Vec3::Z)
    };
    let normals = (0..target.id.len()).into_par_iter().map(normal_at).collect();
    (target.near, normals)
}

struct Probing<'a> {
    camera: &'a Camera,
    width: u32,
    height: u32,
    near: &'a [f32],
    reach: f32,
}

impl Probing<'_> {
    fn free(&self, pixel: usize, normal: Vec3) -> f32 {
        let (column, row) = (pixel as u32 % self.width, pixel as u32 / self.width);
        let center = Vec2::new(column as f32 + 0.5, row as f32 + 0.5);
        let place = self.camera.unproject(center, 1.0 / self.near[pixel]);
        let (first, second) = normal.any_orthonormal_pair();
        let turn = TURNS[(row % 4) as usize][(column % 4) as usize] / 16.0;
        let occluded: f32 = (0..PROBES)
            .map(|number| {
                let [a, b, up, distance] = probe(number, turn);
                let arm = (first * a + second * b + normal * up) * (distance * self.reach);
                self.occlusion(place, place + arm + normal * (0.01 * self.reach))
            })
            .sum();
        1.0 - occluded / PROBES as f32
    }

    /// Whether something lies in front of a probe, fading out where it is so
    /// far in front that it need not be what shades the place.
    fn occlusion(&self, place: Vec3, probe: Vec3) -> f32 {
        let at = self.camera.pixel(probe);
        if at.x < 0.0 || at.y < 0.0 || at.x >= self.width as f32 || at.y >= self.height as f32 {
            return 0.0;
        }
        let near = self.near[at.y as usize * self.width as usize + at.x as usize];
        if near <= 0.0 {
            return 0.0;
        }
        let ahead = -probe.z - 1.0 / near;
        if ahead <= 0.002 * self.reach {
            return 0.0;
        }
        let gap = (1.0 / near + place.z).abs() / self.reach;
        (1.5 - gap).clamp(0.0, 1.0)
    }
}

/// An ordered dither: every sixteenth of a turn once in 4 × 4 pixels.
const TURNS: [[f32; 4]; 4] =
    [[0.0, 8.0, 2.0, 10.0], [12.0, 4.0, 14.0, 6.0], [3.0, 11.0, 1.0, 9.0], [15.0, 7.0, 13.0, 5.0]];

/// A direction over the hemisphere by cosine, and a distance in (0, 1): most
/// probes are close.
fn probe(number: usize, turn: f32) -> [f32; 4] {
    const GOLDEN_TURN: f32 = 0.618_034;
    let part = (number as f32 + 0.5) / PROBES as f32;
    let angle = std::f32::consts::TAU * (number as f32 * GOLDEN_TURN + turn);
    let flat = part.sqrt();
    // Distances in another order than heights.
    let order = ((number * 13) % PROBES) as f32 + 0.5 + (turn - 0.5) * 0.9;
    let distance = (order / PROBES as f32).clamp(0.01, 1.0).powf(1.5);
    [flat * angle.cos(), flat * angle.sin(), (1.0 - part).sqrt(), distance]
}
