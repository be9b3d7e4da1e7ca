//! The volume that a stack's areas speak of: by Cavalieri's principle, area
//! times spacing.

use serde::Serialize;

use crate::label::Label;
use crate::section::{Section, Stack};

/// What a stack says of a label's volume, and what became of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Cavalieri {
    /// The label's area on each section times the distance that the section
    /// stands for ([`Stack::thicknesses`]), added up, in cubic world units.
    pub volume: f64,
    /// The reconstruction's volume over that.
    pub ratio: f64,
}

impl Cavalieri {
    /// Of a label whose reconstruction has a volume. None where the label is
    /// on no section, borders on what is unknown, or reaches to infinity: then
    /// its area is not known.
    pub fn new(stack: &Stack, sections: &[Section], label: Label, volume: f64) -> Option<Self> {
        let areas = stack.order.iter().map(|&section| area(&sections[section], label));
        let areas: Vec<f64> = areas.collect::<Option<_>>()?;
        let stacked: f64 =
            areas.iter().zip(stack.thicknesses()).map(|(area, thickness)| area * thickness).sum();
        (stacked > 0.0).then(|| Self { volume: stacked, ratio: volume / stacked })
    }
}

/// The area of a label on a section, in square world units.
fn area(section: &Section, label: Label) -> Option<f64> {
    if section.background() == label {
        return None;
    }
    let normal = section.plane().unit_normal();
    // Far from the origin the triangles would cancel digits away.
    let base = section.edges().first().map(|edge| section.point(edge.start));
    let mut doubled = 0.0;
    for edge in section.edges() {
        let sides = [edge.left, edge.right];
        if !sides.contains(&label) {
            continue;
        }
        if sides.contains(&Label::UNKNOWN) {
            return None;
        }
        let [start, end] = [edge.start, edge.end].map(|vertex| section.point(vertex));
        let base = base.unwrap_or(start);
        let turn = (start - base).cross(end - base).dot(normal);
        doubled += if edge.left == label { turn } else { -turn };
    }
    Some(doubled / 2.0)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::*;
    use crate::check::shapes::disc;
    use crate::plane::Plane;

    fn discs(radii: &[(f64, f64)]) -> Vec<Section> {
        let normal = DVec3::new(0.6, 0.0, 0.8);
        let disc = |&(height, radius): &(f64, f64)| {
            disc(Plane { normal, offset: height }, radius, 1000, Label(1))
        };
        radii.iter().map(disc).collect()
    }

    #[test]
    fn a_cylinder_has_its_own_volume() {
        // Sections in the middle of four slices of half a unit: [0, 2].
        let sections = discs(&[(0.25, 2.0), (0.75, 2.0), (1.25, 2.0), (1.75, 2.0)]);
        let stack = Stack::new(&sections).expect("they are parallel");
        let own = Cavalieri::new(&stack, &sections, Label(1), 0.9 * 8.0 * PI).expect("its area");
        assert!((own.volume / (8.0 * PI) - 1.0).abs() < 1e-4, "{}", own.volume);
        assert!((own.ratio - 0.9).abs() < 1e-4);
        assert_eq!(Cavalieri::new(&stack, &sections, Label(2), 1.0), None);
    }

    #[test]
    fn sections_count_by_the_distance_they_stand_for() {
        // Spacings 1 and 3: they stand for 1, 2 and 3.
        let sections = discs(&[(0.0, 1.0), (1.0, 2.0), (4.0, 3.0)]);
        let stack = Stack::new(&sections).expect("they are parallel");
        let right = PI * (1.0 * 1.0 + 2.0 * 4.0 + 3.0 * 9.0);
        let own = Cavalieri::new(&stack, &sections, Label(1), right).expect("its area");
        assert!((own.ratio - 1.0).abs() < 1e-4, "{}", own.ratio);
    }

    #[test]
    fn holes_count_for_what_is_in_them_and_the_unknown_for_nothing() {
        let mut sections = discs(&[(0.0, 2.0), (1.0, 2.0), (2.0, 2.0)]);
        for section in &mut sections {
            // A disc of half the radius in the middle is of label 2.
            let inner = disc(section.plane, 1.0, 1000, Label(2));
            let first = section.vertices.len() as u32;
            section.vertices.extend(inner.vertices);
            section.edges.extend(inner.edges.into_iter().map(|edge| crate::section::Edge {
                start: edge.start + first,
                end: edge.end + first,
                right: Label(1),
                ..edge
            }));
        }
        let stack = Stack::new(&sections).expect("they are parallel");
        let volume = |sections: &[Section], label| {
            Cavalieri::new(&stack, sections, label, 1.0).map(|own| own.volume / (3.0 * PI))
        };
        assert!((volume(&sections, Label(1)).expect("known") - 3.0).abs() < 1e-4);
        assert!((volume(&sections, Label(2)).expect("known") - 1.0).abs() < 1e-4);
        sections[1].edges[0].right = Label::UNKNOWN;
        assert_eq!(volume(&sections, Label(1)), None);
        assert!(volume(&sections, Label(2)).is_some());
    }
}
