//! Parts of a stack that overlap nothing of their label on the next section, linked.

use std::f64::consts::TAU;

use glam::{DQuat, DVec2, DVec3};
use transect::check::Check;
use transect::label::Label;
use transect::method::{Caps, Linking, Method, ShapeBased};
use transect::model::Model;
use transect::plane::Plane;
use transect::section::{Overlap, Rules, Section};
use transect::stack::Links;

use super::derived::{self, checked};
use super::random::Random;

/// A disc: its middle, its radius and its label.
type Disc = ([f64; 2], f64, u32);

const LINKED: Option<Linking> = Some(Linking { farthest: None });

fn section(height: f64, discs: &[Disc], turn: DQuat) -> Section {
    let plane = Plane { normal: turn * DVec3::Z, offset: height };
    let mut builder = Section::builder(format!("at {height}"), plane);
    for &([x, y], radius, label) in discs {
        let circle = (0..96).map(|step| {
            let at = DVec2::new(x, y) + radius * DVec2::from_angle(TAU * f64::from(step) / 96.0);
            turn * at.extend(height)
        });
        builder = builder.region(Label(label), circle);
    }
    let rules = Rules { overlap: Some(Overlap::Smallest), ..Rules::default() };
    builder.build(&rules).expect("a section").0
}

fn stack(slices: &[(f64, Vec<Disc>)]) -> Vec<Section> {
    slices.iter().map(|(height, discs)| section(*height, discs, DQuat::IDENTITY)).collect()
}

fn model(sections: Vec<Section>, link: Option<Linking>, voxels: u32) -> Model {
    let method = ShapeBased { link, caps: Caps::None, ..ShapeBased::default() };
    derived::model(sections, voxels, Method::Stack(method)).expect("a stack")
}

fn links(model: &Model) -> &Links {
    model.derived().and_then(|derived| derived.links.as_ref()).expect("a stack says so")
}

/// So many slices, two apart, of discs that move by 2.5 along x from each to the next.
fn oblique(count: usize, discs: &[Disc]) -> Vec<(f64, Vec<Disc>)> {
    let slice = |number: usize| {
        let along = 2.5 * number as f64;
        let moved = discs.iter().map(|&([x, y], radius, label)| ([x + along, y], radius, label));
        (2.0 * number as f64, moved.collect())
    };
    (0..count).map(slice).collect()
}

#[test]
fn an_oblique_cylinder_becomes_one_piece() {
    let right = TAU / 2.0 * 10.0;
    for turn in
        [DQuat::IDENTITY, DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7)]
    {
        let slices = oblique(6, &[([0.0, 0.0], 1.0, 1)]);
        let sections: Vec<Section> =
            slices.iter().map(|(height, discs)| section(*height, discs, turn)).collect();
        let apart = model(sections.clone(), None, 128);
        let before = checked(&apart);
        assert_eq!(before.labels[0].facts.components, 6);
        assert!(!links(&apart).connected && links(&apart).found.len() == 5);

        let linked = model(sections, LINKED, 128);
        let check = checked(&linked);
        let facts = &check.labels[0].facts;
        assert_eq!((facts.components, facts.genus), (1, 0));
        let ratio = facts.volume / right;
        assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
        let [was, is] = [&before, &check].map(|one| one.dice.min.expect("a Dice"));
        assert!(is > 0.94 && is > was - 0.03, "{was} {is}");
        // It passes every section as it passes the space between.
        let ripple = check.labels[0].ripple.expect("six sections cut it");
        assert!(ripple.angle().abs() < 3.0, "{ripple:?}");
        let found = &links(&linked).found[2];
        assert_eq!(found.sections, ["at 4", "at 6"]);
        let translation = turn.inverse() * DVec3::from_array(found.translation);
        assert!(translation.abs_diff_eq(DVec3::new(2.5, 0.0, 0.0), 0.2), "{translation}");
        let at = turn.inverse() * DVec3::from_array(found.at);
        assert!(at.abs_diff_eq(DVec3::new(5.0, 0.0, 4.0), 0.1), "{at}");
        assert!(found.overlap > 0.9 && (found.length - 2.5).abs() < 0.2, "{found:?}");
    }
}

#[test]
fn cylinders_side_by_side_are_linked_each_to_its_own() {
    // The second one's next disc is farther from it than the first one's.
    let slices = oblique(5, &[([0.0, 0.0], 1.0, 1), ([4.6, 0.0], 1.0, 1), ([0.0, 4.0], 0.9, 1)]);
    let check = checked(&model(stack(&slices), LINKED, 128));
    let facts = &check.labels[0].facts;
    assert_eq!((facts.components, facts.genus), (3, 0));
    let right = TAU / 2.0 * 8.0 * (1.0 + 1.0 + 0.81);
    assert!((facts.volume / right - 1.0).abs() < 0.04, "{}", facts.volume / right);
}

#[test]
fn labels_are_linked_by_themselves_and_leave_no_gap() {
    // A canal of 2 in a cylinder of 1, and a wall of 3 that neither of them touches.
    let canal = [([0.0, 0.0], 1.0, 1), ([0.0, 0.0], 0.5, 2)];
    let mut slices = oblique(5, &canal);
    for (_, discs) in &mut slices {
        discs.push(([5.0, 9.0], 3.0, 3));
    }
    let sections = stack(&slices);
    let apart = model(sections.clone(), None, 160);
    let linked = model(sections, LINKED, 160);
    let check = checked(&linked);
    let of = |check: &Check| -> Vec<(u32, usize)> {
        check.labels.iter().map(|label| (label.label, label.facts.components)).collect()
    };
    // The canal leaves the surface of 1 where it begins and ends.
    assert_eq!(of(&check), [(1, 1), (2, 1), (3, 1)]);
    assert_eq!(of(&checked(&apart))[1..], [(2, 5), (3, 1)]);
    // What no link concerns is what it was.
    let surface = |model: &Model| model.derived().expect("a mesh").mesh.surface(Label(3)).vertices;
    assert_eq!(surface(&apart), surface(&linked));
    // Between the canal and the outside there is label 1, but for both ends.
    let mesh = &linked.derived().expect("a mesh").mesh;
    for (triangle, sides) in mesh.triangles.iter().zip(&mesh.sides) {
        if sides.contains(&Label(2)) && sides.contains(&Label::OUTSIDE) {
            let height = mesh.vertices[triangle[0] as usize].z;
            assert!(!(0.2..7.8).contains(&height), "{height}");
        }
    }
}

#[test]
fn a_hole_that_moves_becomes_a_canal() {
    for label in [1, 2] {
        // With label 2 outside has a field of its own.
        let slice = |number: usize| {
            let x = -3.0 + 2.5 * number as f64;
            let hole = ([x, 0.0], 1.0, 0);
            (2.0 * number as f64, vec![([0.0, 0.0], 6.0, 1), ([0.0, 9.0], 1.0, label), hole])
        };
        let slices: Vec<(f64, Vec<Disc>)> = (0..3).map(slice).collect();
        let facts = |link: Option<Linking>| {
            let check = checked(&model(stack(&slices), link, 128));
            (check.labels[0].facts.genus, check.labels[0].facts.components)
        };
        let beside = usize::from(label == 1);
        // Each end has a dent, and one is a bubble.
        assert_eq!(facts(None), (0, 2 + beside));
        assert_eq!(facts(LINKED), (1, 1 + beside));
    }
}

#[test]
fn what_is_far_stays_apart() {
    let slices = vec![
        (0.0, vec![([0.0, 0.0], 1.0, 1), ([0.0, 6.0], 1.0, 1)]),
        (1.0, vec![([0.0, 0.0], 1.0, 1), ([8.0, 6.0], 1.0, 1)]),
        (2.0, vec![([0.0, 0.0], 1.0, 1), ([8.0, 6.0], 1.0, 1)]),
    ];
    let near = model(stack(&slices), LINKED, 160);
    assert!(links(&near).found.is_empty());
    assert_eq!(checked(&near).labels[0].facts.components, 3);
    let far = model(stack(&slices), Some(Linking { farthest: Some(9.0) }), 160);
    assert_eq!((links(&far).found.len(), checked(&far).labels[0].facts.components), (1, 2));
    // Unlike shapes are none that move.
    let mut unlike = slices;
    unlike[0].1[1].1 = 0.3;
    let unlike = model(stack(&unlike), Some(Linking { farthest: Some(9.0) }), 160);
    assert!(links(&unlike).found.is_empty());
}

#[test]
fn branches_go_on_as_they_did() {
    // One overlaps both of two, and beside them one has two to choose from.
    let slices = vec![
        (0.0, vec![([0.0, 0.0], 2.0, 1), ([0.0, 8.0], 1.0, 1)]),
        (
            2.0,
            vec![
                ([-1.5, 0.0], 0.8, 1),
                ([1.5, 0.0], 0.8, 1),
                ([-2.4, 8.0], 1.0, 1),
                ([2.3, 8.0], 1.0, 1),
            ],
        ),
    ];
    let linked = model(stack(&slices), LINKED, 96);
    let found = &links(&linked).found;
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(found[0].translation[0] > 0.0, "the nearer of the two");
    assert_eq!(checked(&linked).labels[0].facts.components, 3);
}

/// Random discs of three labels in random slices: whatever is linked, surfaces are closed, and
/// sections are what they were.
#[test]
fn random_stacks() {
    let mut connected = 0;
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (mut height, mut slices) = (0.0, Vec::new());
        let lean = [random.between(-3.0..3.0), random.between(-3.0..3.0)];
        for number in 0..2 + random.below(5) {
            let mut discs: Vec<Disc> = Vec::new();
            for disc in 0..random.below(7) {
                let along = number as f64;
                let (x, y) = (3.0 * disc as f64 + along * lean[0], along * lean[1]);
                let jitter = [random.between(-1.0..1.0), random.between(-1.0..1.0)];
                let radius = random.between(0.05..2.0);
                discs.push(([x + jitter[0], y + jitter[1]], radius, random.below(4) as u32));
            }
            slices.push((height, discs));
            height += random.between(0.02..3.0);
        }
        slices[0].1.push(([0.0, 0.0], 1.0, 1));
        let sections = stack(&slices);
        let farthest = random.percent(50).then(|| random.between(0.1..20.0));
        let apart = checked(&model(sections.clone(), None, 48));
        let linked = model(sections, Some(Linking { farthest }), 48);
        connected += links(&linked).found.len();
        let check = checked(&linked);
        assert!(check.labels.iter().all(|label| label.facts.closed && label.facts.outward));
        for (is, was) in check.dice.sections.iter().zip(&apart.dice.sections) {
            let (is, was) = (is.dice.unwrap_or(1.0), was.dice.unwrap_or(1.0));
            assert!(is > was - 0.06, "seed {seed}, {}: {was} {is}", slices.len());
        }
    }
    assert!(connected > 8, "{connected}");
}

#[test]
fn slices_that_nearly_touch_are_not_linked() {
    // Whatever may be linked: a tube so flat would need images larger than any memory.
    let far = Some(Linking { farthest: Some(100.0) });
    for gap in [1e-7, 1e-3] {
        let slices = [(0.0, 0.0), (gap, 8.0), (10.0, 8.0)]
            .map(|(height, along)| (height, vec![([along, 0.0], 1.0, 1)]));
        let model = model(stack(&slices), far, 48);
        assert_eq!(links(&model).found, [], "{gap}");
        checked(&model);
    }
}
