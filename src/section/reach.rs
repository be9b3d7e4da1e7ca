//! The box around sections: how far beyond them a solid may reach.

use glam::DVec3;

use super::{Section, Sections};
use crate::plane::Bounds;

/// How far the box reaches beyond contours within their planes, and where no other
/// section is parallel also across, relative to the diagonal of all contours.
const MARGIN: f64 = 0.05;
/// The sine of the largest angle between planes that count as parallel.
const PARALLEL: f64 = 1e-2;
/// The smallest reach, relative to the diagonal: sections that lie closer are two
/// views of one place and no spacing.
const LEAST: f64 = 2e-3;

impl Section {
    /// The smallest box around the contours; `None` without any.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around((0..self.vertices.len() as u32).map(|vertex| self.point(vertex)))
    }
}

impl Sections {
    /// For every section how far beyond it a solid may reach across its plane, in
    /// world units: as far as the nearest section is away that is parallel.
    /// A twentieth of the diagonal where there is none. Empty without contours.
    pub fn reaches(&self) -> Vec<f64> {
        reaches(&self.sections)
    }

    /// The box in which a solid is looked for: around every contour a twentieth of
    /// their diagonal along its plane, and its section's reach across. So beyond the
    /// last section of a stack it ends one spacing away. `None` without contours.
    pub fn space(&self) -> Option<Bounds> {
        space(&self.sections, MARGIN, 1.0)
    }
}

/// All vertices' box; `None` when there are no contours.
pub fn bounds(sections: &[Section]) -> Option<Bounds> {
    let corners = |own: Bounds| [own.min, own.max];
    Bounds::around(sections.iter().filter_map(Section::bounds).flat_map(corners))
}

/// [`Sections::reaches`].
pub fn reaches(sections: &[Section]) -> Vec<f64> {
    reaches_with(sections, MARGIN)
}

/// The same with another margin, relative to the diagonal.
pub fn reaches_with(sections: &[Section], margin: f64) -> Vec<f64> {
    let Some(all) = bounds(sections) else { return Vec::new() };
    let diagonal = all.diagonal();
    let middle = all.middle();
    let reach = |section: &Section| {
        let normal = section.plane.unit_normal();
        let own = section.bounds().map_or(middle, |own| own.middle());
        let from = own - section.plane.distance(own) * normal;
        let gap = |other: &Section| {
            let is_parallel = normal.cross(other.plane.unit_normal()).length() <= PARALLEL;
            let gap = other.plane.distance(from).abs();
            (is_parallel && gap >= LEAST * diagonal).then_some(gap)
        };
        sections.iter().filter_map(gap).reduce(f64::min).unwrap_or(margin * diagonal)
    };
    sections.iter().map(reach).collect()
}

/// [`Sections::space`] with another margin, relative to the diagonal, and with
/// `beyond` times the reaches.
pub fn space(sections: &[Section], margin: f64, beyond: f64) -> Option<Bounds> {
    let along_plane = margin * bounds(sections)?.diagonal();
    let grown = |(section, reach): (&Section, f64)| {
        let normal = section.plane.unit_normal();
        // Half the size of a disc with a height along the normal.
        let along = (DVec3::ONE - normal * normal).max(DVec3::ZERO);
        let size = beyond * reach * normal.abs() + along_plane * along.map(f64::sqrt);
        let own = section.bounds()?;
        Some(Bounds { min: own.min - size, max: own.max + size })
    };
    let boxes = sections.iter().zip(reaches_with(sections, margin)).filter_map(grown);
    Bounds::around(boxes.flat_map(|own| [own.min, own.max]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::disc;
    use crate::label::Label;
    use crate::plane::Plane;

    fn discs(planes: &[(DVec3, f64)]) -> Sections {
        let disc = |&(normal, offset)| disc(Plane { normal, offset }, 1.0, 64, Label(1));
        Sections { sections: planes.iter().map(disc).collect(), ..Sections::default() }
    }

    #[test]
    fn the_box_of_a_stack_ends_a_spacing_beyond_it() {
        // Gaps of 0.25, 0.5 and 0.75, one plane upside down.
        let stack =
            discs(&[(DVec3::Z, 0.0), (DVec3::Z, 0.25), (-DVec3::Z, -0.75), (2.0 * DVec3::Z, 3.0)]);
        let reaches = stack.reaches();
        for (found, right) in reaches.iter().zip([0.25, 0.25, 0.5, 0.75]) {
            assert!((found - right).abs() < 1e-12);
        }
        let space = stack.space().unwrap();
        assert!((space.min.z + 0.25).abs() < 1e-12);
        assert!((space.max.z - 2.25).abs() < 1e-12);
        // The contours' diagonal is √(2² + 2² + 1.5²).
        let margin = 0.05 * 10.25f64.sqrt();
        assert!((space.max.x - 1.0 - margin).abs() < 1e-12);
    }

    #[test]
    fn a_section_alone_has_the_same_margin_all_around() {
        let normal = DVec3::new(1.0, 2.0, -2.0);
        let space = discs(&[(normal, 0.3)]).space().unwrap();
        let alone = discs(&[(normal, 0.3)]).bounds().unwrap();
        let unit = normal / 3.0;
        let margin = 0.05 * alone.diagonal();
        for axis in 0..3 {
            let size = margin * (unit[axis].abs() + (1.0 - unit[axis] * unit[axis]).sqrt());
            assert!((space.max[axis] - alone.max[axis] - size).abs() < 1e-12);
        }
        assert_eq!(Sections::default().space(), None);
    }

    #[test]
    fn nearly_one_plane_is_no_spacing() {
        let twice = discs(&[(DVec3::Z, 0.0), (DVec3::Z, 1e-6), (DVec3::Z, 0.5)]);
        assert!(twice.reaches().iter().all(|reach| (reach - 0.5).abs() < 1e-5));
    }
}
