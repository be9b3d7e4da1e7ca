//! A tree of vessels: a trunk that branches five times.

use glam::DVec3;

use super::limbs::{Limb, blended, bounds};
use super::{Solid, Truth};

/// How often it branches, from the trunk to a twig.
const BRANCHINGS: u32 = 5;
/// The trunk's length and radius, in millimetres.
const TRUNK: [f64; 2] = [58.0, 8.0];
/// What becomes of these at every branching. A twig's radius is
/// 8 · 0.64⁵ = 0.86 mm, so its diameter about two of the 256 parts of the box's
/// longest side.
const SHRINK: [f64; 2] = [0.8, 0.64];
/// How far the two branches lean to either side, as slopes: never alike.
const LEANS: [f64; 2] = [0.55, -0.8];
/// Fillets are this part of a branch's radius.
const FILLET: f64 = 0.6;

pub fn vessel() -> Solid {
    let mut limbs = Vec::new();
    let [length, radius] = TRUNK;
    let trunk = Shoot { from: DVec3::ZERO, along: DVec3::Z, side: DVec3::X, length, radius };
    grow(&trunk, BRANCHINGS, &mut limbs);
    Solid {
        name: "vessel",
        bounds: bounds(&limbs),
        truth: Truth { components: 1, cavities: 0, genus: 0, volume: None },
        distance: Box::new(move |place| blended(&limbs, place)),
    }
}

/// A limb that is to grow.
struct Shoot {
    from: DVec3,
    along: DVec3,
    /// Where its branches lean to, normal to `along`.
    side: DVec3,
    length: f64,
    radius: f64,
}

/// The shoot and all its branches; each pair of them lies across the one that it
/// springs from.
fn grow(shoot: &Shoot, branchings: u32, limbs: &mut Vec<Limb>) {
    let to = shoot.from + shoot.length * shoot.along;
    let [length, radius] = [shoot.length * SHRINK[0], shoot.radius * SHRINK[1]];
    let end = if branchings > 0 { radius.midpoint(shoot.radius) } else { shoot.radius };
    limbs.push(Limb {
        ends: [shoot.from, to],
        radii: [shoot.radius, end],
        fillet: FILLET * shoot.radius,
    });
    if branchings == 0 {
        return;
    }
    let across = shoot.along.cross(shoot.side);
    for lean in LEANS {
        let along = (shoot.along + lean * shoot.side).normalize();
        // A quarter turn about the new axis, and a little more.
        let side = (across + 0.3 * lean * along.cross(across)).normalize();
        grow(&Shoot { from: to, along, side, length, radius }, branchings - 1, limbs);
    }
}
