//! Where somebody knows how the surface stands on a section: its normals along contours.

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use super::Section;
use crate::error::{Error, Result};

/// Normals by the kept coordinates of the vertices that have them.
#[derive(Debug, Default)]
pub(super) struct Normals(HashMap<[u64; 2], DVec3>);

/// The name of a vertex.
fn key(kept: DVec2) -> [u64; 2] {
    (kept + 0.0).to_array().map(f64::to_bits)
}

impl Normals {
    /// Adds those of a section.
    pub fn add(&mut self, section: &Section) {
        let known = section.vertices.iter().zip(&section.normals);
        self.0.extend(known.map(|(&vertex, &normal)| (key(vertex), normal)));
    }

    /// A section's vertices with those that are known of them.
    pub fn give(&self, section: &mut Section) {
        if self.0.is_empty() {
            return;
        }
        let normal = |&vertex: &DVec2| self.0.get(&key(vertex)).copied().unwrap_or_default();
        let normals: Vec<DVec3> = section.vertices.iter().map(normal).collect();
        if normals.iter().any(|&normal| normal != DVec3::ZERO) {
            section.normals = normals;
        }
    }
}

impl Section {
    /// The surface's normal at every vertex, of length one and either way round, 0 where it is
    /// not known; none where no vertex has any.
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// The same with the surface's normals at some points of its contours. They need not have
    /// length one and may point either way. Points that are no vertices are left out.
    ///
    /// # Errors
    /// For one that is no direction.
    pub fn with_normals(mut self, known: impl IntoIterator<Item = (DVec3, DVec3)>) -> Result<Self> {
        let mut normals = Normals::default();
        for (point, normal) in known {
            let unit = crate::direction::unit(normal).ok_or_else(|| Error::Section {
                section: self.name.clone(),
                what: format!("the normal {normal} at {point} is no direction"),
            })?;
            normals.0.insert(key(self.plane.project(point)), unit);
        }
        normals.give(&mut self);
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::disc;
    use crate::label::Label;
    use crate::plane::Plane;
    use crate::section::Rules;

    #[test]
    fn normals_stay_with_their_vertices() {
        let plane = Plane { normal: DVec3::Z, offset: 0.5 };
        let section = disc(plane, 1.0, 8, Label(1));
        let known = [2, 5].map(|vertex| (section.point(vertex), 3.0 * section.point(vertex)));
        let section = section.with_normals(known).unwrap();
        assert_eq!(section.normals().len(), 8);
        for vertex in 0..8 {
            let expected = match vertex {
                2 | 5 => section.point(vertex).normalize(),
                _ => DVec3::ZERO,
            };
            assert!((section.normals()[vertex as usize] - expected).length() < 1e-15);
        }
        // Beyond an extent the one goes, and the other stays.
        let along = section.point(2) - 0.5 * DVec3::Z;
        let across = along.cross(DVec3::Z);
        let extent = [[-2.0, -2.0], [0.1, -2.0], [0.1, 2.0], [-2.0, 2.0]]
            .map(|[x, y]| 0.5 * DVec3::Z + x * along + y * across);
        let (within, _) = section.within(&extent, &[], 4.0, &Rules::default()).unwrap();
        let left = within.normals().iter().filter(|normal| **normal != DVec3::ZERO).count();
        assert_eq!(left, 1);
    }

    #[test]
    fn what_is_no_direction_is_refused() {
        let plane = Plane { normal: DVec3::Z, offset: 0.5 };
        for bad in [DVec3::ZERO, DVec3::new(f64::NAN, 0.0, 1.0)] {
            let section = disc(plane, 1.0, 8, Label(1));
            let at = section.point(0);
            let error = section.with_normals([(at, bad)]).unwrap_err();
            assert!(error.to_string().contains("is no direction"), "{error}");
        }
    }
}
