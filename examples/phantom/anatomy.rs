//! The phantom: a torso's organs as implicit functions, in millimetres. x
//! points to the patient's left, y to the back, z to the head (LPS).
//!
//! Only sums, products, quotients and square roots occur, which every machine
//! rounds alike: the file comes out the same everywhere.

use glam::DVec3;

use transect::label::{Label, Material};

use crate::bodies::{blend, ellipsoid, rod};

/// Number, name and colour, and a function that is negative inside.
type Organ = (u32, &'static str, [u8; 3], fn(DVec3) -> f64);

/// The organs in the order of precedence: where two overlap, the earlier one
/// is there. So neighbours share their border exactly.
const ORGANS: [Organ; 7] = [
    (1, "vessels", [0xc8, 0x4b, 0x4b], vessels),
    (2, "spine", [0xe6, 0xd8, 0xb4], spine),
    (3, "liver", [0xa8, 0x60, 0x50], liver),
    (4, "gallbladder", [0x6f, 0xa0, 0x5a], gallbladder),
    (5, "kidneys", [0xd0, 0x86, 0x6a], kidneys),
    (6, "stomach", [0xdf, 0xa6, 0xa0], stomach),
    (7, "body", [0xb8, 0xc4, 0xd8], body),
];

/// Names and colours.
pub fn materials() -> Vec<Material> {
    ORGANS.iter().map(|&(id, name, color, _)| Material { id, name: name.into(), color }).collect()
}

/// What is at a place.
pub fn label_at(place: DVec3) -> Label {
    ORGANS
        .iter()
        .find(|(_, _, _, inside)| inside(place) < 0.0)
        .map_or(Label::OUTSIDE, |&(id, ..)| Label(id))
}

/// A trunk that forks below, with a branch that runs into the liver.
fn vessels(place: DVec3) -> f64 {
    const FORK: [f64; 3] = [6.0, 26.0, -28.0];
    let trunk = rod(place, [10.0, 26.0, 84.0], FORK, 11.5);
    let left = rod(place, FORK, [36.0, 16.0, -84.0], 9.5);
    let right = rod(place, FORK, [-28.0, 16.0, -84.0], 9.5);
    let stem = rod(place, [8.0, 26.0, 34.0], [-16.0, 2.0, 34.0], 8.0);
    let twig = rod(place, [-16.0, 2.0, 34.0], [-58.0, -14.0, 44.0], 8.0);
    let legs = blend(blend(trunk, left, 6.0), right, 6.0);
    blend(legs, blend(stem, twig, 4.0), 5.0)
}

/// A column with a canal behind it that goes all the way through.
fn spine(place: DVec3) -> f64 {
    let turned = |x: f64, y: f64| ((place.x - x).powi(2) + (place.y - y).powi(2)).sqrt();
    let column = turned(0.0, 58.0) - 21.0;
    let arch = turned(0.0, 84.0) - 22.0;
    let canal = turned(0.0, 85.0) - 10.0;
    let ends = place.z.abs() - 70.0;
    blend(column, arch, 8.0).max(-canal).max(ends)
}

fn liver(place: DVec3) -> f64 {
    let right = ellipsoid(place, [-54.0, -10.0, 30.0], [50.0, 54.0, 48.0]);
    let left = ellipsoid(place, [-2.0, -44.0, 40.0], [52.0, 28.0, 26.0]);
    blend(right, left, 18.0)
}

/// Leans against the liver from below.
fn gallbladder(place: DVec3) -> f64 {
    blend(
        ellipsoid(place, [-36.0, -48.0, -16.0], [14.0, 15.0, 20.0]),
        rod(place, [-32.0, -42.0, -6.0], [-24.0, -24.0, 8.0], 7.0),
        10.0,
    )
}

/// Two beans, open towards the middle; the right one touches the liver.
fn kidneys(place: DVec3) -> f64 {
    let left = ellipsoid(place, [62.0, 44.0, 6.0], [23.0, 20.0, 40.0]);
    let right = ellipsoid(place, [-58.0, 46.0, -14.0], [23.0, 20.0, 40.0]);
    let dents = ellipsoid(place, [40.0, 38.0, 6.0], [14.0, 14.0, 14.0]).min(ellipsoid(
        place,
        [-36.0, 40.0, -14.0],
        [14.0, 14.0, 14.0],
    ));
    left.min(right).max(-dents)
}

/// A bent bag on the left.
fn stomach(place: DVec3) -> f64 {
    let top = ellipsoid(place, [62.0, -8.0, 56.0], [30.0, 30.0, 30.0]);
    let middle = rod(place, [66.0, -20.0, 40.0], [54.0, -42.0, 0.0], 23.0);
    let end = rod(place, [54.0, -42.0, 0.0], [10.0, -46.0, -18.0], 15.0);
    blend(blend(top, middle, 12.0), end, 12.0)
}

fn body(place: DVec3) -> f64 {
    ellipsoid(place, [0.0, 8.0, 0.0], [128.0, 118.0, 118.0])
}
