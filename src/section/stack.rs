//! Sections that are a stack: parallel planes in their order.

use glam::DVec3;

use super::Section;
use crate::label::Label;
use crate::plane::Bounds;

/// Fewer are no stack: two parallel planes have one distance and no rhythm.
const FEWEST: usize = 3;
/// The sine of the largest angle between planes that count as parallel. Files
/// give normals to some digits; on a box of a hundred spacings' width this is
/// a tenth of a spacing.
const PARALLEL: f64 = 1e-3;

/// Parallel sections, sorted along their common normal. Sections that know
/// nothing at all are in none.
#[derive(Debug, Clone, PartialEq)]
pub struct Stack {
    /// The normal of the first section, of length one.
    pub direction: DVec3,
    /// The sections by their index, in order along `direction`.
    pub order: Vec<usize>,
    /// Where each of them is, in that order: its height along `direction` above
    /// the origin, in world units, in the middle of all contours.
    pub heights: Vec<f64>,
}

impl Stack {
    /// The stack that sections are, if all of them are parallel and there are
    /// at least three.
    pub fn new(sections: &[Section]) -> Option<Self> {
        Self::of(sections, FEWEST)
    }

    /// The same of `fewest` sections or more.
    pub(crate) fn of(sections: &[Section], fewest: usize) -> Option<Self> {
        let speaks = |section: &Section| section.labels() != [Label::UNKNOWN];
        let own: Vec<usize> =
            (0..sections.len()).filter(|&section| speaks(&sections[section])).collect();
        if own.len() < fewest.max(1) {
            return None;
        }
        let direction = sections[own[0]].plane.unit_normal();
        let middle = middle(sections);
        let height = |section: usize| {
            let plane = &sections[section].plane;
            let normal = plane.unit_normal();
            let is_parallel = normal.cross(direction).length() <= PARALLEL;
            let below = plane.distance(middle) * normal.dot(direction).signum();
            is_parallel.then_some((section, middle.dot(direction) - below))
        };
        let mut placed: Vec<(usize, f64)> = own.into_iter().map(height).collect::<Option<_>>()?;
        placed.sort_by(|one, other| one.1.total_cmp(&other.1));
        let (order, heights) = placed.into_iter().unzip();
        Some(Self { direction, order, heights })
    }

    /// The distances between neighbours: one less than there are sections.
    pub fn spacings(&self) -> Vec<f64> {
        self.heights.windows(2).map(|pair| pair[1] - pair[0]).collect()
    }

    /// The distance that each section stands for: half of the way to either
    /// neighbour. The first and the last stand for as much beyond as within, so
    /// that a stack of equal spacings has them all alike.
    pub fn thicknesses(&self) -> Vec<f64> {
        let spacings = self.spacings();
        let (first, last) = (spacings[0], spacings[spacings.len() - 1]);
        let below = std::iter::once(&first).chain(&spacings);
        let above = spacings.iter().chain(std::iter::once(&last));
        below.zip(above).map(|(below, above)| (below + above) / 2.0).collect()
    }

    /// The height of a point along the stack's direction.
    pub fn height(&self, point: DVec3) -> f64 {
        self.direction.dot(point)
    }
}

/// The middle of all contours; the origin without any.
fn middle(sections: &[Section]) -> DVec3 {
    let points = sections
        .iter()
        .flat_map(|section| (0..section.vertices.len() as u32).map(|vertex| section.point(vertex)));
    Bounds::around(points).map_or(DVec3::ZERO, |bounds| bounds.middle())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::disc;
    use crate::plane::Plane;

    fn at(normal: DVec3, offset: f64) -> Section {
        disc(Plane { normal, offset }, 1.0, 8, Label(1))
    }

    #[test]
    fn parallel_sections_are_sorted_whatever_their_normals() {
        // Normals of length 2 and −1 along (3, 0, 4) / 5, at heights 5, −1, 2, 3.
        let along = DVec3::new(0.6, 0.0, 0.8);
        let sections =
            [at(2.0 * along, 10.0), at(-along, 1.0), at(along, 2.0), at(-2.0 * along, -6.0)];
        let stack = Stack::new(&sections).expect("they are parallel");
        assert!(stack.direction.abs_diff_eq(along, 1e-15));
        assert_eq!(stack.order, [1, 2, 3, 0]);
        let close = |found: &[f64], right: &[f64]| {
            assert_eq!(found.len(), right.len());
            assert!(found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        close(&stack.heights, &[-1.0, 2.0, 3.0, 5.0]);
        close(&stack.spacings(), &[3.0, 1.0, 2.0]);
        // (3 + 3) / 2, (3 + 1) / 2, (1 + 2) / 2, (2 + 2) / 2.
        close(&stack.thicknesses(), &[3.0, 2.0, 1.5, 2.0]);
    }

    #[test]
    fn two_sections_are_no_stack_nor_are_tilted_ones() {
        let flat = [at(DVec3::Z, 0.0), at(DVec3::Z, 1.0), at(DVec3::Z, 2.0)];
        assert!(Stack::new(&flat).is_some());
        assert!(Stack::new(&flat[..2]).is_none());
        // An angle of 0.01 is none of rounding, one of 0.0001 may be.
        for (tilt, is_stack) in [(1e-2, false), (1e-4, true)] {
            let tilted = at(DVec3::new(tilt, 0.0, 1.0), 3.0);
            let all = [&flat[..], &[tilted]].concat();
            assert_eq!(Stack::new(&all).is_some(), is_stack);
        }
    }

    #[test]
    fn rounded_normals_far_from_the_origin_make_no_difference() {
        // Discs around (1e4, 0, k) whose planes turn about their middles: at the
        // origin their heights would be off by 1e-4 · 1e4 = 1.
        let tilted = |k: f64, tilt: f64| {
            let (normal, middle) = (DVec3::new(tilt, 0.0, 1.0), DVec3::new(1e4, 0.0, k));
            let plane = Plane { normal, offset: normal.dot(middle) };
            let mut section = disc(Plane { normal: DVec3::Z, offset: k }, 1.0, 8, Label(1));
            section.plane = plane;
            section.vertices.iter_mut().for_each(|vertex| vertex.x += 1e4);
            section
        };
        let sections = [tilted(0.0, 0.0), tilted(1.0, 1e-4), tilted(2.0, -1e-4)];
        let stack = Stack::new(&sections).expect("they are parallel");
        assert_eq!(stack.order, [0, 1, 2]);
        assert!(stack.spacings().iter().all(|spacing| (spacing - 1.0).abs() < 1e-6));
    }

    #[test]
    fn a_section_that_knows_nothing_is_not_in_the_stack() {
        let mut blind = at(DVec3::X, 0.0);
        (blind.vertices, blind.edges) = (Vec::new(), Vec::new());
        blind.background = Label::UNKNOWN;
        let mut all = vec![blind, at(DVec3::Z, 1.0), at(DVec3::Z, 0.0), at(DVec3::Z, 2.0)];
        assert_eq!(Stack::new(&all).expect("three know something").order, [2, 1, 3]);
        all.pop();
        assert!(Stack::new(&all).is_none());
    }
}
