//! The bones of a forearm and a hand, side by side, in millimetres: two in the
//! forearm, five in the palm, fourteen in the fingers. None touches another.

use glam::DVec3;

use super::limbs::{Limb, blended, bounds};
use super::{Solid, Truth};

/// Thickness of a bone's ends over that of its middle.
const HEADS: f64 = 1.45;
/// Space between two bones of a finger.
const JOINT: f64 = 4.0;

/// Where a finger's first bone begins, in the palm, and where it points to; the
/// lengths of its bones, and the radius of the first one's middle.
type Finger = ([f64; 3], [f64; 3], &'static [f64], f64);

const FINGERS: [Finger; 5] = [
    ([-36.0, -10.0, 6.0], [-0.75, -0.35, 1.0], &[40.0, 28.0, 20.0], 5.0),
    ([-22.0, 0.0, 10.0], [-0.16, 0.0, 1.0], &[62.0, 38.0, 22.0, 16.0], 4.6),
    ([-4.5, 2.0, 12.0], [-0.02, 0.04, 1.0], &[60.0, 42.0, 27.0, 17.0], 4.6),
    ([12.0, 1.0, 10.0], [0.11, 0.0, 1.0], &[54.0, 39.0, 25.0, 17.0], 4.2),
    ([27.5, -3.0, 6.0], [0.26, -0.06, 1.0], &[50.0, 31.0, 18.0, 15.0], 3.9),
];

pub fn bones() -> Solid {
    let mut bones = vec![
        bone([-10.0, 2.0, -150.0].into(), [-14.0, 0.0, -12.0].into(), 6.5, DVec3::X * -5.0),
        bone([14.0, 4.0, -160.0].into(), [16.0, 0.0, -12.0].into(), 5.5, DVec3::X * 3.0),
    ];
    FINGERS.iter().for_each(|finger| bones.extend(finger_bones(finger)));
    Solid {
        name: "bones",
        bounds: bounds(bones.as_flattened()),
        truth: Truth { components: bones.len(), cavities: 0, genus: 0, volume: None },
        distance: Box::new(move |place| {
            bones.iter().map(|bone| blended(bone, place)).fold(f64::INFINITY, f64::min)
        }),
    }
}

/// One after the other, thinner and thinner, bent a little towards the palm.
fn finger_bones(&(start, direction, lengths, radius): &Finger) -> Vec<[Limb; 2]> {
    let (mut from, mut along) = (DVec3::from(start), DVec3::from(direction).normalize());
    let mut radius = radius;
    let mut bones = Vec::new();
    for &length in lengths {
        let to = from + length * along;
        bones.push(bone(from, to, radius, DVec3::Y * 0.04 * length));
        let end = HEADS * radius;
        radius *= 0.86;
        along = (along - 0.14 * DVec3::Y).normalize();
        from = to + (end + JOINT + HEADS * radius) * along;
    }
    bones
}

/// Two cones that meet in the middle, where it is thinnest, off the straight line
/// by `bow`.
fn bone(from: DVec3, to: DVec3, radius: f64, bow: DVec3) -> [Limb; 2] {
    let middle = from.midpoint(to) + bow;
    let (end, fillet) = (HEADS * radius, 0.5 * radius);
    [
        Limb { ends: [from, middle], radii: [end, radius], fillet },
        Limb { ends: [middle, to], radii: [radius, end], fillet },
    ]
}
