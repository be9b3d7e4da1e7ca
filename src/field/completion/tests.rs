//! Hand-made complexes whose completion can be derived by hand.

use glam::{DVec2, DVec3};

use super::Completion;
use super::groups::groups;
use crate::complex::{Complex, FacetEdge};
use crate::field::fixture::{Patch, Pattern, Stack};
use crate::field::{Boundaries, Field, Queries, Reference, Run};
use crate::label::Label;
use crate::random::Random;

const UNKNOWN: u32 = u32::MAX;

fn unknown_disc(radius: f64, ground: u32) -> Pattern {
    let mut pattern = Pattern::plain(ground);
    pattern.patches.push(Patch::disc(DVec2::ZERO, radius, 256, UNKNOWN, ground));
    pattern
}

fn complete(complex: &Complex, spacing: f64) -> Completion {
    Completion::new(complex, 1e-6, spacing, None).unwrap()
}

/// The share of a label at the corner nearest to a point.
fn share_at(completion: &Completion, point: DVec3, label: u32) -> f64 {
    let corners = 0..completion.corner_count() as u32;
    let nearest = corners
        .min_by(|&a, &b| {
            let distance = |corner| completion.point(corner).distance(point);
            distance(a).total_cmp(&distance(b))
        })
        .unwrap();
    let slot = completion.labels().binary_search(&Label(label)).unwrap();
    completion.share(nearest, slot)
}

/// An unknown disc of radius ρ in label 1, close (h) to planes of label 2 on
/// both sides: in its middle the planes weigh 2 π/h, and the border 2π/ρ.
#[test]
fn a_region_is_a_blend_of_its_plane_and_its_neighbours() {
    for (radius, thickness) in [(0.5, 0.05), (0.3, 0.03), (0.6, 0.02)] {
        let mut stack =
            Stack::new(vec![Pattern::plain(2), unknown_disc(radius, 1), Pattern::plain(2)]);
        stack.thickness = thickness;
        let completion = complete(&stack.complex(), 0.1);
        let found = share_at(&completion, DVec3::new(0.0, 0.0, thickness), 2);
        let expected = radius / (radius + thickness);
        assert!((found - expected).abs() < 0.01, "ρ {radius}, h {thickness}: {found} {expected}");
    }
}

/// Between known planes of 1 and 2 two that know nothing: 2/3 and 1/3. The
/// walls know nothing either.
#[test]
fn what_is_known_is_seen_through_unknown_planes() {
    let mut stack =
        Stack::new([1, UNKNOWN, UNKNOWN, 2].into_iter().map(Pattern::plain).collect::<Vec<_>>());
    stack.walls = Label::UNKNOWN;
    stack.thickness = 0.05;
    let complex = stack.complex();
    assert_eq!(groups(&complex), [0, 0, 0]);
    let completion = complete(&complex, 0.1);
    for (level, expected) in [(1.0, 2.0 / 3.0), (2.0, 1.0 / 3.0)] {
        let found = share_at(&completion, DVec3::new(0.0, 0.0, 0.05 * level), 1);
        assert!((found - expected).abs() < 0.02, "level {level}: {found}");
    }
    assert!(completion.sweeps() < 100, "{} sweeps", completion.sweeps());
}

/// What was completed before is soon completed again, and is the same.
#[test]
fn a_completion_goes_on_from_the_one_before() {
    let mut busy = Pattern::plain(1);
    busy.patches.push(Patch::disc(DVec2::new(0.2, 0.1), 0.5, 20, 3, 1));
    let patterns = vec![busy, unknown_disc(0.9, 1), unknown_disc(0.8, 2), Pattern::plain(2)];
    let mut stack = Stack::new(patterns);
    let complete = |complex: &Complex, before| Completion::new(complex, 1e-6, 0.1, before).unwrap();
    let complex = stack.complex();
    let first = complete(&complex, None);
    let second = complete(&complex, Some(&first));
    assert!(second.sweeps() < first.sweeps() / 2, "{} {}", second.sweeps(), first.sweeps());
    // From another one it comes to the same, too.
    stack.patterns[3] = Pattern::plain(1);
    let other = complete(&stack.complex(), None);
    let third = complete(&complex, Some(&other));
    for completion in [&second, &third] {
        for corner in 0..first.corner_count() as u32 {
            for slot in 0..first.labels().len() {
                let apart = (first.share(corner, slot) - completion.share(corner, slot)).abs();
                assert!(apart < 2e-5, "{apart}");
            }
        }
    }
    let all: Vec<u32> = complex.facets().iter().map(|(id, _)| id).collect();
    let [was, is, differs] = [&first, &third, &other]
        .map(|completion| completion.shares_on(&all, completion.labels()).unwrap());
    assert!(was.is_near(&is, 2e-5) && !was.is_near(&is, 0.0) && !was.is_near(&differs, 1e-3));
}

/// Two cells around an unknown disc with nothing but label 1 in sight are that
/// label, exactly, though the next cell has another one.
#[test]
fn a_group_with_one_label_is_that_label() {
    let mut busy = Pattern::plain(1);
    busy.patches.push(Patch::disc(DVec2::ZERO, 0.5, 20, 5, 1));
    let mut stack =
        Stack::new(vec![Pattern::plain(1), unknown_disc(0.7, 1), Pattern::plain(1), busy]);
    stack.walls = Label(1);
    stack.rotation = Random::new(3).rotation();
    let complex = stack.complex();
    assert_eq!(groups(&complex), [0, 0, 1]);
    let boundaries = Boundaries::new(&complex, 1e-6, None).unwrap();
    let field = Reference::new(&boundaries).unwrap();
    let labels: Vec<&[Label]> = (0..3).map(|cell| field.labels(cell)).collect();
    assert_eq!(labels, [&[Label(1)][..], &[Label(1)], &[Label(1), Label(5)]]);
    let values = field.evaluate(&stack.queries(&mut Random::new(4), 50)).unwrap();
    assert!(values[..100].iter().all(|&f| f == 1.0));
}

/// Where two known regions and an unknown one meet, the unknown one has half
/// of each, and f is the mean by the angles (§5.1): 1 has an eighth of the
/// circle, 2 three eighths, the unknown one half.
#[test]
fn a_vertex_takes_the_limit_of_its_corners() {
    let stack = Stack::new(vec![Pattern::plain(0), Pattern::plain(0), Pattern::plain(0)]);
    let mut complex = stack.complex();
    let place = |x: f64, y: f64| DVec3::new(x, y, 1.0);
    let edge = |from: (f64, f64), to: (f64, f64), left: u32, right: Option<u32>| FacetEdge {
        start: place(from.0, from.1),
        end: place(to.0, to.1),
        left: Label(left),
        right: right.map(Label),
    };
    let face = complex.facets.values_mut().find(|facet| facet.plane == 1).unwrap();
    let (o, e, w) = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0));
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    let [ne, nw, sw, se] = corners;
    face.edges = vec![
        edge(o, e, 1, Some(UNKNOWN)),
        edge(e, ne, 1, None),
        edge(o, ne, 2, Some(1)),
        edge(ne, nw, 2, None),
        edge(nw, w, 2, None),
        edge(w, o, 2, Some(UNKNOWN)),
        edge(w, sw, UNKNOWN, None),
        edge(sw, se, UNKNOWN, None),
        edge(se, e, UNKNOWN, None),
    ];
    face.labels = vec![Label(1), Label(2), Label::UNKNOWN];
    for cell in complex.cells.values_mut() {
        cell.labels = vec![Label(0), Label(1), Label(2), Label::UNKNOWN];
    }
    let boundaries = Boundaries::new(&complex, 1e-7, Some(0.2)).unwrap();
    let field = Reference::new(&boundaries).unwrap();
    let queries =
        Queries { points: vec![place(0.0, 0.0)], runs: vec![Run { cell: 0, points: 0..1 }] };
    let values = field.evaluate(&queries).unwrap();
    let share = |label: u32| {
        let slot = field.labels(0).binary_search(&Label(label)).unwrap();
        (f64::from(values[slot]) + 1.0) / 2.0
    };
    assert!((share(1) - (1.0 / 8.0 + 1.0 / 4.0)).abs() < 1e-4, "{}", share(1));
    assert!((share(2) - (3.0 / 8.0 + 1.0 / 4.0)).abs() < 1e-4, "{}", share(2));
}

/// Triangles cover an unknown region once, to the tolerance of its outline, the
/// right way round.
#[test]
fn triangles_cover_the_region() {
    let mut stack = Stack::new(vec![Pattern::plain(0), unknown_disc(0.5, 1), Pattern::plain(0)]);
    // A known hole in it.
    stack.patterns[1].patches.push(Patch::disc(DVec2::new(0.1, 0.0), 0.2, 64, 3, UNKNOWN));
    stack.rotation = Random::new(8).rotation();
    stack.offset = DVec3::new(1e4, -3e4, 7.0);
    let complex = stack.complex();
    let completion = complete(&complex, 0.1);
    let normal = complex.planes()[1].unit_normal();
    let facet = complex.facets().iter().find(|(_, facet)| facet.plane == 1).unwrap().0;
    let mut area = 0.0;
    for corners in completion.triangles(facet) {
        let [a, b, c] = corners.map(|corner| completion.point(corner));
        let own = (b - a).cross(c - a).dot(normal) / 2.0;
        assert!(own > 0.0);
        area += own;
    }
    let expected = std::f64::consts::PI * (0.25 - 0.04);
    // The outline strays by a 160th, over a length of 1.4 π.
    assert!((area - expected).abs() < 1.4 * std::f64::consts::PI / 160.0, "{area} {expected}");
    let total: usize = completion.triangle_count();
    assert_eq!(total, completion.triangles(facet).len());
}

#[test]
fn everything_unknown_is_an_error() {
    let mut stack = Stack::new(vec![Pattern::plain(UNKNOWN), Pattern::plain(UNKNOWN)]);
    stack.walls = Label::UNKNOWN;
    let error = Boundaries::new(&stack.complex(), 1e-6, None).unwrap_err();
    assert!(error.to_string().contains("everything is unknown"), "{error}");
}

/// The numbers of threads change no bit.
#[test]
fn threads_change_nothing() {
    let mut patterns = vec![Pattern::plain(0), unknown_disc(0.5, 1), unknown_disc(0.7, 2)];
    patterns.push(Pattern::plain(1));
    let complex = Stack::new(patterns).complex();
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| complete(&complex, 0.05).shares)
    });
    assert!(!one.is_empty());
    assert_eq!(one, three);
}
