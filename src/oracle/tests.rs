//! Hand-made points, and everything once more by brute force in rationals.

use glam::DVec2;

use super::exact::{ExactPlane, Spot, triple};
use super::*;
use crate::plane::Plane;
use crate::random::Random;
use crate::section::Edge;

const U: Label = Label::UNKNOWN;
const O: Label = Label::OUTSIDE;
const A: Label = Label(1);
const B: Label = Label(2);

fn plane(normal: [f64; 3], offset: f64) -> Plane {
    Plane { normal: normal.into(), offset }
}

fn floor() -> Plane {
    plane([0.0, 0.0, 2.0], 0.0)
}

/// A plane with polygons on it, counter-clockwise, and the labels left and
/// right of their edges.
fn section(plane: Plane, polygons: &[(Vec<DVec2>, [Label; 2])], background: Label) -> Section {
    let mut section =
        Section { name: "test".into(), plane, vertices: vec![], edges: vec![], background };
    for (corners, [left, right]) in polygons {
        let (first, count) = (section.vertices.len() as u32, corners.len() as u32);
        let edge = |at| Edge {
            start: first + at,
            end: first + (at + 1) % count,
            left: *left,
            right: *right,
        };
        section.edges.extend((0..count).map(edge));
        section.vertices.extend(corners);
    }
    section
}

fn rectangle(min: [f64; 2], max: [f64; 2]) -> Vec<DVec2> {
    [min, [max[0], min[1]], max, [min[0], max[1]]].map(DVec2::from).to_vec()
}

fn square(half: f64) -> Vec<DVec2> {
    rectangle([-half; 2], [half; 2])
}

fn cube(half: f64) -> Bounds {
    Bounds { min: DVec3::splat(-half), max: DVec3::splat(half) }
}

/// Label, section and distance.
fn ask(oracle: &Oracle, point: [f64; 3]) -> (Label, Option<u32>, f64) {
    let nearest = oracle.nearest(point.into());
    assert!((nearest.foot.distance(point.into()) - nearest.distance).abs() < 1e-12);
    (nearest.label, nearest.section, nearest.distance)
}

#[test]
fn the_nearest_plane_decides() {
    let sections = [
        section(plane([0.0, 0.0, 1.0], -0.5), &[(square(0.4), [A, O])], O),
        section(plane([0.0, 0.0, -3.0], -1.5), &[(square(0.4), [B, O])], O),
    ];
    let oracle = Oracle::new(&sections, cube(1.5), O).unwrap();
    assert_eq!(ask(&oracle, [0.1, 0.2, 0.25]), (B, Some(1), 0.25));
    assert_eq!(ask(&oracle, [0.1, 0.2, -0.125]), (A, Some(0), 0.375));
    assert_eq!(ask(&oracle, [0.5, 0.2, -0.125]), (O, Some(0), 0.375));
    assert_eq!(ask(&oracle, [0.0, 0.0, 0.5]), (B, Some(1), 0.0));
    // Equally near: the first.
    assert_eq!(ask(&oracle, [0.0, 0.0, 0.0]), (A, Some(0), 0.5));
    // Equally near to the box's face at 1.5: the section; a little beyond: the box.
    assert_eq!(ask(&oracle, [0.0, 0.0, 1.0]), (B, Some(1), 0.5));
    assert_eq!(ask(&oracle, [0.0, 0.0, 1.0_f64.next_up()]).1, None);
    assert_eq!(ask(&oracle, [0.0, -1.25, 0.0]), (O, None, 0.25));
    assert_eq!(ask(&oracle, [7.0, 0.0, 0.25]), (O, None, 0.0));
    // Faces that are not known do not count.
    let open = Oracle::new(&sections, cube(1.5), U).unwrap();
    assert_eq!(ask(&open, [0.0, 0.0, 1.25]), (B, Some(1), 0.75));
    assert_eq!(ask(&open, [0.0, 0.0, 4.5]), (B, Some(1), 4.0));
}

#[test]
fn on_a_contour_the_smallest_label_around_counts() {
    // Two squares side by side, and one that touches them in a corner.
    let polygons =
        [(rectangle([0.0, 0.0], [1.0, 1.0]), [B, O]), (rectangle([1.0, 1.0], [2.0, 2.0]), [A, O])];
    let mut sections = [section(floor(), &polygons, Label(7))];
    sections[0].edges.iter_mut().for_each(|edge| edge.right = Label(7));
    let oracle = Oracle::new(&sections, cube(5.0), U).unwrap();
    let label = |x, y| ask(&oracle, [x, y, 0.25]).0;
    assert_eq!(label(0.5, 0.5), B);
    assert_eq!(label(1.5, 1.5), A);
    assert_eq!(label(1.5, 0.5), Label(7));
    for (x, y) in [(0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.0, 1.0), (1.0, 0.25)] {
        assert_eq!(label(x, y), B, "{x} {y}");
    }
    assert_eq!(label(1.0, 1.0), A);
    // On the lines of edges, but not on edges.
    for (x, y) in [(-1.0, 0.0), (3.0, 1.0), (1.0, -0.5), (2.5, 0.0), (2.0, 0.5)] {
        assert_eq!(label(x, y), Label(7), "{x} {y}");
    }
}

#[test]
fn beyond_a_half_plane_its_border_is_nearest() {
    // Known where x < 0 (and not very far away), A below y = 0 and B above.
    let mut half = section(
        floor(),
        &[
            (rectangle([-9.0, -9.0], [0.0, 0.0]), [A, U]),
            (rectangle([-9.0, 0.0], [0.0, 9.0]), [B, U]),
        ],
        U,
    );
    // Shared by both: the edge along y = 0.
    half.vertices = [[-9.0, -9.0], [0.0, -9.0], [0.0, 0.0], [-9.0, 0.0], [0.0, 9.0], [-9.0, 9.0]]
        .map(DVec2::from)
        .to_vec();
    let edge = |start, end, left, right| Edge { start, end, left, right };
    half.edges = vec![
        edge(0, 1, A, U),
        edge(1, 2, A, U),
        edge(2, 3, A, B),
        edge(3, 0, A, U),
        edge(2, 4, B, U),
        edge(4, 5, B, U),
        edge(5, 3, B, U),
    ];
    let sections = [half];
    let oracle = Oracle::new(&sections, cube(10.0), U).unwrap();
    assert_eq!(ask(&oracle, [-1.0, -2.0, 0.5]), (A, Some(0), 0.5));
    assert_eq!(ask(&oracle, [3.0, -2.0, 4.0]), (A, Some(0), 5.0));
    assert_eq!(ask(&oracle, [3.0, 1e-9, 4.0]), (B, Some(0), 5.0));
    // The point where A, B and the unknown meet, which is both: the smallest.
    assert_eq!(ask(&oracle, [3.0, 0.0, 4.0]), (A, Some(0), 5.0));
    // The corner (0, 9).
    assert_eq!(ask(&oracle, [3.0, 13.0, 12.0]), (B, Some(0), 13.0));
}

#[test]
fn in_a_hole_the_nearest_rim_counts() {
    let hole = section(
        floor(),
        &[(square(4.0), [A, O]), (rectangle([-2.0, -1.0], [2.0, 1.0]), [U, A])],
        O,
    );
    let above = section(plane([0.0, 0.0, 1.0], 3.0), &[], B);
    let sections = [hole, above];
    let oracle = Oracle::new(&sections, cube(20.0), O).unwrap();
    assert_eq!(ask(&oracle, [0.0, 0.5, 0.0]), (A, Some(0), 0.5));
    assert_eq!(ask(&oracle, [1.75, 0.25, 0.0]), (A, Some(0), 0.25));
    // √(1 + 1.25²) > 1.75 from the rim's middle and 1.75 from the plane above.
    assert_eq!(ask(&oracle, [0.0, 0.0, 1.25]).0, A);
    assert_eq!(ask(&oracle, [0.0, 0.0, 1.5]), (B, Some(1), 1.5));
    // 1 + z² = (3 − z)² at z = 4/3, just beside which floats still can tell.
    assert_eq!(ask(&oracle, [0.0, 0.0, 4.0 / 3.0 - 1e-12]).0, A);
    assert_eq!(ask(&oracle, [0.0, 0.0, 4.0 / 3.0 + 1e-12]).0, B);
}

#[test]
fn a_patch_is_nearest_at_its_sides_and_corners() {
    let sections = [section(plane([1.0, 0.0, 0.0], 0.0), &[(square(1.0), [A, U])], U)];
    let oracle = Oracle::new(&sections, cube(9.0), O).unwrap();
    assert_eq!(ask(&oracle, [0.5, 0.5, 0.5]), (A, Some(0), 0.5));
    assert_eq!(ask(&oracle, [3.0, 5.0, 0.0]), (O, None, 4.0));
    assert_eq!(ask(&oracle, [2.0, 3.0, 2.0]), (A, Some(0), 3.0));
    let unknown = [section(floor(), &[], U)];
    assert!(Oracle::new(&unknown, cube(1.0), U).is_err());
    assert_eq!(ask(&Oracle::new(&unknown, cube(1.0), O).unwrap(), [0.5, 0.0, 0.0]).2, 0.5);
}

#[test]
fn what_is_not_a_number_is_near_to_nothing() {
    let sections = [section(floor(), &[(square(1.0), [A, U])], U)];
    for border in [O, U] {
        let oracle = Oracle::new(&sections, cube(9.0), border).unwrap();
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            oracle.nearest(DVec3::new(0.0, bad, 0.0));
        }
    }
}

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
        let kind = random.next();
        let polygons = star(&mut random, kind);
        let background = polygons[0].1[1];
        section(plane(normal, offset), &polygons, background)
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
