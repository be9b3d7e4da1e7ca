//! The foot of a point on a section's plane, and the label there.

use std::cell::OnceCell;
use std::cmp::Ordering;

use glam::{DVec2, DVec3};

use super::exact::{self, Number, Query, number};
use super::site::Site;
use crate::label::Label;
use crate::section::{Ray, Target};

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

impl<'a> Foot<'a> {
    pub fn new(site: &'a Site, query: &'a Query) -> Self {
        let (place, error) = site.plane.foot(query.point);
        let kept = site.section.plane().project(place);
        Self { site, query, place, kept, error, exact: OnceCell::new() }
    }

    /// The label at the foot. On an edge or a vertex it is the smallest of the
    /// labels around, *unknown* being the largest of all.
    pub fn label(&self) -> Label {
        let section = self.site.section;
        let mut ray = Ray::new(self, section.background());
        let (low, high) = (self.kept - self.error, self.kept + self.error);
        let passes = |[min, max]: [DVec2; 2]| min.y <= high.y && max.y >= low.y && max.x >= low.x;
        self.site.edges.visit(passes, |number| {
            ray.meet(&section.edges()[number as usize], self.site.ends(number));
        });
        ray.label()
    }

    fn exact(&self) -> &[Number; 2] {
        self.exact.get_or_init(|| self.site.exact.foot(self.query.exact()))
    }
}

impl Target for Foot<'_> {
    fn compare(&self, axis: usize, value: f64) -> Ordering {
        let gap = self.kept[axis] - value;
        if gap.abs() > 2.0 * self.error {
            return if gap > 0.0 { Ordering::Greater } else { Ordering::Less };
        }
        self.exact()[axis].cmp(&number(value))
    }

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
}
