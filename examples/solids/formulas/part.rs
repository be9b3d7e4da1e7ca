//! A machine's part with sharp edges, in millimetres: a plate with four bores and
//! a window, a bored boss on it, and a rib with an eye.

use std::f64::consts::PI;

use glam::DVec3;

use transect::plane::Bounds;

use super::pieces::{block, pillar, without};
use super::{Solid, Truth};

/// The plate's sides; it lies on z = 0, its middle over the origin.
const PLATE: DVec3 = DVec3::new(120.0, 80.0, 12.0);
/// Where the bores are, mirrored in x and y, and their radius.
const BORES: ([f64; 2], f64) = ([48.0, 30.0], 5.0);
/// The window's middle and half its sides.
const WINDOW: ([f64; 2], [f64; 2]) = ([15.0, 22.0], [15.0, 7.0]);
/// The boss's axis, its radius, the radius of its bore, and its height.
const BOSS: ([f64; 2], f64, f64, f64) = ([-20.0, 0.0], 18.0, 10.0, 36.0);
/// The rib's thickness, where it ends in x, and how much lower it is per step
/// away from the boss.
const RIB: (f64, f64, f64) = (6.0, 45.0, 22.0 / 47.0);
/// The eye's middle in x and z, and its radius.
const EYE: ([f64; 2], f64) = ([10.0, 19.0], 4.0);

pub fn part() -> Solid {
    let half = DVec3::new(PLATE.x / 2.0, PLATE.y / 2.0, 0.0);
    Solid {
        name: "part",
        bounds: Bounds { min: -half, max: half.with_z(BOSS.3) },
        // Four bores, the window, the boss's bore, and the eye.
        truth: Truth { components: 1, cavities: 0, genus: 7, volume: Some(volume()) },
        distance: Box::new(distance),
    }
}

fn distance(place: DVec3) -> f64 {
    let plate = block(place - DVec3::Z * PLATE.z / 2.0, PLATE / 2.0);
    let mirrored = DVec3::new(place.x.abs(), place.y.abs(), place.z);
    let plate = without(plate, pillar(mirrored, BORES.0, BORES.1));
    let (middle, [x, y]) = WINDOW;
    let window = (place.truncate() - glam::DVec2::from(middle)).abs() - glam::DVec2::new(x, y);
    let plate = without(plate, window.max_element());
    let (center, outer, inner, top) = BOSS;
    let boss = pillar(place, center, outer).max((place.z - top / 2.0).abs() - top / 2.0);
    without(plate.min(boss).min(rib(place)), pillar(place, center, inner))
}

/// It reaches into the boss, and down into the plate.
fn rib(place: DVec3) -> f64 {
    let (thickness, end, slope) = RIB;
    let above = place.z - PLATE.z - slope * (end - place.x);
    let sloping = above / (1.0 + slope * slope).sqrt();
    let sides = place.y.abs() - thickness / 2.0;
    // Within the boss, it ends with it.
    let ends = (BOSS.0[0] - place.x).max(place.z - BOSS.3);
    let rib = sloping.max(sides).max(ends).max(PLATE.z / 2.0 - place.z);
    let eye = DVec3::new(place.x, place.z, place.y);
    without(rib, pillar(eye, EYE.0, EYE.1))
}

fn volume() -> f64 {
    let square = |radius: f64| radius * radius;
    let (_, [x, y]) = WINDOW;
    let (_, outer, inner, top) = BOSS;
    let plate = PLATE.element_product() - PLATE.z * (4.0 * PI * square(BORES.1) + 4.0 * x * y);
    let boss = PI * square(outer) * (top - PLATE.z) - PI * square(inner) * top;
    plate + boss + rib_volume() - PI * square(EYE.1) * RIB.0
}

/// The rib between boss and plate. At y it begins √(R² − y²) beyond the boss's
/// axis, which is ℓ before its end, and is a triangle with the area
/// s (ℓ − √(R² − y²))² / 2 there, or s (ℓ² − 2ℓ√(R² − y²) + R² − y²) / 2.
fn rib_volume() -> f64 {
    let (thickness, end, slope) = RIB;
    let ([axis, _], radius, ..) = BOSS;
    let (length, half) = (end - axis, thickness / 2.0);
    let segment =
        half * (radius * radius - half * half).sqrt() + radius * radius * (half / radius).asin();
    let squares = length * length + radius * radius;
    slope * (half * squares - half.powi(3) / 3.0 - length * segment)
}
