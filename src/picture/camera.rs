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

/// The most that half the frame's width and height may be over its distance: a
/// view angle of 28° from bottom to top, about that of a portrait lens, and no
/// wider one than 41° in a panorama.
const HALF_SLOPES: Vec2 = Vec2::new(0.375, 0.25);

impl Camera {
    /// The camera of a rotation to its space, so close that `points` just fit
    /// into the frame.
    pub fn fit(rotation: Mat3, points: &[Vec3], frame: Frame) -> Self {
        let size = (frame.max - frame.min).max(Vec2::ONE);
        let focal = (size / (2.0 * HALF_SLOPES)).max_element();
        let slope = size / (2.0 * focal);

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

    /// The direction towards the viewer, in the scene's space.
    pub fn towards(&self) -> Vec3 {
        self.rotation.row(2)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::section::Sections;
    use crate::sides::Sides;

    const FRAME: Frame = Frame { min: Vec2::new(100.0, 50.0), max: Vec2::new(500.0, 350.0) };

    /// Seen from a direction with z up.
    fn facing(direction: Vec3) -> Mat3 {
        Sides::of(&Sections::default()).rotation(direction)
    }

    #[test]
    fn a_fitted_camera_shows_every_point_and_touches_the_frame() {
        let corners: Vec<Vec3> = (0..8)
            .map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32 * 3.0))
            .collect();
        let camera = Camera::fit(facing(Vec3::new(1.0, -2.0, 0.7)), &corners, FRAME);
        let pixels: Vec<Vec2> =
            corners.iter().map(|&corner| camera.pixel(camera.place(corner))).collect();
        let low = pixels.iter().fold(Vec2::INFINITY, |low, &pixel| low.min(pixel));
        let high = pixels.iter().fold(Vec2::NEG_INFINITY, |high, &pixel| high.max(pixel));
        assert!(low.cmpge(FRAME.min - 0.1).all() && high.cmple(FRAME.max + 0.1).all());
        // The box is tall: it touches the frame above and below.
        assert!(low.y - FRAME.min.y < 0.5 && FRAME.max.y - high.y < 0.5, "{low} {high}");
    }

    #[test]
    fn panoramas_and_columns_show_every_point_without_a_wide_angle() {
        let corners = [Vec3::ZERO, Vec3::X * 9.0, Vec3::Y, Vec3::Z, Vec3::new(9.0, 1.0, 1.0)];
        for size in [Vec2::new(3000.0, 200.0), Vec2::new(200.0, 3000.0)] {
            let frame = Frame { min: Vec2::ZERO, max: size };
            let camera = Camera::fit(facing(Vec3::NEG_Y), &corners, frame);
            for pixel in corners.map(|corner| camera.pixel(camera.place(corner))) {
                assert!(pixel.cmpge(-Vec2::ONE).all() && pixel.cmple(size + 1.0).all(), "{pixel}");
            }
            assert!((size / (2.0 * camera.focal)).cmple(HALF_SLOPES + 1e-6).all(), "{size}");
        }
    }

    #[test]
    fn up_is_up_and_right_is_right() {
        let camera = Camera::fit(facing(Vec3::NEG_Y), &[Vec3::ZERO, Vec3::ONE], FRAME);
        let at = |point| camera.pixel(camera.place(point));
        assert!(at(Vec3::Z).y < at(Vec3::ZERO).y, "z points up, so to smaller rows");
        assert!(at(Vec3::X).x > at(Vec3::ZERO).x, "seen from −y, x points right");
    }

    #[test]
    fn unproject_inverts_pixel() {
        let camera = Camera::fit(facing(Vec3::ONE), &[Vec3::ZERO, Vec3::ONE], FRAME);
        let place = camera.place(Vec3::new(0.3, 0.6, 0.1));
        let back = camera.unproject(camera.pixel(place), -place.z);
        assert!(back.distance(place) < 1e-4);
    }
}
