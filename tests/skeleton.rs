//! The exact reconstruction between full sections: small cases whose volumes
//! follow by hand, and real sections.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3, Vec3Swizzles};
use transect::label::Label;
use transect::mesh::Mesh;
use transect::mesh::facts::Facts;
use transect::plane::{Bounds, Plane};
use transect::progress::Silent;
use transect::section::{Loop, Rules, Section};
use transect::skeleton::{Kind, Options, Skeleton, skeleton};

const BOX: Bounds = Bounds { min: DVec3::splat(-1.5), max: DVec3::splat(1.5) };

/// A section with loops of labels.
fn section(normal: DVec3, offset: f64, loops: &[(u32, Vec<DVec3>)]) -> Section {
    let loops: Vec<Loop> = loops
        .iter()
        .map(|(label, points)| Loop { points: points.clone(), label: Label(*label), hole_of: None })
        .collect();
    named(&format!("{normal} {offset}"), normal, offset, &loops)
}

fn named(name: &str, normal: DVec3, offset: f64, loops: &[Loop]) -> Section {
    let plane = Plane { normal, offset };
    Section::from_loops(name, plane, loops, 3.0, &Rules::default()).expect("a section").0
}

/// A rectangle on the plane z = `height`.
fn rectangle(height: f64, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2]) -> Vec<DVec3> {
    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|at| DVec2::from(at).extend(height)).to_vec()
}

fn square(height: f64, half: f64) -> Vec<DVec3> {
    rectangle(height, [-half, half], [-half, half])
}

/// The plane z = `height` with loops of label 1.
fn flat(height: f64, loops: &[Vec<DVec3>]) -> Section {
    let loops: Vec<(u32, Vec<DVec3>)> = loops.iter().map(|points| (1, points.clone())).collect();
    section(DVec3::Z, height, &loops)
}

/// The plane z = `height` with a square of label 1 that has a square hole.
fn annulus(height: f64, outer: f64, inner: f64) -> Section {
    let ring = |half: f64, hole_of| Loop { points: square(height, half), label: Label(1), hole_of };
    named("annulus", DVec3::Z, height, &[ring(outer, None), ring(inner, Some(0))])
}

fn exact(sections: &[Section]) -> Skeleton {
    let result = skeleton(sections, BOX, &Options::default(), &Silent).expect("a skeleton");
    assert_eq!(result.mesh.triangles.len(), result.details.origins.len());
    for label in result.mesh.labels() {
        assert_eq!(edges_of(&result.mesh, label).1, 0, "label {label} is not closed");
    }
    result
}

/// Edges of a label's triangles: how many have more than two, and how many are
/// not passed as often in one direction as in the other.
fn edges_of(mesh: &Mesh, label: Label) -> (usize, usize) {
    let mut edges: BTreeMap<[u32; 2], (i32, usize)> = BTreeMap::new();
    for [a, b, c] in mesh.triangles_around(|side| side == label) {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let edge = edges.entry([from.min(to), from.max(to)]).or_default();
            edge.0 += if from < to { 1 } else { -1 };
            edge.1 += 1;
        }
    }
    let many = edges.values().filter(|edge| edge.1 > 2).count();
    (many, edges.values().filter(|edge| edge.0 != 0).count())
}

fn facts(result: &Skeleton, label: u32) -> Facts {
    let facts = result.mesh.surface(Label(label)).facts(true).expect("facts");
    assert!(facts.closed && facts.outward, "label {label}: {facts:?}");
    assert_eq!(facts.self_intersections, Some(0), "label {label}");
    facts
}

/// Label 1 has so many shells, handles and so much volume.
fn expect(sections: &[Section], shells: usize, genus: i64, volume: f64) -> Skeleton {
    let result = exact(sections);
    let facts = facts(&result, 1);
    assert_eq!((facts.components, facts.genus), (shells, genus));
    assert!(
        (volume - enclosed(&result.mesh, 1)).abs() < 1e-9,
        "{} for {volume}",
        enclosed(&result.mesh, 1)
    );
    result
}

/// Cavities taken off.
fn enclosed(mesh: &Mesh, label: u32) -> f64 {
    mesh.surface(Label(label)).volume()
}

/// Between z = ±½ a square joins itself; beyond, it ends halfway to the box, ½
/// from it.
#[test]
fn equal_sections_make_a_prism() {
    let sections = [0.5, -0.5].map(|height| flat(height, &[square(height, 0.5)]));
    let result = expect(&sections, 1, 0, 2.0);
    assert!(result.details.contradictions.is_empty());
    assert_eq!((result.details.cells, result.details.bits), (3, 60));
    assert!(result.details.origins.iter().any(|origin| origin.kind == Kind::Wall));
}

#[test]
fn sections_apart_make_two_bodies() {
    let upper = rectangle(0.5, [-0.9, -0.3], [-0.3, 0.3]);
    let lower = rectangle(-0.5, [0.3, 0.9], [-0.3, 0.3]);
    expect(&[flat(0.5, &[upper]), flat(-0.5, &[lower])], 2, 0, 0.72);
}

#[test]
fn one_contour_branches_into_two() {
    let upper = rectangle(0.5, [-0.8, 0.8], [-0.25, 0.25]);
    let lower = [[-0.8, -0.3], [0.3, 0.8]].map(|x| rectangle(-0.5, x, [-0.25, 0.25]));
    expect(&[flat(0.5, &[upper]), flat(-0.5, &lower)], 1, 0, 0.8 + 0.5);
}

#[test]
fn holes_become_tunnels_cups_and_voids() {
    // 1.44 − 0.36 = 1.08 is the ring's area.
    expect(&[annulus(0.5, 0.6, 0.3), annulus(-0.5, 0.6, 0.3)], 1, 1, 2.0 * 1.08);
    expect(&[annulus(0.5, 0.6, 0.3), flat(-0.5, &[square(-0.5, 0.6)])], 1, 0, 1.08 + 1.44);
    let full = [0.5, -0.5].map(|height| flat(height, &[square(height, 0.6)]));
    let [upper, lower] = full;
    expect(&[upper, annulus(0.0, 0.6, 0.3), lower], 2, 0, 2.0 * 1.44 - 0.5 * 0.36);
}

#[test]
fn edges_that_project_onto_each_other_touch() {
    let upper = rectangle(0.5, [-0.6, 0.0], [-0.3, 0.3]);
    let lower = rectangle(-0.5, [0.0, 0.6], [-0.3, 0.3]);
    let result = expect(&[flat(0.5, &[upper]), flat(-0.5, &[lower])], 2, 0, 0.72);
    assert_eq!(edges_of(&result.mesh, Label(1)).0, 1);
}

#[test]
fn corners_that_project_onto_each_other_touch() {
    let upper = rectangle(0.5, [-0.6, 0.0], [-0.6, 0.0]);
    let lower = rectangle(-0.5, [0.0, 0.6], [0.0, 0.6]);
    let result = expect(&[flat(0.5, &[upper]), flat(-0.5, &[lower])], 2, 0, 0.72);
    assert_eq!(edges_of(&result.mesh, Label(1)).0, 0);
    let shared = result.mesh.vertices.iter().filter(|vertex| **vertex == DVec3::ZERO).count();
    assert_eq!(shared, 1);
}

/// The corner where two squares touch is an upright edge with four walls, above,
/// below, and twice between the sections.
#[test]
fn a_checkerboard_has_edges_with_four_walls() {
    let sections = [0.5, -0.5].map(|height| {
        let squares = [[-0.5, 0.0], [0.0, 0.5]].map(|side| rectangle(height, side, side));
        flat(height, &squares)
    });
    let result = expect(&sections, 2, 0, 1.0);
    assert_eq!(edges_of(&result.mesh, Label(1)).0, 4);
}

/// Rectangles on four planes through the z axis: over an octagon with apothem ½.
#[test]
fn planes_through_a_line() {
    let sections = [DVec2::X, DVec2::ONE, DVec2::Y, DVec2::new(-1.0, 1.0)].map(|along| {
        // Half a unit along a diagonal is no double: the corners are rounded.
        let out = 0.5 * along.normalize();
        let corners = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]];
        let points = corners.map(|[side, z]| (side * out).extend(z)).to_vec();
        section(along.perp().extend(0.0), 0.0, &[(1, points)])
    });
    expect(&sections, 1, 0, 2.0 * (std::f64::consts::PI / 8.0).tan());
}

/// An octahedron on three planes through its corners and one that cuts it in a
/// hexagon, all through its middle.
#[test]
fn planes_through_a_point() {
    let diamond = |first: DVec3, second: DVec3| -> Vec<DVec3> {
        [first, second, -first, -second].map(|corner| 0.9 * corner).to_vec()
    };
    let corners = [[1, -1, 0], [1, 0, -1], [0, 1, -1], [-1, 1, 0], [-1, 0, 1], [0, -1, 1]];
    let hexagon = corners.map(|corner| DVec3::from(corner.map(|at| 0.45 * f64::from(at))));
    let sections = [
        section(DVec3::X, 0.0, &[(1, diamond(DVec3::Y, DVec3::Z))]),
        section(DVec3::Y, 0.0, &[(1, diamond(DVec3::Z, DVec3::X))]),
        section(DVec3::Z, 0.0, &[(1, diamond(DVec3::X, DVec3::Y))]),
        section(DVec3::ONE, 0.0, &[(1, hexagon.to_vec())]),
    ];
    let result = exact(&sections);
    assert!(result.details.contradictions.is_empty());
    let facts = facts(&result, 1);
    assert_eq!((facts.components, facts.genus), (1, 0));
}

/// On z = 0 a rectangle ends at the plane x = 0, which is empty: a wedge of
/// height |x| above and below.
#[test]
fn a_contour_along_the_line_of_an_empty_section() {
    let touching = flat(0.0, &[rectangle(0.0, [0.0, 0.5], [-0.25, 0.25])]);
    expect(&[touching, section(DVec3::X, 0.0, &[])], 1, 0, 0.125);
}

/// As before, but the other section has |z| ≤ 0.4: wedges beside it on both sides.
#[test]
fn a_contour_along_the_line_of_a_full_section() {
    let touching = flat(0.0, &[rectangle(0.0, [0.0, 0.5], [-0.25, 0.25])]);
    let upright = [[-0.25, -0.4], [0.25, -0.4], [0.25, 0.4], [-0.25, 0.4]]
        .map(|[y, z]| DVec3::new(0.0, y, z));
    let crossing = section(DVec3::X, 0.0, &[(1, upright.to_vec())]);
    let result = expect(&[touching, crossing], 1, 0, 0.5 * (2.0 * 0.125 + 4.0 * 0.08));
    assert!(result.details.contradictions.is_empty());
}

/// A triangle with a corner on the line: ∫ x · x dx above and below.
#[test]
fn a_corner_on_the_line_of_an_empty_section() {
    let corners = [[0.0, 0.0], [0.5, -0.25], [0.5, 0.25]];
    let triangle = corners.map(|at| DVec2::from(at).extend(0.0)).to_vec();
    let sections = [flat(0.0, &[triangle]), section(DVec3::X, 0.0, &[])];
    expect(&sections, 1, 0, 2.0 * 0.125 / 3.0);
}

#[test]
fn an_empty_section_parts_bodies() {
    let full = [0.5, -0.5].map(|height| flat(height, &[square(height, 0.5)]));
    let [upper, lower] = full;
    expect(&[upper, flat(0.0, &[]), lower], 2, 0, 2.0 * 0.75);
}

/// One section, 1½ from the box on both sides.
#[test]
fn four_labels_meet_in_a_corner() {
    let regions = [
        (1, [0.0, 0.6], [0.0, 0.5]),
        (2, [-0.4, 0.0], [0.0, 0.5]),
        (3, [-0.4, 0.0], [-0.7, 0.0]),
        (4, [0.0, 0.6], [-0.7, 0.0]),
    ];
    let loops = regions.map(|(label, x, y)| (label, rectangle(0.0, x, y)));
    let result = exact(&[section(DVec3::Z, 0.0, &loops)]);
    for (label, [x0, x1], [y0, y1]) in regions {
        let facts = facts(&result, label);
        assert_eq!((facts.components, facts.genus), (1, 0));
        assert!((facts.volume - 1.5 * (x1 - x0) * (y1 - y0)).abs() < 1e-12);
    }
}

#[test]
fn planes_a_billionth_apart() {
    let sections = [0.0, 1e-9].map(|height| flat(height, &[square(height, 0.5)]));
    expect(&sections, 1, 0, 1.5 + 0.5e-9);
}

/// The plane x = 0 says that nothing is there: what z = 0 says holds where |z| <
/// |x|, in two wedges that touch along the line.
#[test]
fn contradicting_sections_are_reported_and_closed() {
    let empty = named("empty", DVec3::X, 0.0, &[]);
    let result = expect(&[flat(0.0, &[square(0.0, 0.5)]), empty], 2, 0, 0.5);
    assert_eq!(edges_of(&result.mesh, Label(1)).0, 1);
    let [found] = &result.details.contradictions[..] else {
        panic!("{:?}", result.details.contradictions)
    };
    assert_eq!(found.sections[1], "empty");
    assert_eq!(found.labels, [vec!["1".to_owned()], vec!["outside".to_owned()]]);
    let mut ends = found.ends;
    ends.sort_by(|one, other| one[1].total_cmp(&other[1]));
    assert_eq!(ends, [[0.0, -0.5, 0.0], [0.0, 0.5, 0.0]]);
    assert_eq!(found.length, 1.0);
}

/// A cube's faces show squares: over each, in and out of the cube, the roof is as
/// high as the nearest edge of the face is far.
#[test]
fn a_cubic_cell() {
    let sections: Vec<Section> = [DVec3::X, DVec3::Y, DVec3::Z]
        .into_iter()
        .flat_map(|normal| [0.5, -0.5].map(|offset| (normal, offset)))
        .map(|(normal, offset)| {
            let points = square(offset, 0.3).into_iter().map(|point| match normal {
                DVec3::X => point.zxy(),
                DVec3::Y => point.yzx(),
                _ => point,
            });
            section(normal, offset, &[(1, points.collect())])
        })
        .collect();
    // ∬ min(½ − |u|, ½ − |v|) = 4 (½ a² − ⅔ a³) for a = 0.3.
    expect(&sections, 1, 0, 12.0 * 4.0 * (0.045 - 0.018));
}

#[test]
fn normals_of_any_length_and_direction() {
    let upper = section(3.0 * DVec3::Z, 1.5, &[(1, square(0.5, 0.5))]);
    let lower = section(-0.25 * DVec3::Z, 0.125, &[(1, square(-0.5, 0.5))]);
    expect(&[upper, lower], 1, 0, 2.0);
    let tiny = section(1e-20 * DVec3::Z, 0.5e-20, &[(1, square(0.5, 0.5))]);
    let large = section(-1e20 * DVec3::Z, 0.5e20, &[(1, square(-0.5, 0.5))]);
    expect(&[tiny, large], 1, 0, 2.0);
}

/// Sixty bits do not tell planes apart that differ by 1e-11 in angle.
#[test]
fn nearly_parallel_planes_need_more_bits() {
    let tilted: Vec<DVec3> = square(0.0, 0.5)
        .into_iter()
        .map(|point| DVec3::new(point.x, point.y, 1e-11 * point.x))
        .collect();
    let sections = [
        flat(0.0, &[square(0.0, 0.5)]),
        section(DVec3::new(-1e-11, 0.0, 1.0), 0.0, &[(1, tilted)]),
    ];
    let result = exact(&sections);
    assert_eq!(result.details.bits, 120);
    // Between planes that doubles hardly tell apart rounding makes triangles meet.
    let facts = result.mesh.surface(Label(1)).facts(false).expect("facts");
    assert!(facts.closed && facts.outward);
    assert_eq!((facts.components, facts.genus), (1, 0));
    assert!((facts.volume - 1.5).abs() < 1e-9);
}

/// The corners of a square are exact, and roofs are halfway.
#[test]
fn exact_coordinates() {
    let sections = [0.5, -0.25].map(|height| flat(height, &[square(height, 0.5)]));
    let options = Options { exact: true, ..Options::default() };
    let result = skeleton(&sections, BOX, &options, &Silent).expect("a skeleton");
    let exact = result.details.exact.expect("exact coordinates");
    assert_eq!(exact.len(), result.mesh.vertices.len());
    for (vertex, fractions) in result.mesh.vertices.iter().zip(&exact) {
        for axis in 0..3 {
            let (above, below) = fractions[axis].split_once('/').expect("a fraction");
            let [above, below] = [above, below].map(|text| text.parse::<f64>().expect("a number"));
            assert_eq!(vertex[axis], above / below);
        }
    }
    let heights: Vec<&str> = exact.iter().map(|point| point[2].as_str()).collect();
    for height in ["1/1", "1/2", "1/8", "-1/4", "-7/8"] {
        assert!(heights.contains(&height), "{height} is missing");
    }
}
