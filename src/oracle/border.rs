//! The box's faces, and all beyond them, when these are known.

use glam::DVec3;

use super::Nearest;
use super::candidate::Candidate;
use super::exact::{Number, number};
use super::float::Range;
use crate::label::Label;
use crate::plane::Bounds;

/// A box that is known to have a label on its faces and beyond them.
#[derive(Debug, Clone, Copy)]
pub struct Border {
    pub bounds: Bounds,
    pub label: Label,
}

impl Border {
    /// What is nearest to a point beyond the box: itself.
    pub fn beyond(&self, point: DVec3) -> Option<Nearest> {
        let here = Nearest { label: self.label, section: None, distance: 0.0, foot: point };
        (!self.bounds.contains(point)).then_some(here)
    }

    /// The nearest point of the faces; the point itself beyond them.
    pub fn nearest(&self, point: DVec3) -> (f64, DVec3) {
        if !self.bounds.contains(point) {
            return (0.0, point);
        }
        let place = |(axis, face): (usize, f64)| {
            let mut place = point;
            place[axis] = face;
            ((point[axis] - face).abs(), place)
        };
        let nearest = self.faces().map(place).min_by(|one, other| one.0.total_cmp(&other.0));
        nearest.unwrap_or((0.0, point))
    }

    /// The nearest point of the faces, with a bound on its distance's error.
    pub fn candidate(&self, point: DVec3) -> Candidate {
        let (distance, place) = self.nearest(point);
        let distance = Range::around(distance, f64::EPSILON * distance);
        Candidate { distance, place, label: Some(self.label), edges: Vec::new() }
    }

    /// The exact squared distance of a point of the box to the faces.
    pub fn squared_distance(&self, point: DVec3) -> Number {
        let square = |(axis, face): (usize, f64)| (number(point[axis]) - number(face)).sqr();
        self.faces().map(square).min().unwrap_or(Number::ZERO)
    }

    /// Axis and place of every face.
    fn faces(&self) -> impl Iterator<Item = (usize, f64)> {
        let Bounds { min, max } = self.bounds;
        (0..3).flat_map(move |axis| [(axis, min[axis]), (axis, max[axis])])
    }
}
