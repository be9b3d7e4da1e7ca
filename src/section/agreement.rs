//! Where sections say different things along their common lines.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::{Here, Section, Sections};
use crate::label::Label;

/// Shorter than this, relative to the diagonal, is rounding: files give seven
/// digits after the point, of vertices that lie near their planes.
const NOISE: f64 = 1e-8;

/// How two sections differ along their common line, as drawn and up to rounding. What of it
/// the exact reconstruction has to bridge is a [`Contradiction`](crate::skeleton::Contradiction).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Disagreement {
    /// The names of the two sections.
    pub sections: [String; 2],
    /// The length on which both know and say different things, in world units.
    pub length: f64,
    /// The length on which either says that there is a material.
    pub occupied: f64,
    /// The middle of the longest piece of disagreement.
    pub worst: [f64; 3],
    /// That piece's length.
    pub worst_length: f64,
    /// What the two sections say there.
    pub labels: [String; 2],
}

impl Sections {
    /// Where pairs of sections disagree, the worst first.
    pub fn disagreements(&self) -> Vec<Disagreement> {
        let noise = NOISE * self.bounds().map_or(0.0, |bounds| bounds.diagonal());
        let count = self.sections.len();
        let mut found: Vec<Disagreement> = (0..count)
            .into_par_iter()
            .flat_map_iter(|i| (i + 1..count).map(move |j| (i, j)))
            .filter_map(|(i, j)| disagreement(&self.sections[i], &self.sections[j]))
            .filter(|pair| pair.length > noise)
            .collect();
        found.sort_by(|a, b| {
            b.length.total_cmp(&a.length).then_with(|| a.sections.cmp(&b.sections))
        });
        found
    }
}

/// A label along a line, from a parameter to the next entry's.
type Run = Vec<(f64, Label)>;

fn disagreement(a: &Section, b: &Section) -> Option<Disagreement> {
    let line = Line::new(a, b)?;
    let mut found = Disagreement {
        sections: [a.name.clone(), b.name.clone()],
        length: 0.0,
        occupied: 0.0,
        worst: [0.0; 3],
        worst_length: 0.0,
        labels: [String::new(), String::new()],
    };
    for (start, end, labels) in line.stretches(a, b) {
        let length = end - start;
        if labels.iter().any(|label| label.is_material()) {
            found.occupied += length;
        }
        if labels[0] == labels[1] || labels.contains(&Label::UNKNOWN) {
            continue;
        }
        found.length += length;
        if length > found.worst_length {
            found.worst = line.place(a, 0.5 * (start + end)).to_array();
            found.worst_length = length;
            found.labels = labels.map(|label| label.to_string());
        }
    }
    Some(found)
}

/// Where two sections show one material along their common line: the middle of every stretch, its
/// length, and the material.
pub(crate) fn in_common(a: &Section, b: &Section) -> Vec<(DVec3, f64, Label)> {
    let Some(line) = Line::new(a, b) else { return Vec::new() };
    let stretches = line.stretches(a, b).into_iter();
    let same = stretches.filter(|(_, _, labels)| labels[0] == labels[1] && labels[0].is_material());
    same.map(|(start, end, [label, _])| (line.place(a, 0.5 * (start + end)), end - start, label))
        .collect()
}

/// The common line of two planes.
struct Line {
    /// Parameters count from the foot of this.
    origin: DVec3,
    foot: DVec3,
    /// Of length one.
    direction: DVec3,
}

impl Line {
    /// `None` where planes are parallel, or nothing is drawn.
    fn new(a: &Section, b: &Section) -> Option<Self> {
        let direction = a.plane.unit_normal().cross(b.plane.unit_normal());
        if direction.length() < 1e-12 {
            return None;
        }
        let origin = a.vertices.first().or(b.vertices.first()).map(|&kept| a.plane.lift(kept))?;
        Some(Self { origin, foot: foot(a, b, origin), direction: direction.normalize() })
    }

    /// The bounded pieces on which neither section's label changes, from one parameter to another.
    fn stretches(&self, a: &Section, b: &Section) -> Vec<(f64, f64, [Label; 2])> {
        let [first, second] =
            [(a, b), (b, a)].map(|(own, other)| run(own, other, self.origin, self.direction));
        together(&first, &second)
    }

    /// The point at a parameter, on the first plane.
    fn place(&self, a: &Section, at: f64) -> DVec3 {
        a.plane.lift(a.plane.project(self.foot + at * self.direction))
    }
}

/// The point of the common line of two planes that is nearest to `origin`.
fn foot(a: &Section, b: &Section, origin: DVec3) -> DVec3 {
    let [n, m] = [a.plane.unit_normal(), b.plane.unit_normal()];
    let [d, e] = [a.plane.distance(origin), b.plane.distance(origin)];
    let cos = n.dot(m);
    let det = 1.0 - cos * cos;
    origin - n * ((d - cos * e) / det) - m * ((e - cos * d) / det)
}

/// The labels of a section along its common line with another's plane, by the
/// distance from `origin` along `direction`. A vertex on the line counts as in
/// front of it, so that every edge crosses or does not.
fn run(section: &Section, other: &Section, origin: DVec3, direction: DVec3) -> Run {
    let points: Vec<DVec3> =
        section.vertices.iter().map(|&vertex| section.plane.lift(vertex)).collect();
    let sides: Vec<f64> = points.iter().map(|&point| other.plane.distance(point)).collect();
    // Behind the other plane lies left or right of the line.
    let left_in_front = section.plane.normal.cross(direction).dot(other.plane.normal) > 0.0;
    let mut crossings: Vec<(f64, [Label; 2])> = Vec::new();
    for edge in &section.edges {
        let [start, end] = [edge.start as usize, edge.end as usize];
        let [s, e] = [sides[start], sides[end]];
        if (s >= 0.0) == (e >= 0.0) {
            continue;
        }
        let point = points[start].lerp(points[end], s / (s - e));
        // Who crosses from right to left has the line's beginning on the left.
        let to_left = (e >= 0.0) == left_in_front;
        let labels = if to_left { [edge.left, edge.right] } else { [edge.right, edge.left] };
        crossings.push(((point - origin).dot(direction), labels));
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    follow(section.background, &crossings)
}

/// The labels after each place.
fn follow(background: Label, crossings: &[(f64, [Label; 2])]) -> Run {
    let mut run = vec![(f64::NEG_INFINITY, background)];
    let mut here = Here::new(background);
    for (i, &(place, [before, after])) in crossings.iter().enumerate() {
        here.change(before, after);
        if crossings.get(i + 1).is_none_or(|next| next.0 != place) {
            run.push((place, here.label()));
        }
    }
    run
}

/// The bounded pieces on which neither label changes.
fn together(a: &Run, b: &Run) -> Vec<(f64, f64, [Label; 2])> {
    let mut places: Vec<f64> =
        a.iter().chain(b).map(|entry| entry.0).filter(|place| place.is_finite()).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let at = |run: &Run, place: f64| run[run.partition_point(|entry| entry.0 <= place) - 1].1;
    places.windows(2).map(|pair| (pair[0], pair[1], [at(a, pair[0]), at(b, pair[0])])).collect()
}
