//! What is checked of every section while it is made: its plane, its points,
//! and how doubtful things are told.

use glam::{DVec2, DVec3};

use super::{Findings, Rules, Warning};
use crate::error::{Error, Remedy, Result};
use crate::plane::Plane;

/// Coordinates beyond this overflow when areas and moments are computed.
const LARGEST: f64 = 1e75;
/// How near vertices and edges are the same, relative to the diagonal, where the rules do not
/// say: files of seven digits round away more than that, and coincidences of doubles far less.
const SNAPPING: f64 = 1e-8;

/// A section in the making.
#[derive(Clone)]
pub(super) struct Draft<'a> {
    pub name: &'a str,
    pub plane: Plane,
    pub rules: &'a Rules,
    pub findings: Findings,
    /// How far off the plane a point may lie, in world units.
    tolerance: f64,
}

impl<'a> Draft<'a> {
    /// Refuses planes that are none.
    pub fn new(name: &'a str, plane: Plane, diagonal: f64, rules: &'a Rules) -> Result<Self> {
        let snapping = snapping(rules, diagonal);
        let findings = Findings { snapping, ..Findings::default() };
        let tolerance = rules.tolerance * diagonal;
        let draft = Self { name, plane, rules, findings, tolerance };
        let Plane { normal, offset } = plane;
        if !normal.is_finite() || !offset.is_finite() {
            return Err(draft.error(format!(
                "its plane is not finite (normal {normal}, offset {offset}): correct the plane"
            )));
        }
        if normal == DVec3::ZERO {
            return Err(draft.error("its plane has a zero normal: correct the plane"));
        }
        let length = normal.length_squared();
        if !(1.0 / LARGEST..=LARGEST).contains(&length) {
            return Err(draft.error(format!(
                "the length of its plane's normal {normal} is out of range: scale normal and offset"
            )));
        }
        Ok(draft)
    }

    /// An error of this section.
    pub fn error(&self, what: impl Into<String>) -> Error {
        Error::Section { section: self.name.to_owned(), what: what.into() }
    }

    /// Something doubtful was dealt with: a warning, or an error when strict.
    pub fn warn(&mut self, what: String) -> Result<()> {
        if self.rules.strict {
            return Err(self.error(what).avoidable(Remedy::NotStrict));
        }
        self.findings.warnings.push(Warning { section: self.name.to_owned(), what });
        Ok(())
    }

    /// None of what was drawn encloses anything.
    pub fn leave_all_out(&mut self) {
        self.findings.is_void = true;
        self.leave_out(
            "none of its contours encloses anything: the section is left out".to_owned(),
        );
    }

    /// Something is left out.
    pub fn leave_out(&mut self, what: String) {
        self.findings.left_out.push(Warning { section: self.name.to_owned(), what });
    }

    /// The kept coordinates of a point that must lie on the plane; `called`
    /// names it in errors.
    pub fn project(&mut self, point: DVec3, called: impl Fn() -> String) -> Result<DVec2> {
        if !(point.abs().max_element() <= LARGEST && point.is_finite()) {
            return Err(self.error(format!(
                "{} is {point}: coordinates must be finite and below {LARGEST:e}",
                called()
            )));
        }
        let distance = self.plane.distance(point).abs();
        if distance > self.tolerance + rounding(&self.plane, point) {
            return Err(self.error(format!(
                "{} at {point} is {distance:.6} off its plane, more than the tolerance of {:.6}: \
                 correct the point or the plane",
                called(),
                self.tolerance
            )));
        }
        self.findings.off_plane = self.findings.off_plane.max(distance);
        // Adding zero turns -0 into 0, so that equal coordinates are equal bits.
        Ok(self.plane.project(point) + 0.0)
    }

    /// A place on the plane, in space, for messages.
    pub fn place(&self, kept: DVec2) -> DVec3 {
        self.plane.lift(kept) + 0.0 // no -0
    }
}

/// How near vertices and edges are the same, in world units, in a drawing of this diagonal.
pub(super) fn snapping(rules: &Rules, diagonal: f64) -> f64 {
    rules.snapping.unwrap_or(SNAPPING * diagonal)
}

/// A bound on the rounding error of the distance of a point that is the nearest
/// double to one on the plane; far from the origin it can exceed any tolerance
/// that is relative to the diagonal.
fn rounding(plane: &Plane, point: DVec3) -> f64 {
    let terms = (plane.normal * point).abs().element_sum() + plane.offset.abs();
    8.0 * f64::EPSILON * terms / plane.normal.length()
}

/// How much larger areas are on the plane than in its kept coordinates.
pub(super) fn stretch(plane: &Plane) -> f64 {
    plane.normal.length() / plane.normal[plane.dropped_axis()].abs()
}
