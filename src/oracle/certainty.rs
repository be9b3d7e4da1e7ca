//! Where the mean-value field must have the label of the nearest point.

use glam::{DVec2, DVec3};

use super::Oracle;
use super::exact::Query;
use super::foot::Foot;
use super::site::Site;
use super::tree::Rectangle;
use crate::label::Label;
use crate::plane::{Bounds, Plane, clipped};

/// How clearly the nearest plane decides a point's label. Planes are those of
/// the sections and of the box's faces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certainty {
    /// The distance to the nearest plane over that to the second nearest.
    pub rho: f64,
    /// How far around its foot the nearest plane has one label and meets no
    /// other plane, over its distance. Infinite for a point on it.
    pub alpha: f64,
    /// Whether everything is known on the walls of the point's cell, and so
    /// whether ρ and α say anything.
    pub known: bool,
}

impl Certainty {
    /// Whether the mean-value field, unsmoothed, has the same label.
    ///
    /// With the nearest plane at the distance r, the disc of radius αr around
    /// the foot has the weight (π/r)(1 − c²), c = 1/√(1 + α²), of the π/r that
    /// the whole plane could have, and all that is beyond the second-nearest
    /// plane no more than ρ(1 + c) times as much again on either side.
    pub fn must_agree(&self) -> bool {
        let cosine = 1.0 / 1.0_f64.hypot(self.alpha);
        self.known && 1.0 - 2.0 * cosine * cosine > 2.0 * self.rho * (1.0 + cosine)
    }
}

/// The planes that divide the box, and the box's faces.
pub(super) struct Walls {
    /// Those of the sections in their order, then the faces; of unit length.
    planes: Vec<Plane>,
    /// Of every plane that is not known all over, its part in the box.
    partial: Vec<(usize, Vec<DVec3>)>,
}

impl Walls {
    pub fn new(sites: &[Site], bounds: Bounds, faces_are_known: bool) -> Self {
        let unit = |plane: &Plane| {
            let length = plane.normal.length();
            Plane { normal: plane.normal / length, offset: plane.offset / length }
        };
        let mut planes: Vec<Plane> = sites.iter().map(|site| unit(site.section.plane())).collect();
        for axis in 0..3 {
            for face in [bounds.min, bounds.max] {
                planes.push(Plane { normal: DVec3::AXES[axis], offset: face[axis] });
            }
        }
        let is_known =
            |number: usize| sites.get(number).map_or(faces_are_known, |site| site.is_full);
        let partial = (0..planes.len()).filter(|&number| !is_known(number));
        let partial = partial.map(|number| (number, planes[number].polygon_in(bounds))).collect();
        Self { planes, partial }
    }

    /// The nearest plane and its distance, and that of the second nearest.
    fn nearest(&self, point: DVec3) -> (usize, f64, f64) {
        let mut nearest = (0, f64::INFINITY, f64::INFINITY);
        for (number, plane) in self.planes.iter().enumerate() {
            let distance = height(plane, point).abs();
            if distance < nearest.1 {
                nearest = (number, distance, nearest.1);
            } else {
                nearest.2 = nearest.2.min(distance);
            }
        }
        nearest
    }

    /// The distance within a plane to the nearest line that another cuts it in.
    fn nearest_line(&self, number: usize, foot: DVec3) -> f64 {
        let own = &self.planes[number];
        let others = self.planes.iter().enumerate().filter(|&(other, _)| other != number);
        let distance = |(_, plane): (usize, &Plane)| {
            let sine = plane.normal.cross(own.normal).length();
            if sine > 0.0 { height(plane, foot).abs() / sine } else { f64::INFINITY }
        };
        others.map(distance).fold(f64::INFINITY, f64::min)
    }

    /// The part of a plane, cut to the box, that is a wall of a point's cell.
    fn wall(&self, number: usize, mut polygon: Vec<DVec3>, point: DVec3) -> Vec<DVec3> {
        for (_, plane) in self.planes.iter().enumerate().filter(|&(other, _)| other != number) {
            let side = height(plane, point).signum();
            polygon = clipped(&polygon, |corner| side * height(plane, corner));
        }
        polygon
    }
}

/// Over a plane of unit normal.
fn height(plane: &Plane, point: DVec3) -> f64 {
    plane.normal.dot(point) - plane.offset
}

impl Oracle<'_> {
    /// How clearly the nearest plane decides the label of a point in the box.
    pub fn certainty(&self, point: DVec3) -> Certainty {
        let (number, distance, second) = self.walls.nearest(point);
        let foot =
            point - height(&self.walls.planes[number], point) * self.walls.planes[number].normal;
        let line = self.walls.nearest_line(number, foot);
        let query = Query::new(foot);
        let label_change =
            |site: &Site| site.aside(&Foot::new(site, &query), &site.edges, line).unwrap_or(line);
        let around = self.sites.get(number).map_or(line, label_change);
        Certainty {
            rho: distance / second,
            alpha: around / distance,
            known: self.knows_walls(point),
        }
    }

    /// Whether everything is known on the walls of a point's cell.
    fn knows_walls(&self, point: DVec3) -> bool {
        self.walls.partial.iter().all(|(number, polygon)| {
            let wall = self.walls.wall(*number, polygon.clone(), point);
            wall.len() < 3 || self.sites.get(*number).is_some_and(|site| knows(site, &wall))
        })
    }
}

/// Whether everything is known on a convex polygon of a section's plane.
fn knows(site: &Site, polygon: &[DVec3]) -> bool {
    let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    if Foot::new(site, &Query::new(middle)).label() == Label::UNKNOWN {
        return false;
    }
    let Some(borders) = site.around(Label::UNKNOWN) else { return true };
    let flat: Vec<DVec2> =
        polygon.iter().map(|&corner| site.section.plane().project(corner)).collect();
    let low = flat.iter().fold(DVec2::INFINITY, |low, &corner| low.min(corner));
    let high = flat.iter().fold(DVec2::NEG_INFINITY, |high, &corner| high.max(corner));
    let meets = |[min, max]: Rectangle| min.cmple(high).all() && max.cmpge(low).all();
    let mut met = false;
    borders.visit(meets, |edge| met = met || passes(site.ends(edge), &flat));
    !met
}

/// Whether a segment has more than a point in a convex polygon, which is
/// counter-clockwise.
fn passes([start, end]: [DVec2; 2], polygon: &[DVec2]) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for (index, &corner) in polygon.iter().enumerate() {
        let side = polygon[(index + 1) % polygon.len()] - corner;
        let [first, last] = [start, end].map(|place| side.perp_dot(place - corner));
        // Along the segment this goes from `first` to `last`, positive inside.
        match (first > 0.0, last > 0.0) {
            (true, true) => {}
            (false, false) => return false,
            (true, false) => to = to.min(first / (first - last)),
            (false, true) => from = from.max(first / (first - last)),
        }
    }
    from < to
}
