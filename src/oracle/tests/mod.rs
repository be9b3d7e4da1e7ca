//! Hand-made points; brute force in rationals is in `brute`.

use glam::DVec2;

use super::*;
use crate::check::shapes::{partition, rectangle};
use crate::plane::Plane;
use crate::section::Edge;

mod brute;
mod shape;

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
        partition(plane([0.0, 0.0, 1.0], -0.5), &[(square(0.4), [A, O])], O),
        partition(plane([0.0, 0.0, -3.0], -1.5), &[(square(0.4), [B, O])], O),
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
    let mut sections = [partition(floor(), &polygons, Label(7))];
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
    let mut half = partition(
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
    let hole = partition(
        floor(),
        &[(square(4.0), [A, O]), (rectangle([-2.0, -1.0], [2.0, 1.0]), [U, A])],
        O,
    );
    let above = partition(plane([0.0, 0.0, 1.0], 3.0), &[], B);
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
    let sections = [partition(plane([1.0, 0.0, 0.0], 0.0), &[(square(1.0), [A, U])], U)];
    let oracle = Oracle::new(&sections, cube(9.0), O).unwrap();
    assert_eq!(ask(&oracle, [0.5, 0.5, 0.5]), (A, Some(0), 0.5));
    assert_eq!(ask(&oracle, [3.0, 5.0, 0.0]), (O, None, 4.0));
    assert_eq!(ask(&oracle, [2.0, 3.0, 2.0]), (A, Some(0), 3.0));
    let unknown = [partition(floor(), &[], U)];
    assert!(Oracle::new(&unknown, cube(1.0), U).is_err());
    assert_eq!(ask(&Oracle::new(&unknown, cube(1.0), O).unwrap(), [0.5, 0.0, 0.0]).2, 0.5);
}

#[test]
fn what_is_not_a_number_is_near_to_nothing() {
    let sections = [partition(floor(), &[(square(1.0), [A, U])], U)];
    for border in [O, U] {
        let oracle = Oracle::new(&sections, cube(9.0), border).unwrap();
        for bad in [f64::NAN, f64::INFINITY, f64::MAX] {
            oracle.nearest(DVec3::new(0.0, bad, 0.0));
        }
    }
}
