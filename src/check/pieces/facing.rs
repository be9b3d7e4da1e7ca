//! Regions of one label that face each other.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::check::raster::{Raster, Region};
use crate::label::Label;
use crate::section::Section;

/// From so many points of a region it is looked what is opposite.
const POINTS: u64 = 64;
/// The cosine of the largest angle between planes that face each other.
const FACING: f64 = 0.5;
/// More than this part of either sees the other.
const SHARE: f64 = 0.5;

/// The pairs of regions of different sections among some that face each other, by section and
/// region: in a stack however far away, else no farther than either is wide.
pub fn facing(
    sections: &[Section],
    rasters: &[Raster],
    among: &[usize],
    is_stack: bool,
) -> Vec<[[u32; 2]; 2]> {
    let look = |&section: &usize| Look { sections, rasters, among, section, is_stack }.seen();
    let seen: Vec<_> = among.par_iter().flat_map_iter(look).collect();
    let mut pairs: Vec<[[u32; 2]; 2]> =
        seen.into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// From one section to the others.
struct Look<'a> {
    sections: &'a [Section],
    rasters: &'a [Raster],
    among: &'a [usize],
    section: usize,
    is_stack: bool,
}

impl Look<'_> {
    /// What most of every region of this section sees.
    fn seen(&self) -> Vec<[[u32; 2]; 2]> {
        let raster = &self.rasters[self.section];
        let regions = raster.regions();
        let mut passed = vec![0u64; regions.len()];
        let mut asked = vec![0u64; regions.len()];
        let mut votes: BTreeMap<[[u32; 2]; 2], u64> = BTreeMap::new();
        let normal = self.sections[self.section].plane().unit_normal();
        for (region, _, point) in raster.pixels() {
            let own = &regions[region as usize];
            let every = own.pixels.div_ceil(POINTS);
            passed[region as usize] += 1;
            if !passed[region as usize].is_multiple_of(every) {
                continue;
            }
            asked[region as usize] += 1;
            let width = self.width(own);
            for direction in [normal, -normal] {
                if let Some(seen) = self.next(point, direction, own.label, width) {
                    *votes.entry([[self.section as u32, region], seen]).or_default() += 1;
                }
            }
        }
        let is_most = |&([own, _], votes): &([[u32; 2]; 2], u64)| {
            votes as f64 > SHARE * asked[own[1] as usize] as f64
        };
        votes.into_iter().filter(is_most).map(|(pair, _)| pair).collect()
    }

    /// How far a region looks: as far as a disc of its area is wide.
    fn width(&self, region: &Region) -> f64 {
        if self.is_stack {
            return f64::INFINITY;
        }
        let pixel = self.rasters[self.section].pixel();
        2.0 * pixel * (region.pixels as f64 / PI).sqrt()
    }

    /// The region of a label that is next from a point along a direction, before anything else is
    /// known.
    fn next(&self, from: DVec3, along: DVec3, label: Label, width: f64) -> Option<[u32; 2]> {
        let meet = |&other: &usize| {
            let section = &self.sections[other];
            let slope = section.plane().unit_normal().dot(along);
            let distance = -section.plane().distance(from) / slope;
            let is_ahead = other != self.section && distance > 0.0 && distance <= width;
            is_ahead.then_some((distance, slope.abs(), other))
        };
        let mut met: Vec<_> = self.among.iter().filter_map(meet).collect();
        met.sort_by(|one, other| one.0.total_cmp(&other.0));
        let (distance, slope, other) = met.into_iter().find(|&(distance, _, other)| {
            let section = &self.sections[other];
            let there = from + distance * along;
            !section.is_partial()
                || section.label_at(section.plane().project(there)) != Label::UNKNOWN
        })?;
        let (region, found) = self.rasters[other].region_at(from + distance * along)?;
        (found == label && slope >= FACING).then_some([other as u32, region])
    }
}
