//! The default method on sections whose solid is known, and on awkward ones.

mod common;

use std::f64::consts::{PI, TAU};

use common::data;
use glam::{DVec2, DVec3};
use transect::change::Change;
use transect::check::Check;
use transect::compare::{self, compare};
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::io::mesh::read_mesh;
use transect::io::read_sections;
use transect::label::Label;
use transect::mesh::facts::Facts;
use transect::method::{Method, Variational};
use transect::model::{Model, Options};
use transect::plane::Plane;
use transect::progress::Silent;
use transect::section::{Loop, Rules, Section, Sections};

/// A section of a ball of radius 1 around the origin, or of a cylinder: a circle of
/// a radius around the foot of the origin.
fn circle(name: usize, plane: Plane, radius: f64, label: Label) -> Section {
    let [first, second] = plane.tangents();
    let foot = plane.unit_normal() * plane.offset / plane.normal.length();
    let point = |at: i32| {
        let along = radius * DVec2::from_angle(TAU * f64::from(at) / 120.0);
        foot + along.x * first + along.y * second
    };
    let points = (0..120).map(point).collect();
    let ring = Loop { points, label, hole_of: None };
    Section::from_loops(&name.to_string(), plane, &[ring], 1.0, &Rules::default())
        .expect("a circle")
        .0
}

fn ball(planes: &[(DVec3, f64)]) -> Vec<Section> {
    let section = |(name, &(normal, offset)): (usize, &(DVec3, f64))| {
        let plane = Plane { normal: normal.normalize(), offset };
        circle(name, plane, (1.0 - offset * offset).sqrt(), Label(1))
    };
    planes.iter().enumerate().map(section).collect()
}

fn stack(heights: impl IntoIterator<Item = f64>) -> Vec<Section> {
    let section = |(name, offset)| circle(name, Plane { normal: DVec3::Z, offset }, 1.0, Label(1));
    heights.into_iter().enumerate().map(section).collect()
}

fn model(sections: Sections, voxels: u32, border: Label) -> Model {
    let method = Method::Variational(Variational { border, ..Variational::default() });
    let resolution = Resolution::Voxels(voxels);
    let mut model = Model::new(Options { method, resolution, ..Options::default() });
    model.apply(Change::Add(sections), &mut Context::default()).expect("it reconstructs");
    let samples = &model.derived().expect("something was derived").samples;
    samples.sanity_check().expect("sound samples");
    model
}

fn closed_model(sections: Vec<Section>, voxels: u32) -> Model {
    let sections = Sections::new(sections, &Rules::default()).expect("sections");
    model(sections, voxels, Label::OUTSIDE)
}

fn checked(model: &Model) -> Check {
    let found = model.check(&mut Context::default()).expect("it can be checked");
    assert!(found.is_sound());
    found
}

/// The check of a model, and the facts of label 1.
fn reconstructed(sections: Vec<Section>, voxels: u32) -> (Check, Facts) {
    let check = checked(&closed_model(sections, voxels));
    let facts = check.labels[0].facts.clone();
    (check, facts)
}

/// The radii of the surface around the z axis between two heights.
fn radii(model: &Model, heights: [f64; 2]) -> [f64; 2] {
    let mesh = &model.derived().expect("something was derived").mesh;
    let within = mesh.vertices.iter().filter(|at| heights[0] < at.z && at.z < heights[1]);
    within
        .map(|at| at.truncate().length())
        .fold([f64::INFINITY, 0.0], |[least, most], radius| [least.min(radius), most.max(radius)])
}

#[test]
fn equal_circles_make_nearly_a_cylinder() {
    let model = closed_model(stack((0..6).map(f64::from)), 96);
    let [least, most] = radii(&model, [0.0, 5.0]);
    // Beside the rounded ends it is wider, as a barrel is.
    assert!(least > 0.98 && most < 1.08, "{least} to {most}");
    let [least, most] = radii(&model, [1.0, 4.0]);
    assert!(least > 0.98 && most < 1.02, "{least} to {most}");
    // It ends about half a spacing beyond the last section.
    let bounds = model.derived().unwrap().mesh.bounds().unwrap();
    for end in [-bounds.min.z, bounds.max.z - 5.0] {
        assert!((0.2..0.8).contains(&end), "{end}");
    }
    assert!(checked(&model).dice.min > Some(0.99));
}

#[test]
fn a_ball_comes_back_from_few_sections() {
    // Of a stack half of what lies beyond the last sections is missing: caps of the
    // height 0.25 are π 0.25² (3 − 0.25) / 3 each, 4.3 % of the ball.
    let volume = 4.0 / 3.0 * PI;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let parallel: Vec<_> = (-3..=3).map(|at| (DVec3::Z, 0.25 * f64::from(at))).collect();
    let crossed: Vec<_> =
        axes.iter().flat_map(|&axis| [-0.5, 0.0, 0.5].map(|at| (axis, at))).collect();
    // All through one line: midway between them, at 22.5°, nothing is known.
    let fan: Vec<_> = (0..4)
        .map(|at| (DVec3::from((DVec2::from_angle(PI * f64::from(at) / 4.0), 0.0)), 0.0))
        .collect();
    for (name, planes, off) in
        [("parallel", parallel, 0.06), ("crossed", crossed, 0.02), ("fan", fan, 0.06)]
    {
        let (check, facts) = reconstructed(ball(&planes), 64);
        assert_eq!((facts.components, facts.genus), (1, 0), "{name}");
        let ratio = facts.volume / volume;
        assert!((ratio - 1.0).abs() < off, "{name}: {ratio}");
        assert!(check.dice.min > Some(0.99), "{name}: {:?}", check.dice.min);
    }
}

#[test]
fn resolution_does_not_change_the_shape() {
    let planes: Vec<_> =
        (-2..=2).map(|at| (DVec3::new(0.2, -0.1, 1.0), 0.3 * f64::from(at))).collect();
    let [coarse, fine] = [64, 160].map(|voxels| reconstructed(ball(&planes), voxels).1.volume);
    assert!((fine / coarse - 1.0).abs() < 0.01, "{coarse} {fine}");
}

#[test]
fn one_section_is_a_blob_and_two_are_bridged() {
    let (check, facts) = reconstructed(ball(&[(DVec3::new(1.0, 2.0, 3.0), 0.1)]), 48);
    assert_eq!((facts.components, facts.genus), (1, 0));
    assert!(check.dice.min > Some(0.98), "{:?}", check.dice.min);
    // Circles of radius 1, 0.8 apart.
    let (check, facts) = reconstructed(stack([0.0, 0.8]), 48);
    assert_eq!((facts.components, facts.genus), (1, 0));
    assert!(check.dice.min > Some(0.98));
}

#[test]
fn in_an_open_box_a_cylinder_goes_on() {
    let sections = Sections::new(stack((0..4).map(f64::from)), &Rules::default()).unwrap();
    let model = model(sections, 64, Label::UNKNOWN);
    let samples = &model.derived().unwrap().samples;
    let bounds = samples.open.expect("an open box");
    let mesh = model.derived().unwrap().mesh.bounds().unwrap();
    assert!((mesh.min.z - bounds.min.z).abs() < samples.lattice.voxel);
    assert!((mesh.max.z - bounds.max.z).abs() < samples.lattice.voxel);
    let [least, most] = radii(&model, [bounds.min.z + 0.1, bounds.max.z - 0.1]);
    assert!(least > 0.9 && most < 1.1, "{least} to {most}");
    checked(&model);
}

#[test]
fn two_materials_that_touch_leave_no_gap() {
    // Half discs of labels 1 and 2 on six planes: their border is a plane.
    let half = |from: f64, label: u32, height: f64| {
        let arc = |at: i32| DVec2::from_angle(from + PI * f64::from(at) / 60.0).extend(height);
        Loop { points: (0..=60).map(arc).collect(), label: Label(label), hole_of: None }
    };
    let section = |layer: u32| {
        let height = 0.4 * f64::from(layer);
        let plane = Plane { normal: DVec3::Z, offset: height };
        let loops = [half(0.0, 1, height), half(PI, 2, height)];
        Section::from_loops(&layer.to_string(), plane, &loops, 1.0, &Rules::default()).unwrap().0
    };
    let model = closed_model((0..6).map(section).collect(), 64);
    let check = checked(&model);
    // Where the border ends at outside, the mesh may cut off slivers of no size.
    let voxel = check.voxel;
    for label in &check.labels {
        assert_eq!(label.facts.components - label.afloat.pieces, 1);
        assert!(label.afloat.volume < 0.01 * voxel.powi(3), "{}", label.afloat.volume);
    }
    // The border is there as triangles between 1 and 2: its area between the first and
    // the last section is 2 × 2, the caps add a little, and the waists between sections
    // take a tenth of the width.
    let mesh = &model.derived().unwrap().mesh;
    let border = (0..mesh.triangles.len()).filter(|&at| mesh.sides[at] == [Label(1), Label(2)]);
    let area: f64 = border
        .map(|at| {
            let [a, b, c] = mesh.corners(at);
            (b - a).cross(c - a).length() / 2.0
        })
        .sum();
    assert!((3.6..5.5).contains(&area), "{area}");
    assert!(check.dice.min > Some(0.98), "{:?}", check.dice.min);
}

/// A grid of 6 × 6 posts in five sections of which none touches another: as 36 labels and as one.
#[test]
fn a_label_costs_what_is_near_to_it() {
    let posts = |label: &dyn Fn(u32) -> Label| -> Sections {
        let section = |z: u32| {
            let plane = Plane { normal: DVec3::Z, offset: 0.5 * f64::from(z) };
            let post = |number: u32| {
                let middle = DVec2::new(f64::from(number / 6), f64::from(number % 6));
                let point = |at: i32| {
                    let at = middle + 0.3 * DVec2::from_angle(TAU * f64::from(at) / 40.0);
                    at.extend(plane.offset)
                };
                Loop { points: (0..40).map(point).collect(), label: label(number), hole_of: None }
            };
            let loops: Vec<Loop> = (0..36).map(post).collect();
            let name = z.to_string();
            Section::from_loops(&name, plane, &loops, 1.0, &Rules::default()).expect("posts").0
        };
        Sections::new((0..5).map(section).collect(), &Rules::default()).expect("sections")
    };
    let made = |sections: Sections| {
        let mut model =
            Model::new(Options { resolution: Resolution::Voxels(96), ..Options::default() });
        let mut context = Context::default();
        model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
        let facts = checked(&model).labels.iter().map(|label| label.facts.clone()).collect();
        (context.stages.count_of("unknowns"), facts)
    };
    let (of_one, one): (u64, Vec<Facts>) = made(posts(&|_| Label(1)));
    let (of_many, many) = made(posts(&|number| Label(number + 1)));
    assert_eq!((one.len(), one[0].components), (1, 36));
    assert_eq!(many.len(), 36);
    assert!(many.iter().all(|post| post.components == 1));
    let volume: f64 = many.iter().map(|post| post.volume).sum();
    assert!((volume / one[0].volume - 1.0).abs() < 0.01, "{volume} {}", one[0].volume);
    // Their surface is solved for once more, for what is outside; the rest is what the coarsest
    // level takes.
    assert!(of_many < 7 * of_one, "{of_many} unknowns, {of_one} as one label");
}

#[test]
fn threads_change_nothing() {
    let planes: Vec<_> =
        (-2..=2).map(|at| (DVec3::new(0.3, 0.1, 1.0), 0.3 * f64::from(at))).collect();
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| closed_model(ball(&planes), 96))
    });
    assert_eq!(one.derived().unwrap().samples, three.derived().unwrap().samples);
    assert_eq!(one.derived().unwrap().mesh, three.derived().unwrap().mesh);
}

#[test]
fn tiny_grids_and_flat_boxes_are_no_trouble() {
    for voxels in [4, 5, 9, 17] {
        let (_, facts) = reconstructed(ball(&[(DVec3::Z, 0.0), (DVec3::X, 0.2)]), voxels);
        assert!(facts.closed);
    }
    // Two planes a thousandth of the circles' size apart.
    let model = closed_model(stack([0.0, 0.01]), 64);
    checked(&model);
}

/// What a reconstruction of given sections must reach against the solid they are cut
/// from: intersection over union, and the volume ratio.
#[test]
fn known_solids_come_back() {
    let goals = [
        ("eight_15", 0.976, [0.99, 1.01]),
        ("hand_ok", 0.957, [0.99, 1.015]),
        ("eight_20", 0.98, [0.99, 1.01]),
        ("Elephant", 0.953, [0.99, 1.01]),
    ];
    for (name, iou, [least, most]) in goals {
        let Some(path) = data(&format!("csl/{name}.csl")) else { return };
        let Some(solid) = data(&format!("reference/{name}_scaled.stl")) else { return };
        let sections = read_sections(&path, &Rules::default()).expect("sections");
        let model = model(sections, 256, Label::OUTSIDE);
        let mesh = &model.derived().unwrap().mesh;
        let solid = read_mesh(&solid).expect("a mesh");
        let found = compare(mesh, &solid, &compare::Options::default(), &Silent).expect("compared");
        println!("{name}: IoU {:.4}, volume ratio {:.4}", found.iou, found.volume_ratio);
        assert!(found.iou >= iou, "{name}: IoU {}", found.iou);
        assert!((least..=most).contains(&found.volume_ratio), "{name}: {}", found.volume_ratio);
        let check = checked(&model);
        let facts = &check.labels[0].facts;
        assert_eq!(facts.components - facts.cavities, 1, "{name}");
        assert!(
            check.dice.mean >= Some(0.995) && check.dice.min >= Some(0.98),
            "{name}: {:?}",
            check.dice.min
        );
    }
}
