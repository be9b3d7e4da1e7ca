//! Shells in a shell, in millimetres: a hollow box with round edges holds two
//! hollow balls, and one of these a ring.

use std::f64::consts::PI;

use glam::DVec3;

use transect::plane::Bounds;

use super::pieces::{ball, block, ring, without};
use super::{Solid, Truth};

/// Half the sides of the box that is rounded off, and the distances from it that
/// its wall has outside and inside.
const BOX: (DVec3, [f64; 2]) = (DVec3::new(50.0, 38.0, 30.0), [10.0, 2.0]);
/// The hollow balls' middles, and their radii outside and inside.
const BALLS: [([f64; 3], [f64; 2]); 2] =
    [([-19.0, 6.0, 1.0], [26.0, 20.0]), ([28.0, -3.0, -4.0], [18.0, 13.0])];
/// In the first ball: the radius of its circle, and of its tube.
const RING: [f64; 2] = [11.0, 4.0];

pub fn shells() -> Solid {
    let half = BOX.0 + BOX.1[0];
    Solid {
        name: "shells",
        bounds: Bounds { min: -half, max: half },
        // Two surfaces for each of the three walls, and the ring.
        truth: Truth { components: 7, cavities: 3, genus: 1, volume: Some(volume()) },
        distance: Box::new(distance),
    }
}

fn distance(place: DVec3) -> f64 {
    let from_box = block(place, BOX.0);
    let wall = without(from_box - BOX.1[0], from_box - BOX.1[1]);
    let mut solid = wall;
    for (middle, [outer, inner]) in BALLS {
        let place = place - DVec3::from(middle);
        solid = solid.min(without(ball(place, outer), ball(place, inner)));
    }
    // It stands upright: its axis is y.
    let within = place - DVec3::from(BALLS[0].0);
    solid.min(ring(DVec3::new(within.x, within.z, within.y), RING[0], RING[1]))
}

fn volume() -> f64 {
    let ball = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
    let balls: f64 = BALLS.iter().map(|(_, [outer, inner])| ball(*outer) - ball(*inner)).sum();
    let ring = 2.0 * PI * PI * RING[0] * RING[1] * RING[1];
    rounded_box(BOX.1[0]) - rounded_box(BOX.1[1]) + balls + ring
}

/// All that is no farther than a radius from a box: the box, a slab on each face,
/// a quarter of a cylinder along each edge, an eighth of a ball at each corner.
fn rounded_box(radius: f64) -> f64 {
    let half = BOX.0;
    let faces = 8.0 * (half.x * half.y + half.y * half.z + half.z * half.x);
    let edges = 8.0 * half.element_sum();
    8.0 * half.element_product()
        + faces * radius
        + edges * PI * radius * radius / 4.0
        + 4.0 / 3.0 * PI * radius.powi(3)
}
