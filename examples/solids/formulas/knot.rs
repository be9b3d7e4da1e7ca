//! A tube around a torus knot.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use transect::plane::Bounds;

use super::{Solid, Truth};

/// Turns about the axis, and about the torus's own circle.
const TURNS: [u32; 2] = [2, 5];
/// Radii of the torus's circle, of the torus, and of the tube.
const RADII: [f64; 3] = [100.0, 42.0, 15.0];
/// Steps of Newton's method from the torus's longitude to the nearest point:
/// enough for 1e-4 of the tube's radius near its surface.
const STEPS: u32 = 4;

pub fn knot() -> Solid {
    let [circle, torus, tube] = RADII;
    let half = DVec3::new(circle + torus + tube, circle + torus + tube, torus + tube);
    Solid {
        name: "knot",
        bounds: Bounds { min: -half, max: half },
        // A tube that nowhere touches itself has its disc's area times its
        // axis's length.
        truth: Truth {
            components: 1,
            cavities: 0,
            genus: 1,
            volume: Some(PI * tube * tube * length()),
        },
        distance: Box::new(|place| axis_distance(place) - RADII[2]),
    }
}

/// The axis at an angle, and its first two derivatives.
pub fn axis(angle: f64) -> [DVec3; 3] {
    let [p, q] = TURNS.map(f64::from);
    let ((sin, cos), (up, out)) = ((p * angle).sin_cos(), (q * angle).sin_cos());
    let [circle, torus, _] = RADII;
    let [outward, onward] = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0)];
    let radius = [circle + torus * out, -q * torus * up, -q * q * torus * out];
    let height = [torus * up, q * torus * out, -q * q * torus * up];
    [
        radius[0] * outward + height[0] * DVec3::Z,
        radius[1] * outward + p * radius[0] * onward + height[1] * DVec3::Z,
        (radius[2] - p * p * radius[0]) * outward
            + 2.0 * p * radius[1] * onward
            + height[2] * DVec3::Z,
    ]
}

/// The distance to the axis, from each of its strands at the place's longitude.
fn axis_distance(place: DVec3) -> f64 {
    let longitude = place.y.atan2(place.x);
    let [turns, _] = TURNS;
    (0..turns)
        .map(|strand| (longitude + TAU * f64::from(strand)) / f64::from(turns))
        .map(|start| strand_distance(place, start))
        .fold(f64::INFINITY, f64::min)
}

/// The least distance that Newton's method finds from an angle on.
fn strand_distance(place: DVec3, start: f64) -> f64 {
    let mut angle = start;
    for _ in 0..STEPS {
        let [point, slope, bend] = axis(angle);
        let away = point - place;
        // Half the second derivative of the squared distance; where it is small
        // a step would lead far off.
        let curvature = (slope.length_squared() + away.dot(bend)).max(0.3 * slope.length_squared());
        angle -= away.dot(slope) / curvature;
    }
    axis(angle)[0].distance(place)
}

/// The axis's length: the trapezoidal rule, which for periodic functions
/// converges faster than any power.
fn length() -> f64 {
    const STEPS: u32 = 1000;
    let speed = |step: u32| axis(TAU * f64::from(step) / f64::from(STEPS))[1].length();
    TAU / f64::from(STEPS) * (0..STEPS).map(speed).sum::<f64>()
}
