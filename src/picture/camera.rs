//! The way from space to pixels.

use glam::{Mat3, Vec2, Vec3};

use super::raster::ScreenPoint;

/// A rectangle of the picture, in pixels from its top left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Top left.
    pub min: Vec2,
    /// Bottom right.
    pub max: Vec2,
}

/// A perspective camera. Its space has x to the right, y up and z towards the
/// viewer; distances are measured along −z from the eye.
#[derive(Debug, Clone)]
pub struct Camera {
    /// From the scene's space to the camera's.
    pub rotation: Mat3,
    /// The eye, in the camera's space.
    pub eye: Vec3,
    /// The pixel that the eye looks at.
    pub center: Vec2,
    /// Pixels per unit of slope.
    pub focal: f32,
}

/// Half the frame's height over its distance: a view angle of 28°, about that
/// of a portrait lens.
const HALF_SLOPE: f32 = 0.25;

impl Camera {
    /// The camera that looks against `direction` (towards the viewer), with z
    /// up, so close that `points` just fit into the frame.
    pub fn fit(direction: Vec3, points: &[Vec3], frame: Frame) -> Self {
        let rotation = facing(direction);
        let size = (frame.max - frame.min).max(Vec2::ONE);
        let focal = size.y / (2.0 * HALF_SLOPE);
        let slope = Vec2::new(size.x / (2.0 * focal), HALF_SLOPE);

        // A point (x, y, z) is inside on the right when x − e.x ≤ s (e.z − z),
        // so e.x + s e.z ≥ max(x + s z); likewise on the other sides.
        let mut high = Vec2::splat(f32::NEG_INFINITY);
        let mut low = Vec2::splat(f32::NEG_INFINITY);
        let mut front = f32::NEG_INFINITY;
        for &point in points {
            let p = rotation * point;
            high = high.max(p.truncate() + slope * p.z);
            low = low.max(-p.truncate() + slope * p.z);
            front = front.max(p.z);
        }
        if points.is_empty() {
            (high, low, front) = (Vec2::ONE, Vec2::ONE, 0.0);
        }
        let back = ((high + low) / (2.0 * slope)).max_element();
        let distance = (back - front).max(f32::MIN_POSITIVE);
        let eye = ((high - low) / 2.0).extend(front + distance * 1.000_1);
        Self { rotation, eye, center: (frame.min + frame.max) / 2.0, focal }
    }

    /// The same view in a picture of another size.
    pub fn scaled(&self, scale: f32) -> Self {
        Self { center: self.center * scale, focal: self.focal * scale, ..self.clone() }
    }

    /// A point of the scene's space in the camera's, the eye at the origin.
    pub fn place(&self, point: Vec3) -> Vec3 {
        self.rotation * point - self.eye
    }

    /// The pixel of a point in the camera's space.
    pub fn pixel(&self, place: Vec3) -> Vec2 {
        let scale = self.focal / -place.z;
        self.center + Vec2::new(place.x, -place.y) * scale
    }

    /// A point in the camera's space on a lattice of `samples` per pixel side.
    pub fn screen(&self, place: Vec3, samples: f32) -> ScreenPoint {
        ScreenPoint::new(self.pixel(place) * samples, 1.0 / -place.z)
    }

    /// The point in the camera's space that is seen at a pixel at a distance.
    pub fn unproject(&self, pixel: Vec2, distance: f32) -> Vec3 {
        let slope = (pixel - self.center) / self.focal;
        Vec3::new(slope.x, -slope.y, -1.0) * distance
    }
}

/// The rotation that takes `direction` to +z, and z up as far as it goes.
fn facing(direction: Vec3) -> Mat3 {
    let back = direction.normalize_or(Vec3::Y);
    let right = Vec3::Z.cross(back).normalize_or(Vec3::X);
    let up = back.cross(right);
    Mat3::from_cols(right, up, back).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Frame = Frame { min: Vec2::new(100.0, 50.0), max: Vec2::new(500.0, 350.0) };

    #[test]
    fn a_fitted_camera_shows_every_point_and_touches_the_frame() {
        let corners: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32 * 3.0))
            .collect();
        let camera = Camera::fit(Vec3::new(1.0, -2.0, 0.7), &corners, FRAME);
        let pixels: Vec<Vec2> =
            corners.iter().map(|&corner| camera.pixel(camera.place(corner))).collect();
        let low = pixels.iter().fold(Vec2::INFINITY, |low, &pixel| low.min(pixel));
        let high = pixels.iter().fold(Vec2::NEG_INFINITY, |high, &pixel| high.max(pixel));
        assert!(low.cmpge(FRAME.min - 0.1).all() && high.cmple(FRAME.max + 0.1).all());
        // The box is tall: it touches the frame above and below.
        assert!(low.y - FRAME.min.y < 0.5 && FRAME.max.y - high.y < 0.5, "{low} {high}");
    }

    #[test]
    fn up_is_up_and_right_is_right() {
        let camera = Camera::fit(Vec3::NEG_Y, &[Vec3::ZERO, Vec3::ONE], FRAME);
        let at = |point| camera.pixel(camera.place(point));
        assert!(at(Vec3::Z).y < at(Vec3::ZERO).y, "z points up, so to smaller rows");
        assert!(at(Vec3::X).x > at(Vec3::ZERO).x, "seen from −y, x points right");
    }

    #[test]
    fn unproject_inverts_pixel() {
        let camera = Camera::fit(Vec3::new(1.0, 1.0, 1.0), &[Vec3::ZERO, Vec3::ONE], FRAME);
        let place = camera.place(Vec3::new(0.3, 0.6, 0.1));
        let back = camera.unproject(camera.pixel(place), -place.z);
        assert!(back.distance(place) < 1e-4);
    }
}
