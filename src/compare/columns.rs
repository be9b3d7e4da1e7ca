//! Which voxels lie inside a surface, by columns along z: a centre is inside where the surface
//! winds around it at all, whichever way round and how often. A column that the surface leaves
//! more or less often than it enters, as it is open or not turned the same way everywhere, goes
//! by parity: a centre is inside when an odd number of crossings is below.

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

/// What lies inside a surface.
pub struct Columns {
    /// The column, and the first voxel beyond which it is inside, and outside, in turn; sorted.
    changes: Vec<(i64, i64)>,
    /// Columns with an odd number of crossings: none, for a closed surface.
    pub odd: usize,
    /// Voxels that the surface winds around more than once.
    pub overlapping: u64,
}

/// The column, the first voxel whose centre lies beyond, and 1 where one enters the surface there
/// upward, −1 where one leaves it.
type Crossing = (i64, i64, i32);

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
        let mut crossings: Vec<Crossing> = (0..surface.triangles.len())
            .into_par_iter()
            .flat_map_iter(|triangle| self.crossings(surface.corners(triangle)))
            .collect();
        crossings.par_sort_unstable();
        Columns::new(&crossings)
    }

    /// The volume of so many voxels.
    pub fn volume(&self, voxels: u64) -> f64 {
        voxels as f64 * self.voxel.powi(3)
    }

    fn crossings(&self, corners: [DVec3; 3]) -> Vec<Crossing> {
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
                if let Some((height, entering)) = crossing(corners, centre) {
                    let column = i * self.dims[1] + j;
                    crossings.push((column, self.first_centre(height, 2), entering));
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
    /// From sorted crossings.
    fn new(crossings: &[Crossing]) -> Self {
        let mut columns = Self { changes: Vec::new(), odd: 0, overlapping: 0 };
        for run in crossings.chunk_by(|one, other| one.0 == other.0) {
            match run.iter().map(|crossing| crossing.2).sum() {
                0 => columns.add_winding(run),
                _ => columns.add_parity(run),
            }
        }
        columns
    }

    fn add_winding(&mut self, run: &[Crossing]) {
        let (mut winding, mut last) = (0i32, 0);
        for &(column, voxel, entering) in run {
            if winding.abs() > 1 {
                self.overlapping += (voxel - last) as u64;
            }
            let was_inside = winding != 0;
            winding += entering;
            if was_inside != (winding != 0) {
                self.changes.push((column, voxel));
            }
            last = voxel;
        }
    }

    /// The last of an odd number of crossings does not count.
    fn add_parity(&mut self, run: &[Crossing]) {
        self.odd += run.len() % 2;
        let even = &run[..run.len() / 2 * 2];
        self.changes.extend(even.iter().map(|&(column, voxel, _)| (column, voxel)));
    }

    /// Voxels inside.
    pub fn inside(&self) -> u64 {
        let spans = self.changes.as_chunks::<2>().0.iter();
        spans.map(|[enter, leave]| (leave.1 - enter.1) as u64).sum()
    }

    /// Voxels inside both, and inside either.
    pub fn common_and_union(&self, other: &Self) -> (u64, u64) {
        let of = |columns: &Self, source: usize| {
            let changes = columns.changes.iter();
            changes.map(|&(column, voxel)| (column, voxel, source)).collect::<Vec<_>>()
        };
        let mut events = [of(self, 0), of(other, 1)].concat();
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

/// Where a vertical line meets a triangle, and 1 where it enters its back upward, −1 where it
/// leaves it. Lines through edges and vertices
/// are taken to run a little to their right, and yet less behind them, so
/// that of the triangles around a point exactly the right ones are met.
fn crossing([a, b, c]: [DVec3; 3], at: DVec2) -> Option<(f64, i32)> {
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
    let height = if mean.is_finite() { mean.clamp(low, high) } else { low };
    // Counter-clockwise as seen from above, it faces upward.
    Some((height, if left[0] { -1 } else { 1 }))
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
        assert_eq!((outer.odd, inner.odd), (0, 0));
        // Centres 0 … 5 and 2 … 3: the lower end counts, the upper does not.
        assert_eq!(outer.common_and_union(&inner), (2 * 2 * 2, 6 * 6 * 6));
        assert_eq!(inner.common_and_union(&inner), (8, 8));
    }

    /// Blocks of 3³ voxels: what is inside of several, or of one that faces inward, is inside.
    #[test]
    fn what_is_wound_around_is_inside_whichever_way_and_how_often() {
        let grid = Grid { origin: DVec3::splat(-0.5), voxel: 1.0, dims: [8, 8] };
        let at = |corner: f64| block(DVec3::splat(corner), DVec3::splat(corner + 3.0));
        let turned = |mut surface: Surface| {
            surface.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
            surface
        };
        let both = |one: Surface, other: Surface| {
            let first = one.vertices.len() as u32;
            let moved = other.triangles.iter().map(|triangle| triangle.map(|at| at + first));
            let triangles = one.triangles.iter().copied().chain(moved).collect();
            let vertices = [one.vertices, other.vertices].concat();
            grid.columns(&Surface { vertices, triangles })
        };
        let counts = |columns: &Columns| (columns.inside(), columns.overlapping, columns.odd);
        assert_eq!(counts(&grid.columns(&turned(at(0.0)))), (27, 0, 0));
        assert_eq!(counts(&both(at(0.0), at(0.0))), (27, 27, 0));
        assert_eq!(counts(&both(at(0.0), at(2.0))), (53, 1, 0));
        assert_eq!(counts(&both(at(0.0), turned(at(4.0)))), (54, 0, 0));
        let cavity = block(DVec3::ONE, DVec3::splat(2.0));
        assert_eq!(counts(&both(at(0.0), turned(cavity.clone()))), (26, 0, 0));
        assert_eq!(counts(&both(at(0.0), cavity)), (27, 1, 0));
        // A lid turned round does not change what is inside, by parity.
        let mut lid = at(0.0);
        lid.triangles[2].swap(0, 1);
        lid.triangles[3].swap(0, 1);
        assert_eq!(counts(&grid.columns(&lid)), (27, 0, 0));
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
