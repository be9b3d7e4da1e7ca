//! The sections' contours in space, as lines.

use std::collections::BTreeMap;

use glam::DVec3;

use super::Part;
use super::lines::{Sheet, simplified};
use crate::label::Label;
use crate::section::Section;

/// How many points all lines have at most, about.
const POINTS: usize = 80_000;
/// How far a line may be from what it stands for, as parts of the diagonal: at first, and at most.
const NEAR: f64 = 2e-4;
const FAR: f64 = 2e-3;

/// Lines between the same two labels.
#[derive(Debug, Clone, Default)]
pub struct Outline {
    /// One line after the other.
    pub points: Vec<DVec3>,
    /// How many points each line has.
    pub runs: Vec<u32>,
}

/// The lines of sections, by the labels on both sides, the lesser first.
#[derive(Debug, Clone, Default)]
pub struct Outlines {
    pub lines: BTreeMap<[Label; 2], Outline>,
    /// How many sections have lines, and how many of them are here.
    pub count: usize,
    pub shown: usize,
}

impl Outlines {
    /// Of all sections, or of evenly many where these would have too many points.
    pub fn new(parts: &[Part], diagonal: f64) -> Self {
        let sections = parts.iter().flat_map(|part| &part.model.sections().sections);
        let sections: Vec<&Section> =
            sections.filter(|section| !section.edges().is_empty()).collect();
        let count = sections.len();
        let most = (POINTS / count.max(1)).max(32);
        let mut every = 1;
        loop {
            let some: Vec<&Section> = sections.iter().copied().step_by(every).collect();
            let own = Self { count, shown: some.len(), ..Self::of(&some, diagonal, most) };
            if own.lines.values().map(|line| line.points.len()).sum::<usize>() <= 2 * POINTS {
                return own;
            }
            every *= 2;
        }
    }

    fn of(sections: &[&Section], diagonal: f64, most: usize) -> Self {
        let mut own = Self::default();
        for section in sections {
            let plane = section.plane();
            let origin = section.point(section.edges()[0].start);
            let sheet = Sheet { origin, axes: plane.tangents(), turned: false };
            let contours = sheet.contours(section);
            let simple = simplified(&contours, NEAR * diagonal, FAR * diagonal, most);
            for (run, [left, right]) in simple.chains() {
                let line = own.lines.entry([left.min(right), left.max(right)]).or_default();
                line.runs.push(run.len() as u32);
                let points = run.iter().map(|&point| simple.points[point as usize]);
                line.points.extend(points.map(|point| sheet.space(point)));
            }
        }
        own
    }
}
