//! A body with limbs that flow into each other, in centimetres: one arm hangs,
//! and the other one's hand rests on the hip, which makes a handle.

use glam::DVec3;

use super::limbs::{Limb, blended, bounds};
use super::pieces::blend;
use super::{Solid, Truth};

/// The trunk is so much broader than deep.
const FLATTENING: f64 = 1.45;
/// The fillet between trunk and limbs.
const FILLET: f64 = 7.0;

pub fn body() -> Solid {
    let (trunk, limbs) = (trunk(), limbs());
    let bounds = bounds(&[&trunk[..], &limbs].concat());
    Solid {
        name: "body",
        bounds: bounds.grown(FILLET / 4.0),
        truth: Truth { components: 1, cavities: 0, genus: 1, volume: None },
        distance: Box::new(move |place| {
            // Divided, so that it nowhere changes faster than a distance.
            let deep = DVec3::new(place.x, FLATTENING * place.y, place.z);
            blend(blended(&trunk, deep) / FLATTENING, blended(&limbs, place), FILLET)
        }),
    }
}

fn trunk() -> Vec<Limb> {
    vec![
        Limb::new([[0.0, 0.0, 96.0], [0.0, 0.0, 114.0]], [17.0, 14.0], 8.0),
        Limb::new([[0.0, 0.0, 114.0], [0.0, 0.0, 132.0]], [14.0, 18.5], 8.0),
    ]
}

fn limbs() -> Vec<Limb> {
    let mut limbs = vec![
        Limb::new([[0.0, 1.0, 140.0], [0.0, -1.0, 158.0]], [7.0, 5.5], 4.0),
        Limb::new([[0.0, -2.0, 163.0], [0.0, -1.0, 170.0]], [9.0, 9.5], 4.0),
        // The arm that hangs, and the one whose hand is on the hip.
        Limb::new([[-14.0, 0.0, 142.0], [-33.0, 2.0, 117.0]], [6.5, 4.8], 6.0),
        Limb::new([[-33.0, 2.0, 117.0], [-42.0, -8.0, 94.0]], [4.8, 3.4], 1.5),
        Limb::new([[-42.0, -8.0, 94.0], [-43.0, -11.0, 84.0]], [3.6, 3.2], 1.0),
        Limb::new([[14.0, 0.0, 142.0], [40.0, 5.0, 122.0]], [6.5, 4.8], 6.0),
        Limb::new([[40.0, 5.0, 122.0], [19.0, -2.0, 101.0]], [4.8, 3.6], 1.5),
    ];
    for side in [-1.0, 1.0] {
        let at = |x: f64, y: f64, z: f64| [side * x, y, z];
        limbs.extend([
            Limb::new([at(9.5, 0.0, 92.0), at(13.0, -2.0, 50.0)], [10.0, 6.2], 6.0),
            Limb::new([at(13.0, -2.0, 50.0), at(15.0, 3.0, 8.0)], [6.2, 4.0], 1.5),
            Limb::new([at(15.0, 4.0, 4.5), at(18.0, -15.0, 3.5)], [4.2, 3.2], 4.0),
        ]);
    }
    limbs
}
