//! The box around sections: how far beyond them a solid may reach.

use glam::DVec3;

use super::{Section, Sections};
use crate::plane::{Bounds, Plane};

/// How far the box reaches beyond contours within their planes, and where no other
/// section is parallel also across, relative to the diagonal of all contours.
const MARGIN: f64 = 0.05;
/// Where its sides count as outside it reaches by that part of the widest gap between neighbours
/// of a stack, but no farther than so much of the diagonal. Beside a contour that is near enough to
/// the next section half of the gap is as far as the exact method looks; by the mean-value indicator
/// a tube is 1 % wider in a box without end.
const GAPS: f64 = 0.75;
const WIDEST: f64 = 0.375;
/// The sine of the largest angle between planes that count as parallel.
const PARALLEL: f64 = 1e-2;
/// The smallest reach, relative to the diagonal: sections that lie closer are two
/// views of one place and no spacing.
const LEAST: f64 = 2e-3;
/// The share of all contours' length that says nothing about their size.
const FAR: f64 = 0.02;

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

    /// The same where the sides of the box count as outside: to the sides it reaches by
    /// three quarters of the widest gap between neighbours of a stack, but no more than three eighths
    /// of the diagonal, so that one of the two sections is nearer than they are. Sections of which a part is unknown do not count: beside
    /// them the box alone says what is outside. `None` without contours.
    pub fn space_of_cells(&self) -> Option<Bounds> {
        let gap = GAPS * widest_gap(&self.sections) / bounds(&self.sections)?.diagonal();
        let aside = if gap > MARGIN { gap.min(WIDEST) } else { MARGIN };
        around(&self.sections, aside, &self.reaches())
    }

    /// How large what is drawn is, in world units: twice as far as contours are from the middle
    /// of them, but for the fiftieth of their length that is farthest away, so that a speck
    /// there does not count; and the same however they are turned. 0 without contours.
    pub fn span(&self) -> f64 {
        let segments = self.sections.iter().flat_map(Section::segments);
        let mut parts: Vec<(DVec3, f64)> =
            segments.map(|[a, b]| (a.midpoint(b), a.distance(b))).collect();
        let middle = |parts: &[(DVec3, f64)]| {
            let all: f64 = parts.iter().map(|part| part.1).sum();
            parts.iter().map(|&(at, length)| length / all * at).sum::<DVec3>()
        };
        // What is far away moves the middle, too.
        let from = middle(&parts);
        parts.sort_by(|one, other| one.0.distance(from).total_cmp(&other.0.distance(from)));
        let most = (1.0 - FAR) * parts.iter().map(|part| part.1).sum::<f64>();
        let mut passed = 0.0;
        let near = parts.iter().take_while(|part| {
            passed += part.1;
            passed <= most
        });
        let near = &parts[..near.count()];
        let from = middle(near);
        2.0 * near.iter().map(|part| part.0.distance(from)).fold(0.0, f64::max)
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
    let reach = |[before, behind]: [f64; 2]| before.min(behind);
    let gaps = gaps(sections, all).into_iter().map(reach);
    gaps.map(|gap| if gap.is_finite() { gap } else { margin * all.diagonal() }).collect()
}

/// The widest gap between two parallel sections that are neighbours and know all of their planes;
/// 0 where none are.
fn widest_gap(sections: &[Section]) -> f64 {
    let whole: Vec<Section> =
        sections.iter().filter(|section| !section.is_partial()).cloned().collect();
    let all = bounds(&whole).map(|all| gaps(&whole, all)).unwrap_or_default();
    all.into_iter().flatten().filter(|gap| gap.is_finite()).fold(0.0, f64::max)
}

/// How far the nearest parallel section is in front of every section and behind it; infinite where
/// there is none.
fn gaps(sections: &[Section], all: Bounds) -> Vec<[f64; 2]> {
    let nearest = |own: &Section| {
        [own.plane, own.plane.turned()].map(|plane| {
            let gaps = heights(own.bounds().unwrap_or(all).middle(), &plane, sections);
            gaps.filter(|&gap| gap >= LEAST * all.diagonal()).fold(f64::INFINITY, f64::min)
        })
    };
    sections.iter().map(nearest).collect()
}

/// How high the planes of sections that are parallel to one are above it, over a place.
pub fn heights(place: DVec3, plane: &Plane, sections: &[Section]) -> impl Iterator<Item = f64> {
    let normal = plane.unit_normal();
    let from = place - plane.distance(place) * normal;
    sections.iter().filter_map(move |other| {
        let other_normal = other.plane.unit_normal();
        let is_parallel = normal.cross(other_normal).length() <= PARALLEL;
        is_parallel.then(|| -other.plane.distance(from) * normal.dot(other_normal).signum())
    })
}

/// The box around contours that reaches beyond them by a part of their diagonal within their
/// planes, and across by what is said for every section.
fn around(sections: &[Section], aside: f64, across: &[f64]) -> Option<Bounds> {
    let aside = aside * bounds(sections)?.diagonal();
    let grown = |(section, &across): (&Section, &f64)| {
        let normal = section.plane.unit_normal();
        // Half the size of a disc with a height along the normal.
        let along = (DVec3::ONE - normal * normal).max(DVec3::ZERO);
        let size = across * normal.abs() + aside * along.map(f64::sqrt);
        let own = section.bounds()?;
        Some(Bounds { min: own.min - size, max: own.max + size })
    };
    let boxes = sections.iter().zip(across).filter_map(grown);
    Bounds::around(boxes.flat_map(|own| [own.min, own.max]))
}

/// [`Sections::space`] with this margin, relative to the diagonal, and with
/// `beyond` times the reaches.
pub fn space(sections: &[Section], margin: f64, beyond: f64) -> Option<Bounds> {
    let reaches = reaches_with(sections, margin).into_iter().map(|reach| beyond * reach);
    around(sections, margin, &reaches.collect::<Vec<_>>())
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
        // Or three quarters of the widest gap.
        let space = stack.space_of_cells().unwrap();
        assert!((space.max.x - 1.0 - 0.5625).abs() < 1e-12);
        assert!((space.max.z - 2.25).abs() < 1e-12);
    }

    #[test]
    fn the_sides_of_the_box_are_no_nearer_than_a_section() {
        // Far apart, and turned.
        let tilted = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        for normal in [DVec3::Z, tilted] {
            let stack = discs(&[0.0, 3.0, 6.5, 9.5].map(|at| (normal, at)));
            let (all, space) = (bounds(&stack.sections).unwrap(), stack.space_of_cells().unwrap());
            let room = (all.min - space.min).min(space.max - all.max);
            let upright = (DVec3::ONE - normal * normal).max(DVec3::ZERO).map(f64::sqrt);
            // Across, the reach of the last section.
            let least = (2.625 * upright).max(3.0 * normal.abs());
            assert!(room.cmpge(least - 1e-9).all(), "{room} {least}");
        }
        // One gap is wide: a part of the diagonal is enough.
        let two = discs(&[(DVec3::Z, 0.0), (DVec3::Z, 40.0)]);
        let (all, space) = (bounds(&two.sections).unwrap(), two.space_of_cells().unwrap());
        assert!((space.max.x - all.max.x - WIDEST * all.diagonal()).abs() < 1e-9);
        // What knows nothing beside itself leaves that to the box.
        let mut partial = two.clone();
        partial.sections[0].background = Label::UNKNOWN;
        assert_eq!(partial.space_of_cells(), partial.space());
    }

    #[test]
    fn a_span_is_that_of_most_contours_however_they_are_turned() {
        let heights = [0.0, 2.0, 4.0, 6.0, 8.0, 10.0];
        let upright = discs(&heights.map(|at| (DVec3::Z, at)));
        let tilted = discs(&heights.map(|at| (DVec3::new(0.36, 0.48, 0.8), at)));
        // From the middle to the circles at the ends, of which a part counts as far.
        assert!((upright.span() / 2.0 / 26f64.sqrt() - 1.0).abs() < 0.05, "{}", upright.span());
        assert!((tilted.span() / upright.span() - 1.0).abs() < 0.02, "{}", tilted.span());
        let mut speck = upright.clone();
        let far = Plane { normal: DVec3::Z, offset: 500.0 };
        speck.sections.push(disc(far, 0.05, 64, Label(2)));
        assert!((speck.span() / upright.span() - 1.0).abs() < 0.05, "{}", speck.span());
        assert_eq!(Sections::default().span(), 0.0);
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
