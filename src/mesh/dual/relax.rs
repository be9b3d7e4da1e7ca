//! Better shaped triangles: points slide along the surface towards the middle
//! of their neighbours.

use glam::DVec3;
use rayon::prelude::*;

use super::polygon::Polygons;
use crate::label::Label;

/// How often.
const STEPS: usize = 3;
/// How much of the way at once.
const FACTOR: f64 = 0.5;
/// How far points stay away from the faces of their cells, in voxels.
const MARGIN: f64 = 0.02;

/// What the polygons around a point say about it.
#[derive(Clone, Copy)]
struct Around {
    neighbours: DVec3,
    count: f64,
    normal: DVec3,
    /// The labels on the two sides of all polygons so far.
    sides: Option<[Label; 2]>,
    /// Whether polygons differ in their sides: then it lies on a junction.
    junction: bool,
}

const NOTHING: Around = Around {
    neighbours: DVec3::ZERO,
    count: 0.0,
    normal: DVec3::ZERO,
    sides: None,
    junction: false,
};

/// Moves the first `lows.len()` points, each within its cell, whose first node
/// `lows` has. Points on junctions, of larger polygons and in cells that
/// `fixed` says yes to stay.
pub fn relax(
    points: &mut [DVec3],
    lows: &[DVec3],
    polygons: &[Polygons],
    fixed: impl Fn(DVec3) -> bool + Sync,
) {
    for _ in 0..STEPS {
        let around = surroundings(points, polygons);
        points[..lows.len()].par_iter_mut().zip(lows).zip(&around).for_each(
            |((point, low), around)| {
                let normal = around.normal.normalize_or_zero();
                let stays = around.junction || around.count == 0.0 || fixed(*low);
                if stays || normal == DVec3::ZERO {
                    return;
                }
                let pull = around.neighbours / around.count - *point;
                let slide = FACTOR * pull.reject_from_normalized(normal);
                *point = (*point + slide).clamp(*low + MARGIN, *low + (1.0 - MARGIN));
            },
        );
    }
}

/// In the order of the polygons, so that sums do not depend on threads.
fn surroundings(points: &[DVec3], polygons: &[Polygons]) -> Vec<Around> {
    let mut around = vec![NOTHING; points.len()];
    for polygons in polygons {
        for (corners, sides) in &polygons.quads {
            let place = corners.map(|corner| points[corner as usize]);
            let normal = (place[2] - place[0]).cross(place[3] - place[1]);
            for corner in 0..4 {
                let entry = &mut around[corners[corner] as usize];
                entry.neighbours += place[(corner + 1) % 4] + place[(corner + 3) % 4];
                entry.count += 2.0;
                entry.normal += normal;
                entry.junction |= *entry.sides.get_or_insert(*sides) != *sides;
            }
        }
        for corner in polygons.large.iter().flat_map(|(corners, _)| corners) {
            around[*corner as usize].junction = true;
        }
    }
    around
}
