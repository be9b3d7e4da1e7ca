//! Where the phantom is cut: three sweeps, every plane tilted its own way.

use glam::DVec3;

use transect::plane::Plane;

/// A sweep along an axis.
struct Sweep {
    name: &'static str,
    axis: DVec3,
    /// The directions that planes are tilted in.
    tilts: [DVec3; 2],
    /// Where the axis is crossed, in mm: the first place, the step, how many.
    first: f64,
    step: f64,
    count: u32,
}

const SWEEPS: [Sweep; 3] = [
    Sweep {
        name: "transverse",
        axis: DVec3::Z,
        tilts: [DVec3::X, DVec3::Y],
        first: -102.0,
        step: 12.0,
        count: 18,
    },
    Sweep {
        name: "sagittal",
        axis: DVec3::X,
        tilts: [DVec3::Y, DVec3::Z],
        first: -99.0,
        step: 22.0,
        count: 10,
    },
    Sweep {
        name: "coronal",
        axis: DVec3::Y,
        tilts: [DVec3::X, DVec3::Z],
        first: -67.0,
        step: 20.0,
        count: 9,
    },
];

/// How far planes are tilted at most, as a slope.
const TILT: f64 = 0.125;

/// The planes with their names.
pub fn planes() -> Vec<(String, Plane)> {
    SWEEPS.iter().flat_map(|sweep| (0..sweep.count).map(|number| cut(sweep, number))).collect()
}

fn cut(sweep: &Sweep, number: u32) -> (String, Plane) {
    let [first, second] = sweep.tilts.map(|tilt| tilt * TILT);
    let normal = sweep.axis + first * wobble(number * 5 + 1) + second * wobble(number * 3 + 4);
    let through = sweep.axis * (sweep.first + sweep.step * f64::from(number));
    (format!("{} {}", sweep.name, number + 1), Plane { normal, offset: normal.dot(through) })
}

/// A triangle wave between −1 and 1 with period 32.
fn wobble(number: u32) -> f64 {
    let phase = f64::from(number % 32) / 32.0;
    4.0 * (phase - 0.5).abs() - 1.0
}
