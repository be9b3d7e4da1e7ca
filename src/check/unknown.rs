//! How much of a section nobody knows.

use glam::DVec3;

use crate::label::Label;
use crate::plane::{Bounds, polygon_area};
use crate::section::Section;

/// The share of a section's plane in a box that is unknown, in [0, 1]; 0 for a
/// plane that misses the box.
///
/// With signs, the triangles from one point to all edges of a region add up to
/// the region, and their parts in the box to its part in the box. An unbounded
/// region is the plane less the others.
pub fn unknown_share(section: &Section, bounds: Bounds) -> f64 {
    let whole = section.plane().polygon_in(bounds);
    let area = polygon_area(&whole);
    if area == 0.0 {
        return 0.0;
    }
    let is_unknown = |label: Label| label == Label::UNKNOWN;
    let normal = section.plane().unit_normal();
    let mut unknown = if is_unknown(section.background()) { area } else { 0.0 };
    for edge in section.edges() {
        let sign = f64::from(is_unknown(edge.left)) - f64::from(is_unknown(edge.right));
        if sign != 0.0 {
            let [start, end] = [edge.start, edge.end].map(|vertex| section.point(vertex));
            unknown += sign * signed_area([whole[0], start, end], normal, bounds);
        }
    }
    (unknown / area).clamp(0.0, 1.0)
}

/// The area of a triangle's part in a box: positive when the triangle is
/// counter-clockwise about the normal.
fn signed_area([a, b, c]: [DVec3; 3], normal: DVec3, bounds: Bounds) -> f64 {
    let doubled = (b - a).cross(c - a).dot(normal);
    polygon_area(&bounds.clipped(vec![a, b, c])).copysign(doubled)
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::check::shapes::{polygon, section};
    use crate::plane::Plane;

    const FLOOR: Plane = Plane { normal: DVec3::Z, offset: 0.0 };
    /// 4 × 4 on the floor.
    const BOX: Bounds = Bounds { min: DVec3::splat(-2.0), max: DVec3::splat(2.0) };

    /// A square [−1, 3] × [−1, 3] with `inside` in it and `around` beyond.
    fn square(inside: Label, around: Label) -> Section {
        let corners = [[-1.0, -1.0], [3.0, -1.0], [3.0, 3.0], [-1.0, 3.0]].map(DVec2::from);
        let mut section = section(FLOOR, &corners, inside);
        section.edges.iter_mut().for_each(|edge| edge.right = around);
        section.background = around;
        section
    }

    #[test]
    fn what_counts_is_the_part_in_the_box() {
        // The square covers 3 × 3 of the box's 4 × 4.
        let share = |inside, around| unknown_share(&square(inside, around), BOX);
        assert!((share(Label::UNKNOWN, Label::OUTSIDE) - 9.0 / 16.0).abs() < 1e-12);
        assert!((share(Label::OUTSIDE, Label::UNKNOWN) - 7.0 / 16.0).abs() < 1e-12);
        assert_eq!(share(Label(1), Label::OUTSIDE), 0.0);
    }

    #[test]
    fn a_plane_without_contours_is_known_or_not() {
        let mut empty = square(Label(1), Label::OUTSIDE);
        empty.edges.clear();
        assert_eq!(unknown_share(&empty, BOX), 0.0);
        empty.background = Label::UNKNOWN;
        assert_eq!(unknown_share(&empty, BOX), 1.0);
        empty.plane.offset = 5.0;
        assert_eq!(unknown_share(&empty, BOX), 0.0);
    }

    #[test]
    fn slanted_planes_and_holes_count_by_their_area() {
        // Known between two discs of area π/4 and π/16 in a box that holds both.
        let plane = Plane { normal: DVec3::new(2.0, -1.0, 3.0), offset: 0.5 };
        let mut ring = crate::check::shapes::disc(plane, 0.5, 400, Label(1));
        let hole = crate::check::shapes::disc(plane, 0.25, 400, Label::UNKNOWN);
        let first = ring.vertices.len() as u32;
        ring.vertices.extend(hole.vertices);
        ring.edges.iter_mut().for_each(|edge| edge.right = Label::UNKNOWN);
        ring.edges.extend(polygon(400, Label::UNKNOWN).into_iter().map(|edge| {
            crate::section::Edge {
                start: edge.start + first,
                end: edge.end + first,
                right: Label(1),
                ..edge
            }
        }));
        ring.background = Label::UNKNOWN;
        let whole = polygon_area(&plane.polygon_in(BOX));
        let known = std::f64::consts::PI * (0.25 - 0.0625);
        assert!((unknown_share(&ring, BOX) - (1.0 - known / whole)).abs() < 1e-5);
    }
}
