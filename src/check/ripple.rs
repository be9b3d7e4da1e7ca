//! Whether a surface ripples in step with the sections, as a string of beads
//! does.
//!
//! A surface *leans* against a section's plane by the angle between its normal
//! and that plane: 0° where it passes the plane at a right angle, 90° where it
//! runs along it. Sections cut a solid where they happen to, so a true surface
//! leans at them as it leans elsewhere. A reconstruction that is made to pass
//! every section at a right angle does not.

use std::collections::BTreeSet;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::label::Label;
use crate::mesh::Mesh;
use crate::plane::Plane;
use crate::section::Section;

/// How near to a section counts as at it: an eighth of the gap.
const NEAR: f64 = 0.125;
/// Gaps of fewer voxels are left out: what is at a section would be less than
/// two voxels thick, where the mesh's triangles say little.
const NARROW: f64 = 8.0;
/// So much of the surface must be at sections, and so much away from them, for
/// the figure to mean anything: as a share of the whole.
const ENOUGH: f64 = 0.02;
/// And it must be at so many sections: what two of them see does not repeat itself, and
/// a blob that bulges away from both looks the same.
const IN_STEP: usize = 3;

/// How a label's surface leans, in degrees: the mean over its area.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Ripple {
    /// In the eighths of the gaps between sections that are nearest to a
    /// section.
    pub at_sections: f64,
    /// In the rest of the gaps.
    pub between: f64,
}

impl Ripple {
    /// By how much more the surface leans between sections than at them, in
    /// degrees: about 0 for true shapes, and more for beads.
    pub fn angle(&self) -> f64 {
        self.between - self.at_sections
    }
}

/// The ripple of each label's surface. None where too little of it lies in
/// gaps that are wide enough, or at too few sections. `voxel` in world units.
pub fn ripples(
    mesh: &Mesh,
    sections: &[Section],
    labels: &[Label],
    voxel: f64,
) -> Vec<Option<Ripple>> {
    let planes: Vec<Plane> = sections.iter().map(|section| unit(section.plane())).collect();
    let mut leans = vec![Leans::default(); labels.len()];
    let measured: Vec<(f64, Option<Lean>)> = (0..mesh.triangles.len())
        .into_par_iter()
        .map(|triangle| lean(mesh.corners(triangle), &planes, NARROW * voxel))
        .collect();
    for ((area, lean), sides) in measured.into_iter().zip(&mesh.sides) {
        for side in sides {
            if let Ok(own) = labels.binary_search(side) {
                leans[own].add(area, lean);
            }
        }
    }
    leans.iter().map(Leans::ripple).collect()
}

fn unit(plane: &Plane) -> Plane {
    let length = plane.normal.length();
    Plane { normal: plane.normal / length, offset: plane.offset / length }
}

/// How a triangle leans against the plane of the nearest section.
#[derive(Debug, Clone, Copy)]
struct Lean {
    degrees: f64,
    /// The section that it is at.
    at_section: Option<usize>,
}

/// A triangle's area, and how it leans where it is between two planes that are
/// at least `narrow` apart there. Planes have normals of unit length.
fn lean([a, b, c]: [DVec3; 3], planes: &[Plane], narrow: f64) -> (f64, Option<Lean>) {
    let doubled = (b - a).cross(c - a);
    let (area, center) = (doubled.length() / 2.0, (a + b + c) / 3.0);
    let none = (area, None);
    if area == 0.0 {
        return none;
    }
    let Some(numbers) = nearest_two(center, planes) else { return none };
    let [nearest, second] = numbers.map(|number| &planes[number]);
    let [near, far] = [nearest, second].map(|plane| plane.normal.dot(center) - plane.offset);
    // Beyond the last of parallel sections there is no gap: both are behind.
    let same_side = near * far * nearest.normal.dot(second.normal) > 0.0;
    let gap = near.abs() + far.abs();
    if (same_side && is_parallel(nearest, second)) || gap < narrow {
        return none;
    }
    let sine = nearest.normal.dot(doubled).abs() / (2.0 * area);
    let degrees = sine.min(1.0).asin().to_degrees();
    (area, Some(Lean { degrees, at_section: (near.abs() < NEAR * gap).then_some(numbers[0]) }))
}

/// Which two planes are nearest to a point.
fn nearest_two(point: DVec3, planes: &[Plane]) -> Option<[usize; 2]> {
    let mut best = [(f64::INFINITY, None), (f64::INFINITY, None)];
    for (number, plane) in planes.iter().enumerate() {
        let distance = (plane.normal.dot(point) - plane.offset).abs();
        if distance < best[0].0 {
            best = [(distance, Some(number)), best[0]];
        } else if distance < best[1].0 {
            best[1] = (distance, Some(number));
        }
    }
    Some([best[0].1?, best[1].1?])
}

fn is_parallel(one: &Plane, other: &Plane) -> bool {
    one.normal.cross(other.normal).length() < 0.05
}

/// The area of a label's surface, and how it leans.
#[derive(Debug, Clone, Default)]
struct Leans {
    at_sections: Mean,
    between: Mean,
    whole: f64,
    /// The sections that it is at.
    sections: BTreeSet<usize>,
}

impl Leans {
    fn add(&mut self, area: f64, lean: Option<Lean>) {
        self.whole += area;
        let Some(Lean { degrees, at_section }) = lean else { return };
        match at_section {
            Some(section) => {
                self.at_sections.add(degrees, area);
                self.sections.insert(section);
            }
            None => self.between.add(degrees, area),
        }
    }

    fn ripple(&self) -> Option<Ripple> {
        if self.sections.len() < IN_STEP {
            return None;
        }
        let least = ENOUGH * self.whole;
        let at_sections = self.at_sections.value(least)?;
        Some(Ripple { at_sections, between: self.between.value(least)? })
    }
}

/// A mean over area.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    area: f64,
    sum: f64,
}

impl Mean {
    fn add(&mut self, value: f64, area: f64) {
        self.area += area;
        self.sum += value * area;
    }

    /// `None` over less area than `least`, and over none.
    fn value(&self, least: f64) -> Option<f64> {
        (self.area > 0.0 && self.area >= least).then(|| self.sum / self.area)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::check::shapes::section;
    use crate::mesh::shapes::{open_samples, solid};
    use crate::plane::Bounds;
    use crate::progress::Silent;

    fn planes(normal: DVec3, offsets: impl Iterator<Item = f64>) -> Vec<Section> {
        offsets.map(|offset| section(Plane { normal, offset }, &[], Label::OUTSIDE)).collect()
    }

    /// The ripple of r = 0.5 + a cos(k z) in [−1, 1]³, without its caps, between
    /// sections where r is largest, four a unit.
    fn corrugated(a: f64) -> Ripple {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let (voxels, k) = (150, 8.0 * PI);
        let voxel = 2.0 / f64::from(voxels);
        let inside = move |point: DVec3| {
            let distance = 0.5 + a * (k * point.z).cos() - point.truncate().length();
            vec![(distance / (3.0 * voxel)).clamp(-1.0, 1.0) as f32]
        };
        let samples = open_samples(bounds, voxels, inside);
        let mesh = crate::mesh::dual(&samples, &Silent).expect("a mesh").without_caps(bounds, 1e-9);
        let sections = planes(DVec3::Z, (-4..=4).map(|level| 0.25 * f64::from(level)));
        ripples(&mesh, &sections, &[Label(1)], voxel)[0].expect("wide gaps")
    }

    #[test]
    fn a_corrugated_cylinder_has_the_ripple_of_its_slope() {
        // The slope is −a k sin(k z), and as small as it is, its angle. At sections
        // k z is up to π/4 from a whole turn: the mean sine there is
        // (1 − cos π/4) / (π/4). In the rest, from π/4 to π, it is
        // (1 + cos π/4) / (3π/4). The area of a stretch is as its slope times its
        // radius, to some percent the same.
        let (a, k) = (0.01, 8.0 * PI);
        let angle = |sine: f64| (a * k * sine).to_degrees();
        let ripple = corrugated(a);
        let cos = (PI / 4.0).cos();
        let right = [angle((1.0 - cos) / (PI / 4.0)), angle((1.0 + cos) / (0.75 * PI))];
        assert!((ripple.at_sections - right[0]).abs() < 0.3, "{ripple:?}, not {right:?}");
        assert!((ripple.between - right[1]).abs() < 0.5, "{ripple:?}, not {right:?}");
        assert!((ripple.angle() - (right[1] - right[0])).abs() < 0.5);
    }

    #[test]
    fn a_smooth_cylinder_and_a_ball_do_not_ripple() {
        let cylinder = corrugated(0.0);
        assert!(cylinder.between < 0.3 && cylinder.angle().abs() < 0.3, "{cylinder:?}");
        // A ball leans by the angle of the sine z / r, of which all are alike often:
        // the mean over [0, 1] is π/2 − 1, or 32.7°. Sections at 0, .29, .58 and .88
        // of the radius see 0, 17.0, 35.7 and 61.1°, the last three twice: 32.5°.
        let voxel = 2.0 / 80.0;
        let ball = solid(81, 1.0, |point| 0.8 - point.length());
        let normal = DVec3::new(2.0, 1.0, -2.0);
        let sections = planes(normal, (-4..=4).map(|level| 0.7 * f64::from(level)));
        let found = ripples(&ball, &sections, &[Label(1), Label(2)], voxel);
        let ripple = found[0].expect("gaps of 9 voxels");
        assert!((ripple.between - 32.7).abs() < 1.0, "{ripple:?}");
        assert!((ripple.at_sections - 32.5).abs() < 1.0, "{ripple:?}");
        assert_eq!(found[1], None);
    }

    #[test]
    fn narrow_gaps_and_what_lies_beyond_all_sections_say_nothing() {
        let ball = solid(81, 1.0, |point| 0.8 - point.length());
        let of = |sections: &[Section], voxel| ripples(&ball, sections, &[Label(1)], voxel)[0];
        let wide = planes(DVec3::Z, (-4..=4).map(|level| 0.2 * f64::from(level)));
        assert!(of(&wide, 0.2 / 8.1).is_some());
        assert!(of(&wide, 0.2 / 7.9).is_none());
        // Only its upper end is beyond them.
        assert!(of(&planes(DVec3::Z, [0.9, 1.3].into_iter()), 0.01).is_none());
        assert!(of(&planes(DVec3::Z, [0.0].into_iter()), 0.01).is_none());
        // Two sections see no step, three do.
        let some = |offsets: &[f64]| of(&planes(DVec3::Z, offsets.iter().copied()), 0.01);
        assert!(some(&[-0.3, 0.3]).is_none());
        assert!(some(&[-0.3, 0.0, 0.3]).is_some());
    }
}
