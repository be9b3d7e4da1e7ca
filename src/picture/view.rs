//! Which direction shows the shape.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::camera::{Camera, Frame};
use super::raster::{NOTHING, Target};
use super::scene::{Facet, Scene};
use crate::sides::Sides;

/// Directions around the body's axis, and their heights above its middle.
const TURNS: usize = 12;
const HEIGHTS: [f32; 2] = [0.2, 0.55];
/// What the front is worth.
const FRONT: f32 = 0.05;
/// The longer side of a trial picture, in pixels.
const TRIAL_SIDE: f32 = 120.0;

/// The camera among two dozen candidates whose picture shows most: projected
/// area, relief, and each material's share of what could be seen of it.
/// The first of equals wins.
pub fn choose(scene: &Scene, sides: &Sides, frame: Frame) -> Camera {
    let coarse = Coarse::new(scene);
    let directions = candidates(sides);
    let trials: Vec<Trial> = directions
        .par_iter()
        .map(|&direction| Trial::new(&coarse, sides.rotation(direction), frame))
        .collect();
    look(scene, sides, directions[Trial::best_of(&trials)], frame)
}

/// The camera that sees all of the scene from a direction.
pub fn look(scene: &Scene, sides: &Sides, direction: Vec3, frame: Frame) -> Camera {
    let ends = scene.layers().flat_map(|layer| &layer.strokes).flat_map(|stroke| stroke.ends);
    let points: Vec<Vec3> = scene.points.iter().copied().chain(ends).collect();
    Camera::fit(sides.rotation(direction), &points, frame)
}

/// The solid layer with vertices merged that lie close together: as much as a
/// small picture needs.
struct Coarse {
    points: Vec<Vec3>,
    facets: Vec<Facet>,
    materials: usize,
    diagonal: f32,
}

impl Coarse {
    /// Cells along the diagonal within which vertices become one.
    const CELLS: f32 = 100.0;

    fn new(scene: &Scene) -> Self {
        let side = scene.diagonal / Self::CELLS;
        let mut cells: HashMap<[i32; 3], u32> = HashMap::new();
        let mut points = Vec::new();
        let merged: Vec<u32> = scene
            .points
            .iter()
            .map(|&point| {
                *cells.entry((point / side).floor().as_ivec3().to_array()).or_insert_with(|| {
                    points.push(point);
                    points.len() as u32 - 1
                })
            })
            .collect();
        let facets = scene
            .solid
            .facets
            .iter()
            .map(|facet| Facet { corners: facet.corners.map(|v| merged[v as usize]), ..*facet })
            .filter(|Facet { corners: [a, b, c], .. }| a != b && b != c && c != a)
            .collect();
        Self { points, facets, materials: scene.materials.len(), diagonal: scene.diagonal }
    }
}

/// Candidates, beginning a little to the side of the front.
fn candidates(sides: &Sides) -> Vec<Vec3> {
    let [up, front, right] = sides.seen();
    let turn = |i: usize| TAU * (i as f32 + 0.5) / TURNS as f32;
    HEIGHTS
        .iter()
        .flat_map(|&height| (0..TURNS).map(move |i| (height, turn(i))))
        .map(|(height, angle)| right * angle.sin() + front * angle.cos() + up * height)
        .map(Vec3::normalize)
        .collect()
}

/// What a small picture of the solid layer shows.
#[derive(Debug, Default)]
struct Trial {
    /// Covered area, in squares of the scene's diagonal.
    area: f32,
    /// The mean step in distance between neighbouring pixels, where a large
    /// step counts as one of a fiftieth of the diagonal.
    relief: f32,
    /// The area by material.
    materials: Vec<f32>,
}

impl Trial {
    fn new(scene: &Coarse, rotation: Mat3, frame: Frame) -> Self {
        let scale = TRIAL_SIDE / (frame.max - frame.min).max_element().max(1.0);
        let size = (frame.max - frame.min) * scale;
        let small = Frame { min: glam::Vec2::ZERO, max: size };
        let camera = Camera::fit(rotation, &scene.points, small);
        let [width, height] = [size.x.ceil() as u32, size.y.ceil() as u32];
        let mut target = Target::new(width, 0..height);
        let screen: Vec<_> =
            scene.points.iter().map(|&point| camera.screen(camera.place(point), 1.0)).collect();
        for (number, facet) in scene.facets.iter().enumerate() {
            target.fill(number as u32, facet.corners.map(|vertex| screen[vertex as usize]));
        }
        Self::measure(scene, &target, width as usize, camera.focal)
    }

    fn measure(scene: &Coarse, target: &Target, width: usize, focal: f32) -> Self {
        let mut trial = Self { materials: vec![0.0; scene.materials], ..Self::default() };
        let cap = scene.diagonal / 50.0;
        for (pixel, &id) in target.id.iter().enumerate().filter(|&(_, &id)| id != NOTHING) {
            let distance = 1.0 / target.near[pixel];
            let area = (distance / focal / scene.diagonal).powi(2);
            trial.area += area;
            let material = scene.facets[id as usize].material;
            trial.materials[usize::from(material)] += area;
            for neighbor in [pixel + 1, pixel + width] {
                if target.near.get(neighbor).is_some_and(|&near| near > 0.0) {
                    let step = (1.0 / target.near[neighbor] - distance).abs();
                    trial.relief += area * step.min(cap) / cap;
                }
            }
        }
        trial
    }

    fn best_of(trials: &[Self]) -> usize {
        let most = |value: &dyn Fn(&Self) -> f32| {
            trials.iter().map(value).fold(f32::MIN_POSITIVE, f32::max)
        };
        let (area, relief) = (most(&|trial| trial.area), most(&|trial| trial.relief));
        let count = trials.first().map_or(0, |trial| trial.materials.len());
        let shares: Vec<f32> =
            (0..count).map(|i| most(&|trial: &Self| trial.materials[i])).collect();
        let score = |trial: &Self| {
            let seen: f32 = trial.materials.iter().zip(&shares).map(|(one, all)| one / all).sum();
            trial.area / area + 0.5 * trial.relief / relief + 1.5 * seen / count.max(1) as f32
        };
        let mut best = (f32::NEG_INFINITY, 0);
        for (number, trial) in trials.iter().enumerate() {
            // All else about equal, from the front.
            let score = score(trial) + FRONT * (TAU * (number as f32 + 0.5) / TURNS as f32).cos();
            if score > best.0 {
                best = (score, number);
            }
        }
        best.1
    }
}

#[cfg(test)]
pub(in crate::picture) mod tests {
    use super::*;
    use crate::label::Label;
    use crate::mesh::Mesh;
    use crate::picture::selection::Selection;
    use crate::section::Sections;
    use glam::{DVec3, Vec2};

    /// A mesh under construction.
    pub struct Builder {
        /// The mesh so far.
        pub mesh: Mesh,
    }

    impl Builder {
        /// Adds another mesh beside this one.
        pub fn append(&mut self, other: Self) {
            let shift = self.mesh.vertices.len() as u32;
            self.mesh.vertices.extend(other.mesh.vertices);
            self.mesh.sides.extend(other.mesh.sides);
            let triangles = other.mesh.triangles.iter();
            self.mesh.triangles.extend(triangles.map(|corners| corners.map(|v| v + shift)));
        }

        /// Triangles the other way round.
        pub fn flipped(mut self) -> Self {
            self.mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
            self
        }
    }

    /// A closed surface over a grid of two angles.
    pub fn turned(
        rings: u32,
        segments: u32,
        sides: [Label; 2],
        position: impl Fn(f64, f64) -> DVec3,
    ) -> Builder {
        let tau = std::f64::consts::TAU;
        let mut mesh = Mesh::default();
        for ring in 0..rings {
            for segment in 0..segments {
                let angle = |i: u32, n: u32| tau * f64::from(i) / f64::from(n);
                mesh.vertices.push(position(angle(ring, rings), angle(segment, segments)));
            }
        }
        let at = |ring: u32, segment: u32| (ring % rings) * segments + segment % segments;
        for ring in 0..rings {
            for segment in 0..segments {
                let [a, b] = [at(ring, segment), at(ring + 1, segment)];
                let [c, d] = [at(ring + 1, segment + 1), at(ring, segment + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
                mesh.sides.extend([sides; 2]);
            }
        }
        Builder { mesh }
    }

    /// A torus about the z axis, its normals outward.
    pub fn torus(center: DVec3, radius: f64, tube: f64, sides: [Label; 2]) -> Builder {
        turned(96, 48, sides, |turn, around| {
            let out = radius + tube * around.cos();
            center + DVec3::new(out * turn.cos(), out * turn.sin(), tube * around.sin())
        })
    }

    /// A sphere from a cube whose faces are split and blown up.
    pub fn sphere(center: DVec3, radius: f64, sides: [Label; 2]) -> Builder {
        let n = 24u32;
        let mut mesh = Mesh::default();
        for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let start = mesh.vertices.len() as u32;
            for i in 0..=n {
                for j in 0..=n {
                    let angle =
                        |k: u32| (f64::from(k) / f64::from(n) - 0.5) * std::f64::consts::FRAC_PI_2;
                    let mut point = DVec3::ZERO;
                    point[axis] = sign;
                    point[(axis + 1) % 3] = sign * angle(i).tan();
                    point[(axis + 2) % 3] = angle(j).tan();
                    mesh.vertices.push(center + radius * point.normalize());
                }
            }
            let at = |i: u32, j: u32| start + i * (n + 1) + j;
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
                mesh.sides.extend([sides; 2]);
            }
        }
        Builder { mesh }
    }

    #[test]
    fn a_flat_shape_is_seen_from_its_broad_side() {
        // A disc in the xz plane: seen from ±y, not edge-on from ±x.
        let mut builder = sphere(DVec3::ZERO, 1.0, [Label(1), Label(0)]);
        builder.mesh.vertices.iter_mut().for_each(|point| point.y *= 0.1);
        let scene = Scene::new(&builder.mesh, &[], &[], Selection::default());
        let frame = Frame { min: Vec2::ZERO, max: Vec2::new(400.0, 300.0) };
        let toward_viewer =
            choose(&scene, &Sides::of(&Sections::default()), frame).rotation.transpose() * Vec3::Z;
        assert!(toward_viewer.y.abs() > 2.0 * toward_viewer.x.abs(), "{toward_viewer}");
    }

    #[test]
    fn the_direction_is_chosen_around_what_is_up() {
        // A disc in the xy plane: with y up it is seen from ±z.
        let mut builder = sphere(DVec3::ZERO, 1.0, [Label(1), Label(0)]);
        builder.mesh.vertices.iter_mut().for_each(|point| point.z *= 0.1);
        let scene = Scene::new(&builder.mesh, &[], &[], Selection::default());
        let frame = Frame { min: Vec2::ZERO, max: Vec2::new(400.0, 300.0) };
        let sides = Sides::of(&Sections::default()).standing(DVec3::Y);
        let rotation = choose(&scene, &sides, frame).rotation;
        let toward_viewer = rotation.transpose() * Vec3::Z;
        assert!(toward_viewer.z.abs() > 2.0 * toward_viewer.x.abs(), "{toward_viewer}");
        assert!((rotation * Vec3::Y).y > 0.8, "y is up: {}", rotation * Vec3::Y);
    }

    #[test]
    fn the_hidden_one_of_two_materials_counts() {
        // A small sphere behind a big one, along x: from −x it would be hidden.
        let mut builder = sphere(DVec3::ZERO, 1.0, [Label(1), Label(0)]);
        builder.append(sphere(DVec3::X * 1.6, 0.4, [Label(2), Label(0)]));
        let scene = Scene::new(&builder.mesh, &[], &[], Selection::default());
        let frame = Frame { min: Vec2::ZERO, max: Vec2::new(400.0, 300.0) };
        let toward_viewer =
            choose(&scene, &Sides::of(&Sections::default()), frame).rotation.transpose() * Vec3::Z;
        assert!(toward_viewer.x > -0.5, "{toward_viewer}");
    }
}
