//! Sections made by hand, and facts about them that anyone can count.

mod contours;
mod editing;
mod locating;
mod planes;

use glam::{DVec2, DVec3};

use super::{BOX_PLANES, Complex, Editor, Facet};
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::random::Random;
use crate::section::{Edge, Section};

const UNIT: Bounds = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
/// Around the origin.
const CENTERED: Bounds = Bounds { min: DVec3::NEG_ONE, max: DVec3::ONE };

fn plane(normal: [f64; 3], offset: f64) -> Plane {
    Plane { normal: DVec3::from_array(normal), offset }
}

/// A section without contours.
fn empty(plane: Plane) -> Section {
    Section {
        name: "empty".to_owned(),
        plane,
        vertices: Vec::new(),
        edges: Vec::new(),
        background: Label::OUTSIDE,
        normals: Vec::new(),
    }
}

/// A section with disjoint polygons, given counter-clockwise in kept
/// coordinates, each with the label inside.
fn drawn(name: &str, plane: Plane, polygons: &[(&[DVec2], u32)]) -> Section {
    let mut section = Section { name: name.to_owned(), ..empty(plane) };
    for (points, label) in polygons {
        let first = section.vertices.len() as u32;
        let count = points.len() as u32;
        section.vertices.extend_from_slice(points);
        section.edges.extend((0..count).map(|i| Edge {
            start: first + i,
            end: first + (i + 1) % count,
            left: Label(*label),
            right: Label::OUTSIDE,
        }));
    }
    section
}

/// An axis-parallel rectangle, counter-clockwise.
fn rectangle(min: [f64; 2], max: [f64; 2]) -> [DVec2; 4] {
    [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]].map(DVec2::from_array)
}

/// The complex, which must be sane.
fn arrange(sections: &[Section], bounds: Bounds) -> Complex {
    let mut editor = Editor::new(bounds, Label::OUTSIDE).unwrap();
    for section in sections {
        editor.add(section).unwrap();
    }
    editor.commit().unwrap();
    editor.assert_sane();
    editor.into_complex()
}

/// As [`arrange`], of planes without contours.
fn arrange_planes(planes: &[Plane], bounds: Bounds) -> Complex {
    arrange(&planes.iter().copied().map(empty).collect::<Vec<_>>(), bounds)
}

/// The facets of the section with an index.
fn facets_on(complex: &Complex, section: u32) -> Vec<&Facet> {
    let plane = BOX_PLANES + section;
    complex.facets().values().filter(|facet| facet.plane == plane).collect()
}

/// The area of a label on some facets.
fn area(complex: &Complex, facets: &[&Facet], label: Label) -> f64 {
    let origin = complex.bounds().min;
    let mut sum = 0.0;
    for (facet, edge) in facets.iter().flat_map(|f| f.edges.iter().map(move |edge| (f, edge))) {
        let normal = complex.planes()[facet.plane].unit_normal();
        let part = (edge.start - origin).cross(edge.end - origin).dot(normal) / 2.0;
        sum += if edge.left == label { part } else { 0.0 };
        sum -= if edge.right == Some(label) { part } else { 0.0 };
    }
    sum
}

/// In [low, high).
fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

fn point_in(random: &mut Random, bounds: Bounds) -> DVec3 {
    let mut coordinate = |axis: usize| between(random, bounds.min[axis], bounds.max[axis]);
    DVec3::new(coordinate(0), coordinate(1), coordinate(2))
}

/// Through a point of the box.
fn plane_in(random: &mut Random, bounds: Bounds) -> Plane {
    let normal = point_in(random, CENTERED);
    Plane { normal, offset: normal.dot(point_in(random, bounds)) }
}
