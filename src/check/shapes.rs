//! Sections for tests.

use glam::{DVec2, DVec3};

use crate::label::Label;
use crate::plane::Plane;
use crate::section::{Edge, Section};

/// The edges of a counter-clockwise polygon with `label` inside and outside
/// around it.
pub fn polygon(corners: u32, label: Label) -> Vec<Edge> {
    let edge =
        |start| Edge { start, end: (start + 1) % corners, left: label, right: Label::OUTSIDE };
    (0..corners).map(edge).collect()
}

/// A polygon on a plane, given in its tangents' coordinates around the foot
/// of the origin.
pub fn section(plane: Plane, corners: &[DVec2], label: Label) -> Section {
    let [first, second] = plane.tangents();
    let foot = plane.unit_normal() * plane.offset / plane.normal.length();
    let point = |corner: &DVec2| -> DVec3 { foot + first * corner.x + second * corner.y };
    Section {
        name: "test".into(),
        plane,
        vertices: corners.iter().map(|corner| plane.project(point(corner))).collect(),
        edges: polygon(corners.len() as u32, label),
        background: Label::OUTSIDE,
        normals: Vec::new(),
    }
}

/// A disc around the foot of the origin on a plane.
pub fn disc(plane: Plane, radius: f64, corners: u32, label: Label) -> Section {
    let turn = std::f64::consts::TAU / f64::from(corners);
    let corners: Vec<DVec2> =
        (0..corners).map(|at| radius * DVec2::from_angle(turn * f64::from(at))).collect();
    section(plane, &corners, label)
}

/// A plane with polygons on it by kept coordinates, counter-clockwise, and the labels left and
/// right of their edges.
pub fn partition(
    plane: Plane,
    polygons: &[(Vec<DVec2>, [Label; 2])],
    background: Label,
) -> Section {
    let mut section = Section {
        name: "test".into(),
        plane,
        vertices: vec![],
        edges: vec![],
        background,
        normals: vec![],
    };
    for (corners, [left, right]) in polygons {
        let (first, count) = (section.vertices.len() as u32, corners.len() as u32);
        let edge = |at| Edge {
            start: first + at,
            end: first + (at + 1) % count,
            left: *left,
            right: *right,
        };
        section.edges.extend((0..count).map(edge));
        section.vertices.extend(corners);
    }
    section
}

/// The corners of a rectangle, counter-clockwise.
pub fn rectangle(min: [f64; 2], max: [f64; 2]) -> Vec<DVec2> {
    [min, [max[0], min[1]], max, [min[0], max[1]]].map(DVec2::from).to_vec()
}
