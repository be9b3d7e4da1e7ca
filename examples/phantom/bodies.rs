//! What made-up anatomy is put together from.

use glam::DVec3;

/// Negative inside an ellipsoid; about a distance near its surface.
pub fn ellipsoid(place: DVec3, center: [f64; 3], radii: [f64; 3]) -> f64 {
    let radii = DVec3::from(radii);
    let scaled = (place - DVec3::from(center)) / radii;
    let (distance, slope) = (scaled.length(), (scaled / radii).length());
    if slope > 0.0 { distance * (distance - 1.0) / slope } else { -radii.min_element() }
}

/// The distance to a rod with round ends.
pub fn rod(place: DVec3, from: [f64; 3], to: [f64; 3], radius: f64) -> f64 {
    let (from, to) = (DVec3::from(from), DVec3::from(to));
    let axis = to - from;
    let part = ((place - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
    (place - from - part * axis).length() - radius
}

/// The union of two bodies with a fillet of about this size.
pub fn blend(one: f64, other: f64, fillet: f64) -> f64 {
    let overlap = (fillet - (one - other).abs()).max(0.0) / fillet;
    one.min(other) - overlap * overlap * fillet / 4.0
}
