//! Labelled regions on faces.

use super::super::FacetEdge;
use super::*;

const HORIZONTAL: [f64; 3] = [0.0, 0.0, 1.0];

/// A horizontal section at half height with a rectangle of label 1, cut by
/// the plane x = `cut`.
fn cut_rectangle(points: &[DVec2], cut: f64) -> Complex {
    let section = drawn("drawn", plane(HORIZONTAL, 0.5), &[(points, 1)]);
    arrange(&[section, empty(plane([1.0, 0.0, 0.0], cut))], UNIT)
}

/// Label areas on the faces of plane 0 from small x to large.
fn areas_by_x(complex: &Complex) -> Vec<f64> {
    let mut faces = facets_on(complex, 0);
    let least =
        |face: &Facet| face.edges.iter().map(|edge| edge.start.x).fold(f64::INFINITY, f64::min);
    faces.sort_by(|a, b| least(a).total_cmp(&least(b)));
    faces.iter().map(|face| face_area(face, Label(1))).collect()
}

/// Areas on a horizontal face.
fn face_area(face: &Facet, label: Label) -> f64 {
    let part = |edge: &FacetEdge| edge.start.cross(edge.end).z / 2.0;
    let left = face.edges.iter().filter(|edge| edge.left == label).map(part).sum::<f64>();
    let right = face.edges.iter().filter(|edge| edge.right == Some(label)).map(part).sum::<f64>();
    left - right
}

#[test]
fn a_contour_inside_a_face_stays_as_it_is() {
    let complex = cut_rectangle(&rectangle([0.25, 0.25], [0.5, 0.75]), 0.75);
    let face = facets_on(&complex, 0).into_iter().find(|face| face.labels.len() == 2).unwrap();
    assert_eq!(face.labels, [Label(0), Label(1)]);
    // Four sides of the contour and four of the face.
    assert_eq!(face.edges.len(), 8);
    let inner: Vec<_> = face.edges.iter().filter(|edge| edge.right.is_some()).collect();
    assert_eq!(inner.len(), 4);
    for edge in inner {
        // Counter-clockwise around label 1 or against it: left says which.
        let turn = (edge.start - edge.end).cross(DVec3::new(0.375, 0.5, 0.5) - edge.start).z;
        assert_eq!(edge.left == Label(1), turn < 0.0);
        assert_eq!(edge.right == Some(Label(1)), turn > 0.0);
    }
    assert_eq!(areas_by_x(&complex), [0.125, 0.0]);
}

#[test]
fn a_contour_is_cut_by_a_plane() {
    let complex = cut_rectangle(&rectangle([0.25, 0.25], [0.5, 0.75]), 0.375);
    assert_eq!(areas_by_x(&complex), [0.0625, 0.0625]);
    let both = complex.cells().values().all(|cell| cell.labels == [Label(0), Label(1)]);
    assert!(both);
}

#[test]
fn a_contour_vertex_may_lie_on_a_plane() {
    // A rhombus whose left and right corners are on and off the plane.
    let rhombus = [[0.25, 0.5], [0.5, 0.25], [0.75, 0.5], [0.5, 0.75]].map(DVec2::from_array);
    assert_eq!(areas_by_x(&cut_rectangle(&rhombus, 0.5)), [0.0625, 0.0625]);
    let touching = cut_rectangle(&rhombus, 0.25);
    assert_eq!(areas_by_x(&touching), [0.0, 0.125]);
    // Where the contour merely touches the border, the border stays whole.
    let borders = |face: &&Facet| face.edges.iter().filter(|edge| edge.right.is_none()).count();
    assert_eq!(facets_on(&touching, 0).iter().map(borders).collect::<Vec<_>>(), [4, 4]);
}

#[test]
fn a_contour_edge_may_lie_on_a_plane() {
    let complex = cut_rectangle(&rectangle([0.25, 0.25], [0.5, 0.75]), 0.5);
    assert_eq!(areas_by_x(&complex), [0.125, 0.0]);
    for face in facets_on(&complex, 0) {
        let on_line = |edge: &&FacetEdge| edge.start.x == 0.5 && edge.end.x == 0.5;
        let edges: Vec<_> = face.edges.iter().filter(on_line).collect();
        assert!(edges.iter().all(|edge| edge.right.is_none()));
        // Left of the line the label changes twice along it, right it does not.
        let expected = if face.labels.len() == 2 { 3 } else { 1 };
        assert_eq!(edges.len(), expected);
    }
}

#[test]
fn contours_may_lie_on_many_lines_and_leave_the_box() {
    let section =
        drawn("drawn", plane(HORIZONTAL, 0.5), &[(&rectangle([-0.5, -0.5], [0.5, 0.5]), 3)]);
    let planes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, -1.0, 0.0]];
    let offsets = [0.5, 0.5, 0.0];
    let mut sections = vec![section];
    sections.extend(planes.iter().zip(offsets).map(|(&n, offset)| empty(plane(n, offset))));
    let complex = arrange(&sections, UNIT);
    assert_eq!(area(&complex, &facets_on(&complex, 0), Label(3)), 0.25);
    // Each of the six wedges has one label.
    let labels: Vec<_> = facets_on(&complex, 0).iter().map(|face| face.labels.len()).collect();
    assert_eq!(labels, [1; 6]);
}

#[test]
fn a_contour_around_the_box_fills_the_plane() {
    let outer = rectangle([-1.0, -1.0], [2.0, 2.0]);
    let sections = [
        drawn("drawn", plane(HORIZONTAL, 0.5), &[(&outer, 1)]),
        empty(plane([1.0, 0.0, 0.0], 0.5)),
    ];
    let complex = Complex::new(&sections, UNIT, Label::UNKNOWN).unwrap();
    let mut box_facets = complex.facets().values().filter(|facet| facet.plane < BOX_PLANES);
    assert!(facets_on(&complex, 0).iter().all(|face| face.labels == [Label(1)]));
    assert!(box_facets.all(|face| face.labels == [Label::UNKNOWN]));
    let all = [Label(0), Label(1), Label::UNKNOWN];
    assert!(complex.cells().values().all(|cell| cell.labels == all));
}

#[test]
fn holes_and_islands_keep_their_labels() {
    let mut section = drawn(
        "drawn",
        plane(HORIZONTAL, 0.5),
        &[
            (&rectangle([0.125, 0.125], [0.875, 0.875]), 1),
            (&rectangle([0.25, 0.25], [0.75, 0.75]), 2),
            (&rectangle([0.375, 0.375], [0.625, 0.625]), 1),
        ],
    );
    for edge in &mut section.edges[4..8] {
        edge.right = Label(1);
    }
    for edge in &mut section.edges[8..] {
        edge.right = Label(2);
    }
    let complex = arrange(&[section, empty(plane([1.0, 0.5, 0.0], 0.75))], UNIT);
    let areas = [0, 1, 2].map(|label| area(&complex, &facets_on(&complex, 0), Label(label)));
    assert_eq!(areas.map(|area| (area * 1e12).round() / 1e12), [0.4375, 0.375, 0.1875]);
}

#[test]
fn a_section_on_a_face_of_the_box_keeps_its_labels() {
    let square = rectangle([0.25, 0.25], [0.5, 0.5]);
    for normal in [HORIZONTAL, [0.0, 0.0, -1.0]] {
        let section = drawn("floor", plane(normal, 0.0), &[(&square, 1)]);
        let complex = arrange(&[section, empty(plane([1.0, 0.0, 0.0], 0.375))], UNIT);
        assert_eq!(complex.cells().count(), 2);
        let floor: Vec<&Facet> =
            complex.facets().values().filter(|facet| facet.plane == 4).collect();
        assert_eq!(area(&complex, &floor, Label(1)), 0.0625);
        assert!(complex.cells().values().all(|cell| cell.labels == [Label(0), Label(1)]));
    }
}

#[test]
fn a_plane_has_one_section() {
    let here = rectangle([0.25, 0.5], [0.5, 0.75]);
    let one = drawn("one", plane(HORIZONTAL, 0.5), &[(&here, 1)]);
    let other = Section { name: "other".to_owned(), ..empty(plane([0.0, 0.0, -2.0], -1.0)) };
    let error = Complex::new(&[one, other], UNIT, Label::OUTSIDE).unwrap_err().to_string();
    assert!(error.starts_with("section other: it lies on the plane of section one"), "{error}");
}

/// A star-shaped polygon in kept coordinates, and its area.
fn star(random: &mut Random, center: DVec2, radius: f64) -> (Vec<DVec2>, f64) {
    let corner = |i| {
        let angle = std::f64::consts::TAU * f64::from(i) / 50.0;
        center + DVec2::from_angle(angle) * radius * between(random, 0.3, 1.0)
    };
    let points: Vec<DVec2> = (0..50).map(corner).collect();
    let next = points.iter().cycle().skip(1);
    let doubled: f64 = points.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum();
    (points, doubled / 2.0)
}

#[test]
fn random_contours_on_random_planes_keep_their_areas() {
    let mut random = Random::new(4);
    for count in [5, 12, 25] {
        let mut expected = Vec::new();
        let sections: Vec<Section> = (0..count)
            .map(|i| {
                let plane = plane_in(
                    &mut random,
                    Bounds { min: DVec3::splat(-0.3), max: DVec3::splat(0.3) },
                );
                let foot = plane.normal * plane.offset / plane.normal.length_squared();
                let (points, projected) = star(&mut random, plane.project(foot), 0.25);
                // A plane's area is larger than its projection along an axis.
                let tilt = plane.unit_normal()[plane.dropped_axis()].abs();
                expected.push(projected / tilt);
                drawn("star", plane, &[(&points, i + 1)])
            })
            .collect();
        let complex = arrange(&sections, CENTERED);
        for (i, expected) in expected.iter().enumerate() {
            let found = area(&complex, &facets_on(&complex, i as u32), Label(i as u32 + 1));
            assert!((found - expected).abs() < 1e-12, "section {i}: {found}, not {expected}");
        }
    }
}

/// Whether two planes with small whole numbers are the same.
fn coincide(a: &Plane, b: &Plane) -> bool {
    a.normal.cross(b.normal) == DVec3::ZERO && a.normal * b.offset == b.normal * a.offset
}

/// Planes and rectangles with coordinates from so few numbers that many meet
/// in common points and lines, with corners and edges of the box among them.
#[test]
fn coarse_coordinates_make_every_coincidence() {
    let mut random = Random::new(5);
    let mut whole = |low: f64, high: f64| between(&mut random, low, high + 1.0).floor();
    for round in 0..60 {
        let mut sections: Vec<Section> = Vec::new();
        for _ in 0..4 + round / 3 {
            let normal = DVec3::new(whole(-2.0, 2.0), whole(-2.0, 2.0), whole(-1.0, 1.0));
            let plane = Plane { normal, offset: whole(-4.0, 4.0) / 2.0 };
            if normal == DVec3::ZERO || sections.iter().any(|s| coincide(&s.plane, &plane)) {
                continue;
            }
            let min = [whole(-5.0, 2.0) / 4.0, whole(-5.0, 2.0) / 4.0];
            let max = min.map(|least| least + whole(1.0, 4.0) / 4.0);
            sections.push(drawn("coarse", plane, &[(&rectangle(min, max), 1 + round)]));
        }
        arrange(&sections, CENTERED);
    }
}

#[test]
fn the_check_of_regions_notices_what_is_wrong() {
    let square = rectangle([0.25, 0.25], [0.5, 0.75]);
    let section = drawn("drawn", plane(HORIZONTAL, 0.5), &[(&square, 1)]);
    let sound = arrange(&[section, empty(plane([1.0, 0.5, 0.0], 0.75))], UNIT);
    let drawn = sound.facets().iter().find(|(_, facet)| facet.labels.len() == 2).unwrap().0;
    let after = |change: &dyn Fn(&mut Facet)| {
        let mut changed = sound.clone();
        change(&mut changed.facets[drawn]);
        changed.check_regions().unwrap_err()
    };
    let says = |text: String, part: &str| assert!(text.contains(part), "{text}");
    says(after(&|facet| facet.edges.truncate(5)), "of a region of facet");
    let turned = |edge: &mut FacetEdge| std::mem::swap(&mut edge.start, &mut edge.end);
    says(after(&|facet| facet.edges.iter_mut().for_each(turned)), "have the areas");
    says(after(&|facet| facet.edges[0].left = Label(9)), "does not list its label 9");
}
