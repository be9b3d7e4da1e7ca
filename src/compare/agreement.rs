//! How two solids agree, in world units.

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::Options;
use super::columns::Grid;
use super::sampling::draw;
use super::solid::Solid;
use super::steps::Part;
use crate::error::{Error, Result};
use crate::mesh::Surface;
use crate::mesh::nearest::Nearest;

/// The part of the distances that `percentile_95` is not below.
const PERCENTILE: f64 = 0.95;
/// Points that are asked for between two steps of the bar.
const BATCH: usize = 1 << 14;
/// The side of a cube of vertices, as a part of the largest distance that is known.
const CUBE: f64 = 0.25;
/// How far the work is when volumes are counted, and when one surface is done.
const COUNTED: f64 = 0.2;
const HALF: f64 = 0.6;

/// How two solids agree.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// Twice the volume in common over the sum of both; 1 when alike.
    pub dice: f64,
    /// The volume in common over that of the union.
    pub iou: f64,
    /// The largest distance from either surface to the other, in world units.
    pub hausdorff: f64,
    /// The larger of the two distances that 95 % of a surface are not beyond.
    pub hausdorff_95: f64,
    /// The mean distance over both surfaces together (average symmetric surface distance).
    pub assd: f64,
    /// The part of both surfaces together that is no farther from the other than a tolerance, if
    /// one is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface_dice: Option<f64>,
    /// From the solid to the reference.
    pub to_reference: Lengths,
    /// From the reference to the solid.
    pub from_reference: Lengths,
    /// Of the solid and the reference, in cubic world units.
    pub volumes: [f64; 2],
    /// Of their surfaces, in square world units.
    pub areas: [f64; 2],
}

/// Distances from one surface to the other, in world units.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Lengths {
    /// The largest, from vertices and drawn points.
    pub max: f64,
    /// 95 % of the surface are no farther, by evenly drawn points.
    pub percentile_95: f64,
    /// The mean over the surface, from the same points.
    pub mean: f64,
}

/// Measures two solids. What they have in common is counted on a grid unless it is known: the
/// volume of that, and of both together.
///
/// # Errors
/// When one of them encloses no volume, and when the work is to end.
pub(super) fn agreement(
    solids: &mut [Solid; 2],
    known: Option<[f64; 2]>,
    options: &Options,
    part: &Part,
    warnings: &mut Vec<String>,
) -> Result<Agreement> {
    let [common, union] = match known {
        Some(known) => known,
        None => common_and_union(solids, options, part, warnings)?,
    };
    part.reach(COUNTED)?;
    let [solid, reference] = &*solids;
    let to = Distances::new(&solid.surface, &reference.surface, options, |share| {
        part.reach(COUNTED + (HALF - COUNTED) * share)
    })?;
    let from = Distances::new(&reference.surface, &solid.surface, options, |share| {
        part.reach(HALF + (1.0 - HALF) * share)
    })?;
    let areas = [solid.area, reference.area];
    let over_both =
        |one: f64, other: f64| (areas[0] * one + areas[1] * other) / (areas[0] + areas[1]);
    let within = |tolerance| over_both(to.within(tolerance), from.within(tolerance));
    Ok(Agreement {
        dice: 2.0 * common / (common + union),
        iou: common / union,
        hausdorff: to.lengths.max.max(from.lengths.max),
        hausdorff_95: to.lengths.percentile_95.max(from.lengths.percentile_95),
        assd: over_both(to.lengths.mean, from.lengths.mean),
        surface_dice: options.tolerance.map(within),
        to_reference: to.lengths,
        from_reference: from.lengths,
        volumes: [solid.volume, reference.volume],
        areas,
    })
}

/// By the voxels of a grid around both whose centres lie inside.
fn common_and_union(
    solids: &mut [Solid; 2],
    options: &Options,
    part: &Part,
    warnings: &mut Vec<String>,
) -> Result<[f64; 2]> {
    let joint = solids[0].bounds.union(solids[1].bounds);
    let grid = Grid::around(&joint, options.grid.max(1));
    let [solid, reference] = solids;
    let inside = solid.columns(&grid, warnings);
    part.reach(0.5 * COUNTED)?;
    let inside = [inside, reference.columns(&grid, warnings)];
    let is_empty = |solid: &&Solid| solid.volume == 0.0 || solid.volume.is_nan();
    if let Some(Solid { name, .. }) = solids.iter().find(is_empty) {
        return Err(Error::Option(format!("the {name} encloses no volume: it must be closed")));
    }
    let (common, union) = inside[0].common_and_union(&inside[1]);
    if union == 0 {
        let what = "both solids are thinner than a voxel everywhere: choose a finer grid";
        return Err(Error::Option(what.into()));
    }
    Ok([common, union].map(|voxels| grid.volume(voxels)))
}

/// Distances from points of a surface to another one.
struct Distances {
    /// From points drawn evenly, sorted.
    drawn: Vec<f64>,
    lengths: Lengths,
}

impl Distances {
    fn new(
        from: &Surface,
        to: &Surface,
        options: &Options,
        reach: impl Fn(f64) -> Result<()>,
    ) -> Result<Self> {
        let nearest = Nearest::on_surface(to)?;
        let points: Vec<DVec3> = draw(from, options.samples.max(1), options.seed);
        let mut drawn = asked(&nearest, &points, |share| reach(0.5 * share))?;
        let most = drawn.iter().copied().fold(0.0, f64::max);
        let max = largest(&nearest, &from.vertices, most, |share| reach(0.5 + 0.5 * share))?;
        let mean = drawn.iter().sum::<f64>() / drawn.len() as f64;
        drawn.sort_unstable_by(f64::total_cmp);
        let place = (PERCENTILE * drawn.len() as f64).ceil() as usize;
        let percentile_95 = drawn[place.clamp(1, drawn.len()) - 1];
        Ok(Self { lengths: Lengths { max, percentile_95, mean }, drawn })
    }

    /// The part of the surface that is no farther than so much.
    fn within(&self, tolerance: f64) -> f64 {
        let count = self.drawn.partition_point(|&distance| distance <= tolerance);
        count as f64 / self.drawn.len() as f64
    }
}

/// The distances of points, in steps.
fn asked(
    nearest: &Nearest,
    points: &[DVec3],
    reach: impl Fn(f64) -> Result<()>,
) -> Result<Vec<f64>> {
    let mut distances = Vec::with_capacity(points.len());
    for batch in points.chunks(BATCH) {
        distances.extend(nearest.distances(batch)?);
        reach(distances.len() as f64 / points.len() as f64)?;
    }
    Ok(distances)
}

/// The largest distance of points, if it is more than one that is known. Points are asked for by
/// cubes: where one of a cube is near, none of the others can be so far.
fn largest(
    nearest: &Nearest,
    points: &[DVec3],
    known: f64,
    reach: impl Fn(f64) -> Result<()>,
) -> Result<f64> {
    let side = CUBE * known;
    let mut keyed: Vec<([i64; 3], DVec3)> = points
        .par_iter()
        .map(|&point| ((point / side).floor().to_array().map(|index| index as i64), point))
        .collect();
    if known > 0.0 {
        keyed.par_sort_by_key(|(cube, _)| *cube);
    }
    let mut most = known;
    let mut done = 0;
    let mut cubes = keyed.chunk_by(|one, other| known > 0.0 && one.0 == other.0).peekable();
    while cubes.peek().is_some() {
        let batch: Vec<&[([i64; 3], DVec3)]> = cubes.by_ref().take(BATCH).collect();
        let firsts: Vec<DVec3> = batch.iter().map(|cube| cube[0].1).collect();
        let found = nearest.distances(&firsts)?;
        most = found.iter().copied().fold(most, f64::max);
        let far = batch.iter().zip(&found).filter(|(cube, distance)| {
            let reach = cube.iter().map(|(_, point)| point.distance(cube[0].1));
            **distance + reach.fold(0.0, f64::max) > most
        });
        let rest: Vec<DVec3> =
            far.flat_map(|(cube, _)| cube[1..].iter().map(|(_, point)| *point)).collect();
        most = asked(nearest, &rest, |_| reach(0.0))?.into_iter().fold(most, f64::max);
        done += batch.iter().map(|cube| cube.len()).sum::<usize>();
        reach(done as f64 / points.len() as f64)?;
    }
    Ok(most)
}
