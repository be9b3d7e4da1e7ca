//! What every backend must do, run for each of them.

use glam::{DVec2, DVec3};

use super::cpu::Instructions;
use super::fixture::{Patch, Pattern, Stack, busy_stack, doubtful_stack};
use super::*;
use crate::random::Random;

/// In f, against the f64 reference.
const TOLERANCE: f32 = 1e-4;

/// A backend on this machine, or nothing (and a word about it).
type Make = fn(&Boundaries) -> Option<Box<dyn Field>>;

fn reference(boundaries: &Boundaries) -> Option<Box<dyn Field>> {
    Some(Box::new(Reference::new(boundaries).unwrap()))
}

fn cpu(boundaries: &Boundaries) -> Option<Box<dyn Field>> {
    Some(Box::new(Cpu::new(boundaries).unwrap()))
}

fn cpu_baseline(boundaries: &Boundaries) -> Option<Box<dyn Field>> {
    let cpu = Cpu::new(boundaries).unwrap();
    Some(Box::new(cpu.with_instructions(Instructions::Baseline)))
}

fn gpu(boundaries: &Boundaries) -> Option<Box<dyn Field>> {
    match Gpu::new(boundaries, Adapter::Any) {
        Ok(gpu) => Some(Box::new(gpu)),
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
            contract!(@tests $backend: reproduces_constants, agrees_with_reference,
                completes_unknown_regions,
                survives_thin_cells, survives_far_offsets, sums_to_one, tends_to_own_region,
                ignores_order_of_runs, answers_nothing_with_nothing, handles_many_labels,
                refuses_bad_runs);
        })*
    };
    (@tests $backend:ident: $($test:ident),*) => {
        $(#[test]
        fn $test() {
            super::$test(super::$backend);
        })*
    };
}

contract!(reference, cpu, cpu_baseline, gpu);

/// The largest difference to the reference over random points.
fn largest_difference(make: Make, stack: &Stack, random: &mut Random, per_cell: usize) -> f32 {
    let complex = stack.complex();
    let clearance = 1e-7 * complex.bounds().diagonal();
    let boundaries = Boundaries::new(&complex, clearance, None).unwrap();
    let Some(field) = make(&boundaries) else { return 0.0 };
    let queries = stack.queries(random, per_cell);
    let expected = Reference::new(&boundaries).unwrap().evaluate(&queries).unwrap();
    let found = field.evaluate(&queries).unwrap();
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().all(|f| (-1.0..=1.0).contains(f)));
    found.iter().zip(&expected).map(|(f, e)| (f - e).abs()).fold(0.0, f32::max)
}

fn reproduces_constants(make: Make) {
    let mut busy = Pattern::plain(0);
    busy.patches.push(Patch::disc(DVec2::ZERO, 0.5, 20, 3, 0));
    let stack = Stack::new(vec![Pattern::plain(0), Pattern::plain(0), busy]);
    let complex = stack.complex();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let Some(field) = make(&boundaries) else { return };
    assert_eq!(field.labels(0), [Label::OUTSIDE]);
    assert_eq!(field.labels(1), [Label::OUTSIDE, Label(3)]);
    assert_eq!(field.edges(0), 0);
    assert_eq!(field.edges(1), 6 * 4 + 20);
    let queries = stack.queries(&mut Random::new(1), 100);
    let values = field.evaluate(&queries).unwrap();
    assert_eq!(values.len(), 100 + 200);
    assert!(values[..100].iter().all(|&f| f == 1.0));
    assert!(values[100..].iter().all(|&f| f != 1.0));
    assert_eq!(queries.edge_evaluations(&*field), 100 * 44);
}

fn agrees_with_reference(make: Make) {
    let mut random = Random::new(2);
    for labels in [2, 3, 9] {
        for corners in [3, 16, 200] {
            let stack = busy_stack(&mut random, labels, corners);
            let difference = largest_difference(make, &stack, &mut random, 200);
            assert!(difference < TOLERANCE, "{labels} labels, {corners} corners: {difference}");
        }
    }
}

/// Unknown discs among the others, and one that reaches over them: values as
/// the reference has them, by another formula.
fn completes_unknown_regions(make: Make) {
    let mut random = Random::new(13);
    for labels in [2, 5, 20] {
        for corners in [3, 40] {
            let stack = doubtful_stack(&mut random, labels, corners);
            let difference = largest_difference(make, &stack, &mut random, 300);
            assert!(difference < TOLERANCE, "{labels} labels, {corners} corners: {difference}");
        }
    }
}

/// Without f64 a GPU knows γ to 4e-11 of a cell's size.
fn survives_thin_cells(make: Make) {
    let mut random = Random::new(3);
    for thickness in [1e-2, 1e-4, 1e-5] {
        let mut stack = busy_stack(&mut random, 4, 30);
        stack.thickness = thickness;
        let difference = largest_difference(make, &stack, &mut random, 500);
        assert!(difference < TOLERANCE, "thickness {thickness}: {difference}");
    }
}

/// Projected map coordinates: millions of metres from the origin.
fn survives_far_offsets(make: Make) {
    let mut random = Random::new(4);
    let mut stack = busy_stack(&mut random, 4, 30);
    stack.offset = DVec3::new(4.5e5, 5.4e6, 300.0);
    let difference = largest_difference(make, &stack, &mut random, 500);
    assert!(difference < TOLERANCE, "{difference}");
}

/// Σ (f_l + 1) / 2 = Σ W_l / W = 1.
fn sums_to_one(make: Make) {
    let mut random = Random::new(5);
    let stack = busy_stack(&mut random, 7, 25);
    let complex = stack.complex();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let Some(field) = make(&boundaries) else { return };
    let values = field.evaluate(&stack.queries(&mut random, 200)).unwrap();
    let labels = field.labels(0).len();
    assert_eq!(field.labels(1).len(), labels);
    for point in values.chunks(labels) {
        let sum: f32 = point.iter().map(|f| (f + 1.0) / 2.0).sum();
        assert!((sum - 1.0).abs() < 1e-5, "{sum}");
    }
}

/// On a plane and next to it f is 1 for the region at the foot and −1 for the
/// others, on both sides, whichever way the normal points.
fn tends_to_own_region(make: Make) {
    let mut disc = Pattern::plain(1);
    disc.patches.push(Patch::disc(DVec2::new(0.2, 0.1), 0.5, 40, 2, 1));
    let mut stack = Stack::new(vec![Pattern::plain(0), disc, Pattern::plain(0)]);
    stack.rotation = Random::new(6).rotation();
    let complex = stack.complex();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let Some(field) = make(&boundaries) else { return };
    for (place, label) in [(DVec2::new(0.2, 0.1), 2), (DVec2::new(-0.7, -0.6), 1)] {
        for (cell, height) in [(0, -1e-4), (0, -1e-9), (0, 0.0), (1, 0.0), (1, 1e-9), (1, 1e-4)] {
            let points = vec![stack.place(place.extend(1.0 + height))];
            let queries = Queries { points, runs: vec![Run { cell, points: 0..1 }] };
            let values = field.evaluate(&queries).unwrap();
            for (&found, &of) in values.iter().zip(field.labels(cell)) {
                let expected = if of == Label(label) { 1.0 } else { -1.0 };
                assert!((found - expected).abs() < 1e-3, "{place} {height} {of}: {found}");
            }
        }
    }
}

/// Cutting and reordering runs changes no byte of any point's values.
fn ignores_order_of_runs(make: Make) {
    let mut random = Random::new(7);
    let stack = busy_stack(&mut random, 3, 12);
    let complex = stack.complex();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let Some(field) = make(&boundaries) else { return };
    let queries = stack.queries(&mut random, 150);
    let values = field.evaluate(&queries).unwrap();
    let labels = field.labels(0).len();
    // Backwards, one run a point in the first cell, runs of 50 in the second.
    let mut shuffled = Queries::default();
    let mut expected = Vec::new();
    for point in (0..queries.points.len()).rev() {
        let cell = u32::from(point >= 150);
        let position = shuffled.points.len();
        shuffled.points.push(queries.points[point]);
        match shuffled.runs.last_mut().filter(|_| cell == 1 && position % 50 != 0) {
            Some(run) => run.points.end += 1,
            None => shuffled.runs.push(Run { cell, points: position..position + 1 }),
        }
        expected.extend_from_slice(&values[point * labels..][..labels]);
    }
    let found = field.evaluate(&shuffled).unwrap();
    let bits = |values: &[f32]| values.iter().map(|f| f.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&found), bits(&expected));
}

fn answers_nothing_with_nothing(make: Make) {
    let stack = busy_stack(&mut Random::new(8), 3, 12);
    let complex = stack.complex();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let Some(field) = make(&boundaries) else { return };
    assert!(field.evaluate(&Queries::default()).unwrap().is_empty());
    let queries = Queries { points: vec![], runs: vec![Run { cell: 1, points: 0..0 }] };
    assert!(field.evaluate(&queries).unwrap().is_empty());
}

/// More labels in a cell than a shader adds up at once.
fn handles_many_labels(make: Make) {
    let mut random = Random::new(9);
    let stack = busy_stack(&mut random, 49, 8);
    assert_eq!(stack.complex().cells()[0].labels.len(), 50);
    let difference = largest_difference(make, &stack, &mut random, 200);
    assert!(difference < TOLERANCE, "{difference}");
}

fn refuses_bad_runs(make: Make) {
    let stack = busy_stack(&mut Random::new(10), 2, 6);
    let complex = stack.complex();
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let Some(field) = make(&boundaries) else { return };
    for runs in [
        vec![],
        vec![Run { cell: 0, points: 0..1 }],
        vec![Run { cell: 0, points: 1..2 }],
        vec![Run { cell: 2, points: 0..2 }],
        vec![Run { cell: 0, points: 0..2 }, Run { cell: 0, points: 1..2 }],
    ] {
        let queries = Queries { points: vec![stack.place(DVec3::Z); 2], runs };
        assert!(matches!(field.evaluate(&queries), Err(Error::Bug { .. })), "{queries:?}");
    }
}

#[test]
fn threads_change_nothing() {
    let mut random = Random::new(11);
    let stack = busy_stack(&mut random, 5, 20);
    let complex = stack.complex();
    let field = Cpu::new(&Boundaries::new(&complex, 1e-6, None).unwrap()).unwrap();
    let queries = stack.queries(&mut random, 1000);
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| field.evaluate(&queries).unwrap())
    });
    assert_eq!(one, three);
}

/// Above a straight contour on an otherwise empty plane, f = s / √(s² + γ²),
/// with s the distance of the foot inside the region.
#[test]
fn reference_above_a_half_plane() {
    let corners = [(0.0, -0.9), (0.9, -0.9), (0.9, 0.9), (0.0, 0.9)].map(DVec2::from).to_vec();
    let half = Patch { corners, inside: Label(2), around: Label::OUTSIDE };
    let pattern = Pattern { ground: Label::OUTSIDE, patches: vec![half] };
    let mut stack = Stack::new(vec![pattern, Pattern::plain(0)]);
    stack.scale = 1e6;
    let complex = stack.complex();
    let field = Reference::new(&Boundaries::new(&complex, 1e-3, None).unwrap()).unwrap();
    assert_eq!(field.labels(0), [Label::OUTSIDE, Label(2)]);
    for s in [-2.0, -0.3, 0.0, 0.1, 1.0] {
        for gamma in [0.1_f64, 0.5, 2.0] {
            let x = DVec3::new(s, 0.0, gamma);
            let found = field.indicator(0, x)[1];
            let expected = s / s.hypot(gamma);
            assert!((found - expected).abs() < 3e-5, "s {s}, γ {gamma}: {found} {expected}");
        }
    }
}

#[test]
fn bad_clearances_and_spacings_are_refused() {
    let complex = busy_stack(&mut Random::new(12), 2, 6).complex();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = Boundaries::new(&complex, bad, None).unwrap_err();
        assert!(error.to_string().contains("clearance"), "{error}");
        let error = Boundaries::new(&complex, 1e-6, Some(bad)).unwrap_err();
        assert!(error.to_string().contains("spacing"), "{error}");
    }
    let error = Boundaries::new(&complex, 1e-6, Some(1e-9)).unwrap_err();
    assert!(error.to_string().contains("too small"), "{error}");
}
