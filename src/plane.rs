//! Oriented planes, as given: their doubles are exact rationals.

use glam::{DVec2, DVec3};

/// The plane `normal · x = offset`. The normal need not have unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Not zero; world units do not matter.
    pub normal: DVec3,
    /// In the normal's length times world units.
    pub offset: f64,
}

impl Plane {
    /// The axis that is dropped to name a point on the plane by two numbers:
    /// the one in which the normal is largest (the first of equals).
    pub fn dropped_axis(&self) -> usize {
        let size = self.normal.abs();
        if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        }
    }

    /// The two kept axes, in the order that makes counter-clockwise in
    /// (first, second) counter-clockwise about the normal.
    pub fn kept_axes(&self) -> [usize; 2] {
        let dropped = self.dropped_axis();
        let [first, second] = [(dropped + 1) % 3, (dropped + 2) % 3];
        if self.normal[dropped] > 0.0 { [first, second] } else { [second, first] }
    }

    /// The kept coordinates of a point: its name on the plane.
    pub fn project(&self, point: DVec3) -> DVec2 {
        let [first, second] = self.kept_axes();
        DVec2::new(point[first], point[second])
    }

    /// The point on the plane with these kept coordinates, the dropped one
    /// solved for and rounded.
    pub fn lift(&self, kept: DVec2) -> DVec3 {
        let dropped = self.dropped_axis();
        let [first, second] = self.kept_axes();
        let rest = self.normal[first] * kept.x + self.normal[second] * kept.y;
        let mut point = DVec3::ZERO;
        point[first] = kept.x;
        point[second] = kept.y;
        point[dropped] = (self.offset - rest) / self.normal[dropped];
        point
    }

    /// The signed distance of a point, in world units.
    pub fn distance(&self, point: DVec3) -> f64 {
        (self.normal.dot(point) - self.offset) / self.normal.length()
    }

    /// The normal, of length one.
    pub fn unit_normal(&self) -> DVec3 {
        self.normal.normalize()
    }

    /// The same plane with a normal of length one.
    pub fn unit(&self) -> Self {
        Self { normal: self.unit_normal(), offset: self.offset / self.normal.length() }
    }

    /// The same plane seen from the other side.
    pub fn turned(&self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// The largest signed distance of a point of a box, in world units.
    pub fn largest_distance(&self, bounds: Bounds) -> f64 {
        let corner = DVec3::select(self.normal.cmpgt(DVec3::ZERO), bounds.max, bounds.min);
        self.distance(corner)
    }

    /// Unit vectors along which people measure width and height on the plane:
    /// the first is as near to x as the plane allows (to y, where the normal is
    /// nearest to x), the second completes them and the normal to a
    /// right-handed frame.
    pub fn sides(&self) -> [DVec3; 2] {
        let normal = self.unit_normal();
        let along = if self.dropped_axis() == 0 { DVec3::Y } else { DVec3::X };
        let first = (along - normal.dot(along) * normal).normalize();
        [first, normal.cross(first)]
    }

    /// The part in a box: a convex polygon, counter-clockwise about the normal;
    /// empty when the plane misses the box.
    pub fn polygon_in(&self, bounds: Bounds) -> Vec<DVec3> {
        let center = bounds.middle();
        let [first, second] = self.tangents();
        let origin = center - self.distance(center) * self.unit_normal();
        let reach = 2.0 * bounds.diagonal();
        let corner = |[a, b]: [f64; 2]| origin + reach * (a * first + b * second);
        bounds.clipped([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(corner).to_vec())
    }

    /// Two unit vectors that with the unit normal form a right-handed frame.
    pub fn tangents(&self) -> [DVec3; 2] {
        let normal = self.unit_normal();
        let first = normal.any_orthonormal_vector();
        [first, normal.cross(first)]
    }
}

/// An axis-parallel box in world units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: DVec3,
    /// The corner with the largest coordinates.
    pub max: DVec3,
}

impl Bounds {
    /// The planes of its faces: lower and upper x, y, z, their normals pointing outward.
    pub fn faces(self) -> [Plane; 6] {
        std::array::from_fn(|index| {
            let axis = index / 2;
            let mut normal = DVec3::ZERO;
            let (sign, offset) =
                if index % 2 == 0 { (-1.0, -self.min[axis]) } else { (1.0, self.max[axis]) };
            normal[axis] = sign;
            Plane { normal, offset }
        })
    }

    /// The smallest box around some points; `None` around none.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Option<Self> {
        points.into_iter().fold(None, |bounds: Option<Self>, point| {
            Some(bounds.map_or(Self { min: point, max: point }, |bounds| Self {
                min: bounds.min.min(point),
                max: bounds.max.max(point),
            }))
        })
    }

    /// The box grown by `margin` world units on every side.
    pub fn grown(self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// The smallest box around this one and another.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The part of a convex polygon in the box.
    pub fn clipped(&self, mut polygon: Vec<DVec3>) -> Vec<DVec3> {
        for axis in 0..3 {
            polygon = clipped(&polygon, |point| point[axis] - self.min[axis]);
            polygon = clipped(&polygon, |point| self.max[axis] - point[axis]);
        }
        polygon
    }

    /// Its middle.
    pub fn middle(&self) -> DVec3 {
        (self.min + self.max) / 2.0
    }

    /// The lengths of the sides.
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }

    /// Whether a point is inside or on a face.
    pub fn contains(&self, point: DVec3) -> bool {
        point.cmpge(self.min).all() && point.cmple(self.max).all()
    }

    /// The face on or beyond which points all lie, up to `tolerance` world
    /// units: twice the axis, and 1 more for the upper face.
    pub fn common_face(&self, points: &[DVec3], tolerance: f64) -> Option<usize> {
        let (min, max) = (self.min + tolerance, self.max - tolerance);
        (0..6).find(|face| {
            let (axis, is_upper) = (face / 2, face % 2 == 1);
            points.iter().all(|point| match is_upper {
                false => point[axis] <= min[axis],
                true => point[axis] >= max[axis],
            })
        })
    }

    /// Whether points all lie on or beyond one face, up to `tolerance` world
    /// units.
    pub fn on_one_face(&self, points: &[DVec3], tolerance: f64) -> bool {
        self.common_face(points, tolerance).is_some()
    }

    /// The point moved onto each face that it is nearer to than `tolerance`.
    pub fn snapped(&self, point: DVec3, tolerance: f64) -> DVec3 {
        let near = |face: DVec3| (point - face).abs().cmplt(DVec3::splat(tolerance));
        DVec3::select(near(self.max), self.max, DVec3::select(near(self.min), self.min, point))
    }

    /// The product of the sides.
    pub fn volume(&self) -> f64 {
        self.size().element_product()
    }
}

/// The area of a plane polygon.
pub fn polygon_area(polygon: &[DVec3]) -> f64 {
    let fan = polygon.windows(2).map(|pair| (pair[0] - polygon[0]).cross(pair[1] - polygon[0]));
    fan.sum::<DVec3>().length() / 2.0
}

/// The part of a convex polygon where `inside` is not negative.
pub(crate) fn clipped(polygon: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, &from) in polygon.iter().enumerate() {
        let to = polygon[(index + 1) % polygon.len()];
        let [at_from, at_to] = [inside(from), inside(to)];
        if at_from >= 0.0 {
            kept.push(from);
        }
        if (at_from >= 0.0) != (at_to >= 0.0) {
            kept.push(from.lerp(to, at_from / (at_from - at_to)));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_cut_to_the_box() {
        let unit = Bounds { min: DVec3::ZERO, max: DVec3::ONE };
        let area = |normal, offset| polygon_area(&Plane { normal, offset }.polygon_in(unit));
        assert!((area(DVec3::new(0.0, 0.0, 2.0), 1.0) - 1.0).abs() < 1e-12);
        // The regular hexagon with side √½, and the triangle with side √½.
        assert!((area(DVec3::ONE, 1.5) - 0.75 * 3.0_f64.sqrt()).abs() < 1e-12);
        assert!((area(DVec3::ONE, 0.5) - 3.0_f64.sqrt() / 8.0).abs() < 1e-12);
        assert_eq!(area(DVec3::X, 2.0), 0.0);
    }
}
