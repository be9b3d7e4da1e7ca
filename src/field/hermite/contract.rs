//! What every backend of the Hermite field must do, run for each of them.

use glam::{DVec2, DVec3};

use super::*;
use crate::check::shapes::{partition, polygon, section};
use crate::complex::Complex;
use crate::field::cpu::Instructions;
use crate::field::{Boundaries, Field, Queries, Run};
use crate::gpu::Adapter;
use crate::label::Label;
use crate::plane::Plane;
use crate::progress::Silent;
use crate::random::Random;
use crate::section::Section;

/// In values, as a part of the box's diagonal, against the f64 reference.
const TOLERANCE: f64 = 1e-4;

/// A backend on this machine, or nothing (and a word about it).
type Make = fn(&Boundaries, &Nodes, &Options) -> Option<Box<dyn Field>>;

fn reference(boundaries: &Boundaries, nodes: &Nodes, options: &Options) -> Option<Box<dyn Field>> {
    Some(Box::new(Reference::new(boundaries, nodes, options, 1.0)))
}

fn cpu(boundaries: &Boundaries, nodes: &Nodes, options: &Options) -> Option<Box<dyn Field>> {
    Some(Box::new(Cpu::on(boundaries, nodes, options, 1.0)))
}

fn baseline(boundaries: &Boundaries, nodes: &Nodes, options: &Options) -> Option<Box<dyn Field>> {
    let cpu = Cpu::on(boundaries, nodes, options, 1.0);
    Some(Box::new(cpu.with_instructions(Instructions::Baseline)))
}

fn gpu(boundaries: &Boundaries, nodes: &Nodes, options: &Options) -> Option<Box<dyn Field>> {
    match super::gpu::open(Adapter::Any) {
        Ok(opened) => {
            Some(Box::new(Gpu::on(opened.into(), Cpu::on(boundaries, nodes, options, 1.0))))
        }
        Err(Error::Device(_)) => {
            crate::skipped::skipped("no wgpu adapter");
            None
        }
        Err(other) => panic!("{other}"),
    }
}

macro_rules! contract {
    ($($backend:ident),*) => {
        $(mod $backend {
            contract!(@tests $backend: agrees_with_the_reference, survives_far_offsets,
                completes_unknown_regions, is_what_sections_say_on_them, keeps_what_is_linear,
                ignores_the_order_of_runs, answers_nothing_with_nothing);
        })*
    };
    (@tests $backend:ident: $($test:ident),*) => {
        $(#[test]
        fn $test() {
            super::$test(super::$backend);
        })*
    };
}

contract!(reference, cpu, baseline, gpu);

/// Sections of any orientation around a point, with two materials on each, side by side.
fn sections(random: &mut Random, count: usize, middle: DVec3) -> Vec<Section> {
    let one = |_| {
        let normal = random.signed().normalize();
        let offset = normal.dot(middle + 0.3 * random.signed());
        let plane = Plane { normal, offset };
        let foot = offset * normal;
        let [u, v] = plane.tangents();
        let centre = DVec2::new(u.dot(middle - foot), v.dot(middle - foot));
        let turn = |part: usize, of: usize| std::f64::consts::TAU * part as f64 / of as f64;
        let radius = 0.5 + 0.3 * random.unit();
        let half = |first: usize| {
            let around = (0..=6).map(move |part| turn(first + part, 12));
            let place = |at: DVec2| plane.project(foot + at.x * u + at.y * v);
            around.map(|turn| place(centre + radius * DVec2::from_angle(turn))).collect()
        };
        halves(plane, [half(0), half(6)])
    };
    (0..count).map(one).collect()
}

/// Half discs that share their straight side.
fn halves(plane: Plane, [upper, lower]: [Vec<DVec2>; 2]) -> Section {
    let mut section = partition(plane, &[(upper, [Label(1), Label::OUTSIDE])], Label::OUTSIDE);
    let first = section.vertices.len() as u32;
    section.vertices.extend(&lower[1..lower.len() - 1]);
    let count = first + lower.len() as u32 - 2;
    let around: Vec<u32> = [first - 1].into_iter().chain(first..count).chain([0]).collect();
    for ends in around.windows(2) {
        section.edges.push(crate::section::Edge {
            start: ends[0],
            end: ends[1],
            left: Label(3),
            right: Label::OUTSIDE,
        });
    }
    // The upper one's last edge runs along the straight side.
    let straight = section.edges.iter_mut().find(|edge| edge.start == first - 1 && edge.end == 0);
    straight.unwrap().right = Label(3);
    section
}

/// Random points, each in a run of its own.
fn queries(complex: &Complex, random: &mut Random, count: usize) -> Queries {
    let bounds = complex.bounds();
    let mut queries = Queries::default();
    let mut places: Vec<(u32, DVec3)> = (0..count)
        .map(|_| bounds.middle() + 0.5 * random.signed() * bounds.size())
        .map(|point| (complex.locate(point), point))
        .collect();
    places.sort_by_key(|place| place.0);
    for own in places.chunk_by(|one, other| one.0 == other.0) {
        let first = queries.points.len();
        queries.points.extend(own.iter().map(|place| place.1));
        queries.runs.push(Run { cell: own[0].0, points: first..queries.points.len() });
    }
    queries
}

/// What a backend and the reference say at random points of sections around a place.
fn difference(make: Make, sections: &[Section], middle: DVec3, options: &Options) -> f64 {
    let mut random = Random::new(71);
    let bounds = Bounds { min: middle - 1.0, max: middle + 1.0 };
    let complex = Complex::new(sections, bounds, Label::OUTSIDE).unwrap();
    let boundaries = Boundaries::new(&complex, 1e-4, options.spacing).unwrap();
    let nodes = Nodes::new(&boundaries, sections, options, &Silent).unwrap();
    let Some(field) = make(&boundaries, &nodes, options) else { return 0.0 };
    let queries = queries(&complex, &mut random, 400);
    let found = field.evaluate(&queries).unwrap();
    let expected = Reference::new(&boundaries, &nodes, options, 1.0).evaluate(&queries).unwrap();
    assert_eq!(found.len(), expected.len());
    assert!(expected.iter().all(|value| value.is_finite()));
    let pairs = found.iter().zip(&expected);
    pairs.map(|(f, e)| f64::from((f - e).abs())).fold(0.0, f64::max) / bounds.diagonal()
}

fn agrees_with_the_reference(make: Make) {
    let mut random = Random::new(70);
    for count in [1, 3, 6] {
        let sections = sections(&mut random, count, DVec3::ZERO);
        for gradients in [Gradients::None, Gradients::Distance, Gradients::Normals] {
            for density in [false, true] {
                let options = Options { spacing: Some(0.2), gradients, density };
                let difference = difference(make, &sections, DVec3::ZERO, &options);
                assert!(difference < TOLERANCE, "{count} {options:?}: {difference:e}");
            }
        }
    }
}

fn survives_far_offsets(make: Make) {
    let middle = DVec3::new(4.5e3, 5.4e4, 300.0);
    let sections = sections(&mut Random::new(72), 4, middle);
    let options = Options { spacing: Some(0.2), ..Options::default() };
    let difference = difference(make, &sections, middle, &options);
    assert!(difference < TOLERANCE, "{difference:e}");
}

/// Discs in which a part is unknown, and a plane of which all is.
fn completes_unknown_regions(make: Make) {
    let disc = |radius: f64, corners: u32| -> Vec<DVec2> {
        (0..corners)
            .map(|at| std::f64::consts::TAU * f64::from(at) / f64::from(corners))
            .map(|turn| radius * DVec2::from_angle(turn))
            .collect()
    };
    let planes = [DVec3::Z, DVec3::X].map(|normal| Plane { normal, offset: 0.05 });
    let doubtful = |plane| {
        let parts = [
            (disc(0.7, 20), [Label(1), Label::OUTSIDE]),
            (disc(0.4, 10), [Label::UNKNOWN, Label(1)]),
        ];
        partition(plane, &parts, Label::OUTSIDE)
    };
    let mut sections: Vec<Section> = planes.into_iter().map(doubtful).collect();
    let blank = Plane { normal: DVec3::Y, offset: 0.1 };
    sections.push(partition(blank, &[], Label::UNKNOWN));
    let options = Options { spacing: Some(0.2), ..Options::default() };
    let difference = difference(make, &sections, DVec3::ZERO, &options);
    assert!(difference < TOLERANCE, "{difference:e}");
}

/// On a section a label's value is positive where the section shows it, and 0 on contours.
fn is_what_sections_say_on_them(make: Make) {
    let plane = Plane { normal: DVec3::Z, offset: 0.1 };
    let square = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(DVec2::from);
    let sections = [section(plane, &square, Label(2))];
    assert_eq!(polygon(4, Label(2)), sections[0].edges);
    let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let complex = Complex::new(&sections, bounds, Label::OUTSIDE).unwrap();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let options = Options { spacing: Some(0.1), ..Options::default() };
    let nodes = Nodes::new(&boundaries, &sections, &options, &Silent).unwrap();
    let Some(field) = make(&boundaries, &nodes, &options) else { return };
    let [u, v] = plane.tangents();
    for (along, expected) in [(0.0, 0.5), (0.3, 0.2), (0.5, 0.0), (0.7, -0.2)] {
        for cell in complex.cells().ids() {
            let points = vec![along * u + 0.05 * v + 0.1 * DVec3::Z];
            let queries = Queries { points, runs: vec![Run { cell, points: 0..1 }] };
            let values = field.evaluate(&queries).unwrap();
            assert_eq!(field.labels(cell), [Label::OUTSIDE, Label(2)]);
            for (found, expected) in values.iter().zip([-expected, expected]) {
                assert!((found - expected).abs() < 0.02, "{along} {cell}: {found}, not {expected}");
            }
        }
    }
}

/// A half-space: its sections' distances are not linear, but with their normals it is kept.
fn keeps_what_is_linear(make: Make) {
    let sections: Vec<Section> = [DVec3::X, DVec3::Y]
        .into_iter()
        .map(|normal| {
            let plane = Plane { normal, offset: 0.0 };
            // Large enough to cut the box: below z = 0.2.
            let corner =
                |[along, z]: [f64; 2]| plane.project(along * DVec3::Z.cross(normal) + z * DVec3::Z);
            let corners = [[-0.9, -0.9], [0.9, -0.9], [0.9, 0.2], [-0.9, 0.2]].map(corner).to_vec();
            partition(plane, &[(corners, [Label(1), Label::OUTSIDE])], Label::OUTSIDE)
        })
        .collect();
    let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let complex = Complex::new(&sections, bounds, Label::OUTSIDE).unwrap();
    let boundaries = Boundaries::new(&complex, 1e-4, None).unwrap();
    let options = Options { spacing: Some(0.1), ..Options::default() };
    let nodes = Nodes::new(&boundaries, &sections, &options, &Silent).unwrap();
    let Some(field) = make(&boundaries, &nodes, &options) else { return };
    for z in [0.1, 0.2, 0.3] {
        let point = DVec3::new(0.06, 0.04, z);
        let cell = complex.locate(point);
        let queries = Queries { points: vec![point], runs: vec![Run { cell, points: 0..1 }] };
        let found = f64::from(field.evaluate(&queries).unwrap()[1]);
        assert!((found - (0.2 - z)).abs() < 0.02, "{z}: {found}");
    }
}

fn ignores_the_order_of_runs(make: Make) {
    let mut random = Random::new(74);
    let sections = sections(&mut random, 2, DVec3::ZERO);
    let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let complex = Complex::new(&sections, bounds, Label::OUTSIDE).unwrap();
    let boundaries = Boundaries::new(&complex, 1e-4, None).unwrap();
    let options = Options { spacing: Some(0.3), ..Options::default() };
    let nodes = Nodes::new(&boundaries, &sections, &options, &Silent).unwrap();
    let Some(field) = make(&boundaries, &nodes, &options) else { return };
    let queries = queries(&complex, &mut random, 150);
    let values = field.evaluate(&queries).unwrap();
    // Backwards, a run a point.
    let (mut shuffled, mut expected, mut next) = (Queries::default(), Vec::new(), values.len());
    for run in queries.runs.iter().rev() {
        for point in run.points.clone().rev() {
            let points = shuffled.points.len()..shuffled.points.len() + 1;
            shuffled.points.push(queries.points[point]);
            shuffled.runs.push(Run { cell: run.cell, points });
            let labels = field.labels(run.cell).len();
            next -= labels;
            expected.extend_from_slice(&values[next..next + labels]);
        }
    }
    let bits = |values: &[f32]| values.iter().map(|f| f.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&field.evaluate(&shuffled).unwrap()), bits(&expected));
}

fn answers_nothing_with_nothing(make: Make) {
    let sections = sections(&mut Random::new(75), 1, DVec3::ZERO);
    let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    let complex = Complex::new(&sections, bounds, Label::OUTSIDE).unwrap();
    let boundaries = Boundaries::new(&complex, 1e-4, None).unwrap();
    let options = Options::default();
    let nodes = Nodes::new(&boundaries, &sections, &options, &Silent).unwrap();
    let Some(field) = make(&boundaries, &nodes, &options) else { return };
    assert!(field.evaluate(&Queries::default()).unwrap().is_empty());
    let empty = Queries { points: Vec::new(), runs: vec![Run { cell: 0, points: 0..0 }] };
    assert!(field.evaluate(&empty).unwrap().is_empty());
    let bad = Queries { points: vec![DVec3::ZERO], runs: vec![Run { cell: 0, points: 0..0 }] };
    assert!(field.evaluate(&bad).is_err());
}
