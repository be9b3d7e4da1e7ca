//! Whether a label hangs together as its sections show it.
//!
//! A region of a section is one, and should be so in the solid; where it is joined in a corner
//! alone it is two. Two regions of one label on
//! different sections belong together where their planes cross in both, and where they face each
//! other: from one of them, across its plane, the next section that knows what is there shows the
//! other, for more than half of either, and no farther away than it is wide. That is what sections
//! show; where the solid has pieces apart, it is torn.

mod facing;
mod numbered;

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::raster::{Common, Raster, Region};
use crate::label::Label;
use crate::mesh::Mesh;
use crate::section::{Section, Stack, in_common};
use crate::sets::Sets;
use facing::facing;
use numbered::Numbered;

/// Regions, and parts of them, of less than so many voxels' faces are too small for the lattice to
/// say what they are joined to.
const SMALLEST: f64 = 16.0;
/// A stretch of so many voxels that two sections have in common joins them.
const STRETCH: f64 = 4.0;

/// In how many pieces a label comes out, where sections pass through them.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Pieces {
    /// Pieces of the solid with regions of sections in them.
    pub found: usize,
    /// What of these regions hangs together as the sections show it.
    pub shown: usize,
    /// Where that is not so.
    pub torn: Vec<Tear>,
    /// Sections of a stack whose own regions hang together with neither neighbour's, where these
    /// face each other past it and are apart, too: by the names of the three.
    pub out_of_place: Vec<Tear>,
}

/// Where a label is torn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tear {
    /// The names of the sections between which it is, or of the one on which it is.
    pub sections: Vec<String>,
    /// A place in what is apart.
    pub at: [f64; 3],
}

/// A region of a section that is large enough, in a solid that has it.
struct Part {
    section: u32,
    region: Region,
    /// The pieces of the solid that it has pixels of.
    touched: BTreeSet<Label>,
    /// Those that have enough of them, and where.
    pieces: Vec<(Label, Common)>,
}

/// What there is to look at.
pub struct Scene<'a> {
    /// The sections.
    pub sections: &'a [Section],
    /// The solid.
    pub mesh: &'a Mesh,
    /// What pixels count from.
    pub origin: DVec3,
    /// World units.
    pub voxel: f64,
    /// The stack that the sections are: what is torn between its neighbours is known already.
    pub stack: Option<&'a Stack>,
}

/// Parts, and where they are among all by section and region.
#[derive(Default)]
struct Parts {
    all: Vec<Part>,
    numbers: BTreeMap<[u32; 2], usize>,
}

impl Parts {
    /// Those of a pair of regions, if both are there.
    fn of(&self, pair: &[[u32; 2]; 2]) -> Option<[usize; 2]> {
        let [one, other] = pair.map(|own| self.numbers.get(&own).copied());
        Some([one?, other?])
    }

    fn on(&self, section: usize) -> impl Iterator<Item = &Part> {
        let numbers = self.numbers.range([section as u32, 0]..[section as u32 + 1, 0]);
        numbers.map(|(_, &number)| &self.all[number])
    }
}

impl Scene<'_> {
    /// The pieces of labels; `pixel` is the side of a pixel on a section.
    pub fn pieces(
        &self,
        labels: &[Label],
        pixel: impl Fn(&Section) -> f64 + Sync,
    ) -> BTreeMap<Label, Pieces> {
        if labels.is_empty() {
            return BTreeMap::new();
        }
        let numbered = Numbered::new(self.mesh, labels);
        let raster = |section: &Section| {
            let direction = section.plane().unit_normal();
            Raster::new(section, direction, self.origin, pixel(section)).joined_by_sides()
        };
        let rasters: Vec<Raster> = self.sections.par_iter().map(raster).collect();
        let of_section = |(number, raster): (usize, &Raster)| {
            let plane = self.sections[number].plane();
            let smallest = SMALLEST * (self.voxel / pixel(&self.sections[number])).powi(2);
            let cut = raster.of_cut(&numbered.mesh.cut(plane));
            let common = raster.common(&cut);
            let touching = cut.neighbors();
            let part = |(region, own): (usize, Region)| {
                let of = (region as u32, Label::OUTSIDE)..(region as u32 + 1, Label::OUTSIDE);
                let pieces = common.range(of).map(|(&(_, piece), &common)| (piece, common));
                let pieces: Vec<_> =
                    pieces.filter(|&(piece, _)| numbered.label(piece) == own.label).collect();
                let touched = pieces.iter().map(|&(piece, _)| piece).collect();
                let is_enough = |(_, common): &(Label, Common)| common.pixels as f64 >= smallest;
                // Pieces that touch are apart on the section, too, or as good as joined.
                let mut apart: Vec<(Label, Common)> = Vec::new();
                for (piece, common) in pieces.into_iter().filter(is_enough) {
                    let touches = |&(other, _): &(Label, Common)| {
                        touching.contains(&[piece.min(other), piece.max(other)])
                    };
                    if !apart.iter().any(touches) {
                        apart.push((piece, common));
                    }
                }
                let pieces = apart;
                let part = Part { section: number as u32, region: own, touched, pieces };
                (!part.pieces.is_empty()).then_some(part)
            };
            raster.regions().into_iter().enumerate().map(part).collect::<Vec<_>>()
        };
        let by_section: Vec<Vec<Option<Part>>> =
            rasters.par_iter().enumerate().map(of_section).collect();
        let mut parts = Parts::default();
        for (section, own) in by_section.into_iter().enumerate() {
            for (region, part) in own.into_iter().enumerate().filter_map(|(i, own)| Some((i, own?)))
            {
                parts.numbers.insert([section as u32, region as u32], parts.all.len());
                parts.all.push(part);
            }
        }
        self.compared(labels, &rasters, &parts)
    }

    /// What came out against what belongs together.
    fn compared(
        &self,
        labels: &[Label],
        rasters: &[Raster],
        parts: &Parts,
    ) -> BTreeMap<Label, Pieces> {
        let everything: Vec<usize> = (0..self.sections.len()).collect();
        let facing = facing(self.sections, rasters, &everything, self.stack.is_some());
        let facing: Vec<_> = facing.iter().filter_map(|pair| parts.of(pair)).collect();
        let crossing = self.crossing(rasters);
        let crossing: Vec<_> = crossing.iter().filter_map(|pair| parts.of(pair)).collect();
        let mut sets = Sets::new(parts.all.len());
        let mut found: BTreeMap<Label, Pieces> =
            labels.iter().map(|&label| (label, Pieces::default())).collect();
        for &[one, other] in crossing.iter().chain(&facing) {
            sets.join(one as u32, other as u32);
        }
        let told = if self.stack.is_some() { &[][..] } else { &facing[..] };
        for pair in crossing.iter().chain(told) {
            let [one, other] = pair.map(|part| &parts.all[part]);
            if let Some(own) = found.get_mut(&one.region.label)
                && one.touched.is_disjoint(&other.touched)
            {
                own.torn.push(self.tear(&[one, other], smaller([one, other]).region.at));
            }
        }
        for part in &parts.all {
            let least = part.pieces.iter().min_by_key(|(_, common)| common.pixels);
            if let (Some((_, common)), Some(own)) = (least, found.get_mut(&part.region.label))
                && part.pieces.len() > 1
            {
                own.torn.push(self.tear(&[part], common.at));
            }
        }
        for (&label, own) in &mut found {
            let of_label =
                || parts.all.iter().enumerate().filter(|(_, part)| part.region.label == label);
            let pieces = of_label().flat_map(|(_, part)| part.pieces.iter().map(|own| own.0));
            own.found = pieces.collect::<BTreeSet<_>>().len();
            let shown: BTreeSet<u32> =
                of_label().map(|(number, _)| sets.root(number as u32)).collect();
            own.shown = shown.len();
        }
        self.misplaced(rasters, parts, &mut found);
        found
    }

    /// Sections of a stack that stand between regions which face each other past them.
    fn misplaced(&self, rasters: &[Raster], parts: &Parts, found: &mut BTreeMap<Label, Pieces>) {
        let order = self.stack.map_or(&[][..], |stack| &stack.order);
        for three in order.windows(3) {
            let [before, own, after] = [three[0], three[1], three[2]];
            let around = facing(self.sections, rasters, &[before, after], true);
            for pair in around.iter().filter_map(|pair| parts.of(pair)) {
                let pair = pair.map(|part| &parts.all[part]);
                let [one, other] = pair;
                if !one.touched.is_disjoint(&other.touched) {
                    continue;
                }
                let beside = || parts.on(before).chain(parts.on(after));
                let is_lonely =
                    |own: &&Part| beside().all(|other| other.touched.is_disjoint(&own.touched));
                let is_alike = |own: &&Part| {
                    own.region.label == one.region.label
                        && 2 * own.region.pixels >= smaller(pair).region.pixels
                };
                let lonely = parts.on(own).filter(is_alike).find(is_lonely);
                if let (Some(lonely), Some(pieces)) = (lonely, found.get_mut(&one.region.label)) {
                    pieces.out_of_place.push(self.tear(&[one, lonely, other], lonely.region.at));
                }
            }
        }
    }

    /// The regions of sections that cross in both of them, by section and region.
    fn crossing(&self, rasters: &[Raster]) -> Vec<[[u32; 2]; 2]> {
        let count = self.sections.len();
        let of_pair = |[i, j]: [usize; 2]| {
            let stretches = in_common(&self.sections[i], &self.sections[j]).into_iter();
            let long = stretches.filter(|&(_, length, _)| length >= STRETCH * self.voxel);
            long.filter_map(move |(middle, _, _)| {
                let at = |own: usize| Some([own as u32, rasters[own].region_at(middle)?.0]);
                let [one, other] = [at(i), at(j)];
                Some([one?, other?])
            })
            .collect::<Vec<_>>()
        };
        let pairs = (0..count).into_par_iter();
        let pairs = pairs.flat_map_iter(|i| (i + 1..count).map(move |j| [i, j]));
        pairs.flat_map_iter(of_pair).collect()
    }

    fn tear(&self, parts: &[&Part], at: DVec3) -> Tear {
        let name = |part: &&Part| self.sections[part.section as usize].name().to_owned();
        Tear { sections: parts.iter().map(name).collect(), at: at.to_array() }
    }
}

fn smaller([one, other]: [&Part; 2]) -> &Part {
    if one.region.pixels <= other.region.pixels { one } else { other }
}

#[cfg(test)]
mod tests;
