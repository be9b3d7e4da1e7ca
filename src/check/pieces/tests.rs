use std::f64::consts::TAU;

use glam::DVec2;

use super::*;
use crate::check::shapes::{disc, section};
use crate::mesh::shapes::solid;
use crate::plane::Plane;

const VOXEL: f64 = 2.0 / 60.0;

/// What a solid in [−1, 1]³ makes of sections that are cuts of another one.
fn found(inside: impl Fn(DVec3) -> f64 + Copy, sections: &[Section]) -> Pieces {
    let mesh = solid(61, 1.0, inside);
    let stack = Stack::new(sections);
    let (origin, stack) = (DVec3::splat(-1.0), stack.as_ref());
    let scene = Scene { sections, mesh: &mesh, origin, voxel: VOXEL, stack };
    scene.pieces(&[Label(1)], |_| 0.5 * VOXEL).remove(&Label(1)).expect("a label")
}

fn named(mut section: Section, name: &str) -> Section {
    section.name = name.to_owned();
    section
}

fn circle(normal: DVec3, offset: f64, radius: f64, name: &str) -> Section {
    named(disc(Plane { normal, offset }, radius, 64, Label(1)), name)
}

/// Two balls on the x axis, apart or joined by a bar.
fn balls(point: DVec3) -> f64 {
    let ball = |x: f64| 0.35 - (point - x * DVec3::X).length();
    ball(-0.45).max(ball(0.45))
}

fn dumbbell(point: DVec3) -> f64 {
    let bar = (0.05 - point.y.hypot(point.z)).min(0.4 - point.x.abs());
    balls(point).max(bar)
}

/// The dumbbell on z = 0.
fn outline() -> Section {
    let ball = |x: f64, turn: f64| DVec2::new(x, 0.0) + 0.35 * DVec2::from_angle(turn);
    // From one side of the bar around to the other.
    let half = (0.05f64 / 0.35).asin();
    let arc = |x: f64, from: f64| {
        (0..=40).map(move |i| ball(x, from + half + f64::from(i) / 40.0 * (TAU - 2.0 * half)))
    };
    let corners: Vec<DVec2> = arc(-0.45, 0.0).chain(arc(0.45, TAU / 2.0)).collect();
    let plane = Plane { normal: DVec3::Z, offset: 0.0 };
    let [first, second] = plane.tangents();
    let turned =
        |at: &DVec2| DVec2::new(at.x * first.x + at.y * first.y, at.x * second.x + at.y * second.y);
    named(section(plane, &corners.iter().map(turned).collect::<Vec<_>>(), Label(1)), "flat")
}

#[test]
fn a_region_in_two_pieces_is_torn() {
    let sections = [outline()];
    let whole = found(dumbbell, &sections);
    assert_eq!((whole.found, whole.shown, whole.torn.len()), (1, 1, 0));
    let torn = found(balls, &sections);
    assert_eq!((torn.found, torn.shown), (2, 1));
    let [tear] = &torn.torn[..] else { panic!("{torn:?}") };
    assert_eq!(tear.sections, ["flat"]);
    assert!(balls(DVec3::from(tear.at)) > 0.0);
}

#[test]
fn bodies_that_touch_are_not_torn() {
    // Two cubes that meet in an edge; on their section two squares that meet in a corner.
    let cubes = |point: DVec3| {
        let cube = |at: f64| 0.4 - (point - DVec3::new(at, at, 0.0)).abs().max_element();
        cube(-0.4).max(cube(0.4))
    };
    let corners = [
        [-0.8, -0.8],
        [0.0, -0.8],
        [0.0, 0.0],
        [0.8, 0.0],
        [0.8, 0.8],
        [0.0, 0.8],
        [0.0, 0.0],
        [-0.8, 0.0],
    ];
    let plane = Plane { normal: DVec3::Z, offset: 0.0 };
    let flat = corners.map(|[x, y]| {
        let [first, second] = plane.tangents().map(|tangent| tangent.dot(DVec3::new(x, y, 0.0)));
        DVec2::new(first, second)
    });
    let pieces = found(cubes, &[named(section(plane, &flat, Label(1)), "flat")]);
    assert_eq!(pieces.torn, [], "{pieces:?}");
}

#[test]
fn regions_that_face_each_other_belong_together() {
    // Through both balls' inner halves, leaning to each other by 20°.
    let lean = |sign: f64| DVec3::new(1.0, 0.0, sign * 0.18).normalize();
    let cut = |sign: f64| {
        let normal = lean(sign);
        let offset = sign * 0.2 * normal.x;
        let height = normal.x * 0.45 - 0.2 * normal.x;
        let mut own = circle(normal, offset, (0.1225 - height * height).sqrt(), "");
        // The disc is around the foot of the origin: move it to that of the ball's middle.
        let middle = DVec3::new(sign * 0.45, 0.0, 0.0);
        let plane = Plane { normal, offset };
        let by = plane.project(middle - plane.distance(middle) * normal)
            - plane.project(normal * offset);
        own.vertices.iter_mut().for_each(|vertex| *vertex += by);
        named(own, if sign > 0.0 { "right" } else { "left" })
    };
    let mut sections = vec![cut(-1.0), cut(1.0)];
    let torn = found(balls, &sections);
    assert_eq!((torn.found, torn.shown), (2, 1), "{torn:?}");
    assert_eq!(torn.torn[0].sections, ["left", "right"]);
    assert_eq!(found(dumbbell, &sections).torn, []);
    // A section between them that knows better.
    let mut empty = circle(DVec3::X, 0.0, 0.1, "between");
    (empty.vertices, empty.edges) = (Vec::new(), Vec::new());
    sections.push(empty.clone());
    let apart = found(balls, &sections);
    assert_eq!((apart.found, apart.shown, apart.torn.len()), (2, 2, 0), "{apart:?}");
    // One that knows nothing there.
    empty.background = Label::UNKNOWN;
    sections[2] = empty;
    assert_eq!(found(balls, &sections).torn.len(), 1);
}

#[test]
fn far_away_is_not_opposite() {
    // The same balls cut by planes through their middles, 0.9 from each other and 0.7 wide.
    let sections: Vec<Section> = [-0.45, 0.45].map(|x| circle(DVec3::X, x, 0.35, "")).to_vec();
    let apart = found(balls, &sections);
    assert_eq!((apart.found, apart.shown, apart.torn.len()), (2, 2, 0), "{apart:?}");
}

#[test]
fn crossing_sections_are_one_body() {
    // A bar cut along and across, of which the solid has a bead left between two ends.
    let bar = |point: DVec3| 0.12 - point.y.hypot(point.z);
    let ends = |point: DVec3| bar(point).min(point.x.abs() - 0.3).min(0.8 - point.x.abs());
    let bead = |point: DVec3| ends(point).max(bar(point).min(0.12 - point.x.abs()));
    let plane = Plane { normal: DVec3::Z, offset: 0.0 };
    let [first, second] = plane.tangents();
    let corners = [[-0.8, -0.12], [0.8, -0.12], [0.8, 0.12], [-0.8, 0.12]];
    let along = corners.map(|[x, y]| {
        let corner = DVec3::new(x, y, 0.0);
        DVec2::new(first.dot(corner), second.dot(corner))
    });
    let along = named(section(plane, &along, Label(1)), "along");
    let sections = [along, circle(DVec3::X, 0.0, 0.12, "across")];
    let torn = found(bead, &sections);
    assert_eq!((torn.found, torn.shown, torn.torn.len()), (3, 1, 1), "{torn:?}");
    assert_eq!(torn.torn[0].sections, ["along"]);
    // Where the bead is gone it is the one along that says so, the other has nothing in the solid.
    let gone = found(ends, &sections);
    assert_eq!((gone.found, gone.shown, gone.torn.len()), (2, 1, 1), "{gone:?}");
}

#[test]
fn a_section_out_of_place_is_told() {
    // A bar along x with a piece of it beside: sections at −0.6, −0.3, … 0.6, the middle one moved.
    let along = |point: DVec3, x: f64, y: f64, half: f64| {
        (0.2 - (point.y - y).hypot(point.z)).min(half - (point.x - x).abs())
    };
    let moved = |point: DVec3| {
        let ends = along(point, -0.5, 0.0, 0.35).max(along(point, 0.5, 0.0, 0.35));
        ends.max(along(point, 0.0, 0.6, 0.14))
    };
    let sections: Vec<Section> = (-2..=2)
        .map(|number| {
            let mut own = circle(DVec3::X, 0.3 * f64::from(number), 0.2, &number.to_string());
            if number == 0 {
                let plane = *own.plane();
                let by = plane.project(0.6 * DVec3::Y) - plane.project(DVec3::ZERO);
                own.vertices.iter_mut().for_each(|vertex| *vertex += by);
            }
            own
        })
        .collect();
    let pieces = found(moved, &sections);
    assert_eq!((pieces.found, pieces.shown), (3, 3), "{pieces:?}");
    let [told] = &pieces.out_of_place[..] else { panic!("{pieces:?}") };
    assert_eq!(told.sections, ["-1", "0", "1"]);
    // Where the middle one is empty it is no mistake.
    let mut empty = sections.clone();
    (empty[2].vertices, empty[2].edges) = (Vec::new(), Vec::new());
    assert_eq!(found(moved, &empty).out_of_place, []);
}

#[test]
fn a_cavity_is_no_piece() {
    // A shell and a ball in its middle: two pieces of three surfaces.
    let shell = |point: DVec3| (0.2 - (point.length() - 0.6).abs()).max(0.2 - point.length());
    let [wide, narrow, small] = [0.8, 0.4, 0.2]
        .map(|radius| disc(Plane { normal: DVec3::Z, offset: 0.0 }, radius, 64, Label(1)));
    let mut own = wide;
    for (ring, is_hole) in [(narrow, true), (small, false)] {
        let first = own.vertices.len() as u32;
        own.vertices.extend(&ring.vertices);
        own.edges.extend(ring.edges.iter().map(|edge| {
            let [left, right] =
                if is_hole { [edge.right, edge.left] } else { [edge.left, edge.right] };
            crate::section::Edge { start: first + edge.start, end: first + edge.end, left, right }
        }));
    }
    let pieces = found(shell, &[named(own, "cut")]);
    assert_eq!((pieces.found, pieces.shown, pieces.torn.len()), (2, 2, 0), "{pieces:?}");
}
