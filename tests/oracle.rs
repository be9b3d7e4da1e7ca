//! The oracle on real sections: against plain floats, and against the field.

mod common;

use common::data;
use glam::{DVec2, DVec3};
use transect::complex::Complex;
use transect::field::{Boundaries, Cpu, Field, Queries, Run};
use transect::io::read_sections;
use transect::label::Label;
use transect::oracle::Oracle;
use transect::plane::Bounds;
use transect::section::{Rules, Section};

/// Sections without anything unknown, and their box.
fn read(name: &str) -> Option<(Vec<Section>, Bounds)> {
    let sections = read_sections(&data(name)?, &Rules::default()).unwrap();
    let around = sections.bounds().unwrap();
    Some((sections.sections, around.grown(0.05 * around.diagonal())))
}

/// Points of a box, evenly spread: Roberts' sequence of the plastic number's
/// kind for three dimensions.
fn spread(bounds: Bounds, count: u32) -> Vec<DVec3> {
    let steps =
        DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    (1..=count).map(|at| bounds.min + bounds.size() * (f64::from(at) * steps).fract()).collect()
}

/// The label of the nearest plane's foot in plain floats, without any index;
/// nothing where these may not be good enough.
fn plainly(sections: &[Section], bounds: Bounds, point: DVec3) -> Option<Label> {
    let tiny = 1e-9 * bounds.diagonal();
    let to_box = (point - bounds.min).min(bounds.max - point).min_element();
    let mut distances: Vec<(f64, Option<&Section>)> = sections
        .iter()
        .map(|section| (section.plane().distance(point).abs(), Some(section)))
        .collect();
    distances.push((to_box, None));
    distances.sort_by(|one, other| one.0.total_cmp(&other.0));
    if distances[1].0 - distances[0].0 < tiny {
        return None;
    }
    let Some(section) = distances[0].1 else { return Some(Label::OUTSIDE) };
    let plane = section.plane();
    let foot = plane.project(point - plane.distance(point) * plane.unit_normal());
    // Winding numbers by angles, for every label the edges that go around it.
    let mut turns = vec![0.0; section.labels().len()];
    let labels = section.labels();
    for edge in section.edges() {
        let [start, end] = [edge.start, edge.end].map(|at| section.vertices()[at as usize] - foot);
        if distance_to(start, end) < tiny {
            return None;
        }
        let angle = start.angle_to(end);
        turns[labels.binary_search(&edge.left).unwrap()] += angle;
        turns[labels.binary_search(&edge.right).unwrap()] -= angle;
    }
    let full = turns.iter().position(|&turn| turn > std::f64::consts::PI);
    Some(full.map_or(section.background(), |at| labels[at]))
}

/// How far a segment is from the origin.
fn distance_to(start: DVec2, end: DVec2) -> f64 {
    let along = end - start;
    let part = (-start.dot(along) / along.length_squared()).clamp(0.0, 1.0);
    (start + part * along).length()
}

#[test]
fn it_agrees_with_plain_floats_where_these_are_good_enough() {
    for name in [
        "vessel.csl",
        "organ.contour",
        "knot.contour",
        "csl/Elephant.csl",
        "csl/Vetebrae.csl",
        "csl/Abdomen.csl",
        "contour/mousebrain.contour",
    ] {
        let Some((sections, bounds)) = read(name) else { continue };
        let oracle = Oracle::new(&sections, bounds, Label::OUTSIDE).unwrap();
        let points = spread(bounds, 20_000);
        let labels = oracle.labels(&points);
        let mut compared = 0;
        for (&point, &label) in points.iter().zip(&labels) {
            if let Some(plain) = plainly(&sections, bounds, point) {
                assert_eq!(label, plain, "{name} {point}");
                compared += 1;
            }
        }
        assert!(compared > 19_900, "{name}: {compared}");
    }
}

#[test]
fn the_field_agrees_where_it_must() {
    for name in [
        "vessel.csl",
        "organ.contour",
        "csl/Elephant.csl",
        "csl/Vetebrae.csl",
        "csl/Heart-25-even-better.csl",
    ] {
        let Some((sections, bounds)) = read(name) else { continue };
        let oracle = Oracle::new(&sections, bounds, Label::OUTSIDE).unwrap();
        let complex = Complex::new(&sections, bounds, Label::OUTSIDE).unwrap();
        let boundaries = Boundaries::new(&complex, 1e-9 * bounds.diagonal(), None).unwrap();
        let field = Cpu::new(&boundaries).unwrap();
        let points = spread(bounds, 20_000);
        let must: Vec<DVec3> =
            points.into_iter().filter(|&point| oracle.certainty(point).must_agree()).collect();
        assert!(must.len() > 1_000, "{name}: {}", must.len());
        for &point in &must {
            let expected = oracle.nearest(point).label;
            assert_eq!(label_of(&field, complex.locate(point), point), expected, "{name} {point}");
        }
    }
}

/// The label with the largest value.
fn label_of(field: &Cpu, cell: u32, point: DVec3) -> Label {
    let labels = field.labels(cell);
    if let [label] = labels {
        return *label;
    }
    let queries = Queries { points: vec![point], runs: vec![Run { cell, points: 0..1 }] };
    let values = field.evaluate(&queries).unwrap();
    let best = (0..labels.len()).max_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap();
    labels[best]
}

#[test]
fn any_number_of_threads_gives_the_same() {
    for name in ["organ.contour", "csl/Abdomen.csl"] {
        let Some((sections, bounds)) = read(name) else { continue };
        assert_same_on_any_number_of_threads(&sections, bounds);
    }
}

fn assert_same_on_any_number_of_threads(sections: &[Section], bounds: Bounds) {
    let oracle = Oracle::new(sections, bounds, Label::OUTSIDE).unwrap();
    let points = spread(bounds, 5_000);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| oracle.labels(&points))
    };
    assert_eq!(on(1), on(3));
}
