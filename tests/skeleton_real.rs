//! The exact reconstruction of real sections.

use glam::{DVec2, DVec3};
use robust::{Coord, orient2d};
use transect::io::read_all;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::oracle::Oracle;
use transect::plane::Bounds;
use transect::progress::Silent;
use transect::section::{Overlap, Rules, Section};
use transect::skeleton::{Options, Skeleton, skeleton};

mod common;
#[path = "common/random.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod random;

use random::Random;

fn sections(file: &str) -> Option<(Vec<Section>, Bounds)> {
    let path = common::data(file)?;
    let rules = Rules { overlap: Some(Overlap::Smallest), ..Rules::default() };
    let sections = read_all(&[path], &rules).expect("sections");
    let bounds = sections.bounds().expect("contours");
    Some((sections.sections, bounds.grown(0.05 * bounds.diagonal())))
}

fn exact(sections: &[Section], bounds: Bounds) -> Skeleton {
    skeleton(sections, bounds, &Options::default(), &Silent).expect("a skeleton")
}

/// Where a vertical line passes triangles: the height, the label below, the one
/// above, from below up.
fn passes(mesh: &Mesh, at: DVec2) -> Vec<(f64, Label, Label)> {
    let mut found = Vec::new();
    for (triangle, &[back, front]) in mesh.sides.iter().enumerate() {
        let corners = mesh.corners(triangle);
        let flat = corners.map(DVec3::truncate);
        let low = flat[0].min(flat[1]).min(flat[2]);
        let high = flat[0].max(flat[1]).max(flat[2]);
        if !(low.cmple(at).all() && at.cmple(high).all()) {
            continue;
        }
        let coord = |point: DVec2| Coord { x: point.x, y: point.y };
        let turn = |a: usize, b: usize| orient2d(coord(flat[a]), coord(flat[b]), coord(at));
        let turns = [turn(1, 2), turn(2, 0), turn(0, 1)];
        let faces_up = turns.iter().all(|&turn| turn > 0.0);
        if !faces_up && !turns.iter().all(|&turn| turn < 0.0) {
            continue;
        }
        let sum: f64 = turns.iter().sum();
        let height: f64 = (0..3).map(|i| turns[i] / sum * corners[i].z).sum();
        found.push(if faces_up { (height, back, front) } else { (height, front, back) });
    }
    found.sort_by(|one, other| one.0.total_cmp(&other.0));
    found
}

/// Closed boundaries without self-intersections, and the label of the nearest
/// section at all of 100,000 random points.
fn holds(file: &str) {
    let Some((sections, bounds)) = sections(file) else { return };
    let result = exact(&sections, bounds);
    assert!(result.details.contradictions.is_empty(), "{:?}", result.details.contradictions);
    for label in result.mesh.labels() {
        let facts = result.mesh.surface(label).facts(true).expect("facts");
        assert!(facts.closed && facts.outward, "{file}, label {label}: {facts:?}");
        assert_eq!(facts.self_intersections, Some(0), "{file}, label {label}");
    }
    let oracle = Oracle::new(&sections, bounds, Label::OUTSIDE).expect("an oracle");
    let mut random = Random::new(1);
    let mut compared = 0;
    let mut lines = 0;
    while compared < 100_000 {
        lines += 1;
        let [x, y] = [0, 1].map(|axis| bounds.min[axis] + random.unit() * bounds.size()[axis]);
        let passes = passes(&result.mesh, DVec2::new(x, y));
        for pair in passes.windows(2) {
            assert_eq!(pair[0].2, pair[1].1, "{file}: labels along a line at {x}, {y}");
        }
        let heights: Vec<f64> =
            (0..100).map(|_| bounds.min.z + random.unit() * bounds.size().z).collect();
        for z in heights {
            // The surface's corners are rounded.
            if passes.iter().any(|pass| (pass.0 - z).abs() < 1e-9 * bounds.diagonal()) {
                continue;
            }
            let below = passes.partition_point(|pass| pass.0 < z);
            let label = if below == 0 { Label::OUTSIDE } else { passes[below - 1].2 };
            let point = DVec3::new(x, y, z);
            assert_eq!(label, oracle.nearest(point).label, "{file}: at {point}");
            compared += 1;
        }
    }
    assert!(lines > 900);
}

#[test]
fn own_anatomy() {
    holds("vessel.csl");
    holds("bone.csl");
    holds("knot.contour");
}

#[test]
fn elephant() {
    holds("csl/Elephant.csl");
}

#[test]
fn heart() {
    holds("csl/Heart-25-even-better.csl");
}

#[test]
fn vertebrae() {
    holds("csl/Vetebrae.csl");
}

#[test]
fn abdomen() {
    holds("csl/Abdomen.csl");
}

#[test]
fn mouse_brain() {
    holds("contour/mousebrain.contour");
}

#[test]
fn one_thread_or_three() {
    for file in ["organ.contour", "csl/eight_20.csl"] {
        let Some((sections, bounds)) = sections(file) else { continue };
        let with_threads = |count| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("threads");
            pool.install(|| exact(&sections, bounds))
        };
        assert_eq!(with_threads(1), with_threads(3), "{file}");
    }
}
