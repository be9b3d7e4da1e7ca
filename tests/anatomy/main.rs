//! Writes `tests/data`: made-up anatomy as drawn by hand, which all tests have, beside the real
//! data that only some do. The solids are known, and so are their volumes (`truth.json`).
//!
//! `cargo test --release --test anatomy -- --ignored`

#[path = "../../examples/phantom/bodies.rs"]
mod bodies;
#[path = "../../examples/phantom/contours.rs"]
mod contours;
mod files;
#[path = "../../examples/phantom/simplify.rs"]
mod simplify;
mod solids;

use std::path::PathBuf;

use glam::{DVec2, DVec3, Vec3Swizzles};

use transect::label::Label;
use transect::mask::{Blobs, Mask, mask};
use transect::plane::Plane;
use transect::section::{Rules, Section, Sections};

use solids::{BONE, KNOT, ORGAN, SOLIDS, Solid, VESSEL, wave, without_bumps};

fn folder() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "tests", "data"].iter().collect()
}

/// So many planes from one end of an axis to the other, in mm, every one with its own tilt of at
/// most this slope.
struct Sweep {
    axis: DVec3,
    from: f64,
    to: f64,
    count: u32,
    tilt: f64,
}

impl Sweep {
    fn planes(&self) -> impl Iterator<Item = Plane> {
        (0..self.count).map(|number| {
            let part = f64::from(number) / f64::from(self.count - 1);
            let at = self.from + part * (self.to - self.from);
            let turn = |step: u32| wave(f64::from(number * step % 16) / 16.0 + 0.03);
            let [one, other] = [self.axis.yzx(), self.axis.zxy()];
            let normal = self.axis + self.tilt * (one * turn(5) + other * turn(3));
            Plane { normal, offset: normal.dot(self.axis * at) }
        })
    }
}

/// What is drawn of a solid on a plane; how unsteady the hand is, in mm. It is unsteady on every
/// plane in another way: planes that cross get none, or they would contradict each other.
fn drawn(solid: &Solid, number: usize, plane: &Plane, unsteady: f64) -> Section {
    let phase = 0.37 * number as f64;
    let seen = |place| (solid.label_at)(without_bumps(place, unsteady, phase));
    let borders = contours::borders(plane, &seen);
    let edges = simplify::simplified(&borders);
    let points: Vec<DVec3> = borders.points.iter().map(|&point| rounded(plane, point)).collect();
    let name = format!("{} {}", solid.name, number + 1);
    Section::from_graph(&name, *plane, &points, &edges, 2.0 * solids::REACH, &strict())
        .expect("a section")
        .0
}

/// The point on the plane whose kept coordinates are whole micrometres.
fn rounded(plane: &Plane, point: DVec3) -> DVec3 {
    let kept = plane.project(point);
    plane.lift(DVec2::new((kept.x * 1000.0).round() / 1000.0, (kept.y * 1000.0).round() / 1000.0))
}

fn strict() -> Rules {
    Rules { strict: true, ..Rules::default() }
}

fn cut(solid: &Solid, sweeps: &[Sweep], unsteady: f64) -> Sections {
    let planes = sweeps.iter().flat_map(Sweep::planes).enumerate();
    let list = planes.map(|(number, plane)| drawn(solid, number, &plane, unsteady)).collect();
    let mut sections = Sections::new(list, &strict()).expect("sections");
    sections.name_materials(solid.materials());
    sections.units = "mm".to_owned();
    sections.frame = "LPS".to_owned();
    sections
}

/// Planes of which no two are parallel.
fn vessel() -> Sections {
    let along = Sweep { axis: DVec3::Z, from: -62.0, to: 64.0, count: 16, tilt: 0.3 };
    let across = Sweep { axis: DVec3::X, from: -40.0, to: 60.0, count: 8, tilt: 0.3 };
    cut(&VESSEL, &[along, across], 0.0)
}

fn bone() -> Sections {
    cut(&BONE, &[Sweep { axis: DVec3::Z, from: -66.0, to: 66.0, count: 17, tilt: 0.0 }], 0.8)
}

/// Three stacks that cross at right angles.
fn organ() -> Sections {
    let stack = |axis, from, to, count| Sweep { axis, from, to, count, tilt: 0.0 };
    let sweeps = [
        stack(DVec3::Z, -46.0, 38.0, 8),
        stack(DVec3::X, -50.5, 55.0, 6),
        stack(DVec3::Y, -35.0, 43.0, 5),
    ];
    cut(&ORGAN, &sweeps, 0.0)
}

fn knot() -> Sections {
    cut(&KNOT, &[Sweep { axis: DVec3::Z, from: -60.0, to: 60.0, count: 16, tilt: 0.0 }], 0.8)
}

/// The organ in frames that show a part of it each, with holes in what they show.
fn frames() -> Sections {
    let along = Sweep { axis: DVec3::Z, from: -46.0, to: 42.0, count: 9, tilt: 0.2 };
    let across = Sweep { axis: DVec3::Y, from: -38.0, to: 44.0, count: 6, tilt: 0.2 };
    let sections = cut(&ORGAN, &[along, across], 0.0);
    let blobs = Some(Blobs { fraction: 0.05, size: 1.0, seed: 1 });
    mask(sections, &Mask { blobs, frame: Some([90.0, 80.0]) }).expect("masked sections")
}

/// Names and contents.
fn all() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("vessel.csl", files::csl(&vessel())),
        ("bone.csl", files::csl(&bone())),
        ("organ.contour", files::contour(&organ())),
        ("knot.contour", files::contour(&knot())),
        ("frames.json", files::json(&frames())),
        ("knot.nrrd", files::nrrd(&KNOT, 2.5)),
        ("truth.json", files::truth(&SOLIDS)),
    ]
}

#[test]
fn the_committed_files_are_what_this_code_writes() {
    for (name, written) in all() {
        let committed = std::fs::read(folder().join(name)).expect("the file is committed");
        assert!(
            committed == written,
            "{name} differs; run: cargo test --release --test anatomy -- --ignored"
        );
    }
}

#[test]
#[ignore = "writes tests/data"]
fn write() {
    std::fs::create_dir_all(folder()).expect("the folder");
    for (name, written) in all() {
        std::fs::write(folder().join(name), written).expect("it is written");
    }
}

#[test]
fn solids_are_what_they_are_said_to_be() {
    let at = |solid: &Solid, [x, y, z]: [f64; 3]| (solid.label_at)(DVec3::new(x, y, z));
    assert_eq!(at(&BONE, [2.0, 6.0, 0.0]), Label::OUTSIDE, "the bone is hollow");
    assert_eq!(at(&ORGAN, [-14.0, 1.0, -2.0]), Label::OUTSIDE, "so is the organ");
    assert_eq!(at(&ORGAN, [-40.0, 24.0, 18.0]), Label(2));
    assert_eq!(at(&VESSEL, [55.0, 11.0, 30.0]), Label(1), "a branch");
    for (solid, count) in SOLIDS.iter().zip([1, 1, 2, 3]) {
        // Nothing reaches the end of what is counted.
        let size = solids::REACH;
        for corner in [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| size * axis) {
            assert_eq!((solid.label_at)(corner), Label::OUTSIDE);
            assert_eq!((solid.label_at)(-corner), Label::OUTSIDE);
        }
        // Counted with cubes of another size: the truth does not hang on these.
        let [fine, coarse] = [1.0, 1.6].map(|step| solid.volumes(step));
        assert_eq!(fine.len(), count);
        for (fine, coarse) in fine.iter().zip(coarse) {
            assert!((coarse / fine - 1.0).abs() < 0.01, "{}: {coarse} {fine}", solid.name);
        }
    }
}
