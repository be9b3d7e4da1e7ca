//! The ends of what sections show: where no other section has a contour any more.

use std::borrow::Cow;

use glam::DVec3;

use super::draft::Draft;
use super::{Rules, Section, Sections, reach};
use crate::error::Result;
use crate::label::Label;
use crate::plane::{Bounds, Plane};

/// How far beyond the plane of an end other contours may lie, relative to the
/// diagonal of all contours: what files round away.
const TOLERANCE: f64 = 1e-4;
/// How far a box goes on beyond the place where a solid has to end, as a part of an end's reach,
/// for that to be said there.
const ROOM: f64 = 1e-3;

/// One side of a section beyond whose plane no other section has a contour: the first
/// and the last section of a stack have one, a section alone has two.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// The section's index.
    pub section: usize,
    /// Its plane, the normal of length one and pointing away from the other contours.
    pub plane: Plane,
    /// How far beyond it a solid may reach ([`Sections::reaches`]), in world units.
    pub reach: f64,
}

impl Sections {
    /// The ends, by section.
    pub fn ends(&self) -> Vec<End> {
        ends(&self.sections)
    }
}

/// [`Sections::ends`].
pub fn ends(sections: &[Section]) -> Vec<End> {
    let Some(all) = reach::bounds(sections) else { return Vec::new() };
    let tolerance = TOLERANCE * all.diagonal();
    let boxes: Vec<Option<Bounds>> = sections.iter().map(Section::bounds).collect();
    let mut ends = Vec::new();
    for ((section, own), reach) in sections.iter().enumerate().zip(reach::reaches(sections)) {
        if boxes[section].is_none() {
            continue;
        }
        for plane in [own.plane.turned().unit(), own.plane.unit()] {
            let goes_on = sections.iter().zip(&boxes).any(|(other, bounds)| {
                let may = bounds.is_some_and(|bounds| plane.largest_distance(bounds) > tolerance);
                may && other.points().any(|point| plane.distance(point) > tolerance)
            });
            if !goes_on {
                ends.push(End { section, plane, reach });
            }
        }
    }
    ends
}

/// The sections, and an empty one as far beyond every end of a stack as a solid may reach, where a
/// box goes on there: a stack that leans in its box then ends as it does upright, not in the box's corners.
///
/// # Errors
/// As [`SectionBuilder::build`](super::SectionBuilder::build).
pub fn stopped(sections: &[Section], bounds: Bounds) -> Result<Cow<'_, [Section]>> {
    let mut all = Cow::from(sections);
    for end in ends(sections) {
        let own = &sections[end.section];
        let plane = end.beyond(end.reach);
        // What rounding leaves of an upright box is no room for another cell.
        let slack = ROOM * end.reach;
        let middle = own.bounds().map_or(DVec3::ZERO, |own| own.middle());
        let heights: Vec<f64> = reach::heights(middle, &end.plane, sections).collect();
        // Sections that cross say themselves where they end, and every plane more costs.
        let is_stack = heights.iter().any(|height| (height.abs() - end.reach).abs() < slack);
        let is_said = heights.iter().any(|&height| height > slack && height < end.reach + slack);
        if is_stack && !is_said && plane.largest_distance(bounds) > slack {
            let name = format!("beyond {}", own.name());
            all.to_mut().push(Section::builder(name, plane).build(&Rules::default())?.0);
        }
    }
    Ok(all)
}

impl End {
    /// The plane this far beyond the end, in world units.
    pub fn beyond(&self, distance: f64) -> Plane {
        Plane { offset: self.plane.offset + distance, ..self.plane }
    }

    /// The section once more, this far beyond the end; `None` where another section
    /// says what is in between.
    ///
    /// # Errors
    /// Where contours touch in ways that rounding takes apart.
    pub fn repeated(&self, sections: &[Section], distance: f64) -> Result<Option<Section>> {
        let own = &sections[self.section];
        let shift = distance * self.plane.normal;
        let is_crossed = |other: &Section| {
            other.background != Label::UNKNOWN
                && own.segments().any(|[a, b]| {
                    let sides = [a, b, a + shift, b + shift].map(|at| other.plane.distance(at));
                    sides.iter().any(|&side| side < 0.0) && sides.iter().any(|&side| side > 0.0)
                })
        };
        let is_other = |&(index, _): &(usize, &Section)| index != self.section;
        if sections.iter().enumerate().filter(is_other).any(|(_, other)| is_crossed(other)) {
            return Ok(None);
        }
        own.shifted(shift).map(Some)
    }
}

impl Section {
    /// The vertices in space, rounded.
    fn points(&self) -> impl Iterator<Item = DVec3> + '_ {
        (0..self.vertices.len() as u32).map(|vertex| self.point(vertex))
    }

    /// The same somewhere else. Rounding moves vertices, so that edges are made to meet
    /// in vertices alone again.
    fn shifted(&self, by: DVec3) -> Result<Self> {
        let plane = Plane { offset: self.plane.offset + by.dot(self.plane.normal), ..self.plane };
        let aside = plane.project(by);
        let vertices = self.vertices.iter().map(|&vertex| vertex + aside).collect();
        let rules = Rules::default();
        let mut draft = Draft::new(&self.name, plane, 0.0, &rules)?;
        Self { plane, vertices, ..self.clone() }.settled(&mut draft)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::{disc, section};
    use glam::DVec2;

    fn at(normal: DVec3, offset: f64) -> Section {
        disc(Plane { normal, offset }, 1.0, 24, Label(1))
    }

    /// The sections that have ends, and the directions of these.
    fn found(sections: &[Section]) -> Vec<(usize, DVec3)> {
        ends(sections).iter().map(|end| (end.section, end.plane.normal)).collect()
    }

    #[test]
    fn a_stack_ends_at_its_first_and_last_section_whatever_their_normals() {
        // At heights 2, 0, −1 and 0.5; planes of any length, some upside down.
        let along = DVec3::new(0.6, 0.0, 0.8);
        let stack = [at(-along, -2.0), at(along, 0.0), at(3.0 * along, -3.0), at(-along, -0.5)];
        let ends = ends(&stack);
        assert_eq!(ends.iter().map(|end| end.section).collect::<Vec<_>>(), [0, 2]);
        for (end, (outward, height, reach)) in
            ends.iter().zip([(along, 2.0, 1.5), (-along, 1.0, 1.0)])
        {
            assert!(end.plane.normal.abs_diff_eq(outward, 1e-12), "{}", end.plane.normal);
            assert!((end.plane.offset - height).abs() < 1e-12);
            assert!((end.reach - reach).abs() < 1e-12);
            assert!((end.beyond(0.25).offset - height - 0.25).abs() < 1e-12);
        }
    }

    #[test]
    fn a_section_alone_has_two_ends_and_one_without_contours_none() {
        let mut empty = at(DVec3::Z, 1.0);
        (empty.vertices, empty.edges) = (Vec::new(), Vec::new());
        let alone = [at(DVec3::Z, 0.0)];
        assert_eq!(found(&alone), [(0, -DVec3::Z), (0, DVec3::Z)]);
        assert_eq!(found(&[alone[0].clone(), empty.clone()]), found(&alone));
        assert_eq!(found(&[empty]), []);
    }

    #[test]
    fn a_box_that_goes_on_beyond_an_end_is_stopped_there() {
        let leaning = DVec3::new(0.6, 0.0, 0.8);
        let stack = [at(leaning, 0.0), at(leaning, 0.5), at(-leaning, -1.5)];
        let sections = Sections { sections: stack.to_vec(), ..Sections::default() };
        let box_around = sections.space().unwrap();
        let all = stopped(&stack, box_around).unwrap();
        // A spacing beyond: of 0.5 below, of 1 above.
        let heights: Vec<f64> = all[3..]
            .iter()
            .map(|own| own.plane.normal.dot(leaning).signum() * own.plane.offset)
            .collect();
        assert_eq!(heights.len(), 2);
        assert!(
            (heights[0] + 0.5).abs() < 1e-12 && (heights[1] - 2.5).abs() < 1e-12,
            "{heights:?}"
        );
        assert!(all[3..].iter().all(|own| own.edges.is_empty() && !own.is_partial()));
        // Stopped already; and a box that ends there stops it itself.
        assert_eq!(stopped(&all, box_around).unwrap().len(), all.len());
        let upright = [at(DVec3::Z, 0.0), at(DVec3::Z, 1.0)];
        let sections = Sections { sections: upright.to_vec(), ..Sections::default() };
        let box_around = sections.space().unwrap();
        assert_eq!(stopped(&upright, box_around).unwrap().len(), 2);
        assert_eq!(stopped(&upright, box_around.grown(0.5)).unwrap().len(), 4);
    }

    #[test]
    fn planes_that_cross_have_ends_only_where_nothing_lies_beyond() {
        // Circles of a ball: each passes on both sides of the other two planes, but
        // for the one that only touches the top.
        let ball = [at(DVec3::X, 0.0), at(DVec3::Y, 0.0), at(DVec3::Z, 0.0)];
        assert_eq!(found(&ball), []);
        let top = disc(Plane { normal: DVec3::Z, offset: 1.0 - 1e-6 }, 1e-3, 24, Label(1));
        assert_eq!(found(&[&ball[..], &[top]].concat()), [(3, DVec3::Z)]);
    }

    #[test]
    fn a_repeated_section_is_the_same_beyond() {
        // A quadrilateral on an oblique plane.
        let plane = Plane { normal: DVec3::new(1.0, 2.0, -2.0), offset: 0.3 };
        let corners = [[0.0, 0.0], [1.0, 0.1], [0.9, 1.0], [0.1, 0.7]].map(DVec2::from_array);
        let sections = [section(plane, &corners, Label(2))];
        for end in ends(&sections) {
            let copy = end.repeated(&sections, 0.7).unwrap().expect("nothing is in the way");
            assert_eq!(copy.edges.len(), sections[0].edges.len());
            assert_eq!(copy.labels(), sections[0].labels());
            let shift = 0.7 * end.plane.normal;
            for point in copy.points() {
                assert!(end.beyond(0.7).distance(point).abs() < 1e-12);
                let near = |other: DVec3| (other + shift).distance(point) < 1e-12;
                assert!(sections[0].points().any(near));
            }
        }
    }

    #[test]
    fn where_another_section_passes_over_an_end_it_is_not_repeated() {
        // The plane x + z = 1.3 passes 0.3 above the disc's middle, and sees nothing.
        let mut over = at(DVec3::new(1.0, 0.0, 1.0), 1.3);
        (over.vertices, over.edges) = (Vec::new(), Vec::new());
        let mut sections = [at(DVec3::Z, 0.0), over];
        let repeated = |sections: &[Section], distance: f64| {
            let upper = ends(sections)[1];
            upper.repeated(sections, distance).unwrap().is_some()
        };
        assert!(repeated(&sections, 0.2));
        assert!(!repeated(&sections, 0.5));
        // What is unknown says nothing.
        sections[1].background = Label::UNKNOWN;
        assert!(repeated(&sections, 0.5));
    }
}
