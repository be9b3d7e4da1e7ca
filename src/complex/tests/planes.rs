//! Cells and faces of planes without contours, degenerate positions first.

use glam::{DMat3, DVec3};

use super::*;

fn counts(complex: &Complex) -> [usize; 2] {
    [complex.cells().count(), complex.facets().count()]
}

#[test]
fn no_plane_leaves_the_box() {
    assert_eq!(counts(&arrange(&[], UNIT)), [1, 6]);
}

#[test]
fn one_plane_parts_the_box_and_four_of_its_faces() {
    let complex = arrange_planes(&[plane([0.0, 0.0, 2.0], 1.0)], UNIT);
    assert_eq!(counts(&complex), [2, 1 + 2 + 4 * 2]);
    let facet = facets_on(&complex, 0)[0];
    assert!(facet.cells.iter().all(Option::is_some));
    let corners: [f64; 3] =
        std::array::from_fn(|i| facet.outline.iter().map(|corner| corner[i]).fold(0.0, f64::max));
    assert_eq!(corners, [1.0, 1.0, 0.5]);
}

#[test]
fn three_planes_through_one_point_make_octants() {
    let planes = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 3.0]].map(|n| plane(n, 0.0));
    assert_eq!(counts(&arrange_planes(&planes, CENTERED)), [8, 9 * 4]);
}

#[test]
fn parallel_planes_make_slabs() {
    for count in [2, 7, 40] {
        let planes: Vec<Plane> =
            (1..=count).map(|i| plane([1.0, 2.0, 0.5], 0.08 * f64::from(i))).collect();
        let complex = arrange_planes(&planes, UNIT);
        assert_eq!(complex.cells().count(), count as usize + 1);
    }
}

#[test]
fn four_planes_through_one_line_make_wedges() {
    let planes = [
        plane([1.0, 0.0, 0.0], 0.5),
        plane([1.0, 1.0, 0.0], 1.0),
        plane([0.0, 1.0, 0.0], 0.5),
        plane([1.0, -1.0, 0.0], 0.0),
    ];
    let complex = arrange_planes(&planes, UNIT);
    // Each plane is halved; four sides are halved, top and bottom show wedges.
    assert_eq!(counts(&complex), [8, 4 * 2 + 4 * 2 + 2 * 8]);
}

#[test]
fn six_planes_through_one_point_make_an_icosidodecahedron() {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let planes = [
        [0.0, 1.0, golden],
        [0.0, -1.0, golden],
        [1.0, golden, 0.0],
        [-1.0, golden, 0.0],
        [golden, 0.0, 1.0],
        [golden, 0.0, -1.0],
    ];
    // 12 pentagons and 20 triangles, seen from the middle.
    assert_eq!(arrange_planes(&planes.map(|n| plane(n, 0.0)), CENTERED).cells().count(), 32);
}

#[test]
fn a_grid_of_planes_makes_boxes() {
    let mut planes = Vec::new();
    for axis in 0..3 {
        for i in 1..=3 {
            planes.push(Plane { normal: DVec3::AXES[axis], offset: f64::from(i) / 4.0 });
        }
    }
    assert_eq!(counts(&arrange_planes(&planes, UNIT)), [64, 9 * 16 + 6 * 16]);
}

#[test]
fn planes_may_pass_through_edges_and_corners_of_the_box() {
    let diagonal = plane([1.0, -1.0, 0.0], 0.0);
    assert_eq!(counts(&arrange_planes(&[diagonal], UNIT)), [2, 1 + 4 + 2 * 2]);
    // Three corners: one cell is a tetrahedron.
    let corners = plane([1.0, 1.0, 1.0], 1.0);
    assert_eq!(counts(&arrange_planes(&[corners], UNIT)), [2, 1 + 3 + 3 * 2]);
    let both = arrange_planes(&[diagonal, corners], UNIT);
    assert_eq!(both.cells().count(), 4);
    // Through one corner and into the box.
    assert_eq!(arrange_planes(&[plane([1.0, 1.0, -1.0], 0.0)], UNIT).cells().count(), 2);
}

#[test]
fn planes_that_only_touch_the_box_or_miss_it_cut_nothing() {
    let corner = plane([1.0, 1.0, 1.0], 3.0);
    let edge = plane([1.0, 1.0, 0.0], 0.0);
    let beyond = plane([1.0, 2.0, 3.0], 100.0);
    for planes in [vec![corner], vec![edge], vec![beyond], vec![corner, edge, beyond]] {
        let complex = arrange_planes(&planes, UNIT);
        assert_eq!(counts(&complex), [1, 6]);
        assert_eq!(complex.locate(DVec3::splat(0.99)), 0);
    }
    let cut = arrange_planes(&[corner, edge, beyond, plane([1.0, 1.0, 0.0], 1.0)], UNIT);
    assert_eq!(counts(&cut), [2, 1 + 4 + 2 * 2]);
}

#[test]
fn nearly_parallel_planes_still_cross() {
    let planes = [plane([0.0, 0.0, 1.0], 0.5), plane([1e-11, 0.0, 1.0], 0.5)];
    let complex = arrange_planes(&planes, CENTERED);
    assert_eq!(complex.cells().count(), 4);
    // With a third plane the wedges are cut along and across.
    let more = [planes[0], planes[1], plane([0.0, 1.0, 0.0], 0.25)];
    assert_eq!(arrange_planes(&more, CENTERED).cells().count(), 8);
}

#[test]
fn planes_on_faces_of_the_box_have_one_cell() {
    let planes = [plane([0.0, 0.0, 3.0], 0.0), plane([-1.0, 0.0, 0.0], -1.0)];
    let complex = arrange_planes(&planes, UNIT);
    assert_eq!(counts(&complex), [1, 6]);
    assert_eq!((complex.name(4), complex.name(1)), (Some("empty"), Some("empty")));
    assert_eq!((complex.name(0), complex.name(BOX_PLANES)), (None, None));
    assert_eq!(complex.locate(DVec3::ZERO), 0);
}

#[test]
fn a_box_without_volume_is_refused() {
    let flat = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 0.0, 1.0) };
    let infinite = Bounds { min: DVec3::ZERO, max: DVec3::INFINITY };
    for bounds in [flat, infinite] {
        let error = Complex::new(&[], bounds, Label::OUTSIDE).unwrap_err();
        assert!(error.to_string().contains("has no volume"), "{error}");
    }
}

/// Whether the line through both planes passes through the box.
fn line_crosses([a, b]: [&Plane; 2], bounds: Bounds) -> bool {
    let direction = a.normal.cross(b.normal);
    let system = DMat3::from_cols(a.normal, b.normal, direction).transpose();
    let origin = system.inverse() * DVec3::new(a.offset, b.offset, 0.0);
    let [one, other] = [bounds.min, bounds.max].map(|corner| (corner - origin) / direction);
    one.min(other).max_element() < one.max(other).min_element()
}

/// Whether the point on three planes is in the box.
fn point_inside(planes: [&Plane; 3], bounds: Bounds) -> bool {
    let [a, b, c] = planes.map(|plane| plane.normal);
    let offsets = DVec3::from_array(planes.map(|plane| plane.offset));
    let point = DMat3::from_cols(a, b, c).transpose().inverse() * offsets;
    point.clamp(bounds.min, bounds.max) == point
}

/// The cells of generic planes through the box, inserted one by one: a plane
/// adds one cell, and one more for each line and each point on it.
fn generic_cells(planes: &[Plane], bounds: Bounds) -> usize {
    let mut cells = 1 + planes.len();
    for (i, a) in planes.iter().enumerate() {
        for (j, b) in planes.iter().enumerate().take(i) {
            cells += usize::from(line_crosses([a, b], bounds));
            let points = planes[..j].iter().filter(|c| point_inside([a, b, c], bounds));
            cells += points.count();
        }
    }
    cells
}

#[test]
fn random_planes_make_as_many_cells_as_they_should() {
    let mut random = Random::new(1);
    for count in [5, 10, 20, 30] {
        let planes: Vec<Plane> = (0..count).map(|_| plane_in(&mut random, CENTERED)).collect();
        let complex = arrange_planes(&planes, CENTERED);
        assert_eq!(complex.cells().count(), generic_cells(&planes, CENTERED), "{count} planes");
    }
}

#[test]
fn planes_far_from_the_origin_lose_nothing() {
    let min = DVec3::new(5e5, 4e6, 100.0);
    let bounds = Bounds { min, max: min + 100.0 };
    let mut random = Random::new(2);
    let planes: Vec<Plane> = (0..12).map(|_| plane_in(&mut random, bounds)).collect();
    let complex = arrange_planes(&planes, bounds);
    assert_eq!(complex.cells().count(), generic_cells(&planes, bounds));
}
