//! Images whose contours are known, and such as nobody drew.

use std::f64::consts::TAU;

use super::curves::contours;
use super::trace::Contours;
use super::*;
use crate::label::Label;
use crate::random::Random;

const HALF_PIXEL: f64 = 0.5;

fn raster(size: [usize; 2], label: impl FnMut(DVec2) -> u32) -> Pixels {
    let at = |index: usize| DVec2::new((index % size[0]) as f64, (index / size[0]) as f64);
    Pixels { size, labels: (0..size[0] * size[1]).map(at).map(label).collect() }
}

fn disc(size: usize, center: DVec2, radius: f64) -> Pixels {
    raster([size; 2], |at| u32::from(at.distance(center) < radius))
}

fn image(pixels: Pixels) -> LabelImage {
    let placement = ImagePlacement { origin: DVec3::Z, steps: [DVec3::X, DVec3::Y] };
    LabelImage::new(pixels.size, pixels.labels, placement).expect("an image")
}

fn section(pixels: Pixels) -> Section {
    image(pixels).section("an image", &Rules::default()).expect("a section").0
}

/// The closed curves with a label on their left.
fn loops(section: &Section, label: u32) -> Vec<Vec<DVec2>> {
    let mut next = vec![None; section.vertices().len()];
    for edge in section.edges() {
        if edge.left == Label(label) {
            next[edge.start as usize] = Some(edge.end);
        } else if edge.right == Label(label) {
            next[edge.end as usize] = Some(edge.start);
        }
    }
    let mut loops = Vec::new();
    for first in 0..next.len() {
        let mut points = Vec::new();
        let mut at = first;
        while let Some(end) = next[at].take() {
            points.push(section.vertices()[at]);
            at = end as usize;
        }
        if !points.is_empty() {
            loops.push(points);
        }
    }
    loops
}

fn sides(points: &[DVec2]) -> impl Iterator<Item = DVec2> + Clone {
    (0..points.len()).map(|own| points[(own + 1) % points.len()] - points[own])
}

fn area(loops: &[Vec<DVec2>]) -> f64 {
    let own = |points: &Vec<DVec2>| -> f64 {
        let pairs = (0..points.len()).map(|own| (points[own], points[(own + 1) % points.len()]));
        pairs.map(|(from, to)| 0.5 * from.perp_dot(to)).sum()
    };
    loops.iter().map(own).sum()
}

/// How far curves turn, either way, in full turns.
fn turning(points: &[DVec2]) -> f64 {
    let next = sides(points).cycle().skip(1);
    sides(points).zip(next).map(|(one, next)| one.angle_to(next).abs()).sum::<f64>() / TAU
}

fn farthest(points: &[DVec2], off: impl Fn(DVec2) -> f64) -> f64 {
    points.iter().map(|&at| off(at).abs()).fold(0.0, f64::max)
}

#[test]
fn a_circle_is_one_again() {
    let center = DVec2::new(100.3, 99.6);
    for radius in [15.2, 40.3, 80.7] {
        let found = loops(&section(disc(200, center, radius)), 1);
        assert_eq!(found.len(), 1);
        let off = farthest(&found[0], |at| at.distance(center) - radius);
        assert!(off < HALF_PIXEL / 2.0, "{radius}: {off}");
        assert!(turning(&found[0]) < 1.02, "{radius}: {}", turning(&found[0]));
        let part = area(&found) / (std::f64::consts::PI * radius * radius);
        assert!((part - 1.0).abs() < 6e-3, "{radius}: {part}");
    }
}

#[test]
fn noise_of_a_pixel_is_smoothed() {
    let center = DVec2::new(50.3, 49.6);
    let mut tried = 0;
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let noise: Vec<f64> = (0..253).map(|_| 2.0 * random.unit() - 1.0).collect();
        let pixels = raster([100; 2], |at| {
            let part = ((at - center).to_angle() / TAU + 0.5).clamp(0.0, 1.0 - 1e-9);
            u32::from(at.distance(center) < 40.3 + noise[(part * noise.len() as f64) as usize])
        });
        let outline = trace::trace(&pixels, |_, _| 0.5, |at| pixels.joined(at));
        let found = loops(&section(pixels.clone()), 1);
        // Pixels that noise cuts off stay parts of their own.
        assert_eq!(found.len(), pixels.outlines().iter().filter(|(own, _)| *own == 1).count());
        if found.len() == 1 {
            tried += 1;
            let off = farthest(&found[0], |at| at.distance(center) - 40.3);
            assert!(off < 1.0, "seed {seed}: off by {off}");
            assert!(turning(&found[0]) < 1.1, "seed {seed}: turns {}", turning(&found[0]));
            assert!(outline.points.len() > 4 * found[0].len(), "seed {seed}");
        }
    }
    assert!(tried >= 5, "{tried}");
}

#[test]
fn small_and_thin_parts_survive() {
    for center in [DVec2::splat(10.0), DVec2::splat(10.5), DVec2::new(10.2, 10.7)] {
        let pixels = disc(20, center, 3.0);
        let count: u32 = pixels.labels.iter().sum();
        let found = loops(&section(pixels), 1);
        let part = area(&found) / f64::from(count);
        assert!(found.len() == 1 && (part - 1.0).abs() < 0.03, "{center}: {part}");
    }
    let strip = raster([80, 20], |at| {
        u32::from((9.5..69.5).contains(&at.x) && (8.5..11.5).contains(&at.y))
    });
    let found = loops(&section(strip), 1);
    assert!(found.len() == 1 && (area(&found) / 180.0 - 1.0).abs() < 0.03, "{}", area(&found));
    // One pixel wide: a part there still is.
    let line = raster([80, 20], |at| u32::from((9.5..69.5).contains(&at.x) && at.y == 9.0));
    let found = loops(&section(line), 1);
    assert!(found.len() == 1 && (area(&found) / 60.0 - 1.0).abs() < 0.1, "{}", area(&found));
}

#[test]
fn corners_stay_within_a_pixel() {
    let square = raster([80; 2], |at| {
        u32::from(at.cmpgt(DVec2::splat(9.5)).all() && at.cmplt(DVec2::splat(69.5)).all())
    });
    let section = section(square);
    for corner in [[9.5, 9.5], [69.5, 9.5], [9.5, 69.5], [69.5, 69.5]].map(DVec2::from) {
        let near = section.vertices().iter().map(|at| at.distance(corner));
        let near = near.fold(f64::INFINITY, f64::min);
        assert!(near < 1.0, "{corner}: {near}");
    }
}

#[test]
fn labels_leave_no_gaps() {
    // Sectors of a disc: three curves that meet in its middle.
    let center = DVec2::new(50.2, 50.4);
    let sector = |at: DVec2| ((at - center).to_angle() / TAU * 3.0 + 1.5).floor() as u32 % 3 + 1;
    let pixels = raster([100; 2], |at| if at.distance(center) < 40.0 { sector(at) } else { 0 });
    let section = section(pixels);
    for label in 1..=3 {
        let found = loops(&section, label);
        let part = area(&found) / (std::f64::consts::PI * 1600.0 / 3.0);
        assert!(found.len() == 1 && (part - 1.0).abs() < 0.01, "{label}: {part}");
    }
    // Where two meet on the border of the disc there is no notch in it.
    let rim = loops(&section, 0).concat();
    let off = farthest(&rim, |at| at.distance(center) - 40.0);
    assert!(rim.len() > 40 && off < HALF_PIXEL / 2.0, "{off}");
    let ends = |edge: &crate::section::Edge| [edge.start, edge.end];
    let mut degrees = vec![0; section.vertices().len()];
    section.edges().iter().flat_map(ends).for_each(|end| degrees[end as usize] += 1);
    assert_eq!(degrees.iter().filter(|&&degree| degree != 2).count(), 4);
}

/// Every outline of every label comes back once.
fn assert_accounted(pixels: &Pixels, what: &str) {
    let Contours { points, edges } = contours(pixels, &CurveOptions::default());
    let mut labels: Vec<u32> = pixels.labels.clone();
    labels.sort_unstable();
    labels.dedup();
    let (section, _) = image(pixels.clone()).section(what, &Rules::default()).expect("a section");
    assert!(points.len() >= section.vertices().len() && edges.len() >= section.edges().len());
    for &label in labels.iter().filter(|&&label| label > 0) {
        let wanted = pixels.outlines().iter().filter(|(own, _)| *own == label).count();
        let mut degrees = vec![0i32; points.len()];
        for edge in edges.iter().filter(|edge| (edge.left.0 == label) != (edge.right.0 == label)) {
            degrees[edge.start as usize] += 1;
            degrees[edge.end as usize] += 1;
        }
        assert!(degrees.iter().all(|degree| degree % 2 == 0), "{what}: {label} is not closed");
        // Four of a label's edges meet where parts of it touch; elsewhere curves are apart.
        if degrees.iter().all(|&degree| degree <= 2) {
            assert_eq!(loops(&section, label).len(), wanted, "{what}: {label}");
        }
    }
}

#[test]
fn pixels_at_random_are_all_accounted_for() {
    let mut random = Random::new(7);
    for number in 0..200 {
        let size = [1 + (random.unit() * 30.0) as usize, 1 + (random.unit() * 30.0) as usize];
        let labels = 1.0 + (random.unit() * 4.0).ceil();
        let grain = 1.0 + (random.unit() * 6.0).floor();
        let cells: Vec<u32> = (0..1024).map(|_| (random.unit() * labels) as u32).collect();
        let pixels = raster(size, |at| {
            let cell = (at / grain).floor();
            cells[(cell.y * 32.0 + cell.x) as usize]
        });
        assert_accounted(&pixels, &format!("image {number}"));
    }
}

#[test]
fn parts_that_touch_in_corners_are_apart_and_borders_are_told() {
    let image = image(Pixels { size: [2, 2], labels: vec![1, 0, 0, 2] });
    assert_eq!(image.on_border(), [1, 2]);
    let (section, _) = image.section("corners", &Rules::default()).expect("a section");
    assert_eq!((loops(&section, 1).len(), loops(&section, 2).len()), (1, 1));
}
