//! The foot of a point on a section's plane, and the label there.

use std::cell::OnceCell;
use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::exact::{self, Number, Query, number};
use super::site::Site;
use crate::label::Label;

/// The foot of a point on a plane: rounded, and in rationals once floats cannot
/// decide something.
pub struct Foot<'a> {
    site: &'a Site<'a>,
    query: &'a Query,
    /// In space, within `error` of the true foot in every coordinate.
    pub place: DVec3,
    /// By its kept coordinates.
    pub kept: DVec2,
    pub error: f64,
    exact: OnceCell<[Number; 2]>,
}

/// How an edge meets the ray from the foot towards larger x.
enum Meeting {
    Missed,
    /// The foot is on the edge.
    Touched,
    /// The edge crosses the ray, upward or downward.
    Crossed {
        upward: bool,
    },
}

impl<'a> Foot<'a> {
    pub fn new(site: &'a Site, query: &'a Query) -> Self {
        let (place, error) = site.plane.foot(query.point);
        let kept = site.section.plane().project(place);
        Self { site, query, place, kept, error, exact: OnceCell::new() }
    }

    /// The label at the foot. On an edge or a vertex it is the smallest of the
    /// labels around, *unknown* being the largest of all.
    ///
    /// Along a ray from infinity to the foot the label changes at every
    /// crossing by the difference of the edge's labels, so the sum of these,
    /// modulo 2³², is all that has to be known: the crossings' order is not.
    /// The ray runs infinitely little above the foot, so that it meets no
    /// vertex and no horizontal edge.
    pub fn label(&self) -> Label {
        let section = self.site.section;
        let mut label = section.background().0;
        let mut touched: Option<Label> = None;
        let (low, high) = (self.kept - self.error, self.kept + self.error);
        let passes = |[min, max]: [DVec2; 2]| min.y <= high.y && max.y >= low.y && max.x >= low.x;
        self.site.edges.visit(passes, |number| {
            let edge = &section.edges()[number as usize];
            match self.meeting(self.site.ends(number)) {
                Meeting::Missed => {}
                Meeting::Touched => {
                    let here = edge.left.min(edge.right);
                    touched = Some(touched.map_or(here, |label| label.min(here)));
                }
                // Upward, what is left of the edge is on the foot's side.
                Meeting::Crossed { upward } => {
                    let change = edge.left.0.wrapping_sub(edge.right.0);
                    let change = if upward { change } else { change.wrapping_neg() };
                    label = label.wrapping_add(change);
                }
            }
        });
        touched.unwrap_or(Label(label))
    }

    fn meeting(&self, [start, end]: [DVec2; 2]) -> Meeting {
        let [from_start, from_end] = [start, end].map(|point| self.compare(1, point.y));
        if from_start == from_end && from_start != Ordering::Equal {
            return Meeting::Missed;
        }
        if from_start == Ordering::Equal && from_end == Ordering::Equal {
            let [one, other] = [start, end].map(|point| self.compare(0, point.x));
            // Between the ends, or on one of them.
            let within = one != other || one == Ordering::Equal;
            return if within { Meeting::Touched } else { Meeting::Missed };
        }
        // Above or at the start, and not the same of the end, or the reverse.
        let upward = start.y < end.y;
        match (self.side(start, end), upward) {
            (Ordering::Equal, _) => Meeting::Touched,
            (Ordering::Greater, true) | (Ordering::Less, false) => {
                let passes = from_start.is_ge() != from_end.is_ge();
                if passes { Meeting::Crossed { upward } } else { Meeting::Missed }
            }
            _ => Meeting::Missed,
        }
    }

    /// A kept coordinate of the foot against a value.
    fn compare(&self, axis: usize, value: f64) -> Ordering {
        let gap = self.kept[axis] - value;
        if gap.abs() > 2.0 * self.error {
            return if gap > 0.0 { Ordering::Greater } else { Ordering::Less };
        }
        self.exact()[axis].cmp(&number(value))
    }

    /// The side of a line the foot is on: greater on the left.
    fn side(&self, start: DVec2, end: DVec2) -> Ordering {
        let (along, offset) = (end - start, self.kept - start);
        let (left, right) = (along.x * offset.y, along.y * offset.x);
        // The differences are good to ε; so are the products, but for what the
        // foot itself is off; and where they underflow nothing is known.
        let bound = 2.0 * self.error * (along.x.abs() + along.y.abs())
            + 8.0 * f64::EPSILON * (left.abs() + right.abs())
            + f64::MIN_POSITIVE;
        let cross = left - right;
        if cross.abs() > bound {
            return if cross > 0.0 { Ordering::Greater } else { Ordering::Less };
        }
        exact::side(self.exact(), start, end)
    }

    fn exact(&self) -> &[Number; 2] {
        self.exact.get_or_init(|| self.site.exact.foot(self.query.exact()))
    }
}
