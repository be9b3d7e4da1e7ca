//! Bodies of round limbs that taper.

use glam::DVec3;

use transect::plane::Bounds;

use super::pieces::blend;

/// Part of a cone with round ends.
#[derive(Debug, Clone, Copy)]
pub struct Limb {
    /// The middles of its ends.
    pub ends: [DVec3; 2],
    /// The radii there.
    pub radii: [f64; 2],
    /// How it is blended with the limbs before it.
    pub fillet: f64,
}

impl Limb {
    /// Between two places.
    pub fn new(ends: [[f64; 3]; 2], radii: [f64; 2], fillet: f64) -> Self {
        Self { ends: ends.map(DVec3::from), radii, fillet }
    }

    /// About the distance, negative inside: the radius is that of the nearest
    /// place of the axis.
    pub fn distance(&self, place: DVec3) -> f64 {
        let [from, to] = self.ends;
        let axis = to - from;
        let part = ((place - from).dot(axis) / axis.length_squared()).clamp(0.0, 1.0);
        let radius = self.radii[0] + part * (self.radii[1] - self.radii[0]);
        (place - from - part * axis).length() - radius
    }
}

/// Farther than any place from any limb, yet a number that can be subtracted.
const FAR: f64 = 1e9;

/// The distance to a chain or tree of limbs, each blended with those before it.
pub fn blended(limbs: &[Limb], place: DVec3) -> f64 {
    limbs.iter().fold(FAR, |body, limb| blend(body, limb.distance(place), limb.fillet))
}

/// A box around limbs and their fillets.
///
/// # Panics
/// Without any limb.
pub fn bounds(limbs: &[Limb]) -> Bounds {
    let corners = limbs.iter().flat_map(|limb| {
        [0, 1].into_iter().flat_map(|end| {
            let reach = limb.radii[end] + limb.fillet / 4.0;
            [limb.ends[end] - reach, limb.ends[end] + reach]
        })
    });
    Bounds::around(corners).expect("there are limbs")
}
