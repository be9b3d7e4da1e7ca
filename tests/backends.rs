//! The field's backends on real sections: each agrees with the f64 reference
//! within 1e-4 at 10,000 random points of the box.

mod common;

use std::time::Instant;

use glam::DVec3;
use transect::complex::Complex;
use transect::error::Error;
use transect::field::{Adapter, Boundaries, Cpu, Field, Gpu, Queries, Reference, Run};
use transect::io::read_sections;
use transect::label::Label;
use transect::plane::Bounds;
use transect::section::{Rules, Section};

const POINTS: usize = 10_000;
/// In f.
const TOLERANCE: f32 = 1e-4;
/// In diagonals of the box. So close to a contour, where f jumps, points need
/// not agree.
const CONTOUR: f64 = 1e-6;
/// In diagonals of the box.
const CLEARANCE: f64 = 1e-7;

/// The box around all vertices, grown by 5 % of its diagonal.
fn bounds(sections: &[Section]) -> Bounds {
    let points = sections.iter().flat_map(|section| {
        (0..section.vertices().len() as u32).map(|vertex| section.point(vertex))
    });
    let bounds = Bounds::around(points).unwrap();
    bounds.grown(0.05 * bounds.diagonal())
}

/// A Weyl sequence: it fills the cube evenly.
fn spread(index: usize) -> DVec3 {
    let steps =
        DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_3, 0.549_700_477_901_970_4);
    ((index + 1) as f64 * steps).fract()
}

/// Points all over the box, sorted by cell.
fn queries(complex: &Complex) -> Queries {
    let bounds = complex.bounds();
    let mut located: Vec<(u32, DVec3)> = (0..POINTS)
        .map(|index| bounds.min + spread(index) * bounds.size())
        .map(|point| (complex.locate(point), point))
        .collect();
    located.sort_by_key(|&(cell, _)| cell);
    let mut queries = Queries::default();
    for same in located.chunk_by(|a, b| a.0 == b.0) {
        let first = queries.points.len();
        queries.points.extend(same.iter().map(|&(_, point)| point));
        queries.runs.push(Run { cell: same[0].0, points: first..queries.points.len() });
    }
    queries
}

/// The distance from a point to the nearest contour.
fn contour_distance(sections: &[Section], point: DVec3) -> f64 {
    let edges = sections.iter().flat_map(|section| {
        section.edges().iter().map(|edge| (section.point(edge.start), section.point(edge.end)))
    });
    edges
        .map(|(start, end)| {
            let span = end - start;
            let along = (point - start).dot(span) / span.length_squared();
            point.distance(start + along.clamp(0.0, 1.0) * span)
        })
        .fold(f64::INFINITY, f64::min)
}

fn evaluate(field: &dyn Field, queries: &Queries) -> Vec<f32> {
    let start = Instant::now();
    let values = field.evaluate(queries).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let rate = queries.edge_evaluations(field) as f64 / seconds / 1e6;
    println!("  {}: {seconds:.3} s, {rate:.0} M edges/s", field.name());
    values
}

/// The backends of this machine.
fn backends(boundaries: &Boundaries) -> Vec<Box<dyn Field>> {
    let mut backends: Vec<Box<dyn Field>> = vec![Box::new(Cpu::new(boundaries).unwrap())];
    match Gpu::new(boundaries, Adapter::Any) {
        Ok(gpu) => backends.push(Box::new(gpu)),
        Err(Error::Device(_)) => common::skipped("no wgpu adapter"),
        Err(other) => panic!("{other}"),
    }
    backends
}

fn check(name: &str) {
    let Some(path) = common::data(name) else { return };
    let sections = read_sections(&path, &Rules::default()).unwrap().sections;
    let complex = Complex::new(&sections, bounds(&sections), Label::OUTSIDE).unwrap();
    let diagonal = complex.bounds().diagonal();
    let boundaries = Boundaries::new(&complex, CLEARANCE * diagonal, None).unwrap();
    let reference = Reference::new(&boundaries).unwrap();
    let queries = queries(&complex);
    println!("{name}: {} edge evaluations", queries.edge_evaluations(&reference));
    let expected = evaluate(&reference, &queries);
    for field in backends(&boundaries) {
        let found = evaluate(&*field, &queries);
        compare(&*field, &sections, &queries, [&expected, &found], CONTOUR * diagonal);
    }
}

/// Every value within the tolerance, or its point next to a contour.
fn compare(
    field: &dyn Field,
    sections: &[Section],
    queries: &Queries,
    [expected, found]: [&[f32]; 2],
    contour: f64,
) {
    assert_eq!(expected.len(), found.len());
    let cells = queries.runs.iter().flat_map(|run| run.points.clone().map(|_| run.cell));
    let mut value = 0;
    let mut largest: f32 = 0.0;
    for (cell, &point) in cells.zip(&queries.points) {
        for _ in field.labels(cell) {
            let difference = (expected[value] - found[value]).abs();
            let excepted = difference > TOLERANCE && contour_distance(sections, point) < contour;
            assert!(
                difference <= TOLERANCE || excepted,
                "{}: f differs by {difference} at {point} in cell {cell}",
                field.name()
            );
            largest = largest.max(if excepted { 0.0 } else { difference });
            value += 1;
        }
    }
    println!("  {}: largest difference {largest:.1e}", field.name());
}

#[test]
fn own_anatomy() {
    check("vessel.csl");
    check("organ.contour");
    check("knot.contour");
}

#[test]
fn elephant() {
    check("csl/Elephant.csl");
}

#[test]
fn vetebrae() {
    check("csl/Vetebrae.csl");
}

#[test]
fn abdomen() {
    check("csl/Abdomen.csl");
}
