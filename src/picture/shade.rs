//! From a surface's normal and colour to light, in linear sRGB. Directions are
//! in the camera's space: x right, y up, z towards the viewer.

use glam::Vec3;

use crate::color::linear;

/// The main light: from the upper left, a little warm.
const KEY: (Vec3, Vec3) = (Vec3::new(-0.447, 0.600, 0.663), Vec3::new(0.66, 0.64, 0.60));
/// A weak cool one from the right, so that no side is dead.
const FILL: (Vec3, Vec3) = (Vec3::new(0.862, -0.020, 0.506), Vec3::new(0.13, 0.14, 0.16));
/// What comes from everywhere: from above and from below.
const SKY: Vec3 = Vec3::new(0.42, 0.43, 0.45);
const GROUND: Vec3 = Vec3::new(0.24, 0.22, 0.20);

/// The light from a dull, slightly glossy surface. `free` is the part of the
/// sky that it sees.
pub fn surface(albedo: Vec3, normal: Vec3, to_eye: Vec3, free: f32) -> Vec3 {
    let sky = GROUND.lerp(SKY, normal.y * 0.5 + 0.5) * free;
    // Light that occluders hold off dims the lamps too, but less.
    let open = 0.3 + 0.7 * free;
    let lamps = (lambert(normal, KEY) + lambert(normal, FILL)) * open;
    let rim = (1.0 - normal.dot(to_eye).max(0.0)).powi(4) * 0.05 * free;
    albedo * (sky + lamps) + Vec3::splat(gloss(normal, to_eye, 40.0) * 0.07 * open + rim)
}

/// The light from glass, and how much of what lies behind it hides.
pub fn glass(albedo: Vec3, normal: Vec3, to_eye: Vec3) -> (Vec3, f32) {
    let facing = normal.dot(to_eye).abs().min(1.0);
    let edge = (1.0 - facing).powi(2);
    let light = albedo * (GROUND.lerp(SKY, normal.y * 0.5 + 0.5) + lambert(normal, KEY));
    let highlight = gloss(normal, to_eye, 60.0) * 0.08;
    (light + Vec3::splat(highlight), (0.14 + 0.55 * edge + highlight).min(1.0))
}

/// The colour of a contour on a surface of this colour.
pub fn stroke(albedo: Vec3) -> Vec3 {
    albedo * 0.10
}

/// The colour of the border of what is unknown: a light neutral grey.
pub fn unknown_stroke() -> Vec3 {
    linear([188, 188, 190])
}

/// How much a contour on glass hides.
pub const GLASS_STROKE: f32 = 0.30;

/// The background at a height from 0 (top) to 1 (bottom): warm paper.
pub fn background(height: f32) -> Vec3 {
    linear([253, 252, 250]).lerp(linear([231, 227, 220]), height * height)
}

fn lambert(normal: Vec3, (direction, light): (Vec3, Vec3)) -> Vec3 {
    light * normal.dot(direction).max(0.0)
}

fn gloss(normal: Vec3, to_eye: Vec3, exponent: f32) -> f32 {
    let half = (KEY.0 + to_eye).normalize_or(Vec3::Z);
    normal.dot(half).max(0.0).powf(exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lamps_have_directions_of_length_one() {
        for (direction, _) in [KEY, FILL] {
            assert!((direction.length() - 1.0).abs() < 1e-3);
        }
    }
}
