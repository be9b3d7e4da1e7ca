//! Sections made by hand, and facts about them that anyone can count.

mod contours;
mod locating;
mod planes;

use glam::{DVec2, DVec3};

use super::{Arrangement, Face};
use crate::label::Label;
use crate::plane::{Bounds, Plane};
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

/// The arrangement, which must be sane.
fn arrange(sections: &[Section], bounds: Bounds) -> Arrangement {
    let arrangement = Arrangement::new(sections, bounds, Label::OUTSIDE).unwrap();
    assert_eq!(arrangement.sanity_check(), Ok(()));
    arrangement
}

/// As [`arrange`], of planes without contours.
fn arrange_planes(planes: &[Plane], bounds: Bounds) -> Arrangement {
    arrange(&planes.iter().copied().map(empty).collect::<Vec<_>>(), bounds)
}

/// The faces on a plane.
fn faces_on(arrangement: &Arrangement, plane: u32) -> Vec<&Face> {
    arrangement.faces().iter().filter(|face| face.plane == plane).collect()
}

/// The area of a label on a plane.
fn area(arrangement: &Arrangement, plane: u32, label: Label) -> f64 {
    let normal = arrangement.planes()[plane as usize].unit_normal();
    let origin = arrangement.bounds().min;
    let mut sum = 0.0;
    for edge in faces_on(arrangement, plane).iter().flat_map(|face| &face.edges) {
        let part = (edge.start - origin).cross(edge.end - origin).dot(normal) / 2.0;
        sum += if edge.left == label { part } else { 0.0 };
        sum -= if edge.right == Some(label) { part } else { 0.0 };
    }
    sum
}

/// A small generator of repeatable numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [low, high).
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn point(&mut self, bounds: Bounds) -> DVec3 {
        let mut coordinate = |axis: usize| self.between(bounds.min[axis], bounds.max[axis]);
        DVec3::new(coordinate(0), coordinate(1), coordinate(2))
    }

    /// Through a point of the box.
    fn plane(&mut self, bounds: Bounds) -> Plane {
        let normal = self.point(CENTERED);
        Plane { normal, offset: normal.dot(self.point(bounds)) }
    }
}
