//! Places on planes, as they are triangulated: the same whoever names them.

use glam::{DVec2, DVec3};

use crate::plane::{Bounds, Plane};

/// Binary digits of places on a plane, of the size of the box. Further ones depend on how a
/// place was computed, and what is triangulated must not.
const DIGITS: f64 = 40.0;

/// What places on planes in a box are multiples of, but for digits that say nothing.
pub(super) fn step(bounds: Bounds) -> f64 {
    (bounds.diagonal().log2().floor() - DIGITS).exp2().max(f64::MIN_POSITIVE)
}

/// The name of a point, which equal points of a plane have in common though their last
/// digits may differ.
pub(super) fn key(point: DVec3, step: f64) -> [u64; 3] {
    ((point / step).round() + 0.0).to_array().map(f64::to_bits)
}

/// The points that cut a segment into equal pieces of about `spacing` at most, its ends among
/// them: the same ones from either end.
pub(super) fn pieces([start, end]: [DVec3; 2], spacing: f64, step: f64) -> Vec<DVec3> {
    const MOST: f64 = 4096.0;
    let turned = key(start, step) > key(end, step);
    let [low, high] = if turned { [end, start] } else { [start, end] };
    // The spacing is positive and not absurdly small.
    let pieces = (low.distance(high) / spacing).ceil().clamp(1.0, MOST) as u32;
    let at = |piece: u32| match if turned { pieces - piece } else { piece } {
        0 => low,
        piece if piece == pieces => high,
        piece => low.lerp(high, f64::from(piece) / f64::from(pieces)),
    };
    (0..=pieces).map(at).collect()
}

/// A plane's frame, of which the triangulation depends: it follows from where
/// the plane lies in the box, not from what was drawn first.
pub(super) struct PlaneFrame {
    /// The foot of the box's middle, so that coordinates stay small.
    origin: DVec3,
    tangents: [DVec3; 2],
    /// Coordinates are multiples of this.
    step: f64,
}

impl PlaneFrame {
    pub fn new(plane: Plane, bounds: Bounds) -> Self {
        let (normal, middle) = (plane.unit_normal(), bounds.middle());
        Self {
            origin: middle - plane.distance(middle) * normal,
            tangents: plane.tangents(),
            step: step(bounds),
        }
    }

    pub fn flatten(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        let flat = DVec2::from_array(self.tangents.map(|tangent| tangent.dot(offset)));
        (flat / self.step).round() * self.step
    }

    pub fn lift(&self, flat: DVec2) -> DVec3 {
        self.origin + flat.x * self.tangents[0] + flat.y * self.tangents[1]
    }
}
