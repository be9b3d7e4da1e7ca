//! Planes in floats with bounds on their errors.

use glam::DVec3;

use crate::plane::Plane;

/// A distance as computed, and doubles that it truly lies between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Range {
    /// Around a distance that is off by no more than an error.
    pub fn around(distance: f64, error: f64) -> Self {
        // One more rounding, of the sum itself.
        let error = error + f64::EPSILON * distance;
        Self { value: distance, low: (distance - error).max(0.0), high: distance + error }
    }

    /// Of the smaller of two distances.
    pub fn min(self, other: Self) -> Self {
        Self {
            value: self.value.min(other.value),
            low: self.low.min(other.low),
            high: self.high.min(other.high),
        }
    }

    /// Of the hypotenuse over two distances.
    pub fn hypot(self, other: Self) -> Self {
        Self {
            value: self.value.hypot(other.value),
            low: self.low.hypot(other.low) * (1.0 - FEW_ROUNDINGS),
            high: self.high.hypot(other.high) * (1.0 + FEW_ROUNDINGS),
        }
    }
}

/// What distances to a plane need.
pub struct FloatPlane {
    normal: DVec3,
    offset: f64,
    /// One over the normal's squared length.
    inverse_square: f64,
    /// One over the normal's length.
    inverse: f64,
}

/// A bound on the relative error of a few operations in a row, with room to
/// spare: the longest such row here has ten.
const FEW_ROUNDINGS: f64 = 16.0 * f64::EPSILON;

impl FloatPlane {
    pub fn new(plane: &Plane) -> Self {
        let square = plane.normal.length_squared();
        Self {
            normal: plane.normal,
            offset: plane.offset,
            inverse_square: 1.0 / square,
            inverse: 1.0 / square.sqrt(),
        }
    }

    /// `normal · point − offset`, and a bound on its error.
    fn height(&self, point: DVec3) -> (f64, f64) {
        let terms = self.normal * point;
        let height = terms.element_sum() - self.offset;
        let size = terms.abs().element_sum() + self.offset.abs();
        (height, 0.5 * FEW_ROUNDINGS * size + 4.0 * f64::MIN_POSITIVE)
    }

    /// The distance of a point.
    pub fn distance(&self, point: DVec3) -> Range {
        let (height, error) = self.height(point);
        let distance = height.abs() * self.inverse;
        Range::around(distance, error * self.inverse + FEW_ROUNDINGS * distance)
    }

    /// The foot of a point, and a bound on the error of its coordinates and of
    /// its place.
    pub fn foot(&self, point: DVec3) -> (DVec3, f64) {
        let (height, error) = self.height(point);
        let foot = point - height * self.inverse_square * self.normal;
        let moved = height.abs() * self.inverse;
        let off = error * self.inverse * (1.0 + FEW_ROUNDINGS);
        (foot, 2.0 * off + FEW_ROUNDINGS * (moved + point.abs().max_element()))
    }
}
