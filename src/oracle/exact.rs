//! Planes, feet and distances in rationals: what decides when floats cannot.
//! All input is doubles, so everything here is exact; roots are never taken,
//! distances are compared by their squares.

use std::cell::OnceCell;
use std::cmp::Ordering;

use dashu_ratio::Relaxed;
use glam::{DVec2, DVec3};

use crate::plane::Plane;

/// A rational that is not kept in lowest terms.
pub type Number = Relaxed;
/// A point or a vector.
pub type Triple = [Number; 3];

/// A finite double as it is.
pub fn number(value: f64) -> Number {
    Number::try_from(value).unwrap_or(Number::ZERO)
}

/// A point of finite doubles as it is.
pub fn triple(point: DVec3) -> Triple {
    point.to_array().map(number)
}

/// A point, rounded.
pub fn rounded(point: &Triple) -> DVec3 {
    DVec3::from(point.each_ref().map(|value| value.to_f64().value()))
}

fn dot(one: &Triple, other: &Triple) -> Number {
    let [x, y, z] = [0, 1, 2].map(|axis| &one[axis] * &other[axis]);
    x + y + z
}

fn difference(one: &Triple, other: &Triple) -> Triple {
    std::array::from_fn(|axis| &one[axis] - &other[axis])
}

/// `start + times * direction`.
fn along(start: &Triple, times: &Number, direction: &Triple) -> Triple {
    std::array::from_fn(|axis| &start[axis] + times * &direction[axis])
}

/// A point that is asked about.
pub struct Query {
    /// As given.
    pub point: DVec3,
    exact: OnceCell<Triple>,
}

impl Query {
    pub fn new(point: DVec3) -> Self {
        Self { point, exact: OnceCell::new() }
    }

    /// The point in rationals, made when it is first needed.
    pub fn exact(&self) -> &Triple {
        self.exact.get_or_init(|| triple(self.point))
    }
}

/// The plane `normal · x = offset`.
pub struct ExactPlane {
    plane: Plane,
    normal: Triple,
    offset: Number,
    /// `normal · normal`.
    squared: Number,
}

impl ExactPlane {
    pub fn new(plane: Plane) -> Self {
        let normal = triple(plane.normal);
        let squared = dot(&normal, &normal);
        Self { plane, normal, offset: number(plane.offset), squared }
    }

    /// `normal · point − offset`: the height times the normal's length.
    fn height(&self, point: &Triple) -> Number {
        dot(&self.normal, point) - &self.offset
    }

    /// The squared distance of a point to the plane.
    pub fn squared_distance(&self, point: &Triple) -> Number {
        self.height(point).sqr() / &self.squared
    }

    /// The kept coordinates of the foot of a point.
    pub fn foot(&self, point: &Triple) -> [Number; 2] {
        let times = -(self.height(point) / &self.squared);
        self.plane.kept_axes().map(|axis| &point[axis] + &times * &self.normal[axis])
    }

    /// The point of the plane with these kept coordinates.
    pub fn lift(&self, [x, y]: [Number; 2]) -> Triple {
        let (dropped, [first, second]) = (self.plane.dropped_axis(), self.plane.kept_axes());
        let rest = &self.normal[first] * &x + &self.normal[second] * &y;
        let mut point = [Number::ZERO; 3];
        point[dropped] = (&self.offset - rest) / &self.normal[dropped];
        point[first] = x;
        point[second] = y;
        point
    }

    /// The point of a segment on the plane that is nearest to a point anywhere.
    pub fn nearest_on(&self, [start, end]: [DVec2; 2], point: &Triple) -> NearestOn {
        let [start, end] = [start, end].map(|kept| self.lift(kept.to_array().map(number)));
        let (direction, offset) = (difference(&end, &start), difference(point, &start));
        let length = dot(&direction, &direction);
        let times = dot(&offset, &direction);
        let (place, at) = if times <= Number::ZERO {
            (start, Spot::Start)
        } else if times >= length {
            (end, Spot::End)
        } else {
            (along(&start, &(times / length), &direction), Spot::Within)
        };
        let gap = difference(point, &place);
        NearestOn { squared: dot(&gap, &gap), place, at }
    }
}

/// The nearest point of a segment.
pub struct NearestOn {
    /// Its squared distance.
    pub squared: Number,
    pub place: Triple,
    pub at: Spot,
}

/// Where on a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spot {
    Start,
    Within,
    End,
}

/// On which side of the line from `start` to `end` a point lies: greater on
/// the left.
pub fn side(point: &[Number; 2], start: DVec2, end: DVec2) -> Ordering {
    let [ax, ay] = start.to_array().map(number);
    let [bx, by] = end.to_array().map(number);
    let left = (bx - &ax) * (&point[1] - &ay);
    left.cmp(&((by - ay) * (&point[0] - ax)))
}
