use glam::DVec2;

use super::*;
use crate::check::shapes::{disc, partition, rectangle};
use crate::label::Label;

const FLOOR: Plane = Plane { normal: DVec3::new(0.0, 0.0, 2.0), offset: 0.0 };

/// The frame [0, 4] × [0, 2] on the floor, with an unknown spot
/// [1, 3] × [½, 1½] in it.
fn frame() -> Section {
    let frame = (rectangle([0.0, 0.0], [4.0, 2.0]), [Label::OUTSIDE, Label::UNKNOWN]);
    let spot = (rectangle([1.0, 0.5], [3.0, 1.5]), [Label::UNKNOWN, Label::OUTSIDE]);
    partition(FLOOR, &[frame, spot], Label::UNKNOWN)
}

fn distance(evidence: &Evidence, point: [f64; 3]) -> f64 {
    evidence.near(point.into(), 0.0).distance(point.into()).unwrap()
}

#[test]
fn from_planes_known_all_over_it_is_the_height() {
    let top = Plane { normal: -DVec3::Z, offset: -3.0 };
    let sections = [disc(FLOOR, 1.0, 12, Label(1)), partition(top, &[], Label::OUTSIDE)];
    let evidence = Evidence::new(&sections);
    for (z, expected) in [(-2.0, 2.0), (0.0, 0.0), (0.25, 0.25), (1.5, 1.5), (2.0, 1.0), (7.0, 4.0)]
    {
        assert_eq!(distance(&evidence, [5.0, -70.0, z]), expected);
    }
}

#[test]
fn from_a_frame_it_is_the_distance_to_its_known_part() {
    let evidence = Evidence::new(&[frame()]);
    let cases = [
        ([0.5, 1.0, 3.0], 3.0),   // above the known part
        ([6.0, 1.0, 0.0], 2.0),   // beside the frame
        ([7.0, 6.0, 12.0], 13.0), // past its corner: 3, 4, 12
        ([2.0, 1.0, 1.2], 1.3),   // above the middle of the spot: ½, 1.2
        ([1.25, 1.0, 0.0], 0.25), // on the spot
    ];
    for (point, expected) in cases {
        let found = distance(&evidence, point);
        assert!((found - expected).abs() < 1e-12, "{point:?}: {found}");
    }
}

#[test]
fn a_section_that_knows_nothing_does_not_count() {
    let unknown = partition(Plane { offset: 1.0, ..FLOOR }, &[], Label::UNKNOWN);
    let evidence = Evidence::new(&[unknown.clone(), frame()]);
    assert_eq!(distance(&evidence, [0.5, 1.0, 0.5]), 0.5);
    assert!(Evidence::new(&[unknown]).near(DVec3::ZERO, 1.0).distance(DVec3::ZERO).is_none());
}

#[test]
fn in_a_leaf_all_is_as_for_each_point_alone() {
    // Frames on planes of all directions, a star with many corners among them.
    let star = |corner: u32| {
        let angle = std::f64::consts::TAU * f64::from(corner) / 60.0;
        DVec2::from_angle(angle) * if corner.is_multiple_of(2) { 2.0 } else { 1.2 }
    };
    let stars = |plane| {
        let corners = (0..60).map(star).collect();
        partition(plane, &[(corners, [Label(1), Label::UNKNOWN])], Label::UNKNOWN)
    };
    let mut sections = vec![frame()];
    for (normal, offset) in [
        (DVec3::new(1.0, 2.0, 0.5), 1.0),
        (DVec3::new(-1.0, 0.3, 2.0), -0.7),
        (DVec3::new(0.1, -1.0, 0.2), 0.4),
    ] {
        sections.push(stars(Plane { normal, offset }));
    }
    let evidence = Evidence::new(&sections);
    let lattice = Lattice { origin: DVec3::splat(-2.0), voxel: 0.11, dims: [40; 3] };
    let alone = |point: DVec3| {
        let each = sections.iter().map(|one| Evidence::new(std::slice::from_ref(one)));
        each.map(|one| distance(&one, point.to_array())).fold(f64::INFINITY, f64::min)
    };
    for at in [[0, 0, 0], [1, 2, 3], [4, 4, 0], [2, 2, 2]] {
        let values = evidence.in_leaf(&lattice, at);
        for (node, value) in values.into_iter().enumerate().step_by(7) {
            let offset = [node / 64, node / 8 % 8, node % 8];
            let node = std::array::from_fn(|axis| at[axis] * 8 + offset[axis] as i32);
            let expected = alone(lattice.position(node));
            assert!((f64::from(value) - expected).abs() < 1e-6, "{node:?}: {value} {expected}");
        }
    }
}

#[test]
fn many_borders_are_searched_as_if_one_by_one() {
    // A row of 40 known squares of side ½ at x = 0, 1, 2, …
    let squares: Vec<_> = (0..40)
        .map(f64::from)
        .map(|x| (rectangle([x, 0.0], [x + 0.5, 0.5]), [Label(1), Label::UNKNOWN]))
        .collect();
    let evidence = Evidence::new(&[partition(FLOOR, &squares, Label::UNKNOWN)]);
    for step in 0..400 {
        let x = 0.1 * f64::from(step) + 0.013;
        let aside = if x.fract() < 0.5 || x > 39.5 {
            (x - 39.5).max(0.0)
        } else {
            (x.fract() - 0.5).min(1.0 - x.fract())
        };
        let found = distance(&evidence, [x, 0.25, 0.3]);
        assert!((found - aside.hypot(0.3)).abs() < 1e-9, "{x}: {found}");
    }
}
