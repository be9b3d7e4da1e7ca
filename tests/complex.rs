//! Cell complexes of real sections.

mod common;

use std::time::Instant;

use glam::DVec3;
use transect::complex::{BOX_PLANES, Complex};
use transect::io::read_sections;
use transect::label::Label;
use transect::plane::Bounds;
use transect::section::{Rules, Section};

/// The box around all vertices, grown by 5 % of its diagonal.
fn bounds(sections: &[Section]) -> Bounds {
    let points = sections.iter().flat_map(|section| {
        (0..section.vertices().len() as u32).map(|vertex| section.point(vertex))
    });
    let bounds = Bounds::around(points).unwrap();
    bounds.grown(0.05 * bounds.diagonal())
}

/// The area of every label of a section on its plane, as drawn.
fn drawn_area(section: &Section, label: Label) -> f64 {
    let mut sum = 0.0;
    for edge in section.edges() {
        let part = part(section, section.point(edge.start), section.point(edge.end));
        sum += if edge.left == label { part } else { 0.0 };
        sum -= if edge.right == label { part } else { 0.0 };
    }
    sum
}

/// The same, on the facets of the complex.
fn arranged_area(complex: &Complex, plane: u32, section: &Section, label: Label) -> f64 {
    let mut sum = 0.0;
    let facets = complex.facets().values().filter(|facet| facet.plane == plane);
    for edge in facets.flat_map(|facet| &facet.edges) {
        let part = part(section, edge.start, edge.end);
        sum += if edge.left == label { part } else { 0.0 };
        sum -= if edge.right == Some(label) { part } else { 0.0 };
    }
    sum
}

/// The area between an edge and the section's first vertex.
fn part(section: &Section, start: DVec3, end: DVec3) -> f64 {
    let origin = section.point(0);
    (start - origin).cross(end - origin).dot(section.plane().unit_normal()) / 2.0
}

fn check(name: &str) {
    let Some(path) = common::data(name) else { return };
    let sections = read_sections(&path, &Rules::default()).unwrap().sections;
    let bounds = bounds(&sections);
    let start = Instant::now();
    let complex = Complex::new(&sections, bounds, Label::OUTSIDE).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let edges: usize = complex.facets().values().map(|facet| facet.edges.len()).sum();
    println!(
        "{name}: {} planes, {} cells, {} facets, {edges} edges in {seconds:.3} s",
        sections.len(),
        complex.cells().count(),
        complex.facets().count()
    );
    for (plane, section) in (BOX_PLANES..).zip(&sections).filter(|(_, s)| !s.vertices().is_empty())
    {
        for label in section.labels().into_iter().filter(|&label| label != section.background()) {
            let expected = drawn_area(section, label);
            let found = arranged_area(&complex, plane, section, label);
            assert!(
                (found - expected).abs() < 1e-9 * bounds.diagonal().powi(2),
                "{}: label {label} has the area {found}, not {expected}",
                section.name()
            );
        }
    }
}

#[test]
fn sections_in_all_directions_keep_their_areas() {
    check("vessel.csl");
    check("csl/Elephant.csl");
    check("csl/Heart-25-even-better.csl");
    check("csl/Vetebrae.csl");
}

#[test]
fn many_labels_keep_their_areas() {
    check("organ.contour");
    check("knot.contour");
    check("csl/Abdomen.csl");
    for name in ["liver", "mousebrain", "mug", "ringc"] {
        check(&format!("contour/{name}.contour"));
    }
}

#[test]
fn parallel_sections_keep_their_areas() {
    check("bone.csl");
    for name in ["eight_15", "eight_20", "hand_ok", "ParallelEight", "SideBishop"] {
        check(&format!("csl/{name}.csl"));
    }
}
