//! Distances with their gradients: known solids, several labels, unknown parts, open boxes, and
//! normals that somebody knows.

mod common;
#[path = "common/derived.rs"]
mod derived;

use common::data;
use derived::checked;
use glam::{DVec2, DVec3};
use transect::compare::{self, Comparison, compare};
use transect::context::Context;
use transect::field::hermite;
use transect::io::mesh::read_mesh;
use transect::io::read_sections;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::method::{Caps, Hermite, Mesher, Method};
use transect::model::Model;
use transect::plane::Plane;
use transect::progress::Silent;
use transect::section::{Overlap, Rules, Section, SectionBuilder};

fn model(sections: Vec<Section>, voxels: u32, method: Hermite) -> transect::Result<Model> {
    derived::model(sections, voxels, Method::Hermite(method))
}

/// The section through balls around the origin, the smaller ones inside, with their labels.
fn cut(normal: DVec3, offset: f64, balls: &[(f64, u32)]) -> SectionBuilder {
    let plane = Plane { normal: normal.normalize(), offset };
    let [u, v] = plane.tangents();
    let builder = Section::builder(format!("{normal} {offset}"), plane);
    balls.iter().filter(|(radius, _)| *radius > offset.abs()).fold(builder, |builder, ball| {
        let radius = (ball.0 * ball.0 - offset * offset).sqrt();
        let corner = |step: u32| {
            let at = radius * DVec2::from_angle(std::f64::consts::TAU * f64::from(step) / 90.0);
            offset * plane.normal + at.x * u + at.y * v
        };
        builder.region(Label(ball.1), (0..90).map(corner))
    })
}

fn built(builder: SectionBuilder) -> Section {
    let rules = Rules { overlap: Some(Overlap::Smallest), ..Rules::default() };
    builder.build(&rules).expect("a section").0
}

/// Planes through and beside the middle of a ball.
fn planes() -> [(DVec3, f64); 5] {
    let lean = DVec3::new(1.0, 1.0, 0.3);
    [(DVec3::X, 0.0), (DVec3::Y, 0.1), (DVec3::Z, -0.3), (DVec3::Z, 0.4), (lean, 0.2)]
}

#[test]
fn a_ball_is_a_ball_whatever_the_options() {
    let volume = 4.0 / 3.0 * std::f64::consts::PI;
    for gradients in [hermite::Gradients::Distance, hermite::Gradients::Normals] {
        for density in [false, true] {
            for mesher in [Mesher::Dual, Mesher::Delaunay(Default::default())] {
                let sections =
                    planes().map(|(normal, offset)| built(cut(normal, offset, &[(1.0, 1)])));
                let interpolation = hermite::Options { spacing: None, gradients, density };
                let method = Hermite { interpolation, mesher, ..Hermite::default() };
                let check = checked(&model(sections.to_vec(), 48, method).expect("a ball"));
                let facts = &check.labels[0].facts;
                assert!(facts.closed && facts.outward, "{method:?}");
                assert_eq!((facts.components, facts.genus), (1, 0), "{method:?}");
                let ratio = facts.volume / volume;
                // What no section says it swells by, away from the box as it is.
                assert!((ratio - 1.0).abs() < 0.08, "{method:?}: {ratio}");
            }
        }
    }
}

#[test]
fn a_ball_in_a_shell_has_no_gap_around_it() {
    let balls = [(1.0, 2), (0.5, 1)];
    let sections = planes().map(|(normal, offset)| built(cut(normal, offset, &balls)));
    let model = model(sections.to_vec(), 64, Hermite::default()).expect("a shell");
    let check = checked(&model);
    let found: Vec<_> =
        check.labels.iter().map(|own| (own.label, own.facts.components, own.facts.genus)).collect();
    // The shell has two surfaces.
    assert_eq!(found, [(1, 1, 0), (2, 2, 0)]);
    let mesh = &model.derived().expect("a mesh").mesh;
    let gap = [Label::OUTSIDE, Label(1)];
    assert!(!mesh.sides.iter().any(|sides| sides.iter().all(|side| gap.contains(side))));
}

#[test]
fn unknown_parts_are_filled_in() {
    let square = |normal: DVec3, offset: f64| {
        let plane = Plane { normal: normal.normalize(), offset };
        let [u, v] = plane.tangents();
        let corner = |[x, y]: [f64; 2]| offset * plane.normal + (0.9 + 0.3 * x) * u + 0.3 * y * v;
        [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner)
    };
    // On every section a square over its contour is unknown.
    let doubtful = planes().map(|(normal, offset)| {
        built(cut(normal, offset, &[(1.0, 1)]).region(Label::UNKNOWN, square(normal, offset)))
    });
    assert!(doubtful.iter().all(Section::is_partial));
    let check = checked(&model(doubtful.to_vec(), 48, Hermite::default()).expect("a ball"));
    let facts = &check.labels[0].facts;
    assert_eq!((facts.components, facts.genus), (1, 0));
    let ratio = facts.volume / (4.0 / 3.0 * std::f64::consts::PI);
    assert!((ratio - 1.0).abs() < 0.12, "{ratio}");
}

/// Two sections through a bar that goes on to both sides.
#[test]
fn an_open_box_is_left_through_its_faces() {
    let bar = |height: f64| {
        let corners = [[-1.0, -0.5], [1.0, -0.5], [1.0, 0.5], [-1.0, 0.5]];
        let corners = corners.map(|[x, y]| DVec3::new(x, y, height));
        let plane = Plane { normal: DVec3::Z, offset: height };
        built(Section::builder(format!("at {height}"), plane).region(Label(1), corners))
    };
    for (caps, closed) in [(Caps::Flat, true), (Caps::None, false)] {
        let method = Hermite { border: Label::UNKNOWN, caps, ..Hermite::default() };
        let model = model(vec![bar(0.0), bar(1.0)], 48, method).expect("a bar");
        let check = model.check(&mut Context::default()).expect("it can be checked");
        let facts = &check.labels[0].facts;
        assert_eq!((facts.components, facts.closed), (1, closed), "{caps:?}");
    }
}

fn compared(model: &Model, reference: &Mesh) -> Comparison {
    let mesh = &model.derived().expect("a mesh").mesh;
    compare(mesh, reference, &compare::Options::default(), &Silent).expect("they can be compared")
}

/// At least what the prototype of the specification reached.
#[test]
fn known_solids() {
    for (name, iou) in
        [("eight_20", 0.934), ("Elephant", 0.93), ("hand_ok", 0.93), ("eight_15", 0.91)]
    {
        let Some(sections) = data(&format!("csl/{name}.csl")) else { return };
        let Some(reference) = data(&format!("reference/{name}_scaled.stl")) else { return };
        let sections = read_sections(&sections, &Rules::default()).expect("sections");
        let model = model(sections.sections, 96, Hermite::default()).expect("a solid");
        checked(&model);
        let found = compared(&model, &read_mesh(&reference).expect("a mesh"));
        println!("{name}: IoU {:.4}, mean distance {:.5}", found.iou, found.chamfer);
        assert!(found.iou >= iou, "{name}: {}", found.iou);
    }
}

/// With the solid's own normals at all vertices of the contours.
#[test]
fn known_normals_are_used() {
    for (name, iou) in [("eight_20", 0.947), ("eight_15", 0.95)] {
        let Some(sections) = data(&format!("csl/{name}.csl")) else { return };
        let Some(reference) = data(&format!("reference/{name}_scaled.stl")) else { return };
        let sections = read_sections(&sections, &Rules::default()).expect("sections");
        let reference = read_mesh(&reference).expect("a mesh");
        let mut normals = vec![DVec3::ZERO; reference.vertices.len()];
        for triangle in &reference.triangles {
            let [a, b, c] = triangle.map(|vertex| reference.vertices[vertex as usize]);
            triangle.iter().for_each(|&vertex| normals[vertex as usize] += (b - a).cross(c - a));
        }
        let nearest = |point: DVec3| {
            let far = |&vertex: &usize| reference.vertices[vertex].distance_squared(point);
            let all = 0..reference.vertices.len();
            all.min_by(|one, other| far(one).total_cmp(&far(other))).expect("a vertex")
        };
        let known = |section: Section| {
            let points: Vec<DVec3> =
                (0..section.vertices().len() as u32).map(|own| section.point(own)).collect();
            let known = points.into_iter().map(|point| (point, normals[nearest(point)]));
            section.with_normals(known).expect("normals")
        };
        let sections = sections.sections.into_iter().map(known).collect();
        let found =
            compared(&model(sections, 96, Hermite::default()).expect("a solid"), &reference);
        println!("{name} with normals: IoU {:.4}", found.iou);
        assert!(found.iou >= iou, "{name}: {}", found.iou);
    }
}

#[test]
fn a_spacing_that_is_too_small_is_refused() {
    let sections = planes().map(|(normal, offset)| built(cut(normal, offset, &[(1.0, 1)])));
    for spacing in [1e-4, 0.0, -1.0, f64::NAN] {
        let interpolation = hermite::Options { spacing: Some(spacing), ..Default::default() };
        let method = Hermite { interpolation, ..Hermite::default() };
        let error = model(sections.to_vec(), 32, method).expect_err("no spacing").to_string();
        assert!(error.contains("spacing"), "{error}");
    }
}
