//! Signed distances to a closed mesh near its surface: the values of a level
//! set. OpenVDB's own conversion fills closed cavities and breaks ties by
//! whichever thread comes first; this one does neither.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::leaf_grid::{LeafGrid, around};
use super::samples::{LEAF_SIDE, Lattice};
use super::winding::Columns;

mod triangle;

use triangle::Triangle;

/// How many voxels a level set reaches from its surface on either side: what
/// OpenVDB's tools expect.
pub const HALF_WIDTH: f64 = 3.0;
const SIDE: i32 = LEAF_SIDE as i32;

/// Signed distances to a closed mesh, on the nodes of a lattice: in voxels, negative
/// inside, cut off at ±[`HALF_WIDTH`]. Leaves are those with a nearer node, sorted; also
/// some beyond the lattice, where the surface is near its border.
pub fn narrow_band(lattice: &Lattice, vertices: &[DVec3], triangles: &[[u32; 3]]) -> LeafGrid {
    band_around(lattice, vertices, triangles, triangles)
}

/// The band around a part of a closed mesh: distances are those to its triangles
/// `near`, signs say what is inside of the whole.
pub fn band_around(
    lattice: &Lattice,
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    near: &[[u32; 3]],
) -> LeafGrid {
    let vertices = in_voxels(lattice, vertices);
    let columns = Columns::new(&vertices, triangles);
    let bins = Bins::new(&vertices, near, HALF_WIDTH);
    leaves_of(&bins, |at, distances| {
        let mut inside = [[false; LEAF_SIDE]; LEAF_SIDE * LEAF_SIDE];
        fill(&columns, at, &mut inside);
        let nodes = distances.iter_mut().zip(inside.as_flattened());
        nodes.filter(|(_, inside)| **inside).for_each(|(distance, _)| *distance = -*distance);
    })
}

/// Distances to triangles on the nodes of a lattice: in voxels, cut off at
/// `reach`. Leaves are those with a nearer node, sorted.
pub fn distances(
    lattice: &Lattice,
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    reach: f64,
) -> LeafGrid {
    let vertices = in_voxels(lattice, vertices);
    leaves_of(&Bins::new(&vertices, triangles, reach), |_, _| {})
}

/// The distances in all leaves that triangles reach, after `sign`.
fn leaves_of(bins: &Bins, sign: impl Fn([i32; 3], &mut [f32]) + Sync) -> LeafGrid {
    let leaf = |at| {
        let mut distances = leaf_distances(bins, at)?;
        sign(at, &mut distances);
        Some((at, distances))
    };
    let found: Vec<([i32; 3], Vec<f32>)> =
        bins.neighborhood().into_par_iter().filter_map(leaf).collect();
    let leaves: Vec<[i32; 3]> = found.iter().map(|(at, _)| *at).collect();
    let mut band = LeafGrid::with_leaves(&leaves);
    for ((_, own), (_, values)) in band.iter_mut().zip(found) {
        own.copy_from_slice(&values);
    }
    band
}

fn in_voxels(lattice: &Lattice, vertices: &[DVec3]) -> Vec<DVec3> {
    vertices.par_iter().map(|&vertex| (vertex - lattice.origin) / lattice.voxel).collect()
}

/// For every node of some leaves, [`LEAF_SIDE`]³ a leaf, whether it is inside of a
/// closed mesh.
pub fn inside(
    lattice: &Lattice,
    vertices: &[DVec3],
    triangles: &[[u32; 3]],
    leaves: &[[i32; 3]],
) -> Vec<bool> {
    let columns = Columns::new(&in_voxels(lattice, vertices), triangles);
    let of_leaf = |&at: &[i32; 3]| {
        let mut nodes = [[false; LEAF_SIDE]; LEAF_SIDE * LEAF_SIDE];
        fill(&columns, at, &mut nodes);
        nodes.into_iter().flatten()
    };
    leaves.par_iter().flat_map_iter(of_leaf).collect()
}

/// Which nodes of a leaf are inside, row by row.
fn fill(columns: &Columns, at: [i32; 3], nodes: &mut [[bool; LEAF_SIDE]; LEAF_SIDE * LEAF_SIDE]) {
    for (row, nodes) in nodes.iter_mut().enumerate() {
        let [x, y] = [row / LEAF_SIDE, row % LEAF_SIDE].map(|offset| offset as i32);
        columns.fill([at[0] * SIDE + x, at[1] * SIDE + y], at[2] * SIDE, nodes);
    }
}

/// The distances of a leaf's nodes, unless none is within reach.
fn leaf_distances(bins: &Bins, at: [i32; 3]) -> Option<Vec<f32>> {
    let reach = bins.reach as f32;
    let mut squares = [[reach * reach; LEAF_SIDE]; LEAF_SIDE * LEAF_SIDE];
    for triangle in bins.near(at) {
        nearest(&Triangle::new(triangle), reach, &mut squares);
    }
    let squares = squares.as_flattened();
    let is_near = squares.iter().any(|&square| square < reach * reach);
    is_near.then(|| squares.iter().map(|square| square.sqrt()).collect())
}

/// Lowers squared distances to those from a triangle, where it is near.
fn nearest(
    triangle: &Triangle,
    reach: f32,
    squares: &mut [[f32; LEAF_SIDE]; LEAF_SIDE * LEAF_SIDE],
) {
    let nodes = |axis: usize| -> Range<usize> {
        let from = (triangle.min[axis] - reach).ceil().clamp(0.0, LEAF_SIDE as f32) as usize;
        let to = (triangle.max[axis] + reach).floor().clamp(-1.0, LEAF_SIDE as f32 - 1.0);
        from..(to + 1.0) as usize
    };
    for x in nodes(0) {
        let gap_x = triangle.gap(0, x as f32);
        for y in nodes(1) {
            let gap_y = triangle.gap(1, y as f32);
            if gap_x * gap_x + gap_y * gap_y < reach * reach {
                triangle.lower_row([x as f32, y as f32], &mut squares[x * LEAF_SIDE + y]);
            }
        }
    }
}

fn first_node(at: [i32; 3]) -> DVec3 {
    DVec3::from(at.map(|at| f64::from(at * SIDE)))
}

/// Triangles by the leaves that their boxes overlap.
struct Bins<'a> {
    vertices: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    /// Leaf and triangle, sorted.
    entries: Vec<([i32; 3], u32)>,
    /// Distinct leaves, sorted, each with the range of its entries.
    leaves: Vec<([i32; 3], Range<usize>)>,
    /// How far from a triangle nodes are of interest, in voxels.
    reach: f64,
}

impl<'a> Bins<'a> {
    fn new(vertices: &'a [DVec3], triangles: &'a [[u32; 3]], reach: f64) -> Self {
        let mut entries: Vec<([i32; 3], u32)> = triangles
            .par_iter()
            .enumerate()
            .flat_map_iter(|(index, triangle)| {
                let [from, to] = leaf_range(triangle.map(|vertex| vertices[vertex as usize]));
                let leaves = (from[0]..=to[0]).flat_map(move |x| {
                    (from[1]..=to[1]).flat_map(move |y| (from[2]..=to[2]).map(move |z| [x, y, z]))
                });
                leaves.map(move |leaf| (leaf, index as u32))
            })
            .collect();
        entries.par_sort_unstable();
        let mut end = 0;
        let leaves = entries
            .chunk_by(|a, b| a.0 == b.0)
            .map(|chunk| {
                let range = end..end + chunk.len();
                end = range.end;
                (chunk[0].0, range)
            })
            .collect();
        Self { vertices, triangles, entries, leaves, reach }
    }

    /// All leaves in or next to which there are triangles, sorted.
    fn neighborhood(&self) -> Vec<[i32; 3]> {
        let around = |&(at, _): &([i32; 3], Range<usize>)| around(at);
        let mut leaves: Vec<[i32; 3]> = self.leaves.par_iter().flat_map_iter(around).collect();
        leaves.par_sort_unstable();
        leaves.dedup();
        leaves
    }

    /// The triangles that may reach nodes of a leaf, each once, in voxels
    /// from its first node.
    fn near(&self, at: [i32; 3]) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let bin = |leaf: [i32; 3]| self.leaves.binary_search_by_key(&leaf, |bin| bin.0).ok();
        let entries =
            around(at).filter_map(bin).flat_map(|bin| &self.entries[self.leaves[bin].1.clone()]);
        let first = first_node(at);
        let last = DVec3::splat(LEAF_SIDE as f64 - 1.0 + self.reach);
        entries.filter_map(move |&(leaf, triangle)| {
            let corners = self.triangles[triangle as usize].map(|v| self.vertices[v as usize]);
            let local = corners.map(|corner| corner - first);
            let [min, max] = box_of(local);
            if max.cmplt(DVec3::splat(-self.reach)).any() || min.cmpgt(last).any() {
                return None;
            }
            let [from, to] = leaf_range(corners);
            // Of all leaves that hold it, the nearest one.
            let nearest = std::array::from_fn(|axis| at[axis].clamp(from[axis], to[axis]));
            (leaf == nearest).then_some(local)
        })
    }
}

/// The first and the last leaf that a triangle's box overlaps.
fn leaf_range(corners: [DVec3; 3]) -> [[i32; 3]; 2] {
    box_of(corners)
        .map(|corner| (corner / f64::from(SIDE)).floor().to_array().map(|leaf| leaf as i32))
}

/// The corners of a triangle's box with the smallest and the largest
/// coordinates.
fn box_of([a, b, c]: [DVec3; 3]) -> [DVec3; 2] {
    [a.min(b).min(c), a.max(b).max(c)]
}

#[cfg(test)]
pub(crate) mod tests;
