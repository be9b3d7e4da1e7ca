//! The oracle: the label of the nearest known point of all sections.
//!
//! On full sections this is what Barequet and Vaxman's reconstruction says of
//! every point; where parts are unknown, the segment from a point to its
//! nearest known point still crosses no section. It needs no cells and no mesh,
//! and every answer is exact: floats with bounds on their errors decide what
//! they can, rationals the rest.
//!
//! For a section known all over, the nearest point is the foot on its plane.
//! For others it is the foot where that is known, and else a point of the edges
//! between known and unknown. Whole planes are asked, not only their parts in
//! the box. If the box's faces are known to be outside that makes no difference:
//! on the way to a point beyond the box there is a face, which is nearer. If
//! they are not, then what sections know beyond the box is known all the same.

mod border;
mod candidate;
mod certainty;
mod distances;
mod exact;
mod float;
mod foot;
mod sampled;
mod site;
mod tree;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::Section;

use border::Border;
use candidate::Candidate;
use certainty::Walls;
use exact::{Number, Query};
use float::Range;
use site::Site;

pub use certainty::Certainty;

/// Sections, made ready to be asked for the label of any point.
pub struct Oracle<'a> {
    /// As many as there are sections.
    sites: Vec<Site<'a>>,
    bounds: Bounds,
    border: Option<Border>,
    /// What is known anywhere, sorted.
    labels: Vec<Label>,
    walls: Walls,
}

/// The nearest known point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// What is there. Of several labels that meet in the point, or in several
    /// points of one section that are equally near, the smallest.
    pub label: Label,
    /// Index of its section; `None` for the box. Of several sections that are
    /// equally near the first, and the box last.
    pub section: Option<u32>,
    /// How far away it is, in world units, rounded.
    pub distance: f64,
    /// Where it is, rounded.
    pub foot: DVec3,
}

/// The nearest point of a section, or of the box.
type Found = (Option<u32>, Candidate);

impl<'a> Oracle<'a> {
    /// Of sections in a box. The box's faces, and all beyond them, are known to
    /// be `border`, unless that is [`Label::UNKNOWN`].
    ///
    /// # Errors
    /// Where nothing is known at all.
    pub fn new(sections: &'a [Section], bounds: Bounds, border: Label) -> Result<Self> {
        let sites: Vec<Site> = sections.par_iter().map(Site::new).collect();
        let border = (border != Label::UNKNOWN).then_some(Border { bounds, label: border });
        let known = sites.iter().flat_map(|site| site.labels.iter().copied());
        let mut labels: Vec<Label> = known.chain(border.map(|border| border.label)).collect();
        labels.sort_unstable();
        labels.dedup();
        if labels.is_empty() {
            return Err(Error::Option(
                "everything is unknown: no section says of any place what is there; add what is \
                 known"
                    .to_owned(),
            ));
        }
        let walls = Walls::new(&sites, bounds, border.is_some());
        Ok(Self { sites, bounds, border, labels, walls })
    }

    /// The known point that is nearest to a finite point.
    pub fn nearest(&self, point: DVec3) -> Nearest {
        if let Some(beyond) = self.border.and_then(|border| border.beyond(point)) {
            return beyond;
        }
        let query = Query::new(point);
        let mut found = self.candidates(&query);
        if found.is_empty() {
            // Nothing is near to what is not a number.
            let (label, distance) = (Label::UNKNOWN, f64::NAN);
            return Nearest { label, section: None, distance, foot: point };
        }
        let first = if found.len() > 1 { self.exactly_nearest(&found, &query) } else { 0 };
        let (section, candidate) = found.swap_remove(first);
        let (label, foot) = match section {
            Some(section) => self.sites[section as usize].resolve(&candidate, &query),
            None => (candidate.label.unwrap_or(Label::OUTSIDE), candidate.place),
        };
        Nearest { label, section, distance: candidate.distance.value, foot }
    }

    /// The labels of many points.
    pub fn labels(&self, points: &[DVec3]) -> Vec<Label> {
        points.par_iter().map(|&point| self.nearest(point).label).collect()
    }

    /// The nearest points of the sections that floats cannot tell to be farther
    /// than another, in the sections' order, then the box.
    fn candidates(&self, query: &Query) -> Vec<Found> {
        let border = self.border.map(|border| border.candidate(query.point));
        let mut limit = border.as_ref().map_or(f64::INFINITY, |border| border.distance.high);
        let mut heights: Vec<(Range, u32)> = Vec::with_capacity(self.sites.len());
        for (number, site) in self.sites.iter().enumerate() {
            let height = site.plane.distance(query.point);
            if site.is_full {
                limit = limit.min(height.high);
            }
            heights.push((height, number as u32));
        }
        heights.retain(|(height, _)| height.low <= limit);
        heights.sort_by(|one, other| one.0.low.total_cmp(&other.0.low));
        let mut found: Vec<Found> = Vec::new();
        for (height, number) in heights {
            if height.low > limit {
                break;
            }
            if let Some(candidate) = self.sites[number as usize].candidate(query, height, limit) {
                limit = limit.min(candidate.distance.high);
                found.push((Some(number), candidate));
            }
        }
        found.extend(border.map(|border| (None, border)));
        found.retain(|(_, candidate)| candidate.distance.low <= limit);
        found.sort_by_key(|(section, _)| section.map_or(u32::MAX, |section| section));
        found
    }

    /// The first of the candidates that are nearest, in rationals.
    fn exactly_nearest(&self, found: &[Found], query: &Query) -> usize {
        let square = |(section, candidate): &Found| match section {
            Some(section) => self.sites[*section as usize].squared_distance(candidate, query),
            None => self.border.map_or(Number::ZERO, |border| border.squared_distance(query.point)),
        };
        let nearest = found.iter().map(square).enumerate().min_by(|one, other| one.1.cmp(&other.1));
        nearest.map_or(0, |(first, _)| first)
    }
}

#[cfg(test)]
mod tests;
