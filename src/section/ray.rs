//! The label at a point of a section: what a ray that comes from far away has reached
//! when it gets there. Across every edge the label changes from one side's to the other's.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use glam::DVec2;
use robust::{Coord, orient2d};

use super::{Edge, Section};
use crate::label::Label;

/// A point of a plane, by kept coordinates, that knows exactly where it is.
pub(crate) trait Target {
    /// A kept coordinate against a value.
    fn compare(&self, axis: usize, value: f64) -> Ordering;

    /// The side of a line that the point is on: greater on the left.
    fn side(&self, start: DVec2, end: DVec2) -> Ordering;
}

impl Target for DVec2 {
    fn compare(&self, axis: usize, value: f64) -> Ordering {
        self[axis].partial_cmp(&value).unwrap_or(Ordering::Equal)
    }

    fn side(&self, start: DVec2, end: DVec2) -> Ordering {
        let [start, end, own] = [start, end, *self].map(|DVec2 { x, y }| Coord { x, y });
        orient2d(start, end, own).partial_cmp(&0.0).unwrap_or(Ordering::Equal)
    }
}

/// A ray from infinity to a point, coming from larger first coordinates. The label changes at
/// every crossing by the difference of the edge's labels, so the sum of these, modulo 2³², is
/// all that has to be known: the crossings' order is not. The ray runs infinitely little above
/// the point, so that it meets no vertex and no horizontal edge.
pub(crate) struct Ray<'a, S> {
    to: &'a S,
    label: u32,
    touched: Option<Label>,
}

/// How an edge meets a ray.
enum Meeting {
    Missed,
    /// The point is on the edge.
    Touched,
    /// The edge crosses the ray, upward or downward.
    Crossed {
        upward: bool,
    },
}

impl<'a, S: Target> Ray<'a, S> {
    /// One that has met no edge yet.
    pub fn new(to: &'a S, background: Label) -> Self {
        Self { to, label: background.0, touched: None }
    }

    /// Takes an edge into account, whose ends have these kept coordinates.
    pub fn meet(&mut self, edge: &Edge, ends: [DVec2; 2]) {
        match meeting(self.to, ends) {
            Meeting::Missed => {}
            Meeting::Touched => {
                let here = edge.left.min(edge.right);
                self.touched = Some(self.touched.map_or(here, |label| label.min(here)));
            }
            // Upward, what is left of the edge is on the point's side.
            Meeting::Crossed { upward } => {
                let change = edge.left.0.wrapping_sub(edge.right.0);
                let change = if upward { change } else { change.wrapping_neg() };
                self.label = self.label.wrapping_add(change);
            }
        }
    }

    /// The label at the point, after all edges of the section. On an edge or a vertex it is
    /// the smallest of the labels around, *unknown* being the largest of all.
    pub fn label(self) -> Label {
        self.touched.unwrap_or(Label(self.label))
    }
}

fn meeting(to: &impl Target, [start, end]: [DVec2; 2]) -> Meeting {
    let [from_start, from_end] = [start, end].map(|point| to.compare(1, point.y));
    if from_start == from_end && from_start != Ordering::Equal {
        return Meeting::Missed;
    }
    if from_start == Ordering::Equal && from_end == Ordering::Equal {
        let [one, other] = [start, end].map(|point| to.compare(0, point.x));
        // Between the ends, or on one of them.
        let within = one != other || one == Ordering::Equal;
        return if within { Meeting::Touched } else { Meeting::Missed };
    }
    // Above or at the start, and not the same of the end, or the reverse.
    let upward = start.y < end.y;
    match (to.side(start, end), upward) {
        (Ordering::Equal, _) => Meeting::Touched,
        (Ordering::Greater, true) | (Ordering::Less, false) => {
            let passes = from_start.is_ge() != from_end.is_ge();
            if passes { Meeting::Crossed { upward } } else { Meeting::Missed }
        }
        _ => Meeting::Missed,
    }
}

impl Section {
    /// The label at a point, given by its kept coordinates ([`Plane::project`](crate::Plane::project));
    /// decided exactly. On an edge or a vertex it is the smallest of the labels around,
    /// *unknown* being the largest of all.
    pub fn label_at(&self, point: DVec2) -> Label {
        let mut ray = Ray::new(&point, self.background);
        for edge in &self.edges {
            ray.meet(edge, [edge.start, edge.end].map(|vertex| self.vertices[vertex as usize]));
        }
        ray.label()
    }
}

/// The label at a place of a line, from the crossings before it, whose places are rounded:
/// each label is entered once more than left where it holds. This does not depend on the
/// order of crossings that rounding puts at the same place.
pub(crate) struct Here {
    entered: BTreeMap<Label, i32>,
}

impl Here {
    /// Far away.
    pub fn new(background: Label) -> Self {
        Self { entered: BTreeMap::from([(background, 1)]) }
    }

    /// Crosses an edge.
    pub fn change(&mut self, from: Label, to: Label) {
        *self.entered.entry(from).or_default() -= 1;
        *self.entered.entry(to).or_default() += 1;
    }

    /// The label that holds now.
    pub fn label(&self) -> Label {
        let holds = self.entered.iter().find(|(_, entered)| **entered > 0);
        holds.map_or(Label::OUTSIDE, |(label, _)| *label)
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::plane::Plane;
    use crate::section::Rules;

    /// A square of 2 in one of 4, whose lower right corner is cut off and unknown.
    fn nested(normal: DVec3) -> Section {
        let plane = Plane { normal, offset: 3.0 };
        let square = |half: f64| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
                .map(|[x, y]| plane.lift(half * DVec2::new(x, y)))
        };
        let corner =
            [[2.0, -2.0], [2.0, -1.0], [1.0, -2.0]].map(|[x, y]| plane.lift(DVec2::new(x, y)));
        let rules = Rules { overlap: Some(crate::section::Overlap::Smallest), ..Rules::default() };
        let section = Section::builder("nested", plane)
            .region(Label(1), square(2.0))
            .region(Label(5), square(1.0))
            .region(Label::UNKNOWN, corner)
            .build(&rules);
        section.expect("a section").0
    }

    #[test]
    fn labels_are_those_of_the_region_and_on_contours_the_smallest() {
        for normal in [DVec3::Z, -DVec3::Z, DVec3::new(1.0, -3.0, 2.0)] {
            let section = nested(normal);
            let label = |x, y| section.label_at(DVec2::new(x, y));
            assert_eq!([label(0.0, 0.0), label(0.9, -0.9), label(1.5, 0.0)], [5, 5, 1].map(Label));
            assert_eq!([label(3.0, 0.0), label(-3.0, 1.0)], [Label::OUTSIDE; 2]);
            assert_eq!(label(1.9, -1.9), Label::UNKNOWN);
            // On edges, on horizontal ones, and on vertices.
            assert_eq!([label(1.0, 0.25), label(0.5, 1.0), label(1.0, -1.0)], [Label(1); 3]);
            assert_eq!([label(2.0, 0.0), label(0.0, -2.0), label(2.0, 2.0)], [Label::OUTSIDE; 3]);
            assert_eq!(label(1.5, -1.5), Label(1));
            assert_eq!([label(2.0, -1.0), label(2.0, -1.5)], [Label::OUTSIDE; 2]);
            // In line with edges and vertices, beyond and before them.
            assert_eq!([label(-1.5, 1.0), label(-1.5, -1.0)], [Label(1); 2]);
            assert_eq!([label(-3.0, 2.0), label(-3.0, -1.0), label(3.0, 1.0)], [Label::OUTSIDE; 3]);
        }
    }
}
