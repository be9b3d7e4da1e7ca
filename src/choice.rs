//! Which method suits sections, by rules that measurements stand behind (`docs/methods.md`).
//!
//! The variational method is the one that fits all. Where sections are a stack, known all over,
//! whose neighbours overlap much, interpolated distances come as near, in a fraction of the time.

use serde::Serialize;

use crate::bounding::{Faces, bounds_of};
use crate::error::Result;
use crate::grid::lattice::Resolution;
use crate::grid::samples::Lattice;
use crate::method::{Method, ShapeBased, Variational};
use crate::section::{Sections, Stack};
use crate::stack;

/// What neighbouring sections of a stack have in common at least, of their materials' area, for
/// distances to be interpolated.
pub const LEAST_OVERLAP: f64 = 0.9;
/// Fewer parallel sections are no stack.
const FEWEST: usize = 2;

/// A method, and why.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// The method.
    pub method: Suited,
    /// In plain words, each of which can follow "because".
    pub reasons: Vec<String>,
}

/// The methods that are chosen from; each with its default options is a [`Method`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Suited {
    /// [`Method::Variational`].
    Variational,
    /// [`Method::Stack`].
    Stack,
}

impl Suited {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Variational => "variational",
            Self::Stack => "stack",
        }
    }

    /// The method with its default options.
    pub fn method(self) -> Method {
        match self {
            Self::Variational => Method::Variational(Variational::default()),
            Self::Stack => Method::Stack(ShapeBased::default()),
        }
    }
}

/// The method that suits sections on a grid.
///
/// # Errors
/// When there is no contour, or nothing known at all, or there can be no such grid.
pub fn choose(sections: &Sections, resolution: Resolution) -> Result<Choice> {
    let variational =
        |reason: String| Ok(Choice { method: Suited::Variational, reasons: vec![reason] });
    let bounds = bounds_of(sections, None, Faces::Silent)?;
    let all = &sections.sections;
    let mut partial = all.iter().filter(|section| section.is_partial());
    if let Some(first) = partial.next() {
        let (count, first) = (1 + partial.count(), first.name());
        return variational(format!(
            "a part is unknown of {count} of {} sections, of {first} for one",
            all.len()
        ));
    }
    if all.len() < FEWEST {
        return variational("there is one section alone".to_owned());
    }
    let Some(stack) = Stack::of(all, FEWEST) else {
        return variational("sections are not parallel".to_owned());
    };
    let voxel = Lattice::new(bounds, resolution)?.voxel;
    let least = stack.spacings().into_iter().fold(f64::INFINITY, f64::min);
    if least < voxel {
        return variational(format!(
            "neighbouring sections are {least:.4} apart, less than a voxel of {voxel:.4}"
        ));
    }
    let overlap = stack::overlap(all, bounds)?;
    let share = (100.0 * overlap).floor();
    if overlap < LEAST_OVERLAP {
        return variational(format!(
            "neighbouring sections have {share} % of their area in common, less than {} %",
            100.0 * LEAST_OVERLAP
        ));
    }
    let reasons = vec![
        format!("all {} sections are parallel and known all over", all.len()),
        format!("neighbours have {share} % of their area in common"),
    ];
    Ok(Choice { method: Suited::Stack, reasons })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::check::shapes::disc;
    use crate::label::Label;
    use crate::plane::Plane;
    use crate::section::{Rules, Section};

    fn at(normal: DVec3, offset: f64, radius: f64) -> Section {
        disc(Plane { normal, offset }, radius, 48, Label(1))
    }

    fn chosen(sections: Vec<Section>, voxels: u32) -> (Suited, String) {
        let sections = Sections::new(sections, &Rules::default()).expect("sections");
        let choice = choose(&sections, Resolution::Voxels(voxels)).expect("a choice");
        (choice.method, choice.reasons.join(", "))
    }

    /// Discs whose radii fall from 1 by this much from slice to slice.
    fn cone(step: f64) -> Vec<Section> {
        (0..5)
            .map(|slice| at(DVec3::Z, 0.5 * f64::from(slice), 1.0 - step * f64::from(slice)))
            .collect()
    }

    #[test]
    fn slices_that_overlap_much_are_a_stack() {
        let (method, why) = chosen(cone(0.02), 64);
        assert_eq!(method, Suited::Stack, "{why}");
        assert!(why.contains("all 5 sections are parallel") && why.contains("97 %"), "{why}");
        assert_eq!(method.method(), Method::Stack(ShapeBased::default()));
    }

    #[test]
    fn slices_that_overlap_little_are_not() {
        let (method, why) = chosen(cone(0.2), 64);
        assert_eq!(method, Suited::Variational, "{why}");
        assert!(why.contains("in common, less than 90 %"), "{why}");
        // Of another label they have nothing in common.
        let mut other = cone(0.0);
        other[2] = disc(Plane { normal: DVec3::Z, offset: 1.0 }, 1.0, 48, Label(2));
        assert!(chosen(other, 64).1.contains("have 50 %"));
    }

    #[test]
    fn slices_closer_than_voxels_are_not() {
        let (method, why) = chosen(cone(0.02), 5);
        assert_eq!(method, Suited::Variational);
        assert!(why.contains("0.5000 apart, less than a voxel"), "{why}");
    }

    #[test]
    fn what_is_no_stack_is_not() {
        let mut crossing = cone(0.02);
        crossing.push(at(DVec3::X, 0.0, 0.5));
        assert_eq!(chosen(crossing, 64), (Suited::Variational, "sections are not parallel".into()));
        let alone = vec![at(DVec3::Z, 0.0, 1.0)];
        assert_eq!(chosen(alone, 64), (Suited::Variational, "there is one section alone".into()));
        let mut partial = cone(0.02);
        let plane = Plane { normal: DVec3::Z, offset: 3.0 };
        let square = [[0.0, 0.0], [0.5, 0.0], [0.5, 0.5], [0.0, 0.5]];
        let square = square.map(|[x, y]| DVec3::new(x, y, 3.0));
        let hole = Section::builder("hole", plane).region(Label::UNKNOWN, square);
        partial.push(hole.build(&Rules::default()).expect("a section").0);
        let (method, why) = chosen(partial, 64);
        assert_eq!(method, Suited::Variational);
        assert!(why.contains("1 of 6 sections, of hole"), "{why}");
    }

    #[test]
    fn nothing_to_reconstruct_is_an_error() {
        let mut empty = at(DVec3::Z, 0.0, 1.0);
        (empty.vertices, empty.edges) = (Vec::new(), Vec::new());
        let sections = Sections::new(vec![empty], &Rules::default()).expect("sections");
        assert!(choose(&sections, Resolution::Voxels(64)).is_err());
    }
}
