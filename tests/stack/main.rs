//! Parallel sections by interpolating distances: known solids, stacks that lean, several
//! labels, and sections that are no stack.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/derived.rs"]
mod derived;
mod links;
#[path = "../common/random.rs"]
mod random;

use std::f64::consts::TAU;

use common::data;
use derived::checked;
use glam::{DQuat, DVec2, DVec3};
use transect::compare::{self, compare};
use transect::io::mesh::read_mesh;
use transect::io::read_sections;
use transect::label::Label;
use transect::method::{Caps, Mesher, Method, ShapeBased};
use transect::model::Model;
use transect::plane::Plane;
use transect::progress::Silent;
use transect::section::{Overlap, Rules, Section, SectionBuilder};

/// A section of discs around the z axis, the smaller ones on top, each with a radius and a
/// label; turned.
fn section(height: f64, discs: &[(f64, u32)], turn: DQuat) -> Section {
    let plane = Plane { normal: turn * DVec3::Z, offset: height };
    let circle = |radius: f64| {
        (0..180).map(move |step| {
            let at = radius * DVec2::from_angle(TAU * f64::from(step) / 180.0);
            turn * at.extend(height)
        })
    };
    let builder = Section::builder(format!("at {height}"), plane);
    let add = |builder: SectionBuilder, &(radius, label): &(f64, u32)| {
        builder.region(Label(label), circle(radius))
    };
    let rules = Rules { overlap: Some(Overlap::Smallest), ..Rules::default() };
    discs.iter().fold(builder, add).build(&rules).expect("a section").0
}

fn model(sections: Vec<Section>, voxels: u32, method: ShapeBased) -> transect::Result<Model> {
    derived::model(sections, voxels, Method::Stack(method))
}

/// A cone from radius 1 to ½ over a height of 2, in five slices.
fn cone(turn: DQuat) -> Vec<Section> {
    let heights = (0..5).map(|slice| 0.5 * f64::from(slice));
    heights.map(|height| section(height, &[(1.0 - 0.25 * height, 1)], turn)).collect()
}

#[test]
fn a_cone_is_a_cone_however_it_leans() {
    // Between the first and the last slice, with half a voxel more on either side.
    let volume = TAU / 2.0 * (1.0 + 0.5 + 0.25) * 2.0 / 3.0;
    let turns = [
        DQuat::IDENTITY,
        DQuat::from_rotation_y(TAU / 4.0),
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7),
    ];
    for turn in turns {
        let method = ShapeBased { caps: Caps::None, ..ShapeBased::default() };
        let check = checked(&model(cone(turn), 96, method).expect("a stack"));
        let facts = &check.labels[0].facts;
        assert_eq!((facts.components, facts.genus), (1, 0));
        let ratio = facts.volume / volume;
        assert!((ratio - 1.0).abs() < 0.03, "{turn}: {ratio}");
        assert!(check.dice.mean > Some(0.99), "{turn}: {:?}", check.dice);
    }
}

#[test]
fn every_cap_closes_it() {
    let mut volumes = Vec::new();
    for caps in [Caps::None, Caps::Rounded, Caps::Flat] {
        for mesher in [Mesher::Dual, Mesher::Delaunay(Default::default())] {
            let method = ShapeBased { caps, mesher, link: None };
            let model = model(cone(DQuat::IDENTITY), 48, method).expect("a stack");
            let check = checked(&model);
            let facts = &check.labels[0].facts;
            assert!(facts.closed && facts.outward && facts.components == 1, "{method:?}");
            volumes.push(facts.volume);
        }
    }
    assert!(volumes.chunks(2).map(|pair| pair[0]).is_sorted(), "{volumes:?}");
}

/// A ring of 2 around 1, which at the upper end is all there is: labels meet without a gap.
#[test]
fn no_gap_opens_between_labels() {
    let rings = [
        (0.0, vec![(1.0, 2), (0.5, 1)]),
        (0.4, vec![(0.9, 2), (0.6, 1)]),
        (0.8, vec![(1.0, 2), (0.3, 1)]),
        (1.2, vec![(0.8, 2)]),
    ];
    let sections =
        rings.iter().map(|(height, discs)| section(*height, discs, DQuat::IDENTITY)).collect();
    let model = model(sections, 96, ShapeBased::default()).expect("a stack");
    let check = checked(&model);
    assert_eq!(check.labels.iter().map(|own| own.label).collect::<Vec<_>>(), [1, 2]);
    // Label 1 is inside of label 2: no triangle has it on one side and nothing on the other, but
    // for where it ends below.
    let mesh = &model.derived().expect("a mesh").mesh;
    let touches = |sides: &[Label; 2]| sides.contains(&Label(1)) && sides.contains(&Label::OUTSIDE);
    let highest = (mesh.triangles.iter().zip(&mesh.sides))
        .filter(|(_, sides)| touches(sides))
        .flat_map(|(triangle, _)| triangle.map(|vertex| mesh.vertices[vertex as usize].z))
        .fold(f64::NEG_INFINITY, f64::max);
    assert!(highest < 0.0, "{highest}");
}

#[test]
fn what_ends_between_slices_ends_about_halfway() {
    // Three discs of one label, and one of another.
    let disc = |(slice, label)| section(f64::from(slice), &[(1.0, label)], DQuat::IDENTITY);
    let sections = [(0, 1), (1, 1), (2, 1), (3, 2)].map(disc).to_vec();
    let model = model(sections, 96, ShapeBased::default()).expect("a stack");
    let check = checked(&model);
    let mesh = &model.derived().expect("a mesh").mesh;
    let heights = |label: u32| {
        let surface = mesh.surface(Label(label));
        let heights = surface.vertices.iter().map(|vertex| vertex.z);
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    };
    let near = |found: f64, wanted: f64, most: f64| {
        assert!((found - wanted).abs() < most, "{found} {wanted}");
    };
    let [lower, upper] = [heights(1), heights(2)];
    near(lower[0], -0.5, 0.05);
    near(upper[1], 3.5, 0.05);
    // A spline that is flat below is a little slow to fall.
    near(lower[1], 2.5, 0.15);
    near(lower[1], upper[0], 0.05);
    assert_eq!(check.labels.len(), 2);
}

#[test]
fn what_is_no_stack_is_refused_by_name() {
    let error = |sections: Vec<Section>| {
        model(sections, 32, ShapeBased::default()).expect_err("no stack").to_string()
    };
    let flat = || cone(DQuat::IDENTITY);
    let mut leaning = flat();
    leaning.push(section(0.3, &[(0.5, 1)], DQuat::from_rotation_x(0.3)));
    let found = error(leaning);
    assert!(found.contains("at 0.3") && found.contains("not parallel to at 0"), "{found}");
    let found = error(flat()[..1].to_vec());
    assert!(found.contains("two parallel sections"), "{found}");
    let plane = Plane { normal: DVec3::Z, offset: 1.25 };
    let square = [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]];
    let square = square.map(|[x, y]| DVec3::new(x, y, 1.25));
    let partial =
        Section::builder("hole", plane).region(Label::UNKNOWN, square).build(&Rules::default());
    let mut sections = flat();
    sections.push(partial.expect("a section").0);
    let found = error(sections);
    assert!(found.contains("hole") && found.contains("unknown"), "{found}");
}

/// Solids cut into 15 slices. The hand's is cut off at the wrist, where a cap would be added.
#[test]
fn known_solids() {
    for (name, caps, iou, distance) in
        [("eight_15", Caps::Rounded, 0.969, 2.5e-3), ("hand_ok", Caps::None, 0.954, 3.0e-3)]
    {
        let Some(sections) = data(&format!("csl/{name}.csl")) else { return };
        let Some(reference) = data(&format!("reference/{name}_scaled.stl")) else { return };
        let sections = read_sections(&sections, &Rules::default()).expect("sections");
        let method = ShapeBased { caps, ..ShapeBased::default() };
        let model = model(sections.sections, 192, method).expect("a stack");
        checked(&model);
        let mesh = &model.derived().expect("a mesh").mesh;
        let reference = read_mesh(&reference).expect("a mesh");
        let found = compare(mesh, &reference, &compare::Options::default(), &Silent)
            .expect("they can be compared");
        println!("{name}: IoU {:.4}, mean distance {:.5}", found.iou, found.chamfer);
        assert!(found.iou > iou, "{name}: {}", found.iou);
        assert!(found.chamfer < distance, "{name}: {}", found.chamfer);
    }
}
