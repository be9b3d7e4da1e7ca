//! The rectangle around a section's contours.

use glam::{DVec2, DVec3};

use super::Section;

/// A rectangle on a plane, its sides along [`Plane::sides`](crate::plane::Plane::sides).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// What `min` and `max` count from.
    pub origin: DVec3,
    /// The directions of width and height, of unit length.
    pub sides: [DVec3; 2],
    /// The corner with the smallest coordinates.
    pub min: DVec2,
    /// The corner with the largest coordinates.
    pub max: DVec2,
}

impl Rectangle {
    /// Width and height, in world units.
    pub fn size(&self) -> DVec2 {
        self.max - self.min
    }

    /// In square world units.
    pub fn area(&self) -> f64 {
        self.size().element_product()
    }

    /// A point of the rectangle in space.
    pub fn point(&self, at: DVec2) -> DVec3 {
        self.origin + at.x * self.sides[0] + at.y * self.sides[1]
    }
}

impl Section {
    /// The rectangle around all contours; `None` without any.
    pub fn rectangle(&self) -> Option<Rectangle> {
        if self.vertices.is_empty() {
            return None;
        }
        let origin = self.point(0);
        let sides = self.plane.sides();
        let (mut min, mut max) = (DVec2::ZERO, DVec2::ZERO); // the origin's own place
        for &vertex in &self.vertices {
            let offset = self.plane.lift(vertex) - origin;
            let at = DVec2::new(offset.dot(sides[0]), offset.dot(sides[1]));
            (min, max) = (min.min(at), max.max(at));
        }
        Some(Rectangle { origin, sides, min, max })
    }
}
