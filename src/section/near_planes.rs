//! Sections on nearly one plane, each with structures that the other does not draw: somebody
//! traced them one by one, and neither means to say that the other's are not there. And frames of
//! one plane whose normals are rounded: what a probe sees before and behind it.

use glam::DVec3;

use super::draft::{Draft, snapping};
use super::overlay::Overlay;
use super::sections::{merge, warn};
use super::{Rules, Section, Sections, Warning};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Plane;

/// So many times nearer to one another than to any other parallel section are two views of one
/// plane.
const ALONE: f64 = 20.0;
/// The sine of the largest angle between planes that count as parallel.
const PARALLEL: f64 = 1e-2;
/// How warnings about such sections begin.
const NEARLY: &str = "lies nearly on the plane of section ";

impl Sections {
    /// Makes one section of those that lie on nearly one plane (up to the tolerance for points off
    /// their planes), where each draws labels that the other lacks and neither contradicts what
    /// the other draws. Where they do, a warning names them.
    ///
    /// # Errors
    /// For any of this when warnings are errors.
    pub(super) fn unite_drawings(&mut self, rules: &Rules) -> Result<()> {
        let Some(bounds) = self.bounds() else { return Ok(()) };
        let (diagonal, middle) = (bounds.diagonal(), bounds.middle());
        let mut first = 0;
        while first < self.sections.len() {
            let group = near(&self.sections, first, rules.tolerance * diagonal, middle);
            // From the last, so that the numbers of the others stay.
            for &other in group.iter().rev() {
                self.unite([first, other], diagonal, rules)?;
            }
            first += 1;
        }
        Ok(())
    }

    /// Merges sections that both know a part only of what is one plane but for rounding (the
    /// tolerance within which contours touch), if they agree: between two such planes there would
    /// be a cell of no thickness, known on one side and unknown on the other.
    ///
    /// # Errors
    /// Where warnings are errors.
    pub(super) fn unite_frames(&mut self, rules: &Rules) -> Result<()> {
        let Some(bounds) = self.bounds() else { return Ok(()) };
        let diagonal = bounds.diagonal();
        let tolerance = snapping(rules, diagonal);
        let mut first = 0;
        while first < self.sections.len() {
            for other in (first + 1..self.sections.len()).rev() {
                let [known, new] = [first, other].map(|number| &self.sections[number]);
                if !is_one_plane([known, new], tolerance) {
                    continue;
                }
                // What disagrees may do so between two planes.
                let Ok(merged) = merge(known, new, diagonal, rules) else { continue };
                let what = format!(
                    "lies on the plane of section {} but for rounding, and agrees with it: merged",
                    known.name
                );
                let name = new.name.clone();
                self.left_out.push(Warning { section: name.clone(), what: what.clone() });
                self.sections[first] = merged;
                self.sections.remove(other);
                warn(self, &name, what, rules)?;
            }
            first += 1;
        }
        Ok(())
    }

    fn unite(&mut self, pair: [usize; 2], diagonal: f64, rules: &Rules) -> Result<()> {
        let [known, new] = pair.map(|section| &self.sections[section]);
        let (drawn, drawn_too) = (drawn(known), drawn(new));
        let mut draft = Draft::new(&known.name, known.plane, diagonal, rules)?;
        let overlay = Overlay::new(&mut draft, [known, &new.onto(known.plane)])?;
        // Outside says nothing of a label that is not drawn.
        let denies = |label: Label, drawn: &[Label], other: Label| {
            label != other
                && ![label, other].contains(&Label::UNKNOWN)
                && (label.is_material() || drawn.contains(&other))
        };
        let conflict = overlay.part(&draft, |[one, other]| match [one, other] {
            [Label::OUTSIDE, other] => denies(Label::OUTSIDE, &drawn, other),
            [one, Label::OUTSIDE] => denies(Label::OUTSIDE, &drawn_too, one),
            [one, other] => denies(one, &drawn, other),
        });
        let begin = format!("{NEARLY}{}", known.name);
        let name = new.name.clone();
        let Some((area, place)) = conflict else {
            let what = format!("{begin}, and each draws what the other lacks: read as one drawing");
            self.sections[pair[0]] = overlay.section(&draft, |[one, other]| match one {
                Label::UNKNOWN => other,
                Label::OUTSIDE if other.is_material() => other,
                one => one,
            });
            self.sections.remove(pair[1]);
            return warn(self, &name, what, rules);
        };
        let what = format!(
            "{begin}, and each draws labels that the other lacks, but they contradict each other (on \
             an area of {area:.3e}, most near {place}): draw all on both, or on one"
        );
        // Once is enough, also when files are read together.
        let is_known = |told: &Warning| told.section == name && told.what.starts_with(NEARLY);
        if self.warnings.iter().any(is_known) { Ok(()) } else { warn(self, &name, what, rules) }
    }
}

/// Whether both know a part only, and every vertex of either is as near to the other's plane.
fn is_one_plane([one, other]: [&Section; 2], tolerance: f64) -> bool {
    let is_on = |own: &Section, plane: &Plane| {
        let mut points = (0..own.vertices.len() as u32).map(|vertex| own.point(vertex));
        !own.vertices.is_empty() && points.all(|point| plane.distance(point).abs() <= tolerance)
    };
    let is_parallel =
        || one.plane.unit_normal().cross(other.plane.unit_normal()).length() <= PARALLEL;
    is_parallel()
        && is_on(one, &other.plane)
        && is_on(other, &one.plane)
        && one.is_partial()
        && other.is_partial()
}

/// The materials on a section.
fn drawn(section: &Section) -> Vec<Label> {
    section.labels().into_iter().filter(|label| label.is_material()).collect()
}

/// The later sections with all contours within a distance (in world units) of a section's plane,
/// if all others are much farther away than those, and each of them draws labels that any of the
/// others lacks. Planes are compared near `middle`.
fn near(sections: &[Section], first: usize, distance: f64, middle: DVec3) -> Vec<usize> {
    let plane = &sections[first].plane;
    let gap = |other: &Section| {
        let normal = other.plane.unit_normal();
        let is_parallel = normal.cross(plane.unit_normal()).length() <= PARALLEL;
        let foot = middle - other.plane.distance(middle) * normal;
        is_parallel.then(|| plane.distance(foot).abs())
    };
    let is_near = |other: &Section| {
        let mut points = (0..other.vertices.len() as u32).map(|vertex| other.point(vertex));
        points.all(|point| plane.distance(point).abs() <= distance)
    };
    let gaps: Vec<(usize, f64)> = (0..sections.len())
        .filter(|&other| other != first)
        .filter_map(|other| Some((other, gap(&sections[other])?)))
        .collect();
    let (near, far): (Vec<_>, Vec<_>) =
        gaps.into_iter().partition(|&(other, gap)| gap <= distance && is_near(&sections[other]));
    let widest = near.iter().fold(0.0, |widest: f64, &(_, gap)| widest.max(gap));
    let is_alone = far.iter().all(|&(_, gap)| gap >= ALONE * widest);
    // In a dense stack labels go on from one section to the next.
    let labels: Vec<Vec<Label>> = near
        .iter()
        .map(|&(other, _)| other)
        .chain([first])
        .map(|section| drawn(&sections[section]))
        .collect();
    let lacks = |one: &[Label], other: &[Label]| other.iter().any(|label| !one.contains(label));
    let each_lacks = labels
        .iter()
        .enumerate()
        .all(|(i, one)| labels[i + 1..].iter().all(|other| lacks(one, other) && lacks(other, one)));
    let later = near.into_iter().map(|(other, _)| other).filter(|&other| other > first);
    if is_alone && each_lacks { later.collect() } else { Vec::new() }
}
