//! Solids whose figures are known.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use super::*;
use crate::label::Material;
use crate::mesh::Mesh;
use crate::mesh::shapes::solid;
use crate::progress::Silent;
use crate::volume::{LabelVolume, Placement};

/// Voxels whose labels follow from the places of their centres.
fn voxels(dims: [usize; 3], placement: Placement, label: impl Fn(DVec3) -> u32) -> LabelVolume {
    let [x, y, z] = dims;
    let places = (0..x * y * z).map(|voxel| [voxel % x, voxel / x % y, voxel / (x * y)]);
    let index = places.map(|place| DVec3::from(place.map(|index| index as f64)));
    let labels = index.map(|index| label(placement.origin + placement.steps * index)).collect();
    LabelVolume::new(dims, labels, placement).expect("a volume")
}

fn shape(layers: Vec<LabelVolume>) -> Shape {
    let content = Content::Voxels(LayeredVolume::new(layers).expect("layers"));
    Shape { content, materials: Vec::new(), units: String::new(), frame: String::new() }
}

fn compared(one: Shape, other: &Shape) -> LabelledComparison {
    let options = Options { tolerance: Some(0.5), ..Options::default() };
    compare_labels(one, other, &options, &Silent).expect("they can be compared")
}

fn of(found: &LabelledComparison, label: u32) -> Agreement {
    let own = found.labels.iter().find(|own| own.label == label);
    own.and_then(|own| own.agreement).unwrap_or_else(|| panic!("no label {label}: {found:?}"))
}

fn assert_near(found: f64, expected: f64, part: f64) {
    assert!((found / expected - 1.0).abs() < part, "{found}, not {expected}");
}

/// A lattice that is turned, oblong and left-handed or not, whose voxels are at whole multiples of
/// its steps from the origin.
fn oblong(hand: f64) -> Placement {
    let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let steps = turned * DMat3::from_diagonal(DVec3::new(0.5, hand, 2.0));
    Placement { origin: DVec3::new(40.0, -7.0, 3.0), steps }
}

/// A box of a × b × c that is moved along a by s: of its surface one end is at s from the other,
/// the other end at the least of s and the distance to the sides, and of the four sides as much as
/// s is on the average at s/2.
#[test]
fn shifted_boxes() {
    let [a, b, c, s] = [15.0f64, 20.0, 20.0, 1.5];
    let ends = b * c * (s + s - s * s * (b + c) / (b * c) + 4.0 * s.powi(3) / (3.0 * b * c));
    let area = 2.0 * (a * b + b * c + c * a);
    let mean = (ends + (b + c) * s * s) / area;
    for hand in [1.0, -1.0] {
        let placement = oblong(hand);
        let inverse = placement.steps.inverse();
        let block = |shift: f64| {
            move |at: DVec3| {
                let index = (inverse * (at - placement.origin)).round();
                let low = DVec3::new(4.0 + shift, 5.0, 6.0);
                let high = low + DVec3::new(30.0, 20.0, 10.0);
                u32::from(index.cmpge(low).all() && index.cmplt(high).all()) * 4_000_000_000
            }
        };
        let volume = |shift| shape(vec![voxels([45, 30, 20], placement, block(shift))]);
        let found = compared(volume(0.0), &volume(3.0));
        assert!(found.exact_overlap && found.all.warnings.is_empty(), "{found:?}");
        let own = of(&found, 4_000_000_000);
        assert_eq!(own, found.union);
        assert_near(own.dice, 0.9, 1e-12);
        assert_near(own.iou, 0.9 / 1.1, 1e-12);
        for volume in own.volumes {
            assert_near(volume, a * b * c, 1e-12);
        }
        for area_found in own.areas {
            assert_near(area_found, area, 1e-12);
        }
        for largest in [own.hausdorff, own.hausdorff_95] {
            assert_near(largest, s, 1e-9);
        }
        for found in [own.assd, own.to_reference.mean, own.from_reference.mean] {
            assert_near(found, mean, 5e-3);
        }
        // Beyond the tolerance t is all of one end; of the other what is inside a frame of t; of
        // the sides the part s − t.
        let t = 0.5;
        let far = b * c + (b - 2.0 * t) * (c - 2.0 * t) + 2.0 * (b + c) * (s - t);
        assert_near(own.surface_dice.expect("a tolerance"), 1.0 - far / area, 5e-3);
        assert_near(found.all.hausdorff * found.all.diagonal, s, 1e-9);
    }
}

fn ball(radius: f64, center: DVec3) -> Mesh {
    solid(61, 10.0, |point| radius - (point - center).length())
}

fn plain(steps: f64, origin: f64) -> Placement {
    Placement { origin: DVec3::splat(origin), steps: DMat3::from_diagonal(DVec3::splat(steps)) }
}

/// Balls of radius 6 and 7 around one centre are 1 apart, as meshes, as voxels of two lattices,
/// and one of each. Between voxels the nearest points are corners that stick out: up to half a
/// voxel less on the average.
#[test]
fn balls_of_triangles_and_voxels() {
    let inside = |radius: f64| move |at: DVec3| u32::from(at.length() < radius);
    let fine = |radius| shape(vec![voxels([80; 3], plain(0.2, -7.9), inside(radius))]);
    let other = |radius| shape(vec![voxels([66; 3], plain(0.23, -7.41), inside(radius))]);
    let mesh = |radius| Shape::from(ball(radius, DVec3::ZERO));
    let dice = 2.0 * 216.0 / (216.0 + 343.0);
    for (one, reference, is_exact, low) in [
        (fine(6.0), fine(7.0), true, 0.13),
        (fine(6.0), other(7.0), false, 0.13),
        (mesh(6.0), other(7.0), false, 0.13),
        (fine(6.0), mesh(7.0), false, 0.13),
        (mesh(6.0), mesh(7.0), false, 0.01),
    ] {
        let found = compared(one, &reference);
        assert_eq!(found.exact_overlap, is_exact);
        assert!(found.all.warnings.is_empty(), "{found:?}");
        assert_near(found.union.dice, dice, 5e-3);
        assert_near(found.union.volumes[0], 4.0 / 3.0 * PI * 216.0, 1e-2);
        // A voxel's face is up to half its diagonal from the sphere.
        assert!((found.union.hausdorff - 1.0).abs() < 0.35, "{found:?}");
        assert!((1.0 - low..1.01).contains(&found.union.assd), "{found:?}");
        assert_eq!(of(&found, 1), found.union);
    }
}

/// What is the same is the same on lattices, in frames and in units of any kind.
#[test]
fn frames_and_units_are_turned_into_each_other() {
    let label = |at: DVec3| match at {
        _ if at.distance(DVec3::new(2.0, 1.0, 0.0)) < 3.0 => 1,
        _ if at.distance(DVec3::new(-3.0, 0.0, 1.0)) < 2.0 => 2,
        _ => 0,
    };
    let lps = Shape {
        units: "mm".to_owned(),
        frame: "LPS".to_owned(),
        ..shape(vec![voxels([24; 3], plain(0.5, -5.75), label)])
    };
    let turned = Placement {
        origin: DVec3::new(0.575, 0.575, -0.575),
        steps: DMat3::from_diagonal(DVec3::new(-0.05, -0.05, 0.05)),
    };
    let ras = voxels([24; 3], turned, |at| label(at * DVec3::new(-10.0, -10.0, 10.0)));
    let ras = Shape { units: "cm".to_owned(), frame: "RAS".to_owned(), ..shape(vec![ras]) };
    for (one, reference, unit) in [(&lps, &ras, "cm"), (&ras, &lps, "mm")] {
        let found = compared(one.clone(), reference);
        assert_eq!((found.unit.as_str(), found.exact_overlap), (unit, true));
        assert!(found.all.warnings.is_empty(), "{found:?}");
        assert_eq!(found.labels.len(), 2);
        for label in [1, 2] {
            let own = of(&found, label);
            assert_eq!((own.dice, own.iou), (1.0, 1.0));
            assert!(own.hausdorff < 1e-12, "{own:?}");
            assert_near(own.volumes[0], own.volumes[1], 1e-9);
        }
    }
    // A mesh that is mirrored, too, faces outward still.
    let center = DVec3::new(1.0, 2.0, 3.0);
    let mesh = |turn: DVec3, frame: &str| Shape {
        frame: frame.to_owned(),
        ..Shape::from(ball(4.0, turn * center))
    };
    let found = compared(mesh(DVec3::new(1.0, -1.0, 1.0), "LAS"), &mesh(DVec3::ONE, "LPS"));
    assert!(found.all.warnings.is_empty(), "{found:?}");
    assert!(found.union.dice > 0.999 && found.union.hausdorff < 0.05, "{found:?}");
    // What cannot be turned is told.
    let other = Shape { frame: "UTM 33N".to_owned(), ..lps.clone() };
    let other = Shape { units: "pixel".to_owned(), ..other };
    let found = compared(other, &lps);
    let [unit, frame] = &found.all.warnings[..] else { panic!("{found:?}") };
    assert!(unit.contains("\"pixel\"") && frame.contains("\"UTM 33N\""), "{found:?}");
}

#[test]
fn labels_of_one_side_are_listed_and_names_at_odds_told() {
    let named = |numbers: &[(u32, &str)], layers| {
        let material = |&(id, name): &(u32, &str)| Material {
            name: name.to_owned(),
            ..Material::numbered(Label(id))
        };
        Shape { materials: numbers.iter().map(material).collect(), ..shape(layers) }
    };
    let row = |labels: &[u32]| {
        LabelVolume::new([labels.len(), 1, 1], labels.to_vec(), plain(1.0, 0.0)).expect("a volume")
    };
    let one = named(
        &[(1, "liver"), (2, "spleen"), (3, "label 3"), (4, "left")],
        vec![row(&[1, 1, 0, 2, 2, 2, 3, 0, 4])],
    );
    let reference = named(
        &[(1, "liver"), (3, "other"), (4, "right"), (5, "spleen")],
        vec![row(&[1, 0, 0, 3, 3, 3, 0, 0, 4]), row(&[0, 1, 5, 5, 0, 0, 0, 0, 0])],
    );
    let found = compared(one, &reference);
    let rows: Vec<_> = found.labels.iter().map(|own| (own.label, own.volumes)).collect();
    let expected = [
        (1, [Some(2.0), Some(2.0)]),
        (2, [Some(3.0), None]),
        (3, [Some(1.0), Some(3.0)]),
        (4, [Some(1.0), Some(1.0)]),
        (5, [None, Some(2.0)]),
    ];
    assert_eq!(rows, expected);
    assert_eq!([1, 3, 4].map(|label| of(&found, label).dice), [1.0, 0.0, 1.0]);
    // Seven and seven voxels, of which six are in both.
    assert_eq!(found.union.dice, 12.0 / 14.0);
    assert_eq!(found.labels[1].name.as_deref(), Some("spleen"));
    let [odds] = &found.all.warnings[..] else { panic!("{found:?}") };
    assert!(odds.contains("\"spleen\" is 2 here and 5 in the reference"), "{odds}");
    assert!(odds.contains("4 is \"left\" here and \"right\" in the reference"), "{odds}");
}

/// One label's surface that cannot be measured does not keep others from it.
#[test]
fn an_open_surface_is_told_and_others_are_measured() {
    let mut mesh = ball(4.0, DVec3::splat(-3.0));
    let closed = ball(4.0, DVec3::splat(4.0));
    let first = mesh.vertices.len() as u32;
    let moved = closed.triangles.iter().map(|triangle| triangle.map(|at| at + first));
    mesh.triangles.extend(moved);
    mesh.vertices.extend_from_slice(&closed.vertices);
    mesh.sides.extend(closed.sides.iter().map(|_| [Label(2), Label::OUTSIDE]));
    let whole = Shape::from(mesh.clone());
    // Of label 1 one triangle is left.
    mesh.triangles.drain(1..closed.triangles.len());
    mesh.sides.drain(1..closed.sides.len());
    let found = compared(Shape::from(mesh), &whole);
    assert_eq!(of(&found, 2).dice, 1.0);
    assert_eq!(found.labels[0].agreement, None);
    let told = found.all.warnings.join("\n");
    assert!(told.contains("surface of label 1 in the mesh encloses no volume"), "{told}");
}
