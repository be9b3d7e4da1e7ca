//! Random sections, many of them degenerate, against brute force in rationals.

use super::super::exact::{ExactPlane, Spot, number, triple};
use super::*;
use crate::random::Random;

/// A star around a place, with unknown, a hole or a second label in it.
fn star(random: &mut Random, kind: u64) -> Vec<(Vec<DVec2>, [Label; 2])> {
    let coordinate = |random: &mut Random| (random.unit() * 16.0).round() / 8.0 - 1.0;
    let middle = DVec2::new(coordinate(random), coordinate(random)) / 2.0;
    let ring = |radius: f64| -> Vec<DVec2> {
        let corner = |corner: u32| {
            let angle = std::f64::consts::TAU * f64::from(corner) / 10.0;
            let radius = if corner.is_multiple_of(2) { radius } else { 0.6 * radius };
            // On a coarse lattice, so that much is degenerate.
            ((middle + radius * DVec2::from_angle(angle)) * 64.0).round() / 64.0
        };
        (0..10).map(corner).collect()
    };
    let around = if kind.is_multiple_of(2) { U } else { O };
    let inside = if kind.is_multiple_of(3) { U } else { B };
    vec![(ring(0.9), [A, around]), (ring(0.3), [inside, A])]
}

/// Sections on planes of all kinds, some of them full.
fn mixture(seed: u64) -> Vec<Section> {
    let mut random = Random::new(seed);
    let normals = [
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -2.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 2.0, 3.0],
        [-0.3, 0.1, 0.7],
        [0.0, 1.0, 1e-9],
    ];
    let offsets = [0.0, -1.0, 0.25, 0.5, 1.0, -0.1, -0.5];
    let sections = normals.into_iter().zip(offsets).map(|(normal, offset)| {
        let kind = random.bits();
        let polygons = star(&mut random, kind);
        let background = polygons[0].1[1];
        partition(plane(normal, offset), &polygons, background)
    });
    sections.collect()
}

/// Points at random, on a coarse lattice, on vertices, and on lines of planes.
fn points(sections: &[Section], seed: u64) -> Vec<DVec3> {
    let mut random = Random::new(seed);
    let mut points = Vec::new();
    for _ in 0..300 {
        let point = DVec3::from([0; 3].map(|_| 3.0 * random.unit() - 1.5));
        points.push(point);
        points.push((point * 8.0).round() / 8.0);
        points.push(DVec3::new(point.x, point.x, 0.0));
    }
    for section in sections {
        let vertices = 0..section.vertices().len() as u32;
        for point in vertices.map(|vertex| section.point(vertex)) {
            points.extend([
                point,
                point + section.plane().normal / 4.0,
                (point * 8.0).round() / 8.0,
            ]);
        }
    }
    points
}

/// The label on a plane, by a ray towards larger second coordinates.
fn brute_label(section: &Section, exact: &ExactPlane, foot: &[Number; 2]) -> Label {
    let mut label = section.background().0;
    let mut touched = U;
    let place = |vertex: u32| section.vertices()[vertex as usize].to_array().map(number);
    for edge in section.edges() {
        let kept = [edge.start, edge.end].map(|vertex| section.vertices()[vertex as usize]);
        let foot_in_space = exact.lift(foot.clone());
        if exact.nearest_on(kept, &foot_in_space).squared == Number::ZERO {
            touched = touched.min(edge.left).min(edge.right);
        }
        let [a, b] = [place(edge.start), place(edge.end)];
        if (a[0] <= foot[0]) == (b[0] <= foot[0]) {
            continue;
        }
        let part = (&foot[0] - &a[0]) / (&b[0] - &a[0]);
        if &a[1] + part * (&b[1] - &a[1]) > foot[1] {
            // Rightward, the edge's right is below it.
            let [below, above] =
                if a[0] < b[0] { [edge.right, edge.left] } else { [edge.left, edge.right] };
            label = label.wrapping_add(below.0.wrapping_sub(above.0));
        }
    }
    if touched == U { Label(label) } else { touched }
}

/// Squared distance and label, for every section without any index or float.
fn brute(section: &Section, point: DVec3) -> Option<(Number, Label)> {
    let exact = ExactPlane::new(*section.plane());
    let point = triple(point);
    let label = brute_label(section, &exact, &exact.foot(&point));
    if label != U {
        return Some((exact.squared_distance(&point), label));
    }
    let vertex_label = |vertex: u32| {
        let at = section.edges().iter().filter(|edge| edge.start == vertex || edge.end == vertex);
        at.map(|edge| edge.left.min(edge.right)).min().unwrap()
    };
    let borders = section.edges().iter().filter(|edge| edge.left == U || edge.right == U);
    let near = borders.map(|edge| {
        let kept = [edge.start, edge.end].map(|vertex| section.vertices()[vertex as usize]);
        let found = exact.nearest_on(kept, &point);
        let label = match found.at {
            Spot::Start => vertex_label(edge.start),
            Spot::End => vertex_label(edge.end),
            Spot::Within => edge.left.min(edge.right),
        };
        (found.squared, label)
    });
    near.min()
}

#[test]
fn it_is_what_brute_force_finds() {
    for seed in 0..4 {
        let sections = mixture(seed);
        let oracle = Oracle::new(&sections, cube(1.5), U).unwrap();
        for point in points(&sections, seed) {
            let mut best: Option<(Number, u32, Label)> = None;
            for (number, section) in sections.iter().enumerate() {
                let Some((squared, label)) = brute(section, point) else { continue };
                if best.as_ref().is_none_or(|best| squared < best.0) {
                    best = Some((squared, number as u32, label));
                }
            }
            let (squared, section, label) = best.unwrap();
            let found = oracle.nearest(point);
            assert_eq!((found.section, found.label), (Some(section), label), "{seed} {point}");
            let distance = squared.to_f64().value().sqrt();
            assert!((found.distance - distance).abs() < 1e-14 * (1.0 + distance));
            assert!((found.foot.distance(point) - distance).abs() < 1e-14 * (1.0 + distance));
        }
    }
}

#[test]
fn many_labels_are_those_of_single_points() {
    let sections = mixture(5);
    let oracle = Oracle::new(&sections, cube(1.5), O).unwrap();
    let points = points(&sections, 9);
    let singly: Vec<Label> = points.iter().map(|&point| oracle.nearest(point).label).collect();
    assert_eq!(oracle.labels(&points), singly);
}
