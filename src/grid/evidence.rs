//! How far the nearest known part of a section is: where the result rests on
//! little.

use glam::DVec3;

use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice};
use crate::plane::Plane;
use crate::section::Section;

mod borders;

use borders::Borders;

/// The known parts of all sections.
pub struct Evidence {
    parts: Vec<KnownPart>,
}

/// The known part of one plane.
struct KnownPart {
    /// Its normal has unit length.
    plane: Plane,
    /// Where it ends; `None` for a plane known all over.
    borders: Option<Borders>,
}

/// The parts that can be nearest to any point of a ball.
pub struct Near<'a> {
    parts: Vec<&'a KnownPart>,
}

impl Evidence {
    /// Of sections; those that know nothing do not count.
    pub fn new(sections: &[Section]) -> Self {
        let part = |section: &Section| {
            let borders = Borders::new(section);
            if !borders.is_known_far_away() && borders.is_empty() {
                return None;
            }
            let length = section.plane().normal.length();
            let plane = Plane {
                normal: section.plane().normal / length,
                offset: section.plane().offset / length,
            };
            Some(KnownPart { plane, borders: (!borders.is_empty()).then_some(borders) })
        };
        Self { parts: sections.iter().filter_map(part).collect() }
    }

    /// The parts that can be nearest to a point of a ball: those not farther
    /// from its centre than the nearest by more than its diameter.
    pub fn near(&self, center: DVec3, radius: f64) -> Near<'_> {
        let mut parts: Vec<(f64, &KnownPart)> =
            self.parts.iter().map(|part| (part.height(center), part)).collect();
        parts.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut nearest = f64::INFINITY;
        let mut found: Vec<(f64, &KnownPart)> = Vec::new();
        for (height, part) in parts {
            let limit = nearest + 2.0 * radius;
            if height > limit {
                break;
            }
            if let Some(distance) = part.distance(center, limit) {
                nearest = nearest.min(distance);
                found.push((distance, part));
            }
        }
        found.retain(|(distance, _)| *distance <= nearest + 2.0 * radius);
        found.sort_by(|one, other| one.0.total_cmp(&other.0));
        Near { parts: found.into_iter().map(|(_, part)| part).collect() }
    }

    /// The distances of a leaf's nodes, in world units; 0 without any known
    /// part.
    pub fn in_leaf(&self, lattice: &Lattice, at: [i32; 3]) -> Vec<f32> {
        let side = LEAF_SIDE as i32;
        let first = lattice.position(at.map(|at| at * side));
        let half = lattice.voxel * f64::from(side - 1) / 2.0;
        let near = self.near(first + half, half * 3f64.sqrt());
        let node = |node: usize| {
            let offset = [node / 64, node / 8 % 8, node % 8].map(|offset| offset as f64);
            near.distance(first + lattice.voxel * DVec3::from(offset)).unwrap_or(0.0) as f32
        };
        (0..LEAF_NODES).map(node).collect()
    }
}

impl Near<'_> {
    /// The distance of a point of the ball to the nearest known part, in world
    /// units; `None` when nothing is known at all.
    pub fn distance(&self, point: DVec3) -> Option<f64> {
        self.parts.iter().fold(None, |nearest, part| {
            part.distance(point, nearest.unwrap_or(f64::INFINITY)).or(nearest)
        })
    }
}

impl KnownPart {
    /// The distance to the whole plane.
    fn height(&self, point: DVec3) -> f64 {
        (self.plane.normal.dot(point) - self.plane.offset).abs()
    }

    /// The distance to the known part, when it is below a limit.
    fn distance(&self, point: DVec3, limit: f64) -> Option<f64> {
        let height = self.height(point);
        if height >= limit {
            return None;
        }
        let Some(borders) = &self.borders else { return Some(height) };
        let aside = borders.distance(point, (limit * limit - height * height).sqrt())?;
        Some(height.hypot(aside))
    }
}

#[cfg(test)]
mod tests;
