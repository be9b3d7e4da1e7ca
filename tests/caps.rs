//! How solids end beyond the outermost sections.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use transect::change::Change;
use transect::check::Check;
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::mesh::{Mesh, delaunay};
use transect::method::{Caps, MeanValue, Mesher, Method, Skeleton, Variational};
use transect::model::{Derived, Model, Options};
use transect::plane::Plane;
use transect::section::{Loop, Rules, Section, Sections};

/// Discs of radius 1 are so far apart, five of them.
const SPACING: f64 = 0.5;
/// How far from its plane the rim of a face may lie, and the rest of it, in voxels: the
/// mesher slides the points of a rim along both surfaces that meet there.
const RIM: f64 = 0.2;
const FACE: f64 = 0.03;
const OBLIQUE: DVec3 = DVec3::new(1.0, 2.0, -2.0);

fn section(plane: Plane, loops: &[(Label, Vec<DVec2>)]) -> Section {
    let [first, second] = plane.tangents();
    let foot = plane.unit_normal() * plane.offset / plane.normal.length();
    let ring = |(label, points): &(Label, Vec<DVec2>)| Loop {
        points: points.iter().map(|at| foot + at.x * first + at.y * second).collect(),
        label: *label,
        hole_of: None,
    };
    let loops: Vec<Loop> = loops.iter().map(ring).collect();
    Section::from_loops("", plane, &loops, 2.0, &Rules::default()).expect("a section").0
}

/// A part of a circle around a point, by the angles between which it lies.
fn arc(middle: DVec2, radius: f64, [from, to]: [f64; 2]) -> Vec<DVec2> {
    let corner =
        |at: i32| middle + radius * DVec2::from_angle(from + (to - from) * f64::from(at) / 120.0);
    let last = if to - from == TAU { 119 } else { 120 };
    (0..=last).map(corner).collect()
}

fn disc(plane: Plane, radius: f64) -> Section {
    section(plane, &[(Label(1), arc(DVec2::ZERO, radius, [0.0, TAU]))])
}

/// The planes of a stack from the origin on, every second one upside down.
fn planes(normal: DVec3) -> impl Iterator<Item = Plane> {
    (0..5).map(move |layer| {
        let side = if layer % 2 == 0 { 1.0 } else { -1.0 };
        let offset = side * SPACING * f64::from(layer) * normal.length();
        Plane { normal: side * normal, offset }
    })
}

fn discs(normal: DVec3) -> Vec<Section> {
    planes(normal).map(|plane| disc(plane, 1.0)).collect()
}

/// The same by both methods that make fields.
fn methods(caps: Caps, mesher: Mesher) -> [Method; 2] {
    [
        Method::Variational(Variational { caps, mesher, ..Variational::default() }),
        Method::MeanValue(MeanValue { caps, mesher, ..MeanValue::default() }),
    ]
}

fn model(sections: Vec<Section>, method: Method, voxels: u32) -> Model {
    let mut model = Model::new(Options {
        method,
        resolution: Resolution::Voxels(voxels),
        ..Options::default()
    });
    let mut context = Context::default();
    let sections = Sections::new(sections, &context.rules).expect("sections");
    model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
    let samples = &model.derived().expect("something was derived").samples;
    samples.sanity_check().expect("sound samples");
    model
}

fn checked(model: &Model) -> Check {
    let found = model.check(&mut Context::default()).expect("it can be checked");
    assert!(found.is_sound());
    found
}

fn mesh(model: &Model) -> &Mesh {
    &model.derived().expect("something was derived").mesh
}

fn voxel(model: &Model) -> f64 {
    model.derived().expect("something was derived").samples.lattice.voxel
}

/// The lowest and the highest point along a direction.
fn extremes(mesh: &Mesh, along: DVec3) -> [f64; 2] {
    let heights = mesh.vertices.iter().map(|at| at.dot(along.normalize()));
    heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
}

/// The area of a label's triangles that lie in a plane, up to `tolerance`.
fn area_in(mesh: &Mesh, label: Label, plane: Plane, tolerance: f64) -> f64 {
    (0..mesh.triangles.len())
        .filter(|&at| mesh.sides[at] == [label, Label::OUTSIDE])
        .map(|at| mesh.corners(at))
        .filter(|corners| corners.iter().all(|&at| plane.distance(at).abs() < tolerance))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum()
}

/// A stack of discs ends where it should, in flat faces with the discs' area, and has
/// the volume that the sections say.
fn assert_cylinder(model: &Model, normal: DVec3, beyond: f64, face: f64, most: f64) {
    let (voxel, mesh, check) = (voxel(model), mesh(model), checked(model));
    let [low, high] = extremes(mesh, normal);
    let last = 4.0 * SPACING;
    for (found, right) in [(low, -beyond), (high, last + beyond)] {
        assert!((found - right).abs() < RIM * voxel, "{found} for {right}");
        let plane = Plane { normal: normal.normalize(), offset: right };
        // Of the disc a rim is missing that is about as wide as a voxel: the mesher
        // cuts off edges.
        let area = area_in(mesh, Label(1), plane, face * voxel) / PI;
        let is_there = (1.0 - 3.0 * voxel..1.01).contains(&area);
        assert!(is_there, "{area} across {normal}, voxel {voxel}: {:?}", model.options().method);
    }
    let facts = &check.labels[0].facts;
    assert_eq!((facts.components, facts.genus), (1, 0));
    let ratio = facts.volume / (PI * (last + 2.0 * beyond));
    assert!((0.98..most).contains(&ratio), "{ratio}");
    assert!(check.dice.min > Some(0.985), "{:?}", check.dice.min);
    assert!(check.contours.largest < 1.0, "{}", check.contours.largest);
}

#[test]
fn flat_caps_end_half_a_spacing_beyond_a_stack() {
    for normal in [DVec3::Z, OBLIQUE] {
        for method in methods(Caps::Flat, Mesher::Dual) {
            assert_cylinder(&model(discs(normal), method, 64), normal, SPACING / 2.0, FACE, 1.01);
        }
    }
}

#[test]
fn without_caps_a_stack_ends_on_its_last_section() {
    for normal in [DVec3::Z, OBLIQUE] {
        for method in methods(Caps::None, Mesher::Dual) {
            let model = model(discs(normal), method, 96);
            // The field is rounded beyond the last section, and bulges a little before it.
            assert_cylinder(&model, normal, 0.5 * voxel(&model), FACE, 1.03);
        }
    }
}

#[test]
fn rounded_caps_are_no_plane() {
    for method in methods(Caps::Rounded, Mesher::Dual) {
        let model = model(discs(DVec3::Z), method, 64);
        let [low, high] = extremes(mesh(&model), DVec3::Z);
        assert!((0.1..0.4).contains(&-low) && (2.1..2.4).contains(&high), "{low} {high}");
        let top = Plane { normal: DVec3::Z, offset: high };
        let area = area_in(mesh(&model), Label(1), top, FACE * voxel(&model));
        // A flat one has an area of π there.
        assert!(area < 0.2, "{area}");
    }
}

/// The corners of a box around a stack that leans are far beyond its last section.
#[test]
fn rounded_caps_are_the_same_however_a_stack_lies() {
    let ends = |normal: DVec3| {
        let [variational, _] = methods(Caps::Rounded, Mesher::Dual);
        extremes(mesh(&model(discs(normal), variational, 64)), normal)
    };
    let upright = ends(DVec3::Z);
    for normal in [OBLIQUE, DVec3::ONE] {
        let leaning = ends(normal);
        let off = [0, 1].map(|end| (leaning[end] - upright[end]).abs());
        assert!(off.iter().all(|&off| off < SPACING / 20.0), "{upright:?} {leaning:?}");
    }
}

#[test]
fn delaunay_refinement_makes_flat_caps_too() {
    let mesher = Mesher::Delaunay(delaunay::Options::default());
    for method in methods(Caps::Flat, mesher) {
        // Triangles may be a tenth of a voxel off the surface.
        assert_cylinder(&model(discs(DVec3::Z), method, 40), DVec3::Z, SPACING / 2.0, 0.2, 1.01);
    }
}

#[test]
fn two_materials_end_in_one_plane() {
    let halves = |plane: Plane| {
        let half = |label, from| (Label(label), arc(DVec2::ZERO, 1.0, [from, from + PI]));
        section(plane, &[half(1, 0.0), half(2, PI)])
    };
    // All the same way up: upside down the halves would change sides.
    let plane = |layer: u32| Plane { normal: DVec3::Z, offset: SPACING * f64::from(layer) };
    let smooth = MeanValue { smooth: 0.0, caps: Caps::Flat, ..MeanValue::default() };
    let [variational, mean_value] = methods(Caps::Flat, Mesher::Dual);
    for method in [variational, mean_value, Method::MeanValue(smooth)] {
        let model = model((0..5).map(plane).map(halves).collect(), method, 48);
        let (voxel, check) = (voxel(&model), checked(&model));
        let [low, high] = extremes(mesh(&model), DVec3::Z);
        assert!((low + 0.25).abs() < RIM * voxel && (high - 2.25).abs() < RIM * voxel);
        let top = Plane { normal: DVec3::Z, offset: 2.25 };
        for label in &check.labels {
            assert!(label.facts.closed && label.facts.outward);
            assert_eq!(label.facts.components - label.afloat.pieces, 1);
            let area = area_in(mesh(&model), Label(label.label), top, FACE * voxel) / (PI / 2.0);
            assert!((1.0 - 5.0 * voxel..1.01).contains(&area), "{area}");
        }
    }
}

#[test]
fn a_section_alone_becomes_a_slice() {
    // A twentieth of its diagonal is the reach: half of that on either side.
    let half = 0.05 * 8f64.sqrt() / 2.0;
    for (caps, method) in [Caps::Flat, Caps::None]
        .into_iter()
        .flat_map(|caps| methods(caps, Mesher::Dual).map(|method| (caps, method)))
    {
        let model = model(vec![disc(Plane { normal: OBLIQUE, offset: 0.6 }, 1.0)], method, 64);
        let half = if caps == Caps::Flat { half } else { 0.5 * voxel(&model) };
        let [low, high] = extremes(mesh(&model), OBLIQUE);
        assert!((low - 0.2 + half).abs() < RIM * voxel(&model), "{low} {half}");
        assert!((high - 0.2 - half).abs() < RIM * voxel(&model), "{high} {half}");
        let check = checked(&model);
        let facts = &check.labels[0].facts;
        assert_eq!((facts.components, facts.genus), (1, 0));
        let ratio = facts.volume / (2.0 * half * PI);
        assert!((0.93..1.02).contains(&ratio), "{caps:?}: {ratio}");
        assert!(check.dice.min > Some(0.97), "{:?}", check.dice.min);
    }
}

/// Circles of a ball of radius 1.
fn ball(planes: &[(DVec3, f64)]) -> Vec<Section> {
    let circle = |&(normal, offset): &(DVec3, f64)| {
        let normal = normal.normalize();
        disc(Plane { normal, offset }, (1.0 - offset * offset).sqrt())
    };
    planes.iter().map(circle).collect()
}

#[test]
fn planes_that_are_no_stack_end_where_all_contours_do() {
    let tilted = [
        (DVec3::new(0.1, 0.0, 1.0), -0.6),
        (DVec3::new(-0.1, 0.1, 1.0), -0.2),
        (DVec3::new(0.0, 0.1, 1.0), 0.2),
        (DVec3::new(0.1, -0.1, 1.0), 0.6),
    ];
    let ends = Sections::new(ball(&tilted), &Rules::default()).expect("sections").ends();
    assert_eq!(ends.iter().map(|end| end.section).collect::<Vec<_>>(), [0, 3]);
    for caps in [Caps::Flat, Caps::None] {
        for method in methods(caps, Mesher::Dual) {
            let model = model(ball(&tilted), method, 48);
            let check = checked(&model);
            assert_eq!(check.labels[0].facts.components, 1);
            assert!((2.0..4.2).contains(&check.labels[0].facts.volume));
            for end in &ends {
                let half = 0.5 * if caps == Caps::Flat { end.reach } else { voxel(&model) };
                let plane = end.beyond(half);
                let distances = mesh(&model).vertices.iter().map(|&at| plane.distance(at));
                let farthest = distances.fold(f64::NEG_INFINITY, f64::max);
                assert!(farthest.abs() < RIM * voxel(&model), "{caps:?}, {method:?}: {farthest}");
            }
        }
    }
}

#[test]
fn where_sections_have_no_ends_caps_change_nothing() {
    let crossed = [(DVec3::X, 0.0), (DVec3::Y, 0.1), (DVec3::new(1.0, 1.0, 1.0), 0.2)];
    let [rounded, flat, none] = [Caps::Rounded, Caps::Flat, Caps::None].map(|caps| {
        methods(caps, Mesher::Dual).map(|method| mesh(&model(ball(&crossed), method, 32)).clone())
    });
    assert_eq!(rounded, flat);
    assert_eq!(rounded, none);
}

#[test]
fn what_a_repeated_section_alone_shows_is_no_piece() {
    // Beside the disc one so small that the field is torn above it: what is left at the
    // copies are two pieces.
    let small = arc(DVec2::new(1.4, 0.0), 0.04, [0.0, TAU]);
    let discs = |plane: Plane| {
        section(plane, &[(Label(1), arc(DVec2::ZERO, 1.0, [0.0, TAU])), (Label(1), small.clone())])
    };
    let plane = |layer: u32| Plane { normal: DVec3::Z, offset: 0.8 * f64::from(layer) };
    for method in methods(Caps::Flat, Mesher::Dual) {
        let model = model((0..3).map(plane).map(discs).collect(), method, 96);
        assert_eq!(checked(&model).labels[0].afloat.pieces, 0);
    }
}

#[test]
fn the_exact_method_ends_flat_by_itself() {
    let method = Method::Skeleton(Skeleton::default());
    assert_eq!(method.caps(), Caps::Flat);
    let model = model(discs(DVec3::Z), method, 32);
    let [low, high] = extremes(mesh(&model), DVec3::Z);
    assert!((low + 0.25).abs() < 1e-9 && (high - 2.25).abs() < 1e-9, "{low} {high}");
    let top = Plane { normal: DVec3::Z, offset: 2.25 };
    let area = area_in(mesh(&model), Label(1), top, 1e-9) / PI;
    // Near the box's sides, which are outside, its rim is bevelled.
    assert!((0.9..1.0).contains(&area), "{area}");
}

#[test]
fn threads_change_nothing() {
    for method in methods(Caps::Flat, Mesher::Dual) {
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let model = pool.install(|| model(discs(OBLIQUE), method, 48));
            let Derived { samples, mesh, .. } = model.derived().expect("something was derived");
            (samples.clone(), mesh.clone())
        });
        assert!(one == three);
    }
}
