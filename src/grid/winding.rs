//! Which nodes are inside of a closed mesh: by the winding number along
//! columns of nodes. Tests are exact, with ties broken as if every node stood
//! a hair off (simulation of simplicity), so that no node is on an edge and
//! the numbers of a closed mesh never contradict one another.

use glam::DVec3;
use rayon::prelude::*;
use robust::{Coord, orient2d};

/// Where columns of nodes (fixed x and y) cross a mesh.
pub(super) struct Columns {
    /// Column, height in voxels, and +1 where one leaves the mesh upward, −1
    /// where one enters it; sorted by column and height.
    crossings: Vec<Crossing>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Crossing {
    column: [i32; 2],
    height: f64,
    leaving: i32,
}

impl Columns {
    /// The crossings of a closed mesh whose vertices are given in voxels,
    /// node (i, j, k) at (i, j, k).
    pub(super) fn new(vertices: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let mut crossings: Vec<Crossing> = triangles
            .par_iter()
            .flat_map_iter(|&triangle| triangle_crossings(vertices, triangle))
            .collect();
        crossings.par_sort_unstable_by(|a, b| {
            let height = || a.height.total_cmp(&b.height);
            a.column.cmp(&b.column).then_with(height).then(a.leaving.cmp(&b.leaving))
        });
        Self { crossings }
    }

    /// Whether nodes `z..z + inside.len()` of a column are inside.
    pub(super) fn fill(&self, column: [i32; 2], z: i32, inside: &mut [bool]) {
        let start = self.crossings.partition_point(|crossing| crossing.column < column);
        let rest = &self.crossings[start..];
        let own = &rest[..rest.partition_point(|crossing| crossing.column == column)];
        let mut left = own.len();
        let mut winding = 0;
        for (step, inside) in inside.iter_mut().enumerate().rev() {
            let height = f64::from(z) + step as f64;
            while left > 0 && own[left - 1].height > height {
                left -= 1;
                winding += own[left].leaving;
            }
            *inside = winding > 0;
        }
    }
}

fn triangle_crossings(vertices: &[DVec3], triangle: [u32; 3]) -> Vec<Crossing> {
    let corners = triangle.map(|vertex| vertices[vertex as usize]);
    let min = corners[0].min(corners[1]).min(corners[2]).ceil();
    let max = corners[0].max(corners[1]).max(corners[2]).floor();
    let mut crossings = Vec::new();
    for x in min.x as i32 - 1..=max.x as i32 {
        for y in min.y as i32 - 1..=max.y as i32 {
            let sides = [[1, 2], [2, 0], [0, 1]].map(|[a, b]| side(corners[a], corners[b], x, y));
            let positive = sides[0].0;
            if sides.iter().all(|side| side.0 == positive) {
                let height = height(corners, sides.map(|side| side.1));
                let leaving = if positive { 1 } else { -1 };
                crossings.push(Crossing { column: [x, y], height, leaving });
            }
        }
    }
    crossings
}

/// Whether the point (x + ε, y + ε²) lies left of the edge from a to b as
/// seen from above, and twice the area that it makes with the edge at ε = 0.
fn side(a: DVec3, b: DVec3, x: i32, y: i32) -> (bool, f64) {
    let flat = |point: DVec3| Coord { x: point.x, y: point.y };
    let area = orient2d(flat(a), flat(b), Coord { x: f64::from(x), y: f64::from(y) });
    let left = if area != 0.0 {
        area > 0.0
    } else if a.y != b.y {
        a.y > b.y // the first derivative of the area by ε: −(b.y − a.y)
    } else {
        a.x < b.x
    };
    (left, area)
}

/// The height of a triangle over a point with these areas opposite to its
/// corners.
fn height(corners: [DVec3; 3], areas: [f64; 3]) -> f64 {
    let total: f64 = areas.iter().sum();
    let mean = corners.iter().map(|corner| corner.z).sum::<f64>() / 3.0;
    if total == 0.0 {
        return mean; // no area as seen from above
    }
    let height = (0..3).map(|corner| corners[corner].z * areas[corner]).sum::<f64>() / total;
    let heights = corners.map(|corner| corner.z);
    height.clamp(
        heights.iter().copied().fold(mean, f64::min),
        heights.iter().copied().fold(mean, f64::max),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box with 12 triangles, seen from outside counter-clockwise.
    fn cuboid(min: DVec3, max: DVec3) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let corner = |index: usize| {
            let pick = |axis: usize| if index >> axis & 1 == 1 { max[axis] } else { min[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let quads =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let halves = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        ((0..8).map(corner).collect(), halves.collect())
    }

    fn inside(columns: &Columns, [x, y, z]: [i32; 3]) -> bool {
        let mut found = [false];
        columns.fill([x, y], z, &mut found);
        found[0]
    }

    #[test]
    fn nodes_exactly_on_edges_and_corners_are_decided() {
        // Every node of the box's border is a tie. A closed box of 4 × 3 × 2
        // voxels holds 4 · 3 columns whichever way they are broken.
        let (vertices, triangles) = cuboid(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0));
        let columns = Columns::new(&vertices, &triangles);
        let mut count = 0;
        for x in -2..7 {
            for y in -2..6 {
                let mut found = [false; 8];
                columns.fill([x, y], -3, &mut found);
                let here = found.iter().filter(|&&inside| inside).count();
                assert!(here == 0 || here == 2, "{x} {y}: {found:?}");
                count += here;
            }
        }
        assert_eq!(count, 24);
        assert!(inside(&columns, [1, 1, 1]) && !inside(&columns, [1, 1, 3]));
    }

    #[test]
    fn cavities_are_outside() {
        let (mut vertices, mut triangles) = cuboid(DVec3::splat(0.5), DVec3::splat(9.5));
        let (inner, cavity) = cuboid(DVec3::splat(3.5), DVec3::splat(6.5));
        triangles.extend(cavity.iter().map(|&[a, b, c]| [a + 8, c + 8, b + 8]));
        vertices.extend(inner);
        let columns = Columns::new(&vertices, &triangles);
        let mut line = [false; 12];
        columns.fill([5, 5], -1, &mut line);
        let expected = "..xxx...xxx.".chars().map(|sign| sign == 'x').collect::<Vec<_>>();
        assert_eq!(line.to_vec(), expected);
    }
}
