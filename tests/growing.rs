//! A box that follows its sections, with the size of voxels given: the grid stays, and what a
//! section outside of the box does not concern is not made again.

use std::f64::consts::TAU;

use glam::DVec3;
use transect::change::{Change, SectionId};
use transect::context::Context;
use transect::grid::lattice::Resolution;
use transect::label::Label;
use transect::mesh::nearest::Nearest;
use transect::mesh::patches::Patches;
use transect::method::{MeanValue, Method, Variational};
use transect::model::{Model, Options};
use transect::plane::Plane;
use transect::section::{Rules, Section, Sections};

const VOXEL: f64 = 0.05;

/// A section of a bent tube: where it crosses a plane across z it is a circle.
fn circle(height: f64) -> Section {
    let middle = DVec3::new(0.3 * height.sin(), 0.2 * height.cos(), height);
    let point = |corner: u32| {
        let turn = TAU * f64::from(corner) / 48.0;
        middle + 0.5 * DVec3::new(turn.cos(), turn.sin(), 0.0)
    };
    let plane = Plane { normal: DVec3::Z, offset: height };
    let builder = Section::builder(format!("at {height}"), plane);
    let points: Vec<DVec3> = (0..48).map(point).collect();
    builder.region(Label(1), points).build(&Rules::default()).expect("a section").0
}

/// A section of a ball around the origin, on a plane across an axis; beyond it nothing is.
fn of_ball(axis: usize, offset: f64) -> Section {
    let plane = Plane { normal: DVec3::AXES[axis], offset };
    let radius = (0.25 - offset * offset).max(0.0).sqrt();
    let point = |corner: u32| {
        let turn = TAU * f64::from(corner) / 32.0;
        let mut point = DVec3::ZERO;
        point[axis] = offset;
        (point[(axis + 1) % 3], point[(axis + 2) % 3]) = (radius * turn.cos(), radius * turn.sin());
        point
    };
    let mut builder = Section::builder(format!("across {axis} at {offset}"), plane);
    if radius > 0.0 {
        builder = builder.region(Label(1), (0..32).map(point).collect::<Vec<_>>());
    }
    builder.build(&Rules::default()).expect("a section").0
}

fn model(method: Method) -> Model {
    Model::new(Options { method, resolution: Resolution::VoxelSize(VOXEL), ..Options::default() })
}

fn add(model: &mut Model, sections: &[Section]) -> (Vec<SectionId>, Context<'static>) {
    let mut context = Context::default();
    let sections = Sections::new(sections.to_vec(), &Rules::default()).expect("sections");
    let added = model.apply(Change::Add(sections), &mut context).expect("a change");
    (added, context)
}

/// What the sections of a model make at once.
fn at_once(living: &Model) -> (Model, Context<'static>) {
    let sections: Vec<Section> = living.given().map(|(_, section)| section.clone()).collect();
    let mut once = Model::new(*living.options());
    let (_, context) = add(&mut once, &sections);
    (once, context)
}

/// Ascending distances of the vertices of one surface from another, in voxels.
fn apart(one: &Model, other: &Model) -> Vec<f64> {
    let [one, other] = [one, other].map(|model| &model.derived().expect("a surface").mesh);
    let mut apart = Nearest::on_mesh(other).unwrap().distances(&one.vertices).unwrap();
    apart.sort_by(f64::total_cmp);
    apart.into_iter().map(|distance| distance / VOXEL).collect()
}

#[test]
fn fields_are_solved_for_where_the_box_grew() {
    let method = Method::default();
    let heights: Vec<f64> = (0..40).map(|step| 0.1 * f64::from(step)).collect();
    let stack: Vec<Section> = heights.iter().map(|&height| circle(height)).collect();
    let mut living = model(method);
    let (mut ids, _) = add(&mut living, &stack[..37]);
    let lattice = |model: &Model| model.derived().expect("samples").samples.lattice;
    let first = lattice(&living);
    for (count, section) in stack.iter().enumerate().skip(37) {
        let (added, last) = add(&mut living, std::slice::from_ref(section));
        ids.extend(added);
        let (once, offline) = at_once(&living);
        assert_eq!(lattice(&living), lattice(&once));
        let found = apart(&living, &once);
        let at = |percent: usize| found[(found.len() - 1) * percent / 100];
        assert!(at(95) < 0.02 && at(99) < 0.05 && at(100) < 0.5, "{count}: {}", at(99));
        let [some, all] = [&last, &offline].map(|context| context.stages.count_of("unknowns"));
        assert!(4 * some < 3 * all, "{some} of {all} with {count}");
    }
    assert_ne!(first, lattice(&living), "the box has grown");
    // And back again.
    for id in ids.drain(37..).rev() {
        living.apply(Change::Remove(id), &mut Context::default()).expect("it is there");
    }
    assert_eq!(first, lattice(&living));
    let found = apart(&living, &at_once(&living).0);
    assert!(found[found.len() * 99 / 100] < 0.05, "{found:?}");
}

#[test]
fn the_mean_value_field_is_evaluated_where_the_box_grew() {
    let method = Method::MeanValue(MeanValue { smooth: 0.0, ..MeanValue::default() });
    let offsets = [-0.45, -0.15, 0.15, 0.45];
    let across = |axis| offsets.map(|offset| of_ball(axis, offset));
    let sections: Vec<Section> = (0..3).flat_map(across).collect();
    // Most leaves are in inner cells alone.
    let resolution = Resolution::VoxelSize(VOXEL / 4.0);
    let mut living = Model::new(Options { method, resolution, ..Options::default() });
    let (_, first) = add(&mut living, &sections);
    // A crumb beside the ball makes the box larger, and touches no cell that the ball is in.
    let crumb = {
        // It is no neighbour in a stack, whose gap would be room for the box on all sides.
        let plane = Plane { normal: DVec3::new(1.0, 0.05, 0.0), offset: 2.5 };
        let corners = [[0.0, 0.0], [0.3, 0.0], [0.0, 0.3]];
        let corners = corners.map(|[y, z]| DVec3::new(2.5 - 0.05 * y, y, z));
        let builder = Section::builder("crumb", plane);
        builder.region(Label(1), corners.to_vec()).build(&Rules::default()).expect("a section").0
    };
    let (added, last) = add(&mut living, &[crumb]);
    let same = |living: &Model| {
        let (once, offline) = at_once(living);
        let [one, other] = [living, &once].map(|model| &model.derived().unwrap().samples);
        assert_eq!(
            (one.lattice, &one.valued, &one.tiles),
            (other.lattice, &other.valued, &other.tiles)
        );
        for (one, other) in one.leaves().zip(other.leaves()) {
            for (one, other) in one.materials.iter().zip(&other.materials) {
                assert_eq!(one.label, other.label);
                let pairs = one.values.iter().zip(other.values.iter());
                assert!(pairs.into_iter().all(|(one, other)| (one - other).abs() < 2e-6));
            }
        }
        offline
    };
    let offline = same(&living);
    let evaluations = |context: &Context| context.stages.count_of("evaluations");
    let counts = [&last, &offline].map(evaluations);
    assert!(4 * counts[0] < 3 * counts[1], "{counts:?}");
    let touched = |context: &Context| context.stages.count_of("touched");
    assert!(touched(&last) < touched(&offline));
    // It goes, and the box is as it was.
    let mut context = Context::default();
    living.apply(Change::Remove(added[0]), &mut context).expect("it is there");
    same(&living);
    let counts = [&context, &first].map(evaluations);
    assert!(2 * counts[0] < counts[1], "{counts:?}");
}

#[test]
fn patches_keep_their_names() {
    let mut living = model(Method::Variational(Variational::default()));
    add(&mut living, &(0..37).map(|step| circle(0.1 * f64::from(step))).collect::<Vec<_>>());
    let follow = |patches: &mut Patches, model: &Model| {
        let derived = model.derived().expect("a surface");
        patches.follow(&derived.mesh, derived.samples.lattice)
    };
    let mut patches = Patches::default();
    let all = follow(&mut patches, &living);
    let before = living.derived().expect("samples").samples.lattice;
    // Below the others: leaves of the grid have other numbers then.
    let (_, _) = add(&mut living, &[circle(-0.1), circle(-0.2), circle(-0.3)]);
    assert_ne!(before.origin, living.derived().expect("samples").samples.lattice.origin);
    let told = follow(&mut patches, &living);
    assert_eq!((told.origin, told.side), (all.origin, all.side));
    assert!(2 * told.changed.len() < all.changed.len(), "{}", told.changed.len());
    assert!(told.changed.iter().all(|name| name[2] < 5), "{:?}", told.changed);
}
