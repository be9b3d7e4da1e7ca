//! Makes parts of sections unknown, for experiments: random blobs (Bermano,
//! Fig. 14), and frames beyond which nothing is known.

mod blobs;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::Plane;
use crate::random::Random;
use crate::section::{COVERED, Edge, Rectangle, Rules, Section, Sections};

/// Smooth random blobs, different ones on every section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blobs {
    /// The part of a section's rectangle that they cover, in (0, 1).
    pub fraction: f64,
    /// Their size: the wavelength of the field they are cut from, relative to
    /// the longer side of the rectangle; in [0.02, 1].
    pub size: f64,
    /// What they are drawn from.
    pub seed: u64,
}

/// What becomes unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Mask {
    /// Blobs within the rectangle around each section's contours.
    pub blobs: Option<Blobs>,
    /// All beyond a frame of this width and height around the middle of each
    /// section's contours, in world units; sides as [`Plane::sides`].
    pub frame: Option<[f64; 2]>,
}

/// The sections with parts made unknown; what was unknown stays so. Sections
/// without contours have no blobs, and their frame lies where the plane is
/// nearest to the middle of all sections.
///
/// # Errors
/// When a number of the mask is out of range, or a stage fails.
pub fn mask(mut sections: Sections, mask: &Mask) -> Result<Sections> {
    check(mask)?;
    let middle = sections.bounds().map_or(DVec3::ZERO, |bounds| bounds.middle());
    let mut seeds = Random::new(mask.blobs.map_or(0, |blobs| blobs.seed));
    let all: Vec<(u64, Section)> =
        std::mem::take(&mut sections.sections).into_iter().map(|one| (seeds.bits(), one)).collect();
    sections.sections = all
        .into_par_iter()
        .map(|(seed, section)| masked(section, mask, seed, middle))
        .collect::<Result<_>>()?;
    let materials = std::mem::take(&mut sections.materials);
    sections.name_materials(materials);
    Ok(sections)
}

fn check(mask: &Mask) -> Result<()> {
    let error = |what: String| Err(Error::Option(what));
    if let Some(Blobs { fraction, size, .. }) = mask.blobs {
        if !(fraction > 0.0 && fraction < 1.0) {
            return error(format!("blobs cannot cover {fraction}: give a part between 0 and 1"));
        }
        if !(0.02..=1.0).contains(&size) {
            return error(format!("blobs cannot have the size {size}: give one from 0.02 to 1"));
        }
    }
    match mask.frame {
        Some([width, height]) if !(positive(width) && positive(height)) => {
            error(format!("a frame cannot be {width} × {height}: both must be positive"))
        }
        _ => Ok(()),
    }
}

fn positive(length: f64) -> bool {
    length.is_finite() && length > 0.0
}

/// One section; the frame's place is that of the contours before blobs.
fn masked(section: Section, mask: &Mask, seed: u64, middle: DVec3) -> Result<Section> {
    let rectangle = section.rectangle();
    let mut found = section;
    if let (Some(blobs), Some(rectangle)) = (&mask.blobs, &rectangle) {
        found = found.without(&blobs::blobs(found.plane(), rectangle, blobs, seed)?)?;
    }
    if let Some(size) = mask.frame {
        found = found.without(&beyond(found.plane(), rectangle, middle, size)?)?;
    }
    Ok(found)
}

/// All of a plane but a frame.
fn beyond(
    plane: &Plane,
    rectangle: Option<Rectangle>,
    middle: DVec3,
    size: [f64; 2],
) -> Result<Section> {
    let rectangle = rectangle.unwrap_or_else(|| {
        let origin = middle - plane.distance(middle) * plane.unit_normal();
        Rectangle { origin, sides: plane.sides(), min: DVec2::ZERO, max: DVec2::ZERO }
    });
    let (center, half) = (rectangle.min.midpoint(rectangle.max), DVec2::from_array(size) / 2.0);
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let points = corners.map(|corner| rectangle.point(center + half * DVec2::from_array(corner)));
    let edges: Vec<Edge> = (0..4)
        .map(|i| Edge { start: i, end: (i + 1) % 4, left: Label::OUTSIDE, right: COVERED })
        .collect();
    cover(plane, &points, &edges)
}

/// A mask from a graph on a plane.
fn cover(plane: &Plane, points: &[DVec3], edges: &[Edge]) -> Result<Section> {
    let diagonal = crate::plane::Bounds::around(points.iter().copied());
    let diagonal = diagonal.map_or(0.0, |bounds| bounds.diagonal());
    // Nobody is told of what is doubtful.
    let rules = Rules { strict: true, ..Rules::default() };
    Section::from_graph("mask", *plane, points, edges, diagonal, &rules).map(|(section, _)| section)
}

#[cfg(test)]
mod tests;
