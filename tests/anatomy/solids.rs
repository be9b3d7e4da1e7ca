//! Four made-up pieces of anatomy as implicit functions, in millimetres.
//!
//! As in the phantom only sums, products, quotients, square roots and floors occur, which every
//! machine rounds alike: the files come out the same everywhere.

use glam::DVec3;

use transect::label::{Label, Material};

use crate::bodies::{blend, ellipsoid, rod};

/// A solid of one or more labels.
pub struct Solid {
    /// Its files are named after it.
    pub name: &'static str,
    /// What its labels 1… are.
    pub labels: &'static [&'static str],
    /// What is at a place.
    pub label_at: fn(DVec3) -> Label,
}

/// All of them lie within this far of the origin along every axis.
pub const REACH: f64 = 80.0;

/// A vessel that bends and branches twice.
pub const VESSEL: Solid = Solid { name: "vessel", labels: &["vessel"], label_at: vessel };
/// A long bone with thick ends, hollow.
pub const BONE: Solid = Solid { name: "bone", labels: &["bone"], label_at: bone };
/// An organ with a tumour at its border and a hollow within.
pub const ORGAN: Solid = Solid { name: "organ", labels: &["tissue", "tumour"], label_at: organ };
/// Three thick strands laid across each other, which share borders.
pub const KNOT: Solid =
    Solid { name: "knot", labels: &["first", "second", "third"], label_at: knot };

pub const SOLIDS: [Solid; 4] = [VESSEL, BONE, ORGAN, KNOT];

impl Solid {
    /// Names and colours.
    pub fn materials(&self) -> Vec<Material> {
        const COLORS: [[u8; 3]; 3] = [[0xc8, 0x60, 0x50], [0xe0, 0xc0, 0x70], [0x60, 0x90, 0xc0]];
        let named = (1..).zip(self.labels.iter().zip(COLORS));
        named.map(|(id, (&name, color))| Material { id, name: name.into(), color }).collect()
    }

    /// The volume of every label, by counting the middles of cubes of this size.
    pub fn volumes(&self, step: f64) -> Vec<f64> {
        let steps = (2.0 * REACH / step) as u32;
        let place = |at: u32| (f64::from(at) + 0.5) * step - REACH;
        let mut counts = vec![0u64; self.labels.len()];
        for (x, y) in (0..steps).flat_map(|x| (0..steps).map(move |y| (place(x), place(y)))) {
            for z in (0..steps).map(place) {
                let Label(label) = (self.label_at)(DVec3::new(x, y, z));
                if label > 0 {
                    counts[label as usize - 1] += 1;
                }
            }
        }
        counts.iter().map(|&count| count as f64 * step.powi(3)).collect()
    }
}

/// A wave of parabolas with period 1, between −1 and 1.
pub fn wave(at: f64) -> f64 {
    let at = at - at.floor();
    if at < 0.5 { 16.0 * at * (0.5 - at) } else { -16.0 * (at - 0.5) * (1.0 - at) }
}

/// The place as it would be in a body without bumps.
pub fn without_bumps(place: DVec3, height: f64, phase: f64) -> DVec3 {
    let bump = |along: f64, across: f64| wave(along / 37.0 + phase) + wave(across / 23.0 - phase);
    place
        + 0.5
            * height
            * DVec3::new(bump(place.y, place.z), bump(place.z, place.x), bump(place.x, place.y))
}

/// Rods from point to point.
fn strand(place: DVec3, points: &[[f64; 3]], radius: f64) -> f64 {
    let rods = points.windows(2).map(|ends| rod(place, ends[0], ends[1], radius));
    rods.reduce(|one, other| blend(one, other, 6.0)).unwrap_or(f64::INFINITY)
}

/// The first that holds a place, by the label after it.
fn first(parts: &[(f64, u32)]) -> Label {
    parts.iter().find(|part| part.0 < 0.0).map_or(Label::OUTSIDE, |part| Label(part.1))
}

fn vessel(place: DVec3) -> Label {
    let place = without_bumps(place, 1.5, 0.1);
    const FORKS: [[f64; 3]; 2] = [[8.0, 12.0, -12.0], [11.0, -3.0, 16.0]];
    let trunk = [[-28.0, 0.0, -58.0], [-18.0, 11.0, -34.0], FORKS[0], FORKS[1]];
    let trunk =
        strand(place, &[&trunk[..], &[[0.0, -9.0, 40.0], [-4.0, 0.0, 60.0]]].concat(), 10.0);
    let one = strand(place, &[FORKS[0], [36.0, 21.0, 4.0], [58.0, 10.0, 34.0]], 7.5);
    let other = strand(place, &[FORKS[1], [-22.0, -22.0, 34.0], [-46.0, -16.0, 58.0]], 6.5);
    first(&[(blend(blend(trunk, one, 6.0), other, 6.0), 1)])
}

fn bone(place: DVec3) -> Label {
    let place = without_bumps(place, 1.0, 0.4);
    let shaft = strand(place, &[[-8.0, 0.0, -52.0], [2.0, 6.0, 0.0], [8.0, 0.0, 52.0]], 13.0);
    let head = ellipsoid(place, [-10.0, -3.0, -54.0], [23.0, 18.0, 15.0]);
    let knee = blend(
        ellipsoid(place, [-4.0, 0.0, 56.0], [17.0, 18.0, 14.0]),
        ellipsoid(place, [20.0, 2.0, 56.0], [15.0, 17.0, 13.0]),
        8.0,
    );
    let outer = blend(blend(shaft, head, 10.0), knee, 10.0);
    first(&[(outer + 4.5, 0), (outer, 1)])
}

fn organ(place: DVec3) -> Label {
    let place = without_bumps(place, 2.0, 0.7);
    let right = ellipsoid(place, [-16.0, 4.0, -4.0], [40.0, 44.0, 46.0]);
    let left = ellipsoid(place, [28.0, -18.0, 10.0], [34.0, 24.0, 24.0]);
    let hollow = rod(place, [-22.0, 10.0, -16.0], [-6.0, -8.0, 12.0], 11.0);
    let tumour = ellipsoid(place, [-40.0, 24.0, 18.0], [19.0, 20.0, 17.0]);
    first(&[(hollow, 0), (tumour, 2), (blend(right, left, 16.0), 1)])
}

fn knot(place: DVec3) -> Label {
    let place = without_bumps(place, 1.5, 0.2);
    let one = strand(place, &[[-48.0, -12.0, 2.0], [0.0, 14.0, -12.0], [48.0, -12.0, 8.0]], 16.0);
    let other = strand(place, &[[2.0, -50.0, -10.0], [-14.0, 0.0, 12.0], [8.0, 50.0, 0.0]], 15.0);
    let third = strand(place, &[[14.0, 0.0, -50.0], [16.0, -14.0, 4.0], [-14.0, 8.0, 50.0]], 14.0);
    first(&[(one, 1), (other, 2), (third, 3)])
}
