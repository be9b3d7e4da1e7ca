//! What the solids are made of: distances, negative inside.

use glam::{DVec2, DVec3};

/// To a ball around the origin.
pub fn ball(place: DVec3, radius: f64) -> f64 {
    place.length() - radius
}

/// To a box around the origin whose sides are twice `half`; exact.
pub fn block(place: DVec3, half: DVec3) -> f64 {
    let beyond = place.abs() - half;
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
}

/// To an endless cylinder along z through a point of the plane z = 0.
pub fn pillar(place: DVec3, center: [f64; 2], radius: f64) -> f64 {
    place.truncate().distance(DVec2::from(center)) - radius
}

/// To a ring about the z axis.
pub fn ring(place: DVec3, radius: f64, tube: f64) -> f64 {
    DVec2::new(place.truncate().length() - radius, place.z).length() - tube
}

/// The first without the second.
pub fn without(one: f64, other: f64) -> f64 {
    one.max(-other)
}

/// The union of two bodies with a fillet of about this size, which swells by a
/// quarter of that where both surfaces meet.
pub fn blend(one: f64, other: f64, fillet: f64) -> f64 {
    let overlap = (fillet - (one - other).abs()).max(0.0);
    one.min(other) - overlap * overlap / (4.0 * fillet)
}
