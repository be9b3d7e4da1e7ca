//! Which voxels lie inside a closed surface, by columns along z: a centre is
//! inside when a line through it has an odd number of crossings below.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use robust::{Coord, orient2d};

use crate::mesh::Surface;
use crate::plane::Bounds;

/// Columns of cubic voxels.
pub struct Grid {
    origin: DVec3,
    voxel: f64,
    /// Columns along x and y.
    dims: [i64; 2],
}

/// The crossings of every column with a surface.
pub struct Columns {
    /// The column, and the first voxel whose centre lies beyond; sorted.
    crossings: Vec<(i64, i64)>,
}

impl Grid {
    /// With `count` voxels along the longest side of a box.
    pub fn around(bounds: &Bounds, count: u32) -> Self {
        let voxel = bounds.size().max_element() / f64::from(count);
        let columns = |side: f64| ((side / voxel).ceil() as i64).clamp(1, i64::from(count));
        let dims = [columns(bounds.size().x), columns(bounds.size().y)];
        Self { origin: bounds.min, voxel, dims }
    }

    /// How many columns there are.
    pub fn count(&self) -> i64 {
        self.dims[0] * self.dims[1]
    }

    /// Where a surface crosses them.
    pub fn columns(&self, surface: &Surface) -> Columns {
        let mut crossings: Vec<(i64, i64)> = (0..surface.triangles.len())
            .into_par_iter()
            .flat_map_iter(|triangle| self.crossings(surface.corners(triangle)))
            .collect();
        crossings.par_sort_unstable();
        Columns { crossings }
    }

    fn crossings(&self, corners: [DVec3; 3]) -> Vec<(i64, i64)> {
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |axis: usize| {
            let first = self.first_centre(low[axis], axis).max(0);
            first..=self.first_centre(high[axis], axis).min(self.dims[axis] - 1)
        };
        let mut crossings = Vec::new();
        for i in range(0) {
            for j in range(1) {
                let centre =
                    self.origin.truncate() + self.voxel * (DVec2::new(i as f64, j as f64) + 0.5);
                if let Some(height) = height(corners, centre) {
                    crossings.push((i * self.dims[1] + j, self.first_centre(height, 2)));
                }
            }
        }
        crossings
    }

    /// The first voxel along an axis whose centre is not before `at`.
    fn first_centre(&self, at: f64, axis: usize) -> i64 {
        ((at - self.origin[axis]) / self.voxel - 0.5).ceil() as i64
    }
}

impl Columns {
    /// How many columns have an odd number of crossings: none, for a closed
    /// surface.
    pub fn odd(&self) -> usize {
        self.crossings
            .chunk_by(|one, other| one.0 == other.0)
            .filter(|run| run.len() % 2 == 1)
            .count()
    }

    /// Voxels inside both, and inside either. In a column with an odd number
    /// of crossings the last one does not count.
    pub fn common_and_union(&self, other: &Self) -> (u64, u64) {
        let mut events: Vec<(i64, i64, usize)> = [self, other]
            .into_iter()
            .enumerate()
            .flat_map(|(source, columns)| {
                columns.crossings.chunk_by(|one, other| one.0 == other.0).flat_map(move |run| {
                    let even = &run[..run.len() / 2 * 2];
                    even.iter().map(move |&(column, voxel)| (column, voxel, source))
                })
            })
            .collect();
        events.par_sort_unstable();
        let mut inside = [false; 2];
        let (mut common, mut union) = (0, 0);
        for pair in events.windows(2) {
            inside[pair[0].2] ^= true;
            if pair[0].0 == pair[1].0 {
                let voxels = (pair[1].1 - pair[0].1) as u64;
                common += if inside[0] && inside[1] { voxels } else { 0 };
                union += if inside[0] || inside[1] { voxels } else { 0 };
            }
        }
        (common, union)
    }
}

/// Where a vertical line meets a triangle. Lines through edges and vertices
/// are taken to run a little to their right, and yet less behind them, so
/// that of the triangles around a point exactly the right ones are met.
fn height([a, b, c]: [DVec3; 3], at: DVec2) -> Option<f64> {
    let flat = [a, b, c].map(DVec3::truncate);
    let left = [[1, 2], [2, 0], [0, 1]].map(|[start, end]| is_left(flat[start], flat[end], at));
    if left[0] != left[1] || left[1] != left[2] {
        return None;
    }
    let weights = [(1, 2), (2, 0), (0, 1)]
        .map(|(one, other): (usize, usize)| (flat[one] - at).perp_dot(flat[other] - at));
    let sum: f64 = weights.iter().sum();
    let (low, high) = (a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z));
    let mean = (weights[0] * a.z + weights[1] * b.z + weights[2] * c.z) / sum;
    Some(if mean.is_finite() { mean.clamp(low, high) } else { low })
}

/// Whether a point lies left of the line from start to end, decided exactly;
/// on the line, for the point moved by (ε, ε²).
fn is_left(start: DVec2, end: DVec2, at: DVec2) -> bool {
    let coord = |point: DVec2| Coord { x: point.x, y: point.y };
    let area = orient2d(coord(start), coord(end), coord(at));
    if area != 0.0 {
        return area > 0.0;
    }
    let along = end - start;
    if along.y == 0.0 { along.x > 0.0 } else { along.y < 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The box from `low` to `high`; quadrilaterals in halves.
    fn block(low: DVec3, high: DVec3) -> Surface {
        let vertices = (0..8u32)
            .map(|corner| {
                let pick =
                    |axis: usize| if corner >> (2 - axis) & 1 == 1 { high } else { low }[axis];
                DVec3::new(pick(0), pick(1), pick(2))
            })
            .collect();
        let quads =
            [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Surface { vertices, triangles }
    }

    #[test]
    fn lines_through_edges_and_vertices_are_met_once_each_way() {
        // Every centre of a grid of 8³ unit voxels, less half a voxel, is at
        // integers: all lines run along edges, diagonals and faces.
        let grid = Grid { origin: DVec3::splat(-0.5), voxel: 1.0, dims: [8, 8] };
        let outer = grid.columns(&block(DVec3::ZERO, DVec3::splat(6.0)));
        let inner = grid.columns(&block(DVec3::splat(2.0), DVec3::splat(4.0)));
        assert_eq!((outer.odd(), inner.odd()), (0, 0));
        // Centres 0 … 5 and 2 … 3: the lower end counts, the upper does not.
        assert_eq!(outer.common_and_union(&inner), (2 * 2 * 2, 6 * 6 * 6));
        assert_eq!(inner.common_and_union(&inner), (8, 8));
    }

    #[test]
    fn solids_apart_have_nothing_in_common() {
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(4.0, 1.0, 2.0) };
        let grid = Grid::around(&bounds, 64);
        assert_eq!(grid.count(), 64 * 16);
        let left = grid.columns(&block(DVec3::ZERO, DVec3::ONE));
        let right = grid.columns(&block(DVec3::new(3.0, 0.0, 0.0), bounds.max));
        assert_eq!(left.common_and_union(&right), (0, 16 * 16 * 16 * 3));
    }
}
