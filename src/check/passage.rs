//! What becomes of a label's regions between neighbouring sections of a stack:
//! which go on, which end, which begin, and which are torn.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use serde::Serialize;

use super::components::Components;
use super::raster::{Raster, Region};
use crate::label::Label;
use crate::section::{Section, Stack};
use crate::sets::components;

/// Regions of fewer pixels, each a voxel on a side, are too small for the
/// lattice to say what they are joined to.
const SMALLEST: u64 = 16;
/// Two regions that have more than this share of the smaller one in common are
/// seen as one body by any reader.
const SAME_BODY: f64 = 0.5;

/// A label between two neighbouring sections, where its regions do not all go
/// on from one to the other through the solid.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Passage {
    /// The names of the two sections, in the stack's order.
    pub sections: [String; 2],
    /// Regions of the second that are connected to none of the first.
    pub begin: usize,
    /// Regions of the first that are connected to none of the second.
    pub end: usize,
    /// Where a region of either lies over one of the other by more than half of
    /// the smaller, and the two are not connected: one body, as the sections
    /// have it, and torn.
    pub torn: Vec<[f64; 3]>,
}

impl Passage {
    /// "2 pieces begin and 1 ends", and less where there is none of either.
    pub fn in_words(&self) -> String {
        let verb = |count: usize, one: &str, many: &str| match count {
            1 => one.to_owned(),
            _ => many.to_owned(),
        };
        let Self { begin, end, .. } = *self;
        let pieces = |count: usize| verb(count, "piece", "pieces");
        let (begins, ends) = (verb(begin, "begins", "begin"), verb(end, "ends", "end"));
        match (begin, end) {
            (0, 0) => String::new(),
            (_, 0) => format!("{begin} {} {begins}", pieces(begin)),
            (0, _) => format!("{end} {} {ends}", pieces(end)),
            _ => format!("{begin} {} {begins} and {end} {ends}", pieces(begin)),
        }
    }
}

/// The passages of each label, in the stack's order. `labels` are sorted;
/// `parts` are those between the stack's sections.
pub fn passages(
    stack: &Stack,
    sections: &[Section],
    parts: &Components,
    rasters: &[Raster],
    labels: &[Label],
) -> Vec<Vec<Passage>> {
    let gaps: Vec<BTreeMap<Label, Gap>> = (1..stack.order.len())
        .into_par_iter()
        .map(|upper| {
            let both = [upper - 1, upper].map(|place| &rasters[stack.order[place]]);
            gap(both, parts, upper as u32)
        })
        .collect();
    let mut found = vec![Vec::new(); labels.len()];
    for (lower, gap) in gaps.into_iter().enumerate() {
        let name = |place: usize| sections[stack.order[place]].name().to_owned();
        for (label, Gap { begin, end, torn }) in gap {
            let Ok(own) = labels.binary_search(&label) else { continue };
            let sections = [name(lower), name(lower + 1)];
            found[own].push(Passage { sections, begin, end, torn });
        }
    }
    found
}

/// What does not go on between two sections.
#[derive(Debug, Default)]
struct Gap {
    begin: usize,
    end: usize,
    torn: Vec<[f64; 3]>,
}

/// What does not go on through a slab from the lower section to the upper.
fn gap(rasters: [&Raster; 2], parts: &Components, slab: u32) -> BTreeMap<Label, Gap> {
    let [lower, upper] = grouped(rasters, parts, slab);
    let mut gaps: BTreeMap<Label, Gap> = BTreeMap::new();
    let lonely = |own: &[Grouped], other: &[Grouped]| -> Vec<Label> {
        // A region too small to count may be what another one goes on to.
        let reached: BTreeSet<u32> = other.iter().map(|other| other.group).collect();
        let lonely = own.iter().filter(|own| own.counts && !reached.contains(&own.group));
        lonely.map(|own| own.region.label).collect()
    };
    lonely(&lower, &upper).into_iter().for_each(|label| gaps.entry(label).or_default().end += 1);
    lonely(&upper, &lower).into_iter().for_each(|label| gaps.entry(label).or_default().begin += 1);
    for ([below, above], pixels) in rasters[0].overlaps(rasters[1]) {
        let pair = [&lower[below as usize], &upper[above as usize]];
        if pair.iter().all(|one| one.counts) && is_torn(pair, pixels) {
            let [one, other] = pair.map(|one| one.region);
            let smaller = if one.pixels <= other.pixels { one } else { other };
            gaps.entry(one.label).or_default().torn.push(smaller.at.to_array());
        }
    }
    gaps
}

/// Whether two regions are apart that have so many pixels in common.
fn is_torn([one, other]: [&Grouped; 2], pixels: u64) -> bool {
    let smaller = one.region.pixels.min(other.region.pixels);
    one.group != other.group && pixels as f64 > SAME_BODY * smaller as f64
}

/// A region and what it is connected to.
struct Grouped {
    region: Region,
    /// The number of its group: the regions of one group are connected through
    /// the slab.
    group: u32,
    /// Whether the lattice can tell: the region is large enough, and the solid
    /// has it.
    counts: bool,
}

/// The regions of both sections of a slab.
fn grouped(rasters: [&Raster; 2], parts: &Components, slab: u32) -> [Vec<Grouped>; 2] {
    let regions = rasters.map(Raster::regions);
    let firsts = [0, regions[0].len() as u32];
    let count = (regions[0].len() + regions[1].len()) as u32;
    let touched: Vec<[u32; 2]> = [0, 1]
        .into_iter()
        .flat_map(|side| {
            let pairs = touched_parts(rasters[side], parts, slab).into_iter();
            pairs.map(move |[region, part]| [firsts[side] + region, part])
        })
        .collect();
    let mut present = vec![false; count as usize];
    touched.iter().for_each(|&[region, _]| present[region as usize] = true);
    let pairs = touched.iter().map(|&[region, part]| [region, count + part]);
    let groups = components(count + parts.count() as u32, pairs);
    let mut numbers = 0..count as usize;
    regions.map(|regions| {
        let grouped = regions.into_iter().zip(&mut numbers).map(|(region, number)| Grouped {
            region,
            group: groups[number],
            counts: present[number] && region.pixels >= SMALLEST,
        });
        grouped.collect()
    })
}

/// Which regions have nodes of which parts of a slab around their pixels, as
/// pairs, each once.
fn touched_parts(raster: &Raster, parts: &Components, slab: u32) -> Vec<[u32; 2]> {
    let mut touched = Vec::new();
    for (region, label, point) in raster.pixels() {
        for (kind, part) in parts.around(point) {
            let pair = [region, part];
            if kind.label == label && kind.slab == slab && touched.last() != Some(&pair) {
                touched.push(pair);
            }
        }
    }
    touched.sort_unstable();
    touched.dedup();
    touched
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::check::shapes::disc;
    use crate::grid::labels::LabelGrid;
    use crate::grid::samples::Lattice;
    use crate::mesh::shapes::samples;
    use crate::plane::Plane;

    /// What a solid in [−1, 1]³ makes of its own sections at heights, by its
    /// radius there.
    fn found(
        inside: impl Fn(DVec3) -> bool,
        sections: &[Section],
    ) -> Vec<([String; 2], usize, usize, usize)> {
        let voxel = 0.04;
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel, dims: [51; 3] };
        let value = |node| vec![if inside(lattice.position(node)) { 0.5 } else { -0.5 }];
        let labels = LabelGrid::new(&samples(lattice, value));
        let stack = Stack::new(sections).expect("they are parallel");
        let raster = |section| Raster::new(section, stack.direction, lattice.origin, voxel);
        let rasters: Vec<Raster> = sections.iter().map(raster).collect();
        let parts = Components::between(&labels, &stack);
        let found = passages(&stack, sections, &parts, &rasters, &[Label(1)]);
        let short =
            |passage: Passage| (passage.sections, passage.begin, passage.end, passage.torn.len());
        found.into_iter().flatten().map(short).collect()
    }

    fn circle(z: f64, radius: f64) -> Section {
        let plane = Plane { normal: DVec3::Z, offset: z };
        let mut section = disc(plane, radius, 100, Label(1));
        section.name = format!("{z}");
        section
    }

    fn between(one: &str, other: &str) -> [String; 2] {
        [one.to_owned(), other.to_owned()]
    }

    #[test]
    fn one_ball_goes_on_and_begins_and_ends_where_a_section_misses_it() {
        let ball = |point: DVec3| point.length() < 0.6;
        let radius = |z: f64| (0.36 - z * z).sqrt();
        let own = |z: f64| circle(z, radius(z));
        assert_eq!(found(ball, &[own(-0.41), own(0.01), own(0.41)]), []);
        let mut sections = vec![own(-0.41), own(0.01), own(0.41)];
        for z in [-0.81, 0.81] {
            let mut empty = circle(z, 1.0);
            (empty.vertices, empty.edges) = (Vec::new(), Vec::new());
            sections.push(empty);
        }
        let right = [(between("-0.81", "-0.41"), 1, 0, 0), (between("0.41", "0.81"), 0, 1, 0)];
        assert_eq!(found(ball, &sections), right);
    }

    #[test]
    fn two_balls_of_one_body_are_torn() {
        // Balls of radius 0.42 around (0, 0, ± 0.45): 0.06 apart. Their sections
        // are at ± 0.61, and at ± 0.31, where each has the radius 0.396 and they lie
        // over each other whole: one ends, one begins, and that is a tear.
        let balls =
            |point: DVec3| [-0.45, 0.45].iter().any(|&z| (point - z * DVec3::Z).length() < 0.42);
        let radius = |z: f64| (0.1764 - (z.abs() - 0.45f64).powi(2)).sqrt();
        let sections = [-0.61, -0.31, 0.31, 0.61].map(|z| circle(z, radius(z)));
        assert_eq!(found(balls, &sections), [(between("-0.31", "0.31"), 1, 1, 1)]);
        // Joined by a thin bar they are one.
        let dumbbell = |point: DVec3| balls(point) || point.truncate().length() < 0.1;
        assert_eq!(found(dumbbell, &sections), []);
    }

    #[test]
    fn regions_side_by_side_end_and_begin_without_a_tear() {
        // A ball below on the left, one above on the right.
        let at = [DVec3::new(-0.5, 0.0, -0.4), DVec3::new(0.5, 0.0, 0.4)];
        let balls = |point: DVec3| at.iter().any(|&at| (point - at).length() < 0.38);
        let moved = |z: f64, x: f64, radius: f64| {
            let mut section = circle(z, radius);
            section.vertices.iter_mut().for_each(|vertex| vertex.x += x);
            section
        };
        let sections = [
            moved(-0.41, -0.5, 0.379),
            moved(-0.21, -0.5, 0.328),
            moved(0.21, 0.5, 0.328),
            moved(0.41, 0.5, 0.379),
        ];
        assert_eq!(found(balls, &sections), [(between("-0.21", "0.21"), 1, 1, 0)]);
    }

    #[test]
    fn pieces_are_counted_in_words() {
        let said = |begin, end| {
            let sections = [String::new(), String::new()];
            Passage { sections, begin, end, torn: Vec::new() }.in_words()
        };
        assert_eq!(said(2, 1), "2 pieces begin and 1 ends");
        assert_eq!(said(1, 2), "1 piece begins and 2 end");
        assert_eq!(said(0, 3), "3 pieces end");
        assert_eq!(said(1, 0), "1 piece begins");
        assert_eq!(said(0, 0), "");
    }
}
