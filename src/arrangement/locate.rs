//! Which cell a point lies in.

use glam::DVec3;

use super::Arrangement;
use super::signs;
use crate::plane::Bounds;

/// The largest number of planes for whose sides a table is made.
const TABLE_PLANES: usize = 5;
/// How many of the planes nearest to a point may have been misjudged by
/// rounding before all cells are looked at.
const DOUBTFUL_PLANES: usize = 8;

/// Finds the cells of points in a part of the box, where only few planes
/// matter.
#[derive(Debug, Clone)]
pub struct Locator<'a> {
    arrangement: &'a Arrangement,
    /// The name of a cell here, but for the planes that cut the region.
    name: Vec<u64>,
    /// The planes that cut the region.
    cutting: Vec<u32>,
    /// The cell for every set of planes that a point is in front of, by the
    /// bits of `cutting`; empty where there are too many.
    table: Vec<Option<u32>>,
}

impl<'a> Locator<'a> {
    /// For points of the region; those outside the box count as the nearest
    /// ones in it.
    pub(super) fn new(arrangement: &'a Arrangement, region: Bounds) -> Self {
        let clamp = |point: DVec3| point.clamp(arrangement.bounds.min, arrangement.bounds.max);
        let (min, max) = (clamp(region.min), clamp(region.max));
        let (center, half) = ((min + max) / 2.0, (max - min) / 2.0);
        let mut name = arrangement.topology.cells[0].words().to_vec();
        let mut cutting = Vec::new();
        for &index in &arrangement.topology.cutting {
            let plane = &arrangement.planes[index as usize];
            let value = plane.normal.dot(center) - plane.offset;
            // Over the region n · x − o varies by this much; rounding adds to it.
            let reach = plane.normal.abs().dot(half);
            let size = plane.normal.abs().dot(center.abs() + half) + plane.offset.abs();
            if value.abs() <= reach + 1e-12 * size {
                cutting.push(index);
            } else {
                signs::set(&mut name, index as usize, if value > 0.0 { 1 } else { -1 });
            }
        }
        let mut locator = Self { arrangement, name, cutting, table: Vec::new() };
        if locator.cutting.len() <= TABLE_PLANES {
            locator.table =
                (0..1 << locator.cutting.len()).map(|front| locator.named(front)).collect();
        }
        locator
    }

    /// The planes that cut the region, indices into [`Arrangement::planes`].
    pub fn planes(&self) -> &[u32] {
        &self.cutting
    }

    /// The cell of all points of the region, if no plane cuts it.
    pub fn only_cell(&self) -> Option<u32> {
        if self.cutting.is_empty() { self.table[0] } else { None }
    }

    /// As [`Arrangement::locate`], for a point of the region.
    pub fn locate(&self, point: DVec3) -> u32 {
        let bounds = self.arrangement.bounds;
        let point = point.clamp(bounds.min, bounds.max);
        let found = if self.table.is_empty() {
            self.arrangement.cell_beside(self.name.clone(), &self.cutting, point)
        } else {
            let planes = self.cutting.iter().enumerate();
            let front = |plane: u32| self.arrangement.side(plane, point) > 0;
            self.table[planes.fold(0, |bits, (i, &plane)| bits | usize::from(front(plane)) << i)]
        };
        found.unwrap_or_else(|| self.arrangement.nearest_cell(point))
    }

    /// The cell in front of some of the planes that cut the region.
    fn named(&self, front: usize) -> Option<u32> {
        let mut name = self.name.clone();
        for (bit, &plane) in self.cutting.iter().enumerate() {
            let sign = if front >> bit & 1 == 1 { 1 } else { -1 };
            signs::set(&mut name, plane as usize, sign);
        }
        self.arrangement.topology.index.get(name.as_slice()).copied()
    }
}

impl Arrangement {
    /// The cell of a point, by its sides of all planes.
    pub(super) fn cell_of(&self, point: DVec3) -> u32 {
        let point = point.clamp(self.bounds.min, self.bounds.max);
        let name = self.topology.cells[0].words().to_vec();
        let found = self.cell_beside(name, &self.topology.cutting, point);
        found.unwrap_or_else(|| self.nearest_cell(point))
    }

    /// The cell with a name but for some planes, of which it is on the same
    /// side as a point.
    fn cell_beside(&self, mut name: Vec<u64>, planes: &[u32], point: DVec3) -> Option<u32> {
        for &plane in planes {
            signs::set(&mut name, plane as usize, self.side(plane, point));
        }
        self.topology.index.get(name.as_slice()).copied()
    }

    /// The side (−1, 1) of a plane that a point is on, to rounding.
    fn side(&self, plane: u32, point: DVec3) -> i8 {
        let plane = &self.planes[plane as usize];
        if plane.normal.dot(point) >= plane.offset { 1 } else { -1 }
    }

    /// The cell to whose planes a point is nearest, for one that rounding has
    /// put on sides that no cell has.
    fn nearest_cell(&self, point: DVec3) -> u32 {
        let distances: Vec<f64> = self
            .topology
            .cutting
            .iter()
            .map(|&p| self.planes[p as usize].distance(point))
            .collect();
        self.flipped_cell(&distances).unwrap_or_else(|| self.least_violated_cell(&distances))
    }

    /// The cell found by crossing the nearest planes, by the smallest sum of
    /// distances.
    fn flipped_cell(&self, distances: &[f64]) -> Option<u32> {
        let mut name = self.topology.cells[0].words().to_vec();
        for (&plane, &distance) in self.topology.cutting.iter().zip(distances) {
            signs::set(&mut name, plane as usize, if distance >= 0.0 { 1 } else { -1 });
        }
        let mut nearest: Vec<usize> = (0..distances.len()).collect();
        nearest.sort_by(|&a, &b| distances[a].abs().total_cmp(&distances[b].abs()));
        nearest.truncate(DOUBTFUL_PLANES);
        let cross = |set: u32| {
            let (mut name, mut sum) = (name.clone(), 0.0);
            for (_, &i) in nearest.iter().enumerate().filter(|(bit, _)| set >> bit & 1 == 1) {
                let sign = if distances[i] >= 0.0 { -1 } else { 1 };
                signs::set(&mut name, self.topology.cutting[i] as usize, sign);
                sum += distances[i].abs();
            }
            self.topology.index.get(name.as_slice()).map(|&cell| (sum, cell))
        };
        let best = (0..1 << nearest.len()).filter_map(cross).min_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, cell)| cell)
    }

    /// The cell on whose wrong side of planes the point is by the least sum.
    fn least_violated_cell(&self, distances: &[f64]) -> u32 {
        let violation = |cell: u32| -> f64 {
            let name = &self.topology.cells[cell as usize];
            let planes = self.topology.cutting.iter().zip(distances);
            planes.map(|(&p, d)| (-d * f64::from(name.get(p as usize))).max(0.0)).sum()
        };
        let cells = (0..self.cells.len() as u32).map(|cell| (violation(cell), cell));
        cells.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0, |(_, cell)| cell)
    }
}
