//! One level of the solver for one label: a lattice over the box, and values
//! where they are needed.

use rayon::prelude::*;

use crate::grid::invariant::neighbor;
use crate::grid::leaf::LeafNodes;
use crate::grid::leaf_grid::{LeafGrid, LeafSet, NO_SLOT, around, leaf_of, node_below};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice};

use super::system::{Domain, SIDE};

/// Nodes along each axis of the part of a coarser level that a leaf depends on:
/// its voxels are not smaller, so 8 nodes lie within 7 of its own, and cubic
/// interpolation takes one more before and two behind.
const COARSE: usize = LEAF_SIDE + 3;

/// A lattice with values in some of its leaves.
#[derive(Debug, Clone)]
pub struct Level {
    /// Where the nodes are.
    pub lattice: Lattice,
    /// The nodes that exist.
    pub domain: Domain,
    /// The values, in voxels of this level.
    pub grid: LeafGrid,
}

impl Level {
    /// Without values. Beyond a closed box there are two layers of nodes; beyond
    /// an open one that layer which the lattice has.
    pub fn new(lattice: Lattice, is_open: bool) -> Self {
        let beyond = if is_open { 0 } else { 1 };
        let domain = Domain { low: [-beyond; 3], high: lattice.dims.map(|nodes| nodes + beyond) };
        Self { lattice, domain, grid: LeafGrid::new(domain.low, domain.high) }
    }

    /// The leaves of `wanted` that may be there and have no values yet, sorted.
    pub fn missing(&self, wanted: impl IntoIterator<Item = [i32; 3]>) -> Vec<[i32; 3]> {
        let mut missing = LeafSet::new(&self.grid);
        for leaf in wanted {
            if self.grid.slot(leaf) == NO_SLOT {
                missing.insert(leaf);
            }
        }
        missing.sorted()
    }

    /// The leaves of this level that some leaves of a finer lattice depend on.
    pub fn below(&self, leaves: &[[i32; 3]], finer: &Lattice) -> Vec<[i32; 3]> {
        let mut below = LeafSet::new(&self.grid);
        for &leaf in leaves {
            let rows = self.rows(leaf, finer);
            let low = std::array::from_fn(|axis| rows[axis][0].first);
            let high = std::array::from_fn(|axis| rows[axis][LEAF_SIDE - 1].first + 3);
            for leaf in leaves_between([leaf_of(low), leaf_of(high)]) {
                below.insert(leaf);
            }
        }
        below.sorted()
    }

    /// The values at a leaf of a finer lattice, in its voxels.
    pub fn interpolated(&self, leaf: [i32; 3], finer: &Lattice) -> [f32; LEAF_NODES] {
        let rows = self.rows(leaf, finer);
        let low = std::array::from_fn(|axis| rows[axis][0].first);
        let mut coarse = [0.0; COARSE * COARSE * COARSE];
        self.grid.gather::<COARSE>(low, &mut coarse);
        let ratio = (self.lattice.voxel / finer.voxel) as f32;
        interpolate(
            &coarse,
            &rows.map(|axis| axis.map(|row| row.relative_to(axis[0].first))),
            ratio,
        )
    }

    /// For every axis and every node of a leaf of a finer lattice the nodes of this
    /// level that it depends on.
    fn rows(&self, leaf: [i32; 3], finer: &Lattice) -> [[Row; LEAF_SIDE]; 3] {
        let shift = (finer.origin - self.lattice.origin) / self.lattice.voxel;
        let ratio = finer.voxel / self.lattice.voxel;
        std::array::from_fn(|axis| {
            let exists = self.domain.low[axis]..self.domain.high[axis];
            std::array::from_fn(|node| {
                let at = f64::from(leaf[axis] * SIDE + node as i32);
                Row::new(shift[axis] + ratio * at, exists.clone())
            })
        })
    }
}

/// Four nodes in a row and what each counts.
#[derive(Debug, Clone, Copy)]
struct Row {
    first: i32,
    weights: [f32; 4],
}

impl Row {
    /// Cubic convolution (Catmull and Rom) at a place. What it takes from nodes
    /// that do not exist it takes from the line through the last two that do.
    fn new(at: f64, exists: std::ops::Range<i32>) -> Self {
        let base = at.floor();
        let t = at - base;
        let cubic = [
            t * (-0.5 + t * (1.0 - 0.5 * t)),
            1.0 + t * t * (-2.5 + 1.5 * t),
            t * (0.5 + t * (2.0 - 1.5 * t)),
            t * t * (-0.5 + 0.5 * t),
        ];
        let wanted = base as i32 - 1;
        let first = wanted.min(exists.end - 4).max(exists.start);
        let mut weights = [0.0; 4];
        for (node, weight) in (wanted..).zip(cubic) {
            let inner = node.clamp(exists.start, exists.end - 1);
            let beyond = f64::from(node - inner);
            let previous = if beyond > 0.0 { inner - 1 } else { inner + 1 };
            // f(node) = f(inner) + |beyond| (f(inner) − f(previous)).
            add(&mut weights, inner - first, weight * (1.0 + beyond.abs()));
            if beyond != 0.0 {
                add(&mut weights, previous - first, -weight * beyond.abs());
            }
        }
        Self { first, weights: weights.map(|weight| weight as f32) }
    }

    fn relative_to(self, low: i32) -> Self {
        Self { first: self.first - low, ..self }
    }
}

/// Where the domain has fewer nodes than a row, or a row lies far beyond it, what
/// does not fit counts for nothing.
fn add(weights: &mut [f64; 4], place: i32, weight: f64) {
    if let Some(own) = usize::try_from(place).ok().and_then(|place| weights.get_mut(place)) {
        *own += weight;
    }
}

/// Axis by axis, x first: then whole lines are added up, which vector instructions do.
fn interpolate(
    coarse: &[f32; COARSE * COARSE * COARSE],
    [rows_x, rows_y, rows_z]: &[[Row; LEAF_SIDE]; 3],
    ratio: f32,
) -> [f32; LEAF_NODES] {
    let mut values = [0.0; LEAF_NODES];
    let planes = coarse.as_chunks::<{ COARSE * COARSE }>().0;
    for (x, row) in rows_x.iter().enumerate() {
        let mut plane = [0.0; COARSE * COARSE];
        row.add(planes, &mut plane);
        for (y, row) in rows_y.iter().enumerate() {
            let mut line = [0.0; COARSE];
            row.add(plane.as_chunks().0, &mut line);
            for (z, row) in rows_z.iter().enumerate() {
                let near = &line[row.first as usize..][..4];
                let value = |node: usize| row.weights[node] * near[node];
                values[(x * LEAF_SIDE + y) * LEAF_SIDE + z] =
                    ratio * ((value(0) + value(1)) + (value(2) + value(3)));
            }
        }
    }
    values
}

impl Row {
    /// The sum over its lines of values, each as often as its node counts.
    #[inline(always)]
    fn add<const LINE: usize>(&self, lines: &[[f32; LINE]], sum: &mut [f32; LINE]) {
        let [a, b, c, d] = self.weights;
        let [line_a, line_b, line_c, line_d] =
            std::array::from_fn(|node| &lines[self.first as usize + node]);
        for at in 0..LINE {
            sum[at] = (a * line_a[at] + b * line_b[at]) + (c * line_c[at] + d * line_d[at]);
        }
    }
}

/// Gives values to leaves of the last level and, where that needs it, of those
/// below: interpolated from below, then `settle` sees each new leaf of a level.
pub fn ensure(
    levels: &mut [Level],
    leaves: impl IntoIterator<Item = [i32; 3]>,
    settle: &(impl Fn(&Lattice, &Domain, [i32; 3], &mut LeafNodes) + Sync),
) {
    let Some((level, below)) = levels.split_last_mut() else { return };
    let missing = level.missing(leaves);
    if missing.is_empty() {
        return;
    }
    if let Some(coarser) = below.last() {
        let needed = coarser.below(&missing, &level.lattice);
        ensure(below, needed, settle);
    }
    let coarser = below.last();
    let Level { lattice, domain, grid } = level;
    let start = grid.add(missing.iter().copied()).start * LEAF_NODES;
    let values = grid.values_mut()[start..].as_chunks_mut().0;
    missing.par_iter().zip(values).for_each(|(&leaf, values)| {
        if let Some(coarser) = coarser {
            *values = coarser.interpolated(leaf, lattice);
        }
        settle(lattice, domain, leaf, values);
    });
}

/// The leaves near where values change their sign, and those within `reach` nodes
/// of such a node; sorted.
pub fn near_changes(grid: &LeafGrid, reach: i32) -> Vec<[i32; 3]> {
    let steps: Vec<u32> = (0..grid.leaves().len() as u32)
        .into_par_iter()
        .map(|slot| steps_to_mark(grid, slot, reach))
        .collect();
    let mut near = LeafSet::new(grid);
    for (&leaf, steps) in grid.leaves().iter().zip(steps).filter(|(_, steps)| *steps != 0) {
        for (step, leaf) in around(leaf).enumerate() {
            if steps >> step & 1 == 1 {
                near.insert(leaf);
            }
        }
    }
    near.sorted()
}

/// One bit for each of the 27 leaves around a leaf: whether a change of sign that
/// begins in it is within reach.
fn steps_to_mark(grid: &LeafGrid, slot: u32, reach: i32) -> u32 {
    let mut steps = 0;
    for (axis, changes) in changes_along_axes(grid, slot).into_iter().enumerate() {
        if changes == [0; LEAF_SIDE] {
            continue;
        }
        // The layers across an axis from which a leaf before, the own one and one
        // behind are within reach; a change also concerns the next node along its axis.
        let layers = |across: usize, step: usize| match step {
            0 => 0..reach.min(SIDE),
            1 => 0..SIDE,
            _ => (SIDE - reach - i32::from(across == axis)).max(0)..SIDE,
        };
        for x in 0..3 {
            let within = layers(0, x).fold(0, |within, layer| within | changes[layer as usize]);
            for y in 0..3 {
                let within =
                    within & layers(1, y).fold(0, |mask, layer| mask | ROW << (SIDE * layer));
                for z in 0..3 {
                    let within =
                        within & layers(2, z).fold(0, |mask, layer| mask | COLUMN << layer);
                    steps |= u32::from(within != 0) << ((x * 3 + y) * 3 + z);
                }
            }
        }
    }
    steps
}

/// One bit for each node of a layer across x, by y and z: those with y = 0, and those
/// with z = 0.
const ROW: u64 = 0xff;
const COLUMN: u64 = 0x0101_0101_0101_0101;

/// For every axis the nodes, layer by layer along x, from which the sign changes to the
/// next node along that axis.
fn changes_along_axes(grid: &LeafGrid, slot: u32) -> [[u64; LEAF_SIDE]; 3] {
    let leaf = grid.leaves()[slot as usize];
    let values = grid.leaf(slot).as_chunks::<{ LEAF_SIDE * LEAF_SIDE }>().0;
    let positive: [u64; LEAF_SIDE] = std::array::from_fn(|x| positive(&values[x]));
    let next = |axis: usize| grid.get(neighbor(leaf, axis, true));
    let mut changes = [[0; LEAF_SIDE]; 3];
    for x in 0..LEAF_SIDE {
        let own = positive[x];
        if x + 1 < LEAF_SIDE {
            changes[0][x] = own ^ positive[x + 1];
        }
        changes[1][x] = (own ^ own >> LEAF_SIDE) & !(ROW << (SIDE * (SIDE - 1)));
        changes[2][x] = (own ^ own >> 1) & !(COLUMN << (SIDE - 1));
    }
    // From the last nodes to the first ones of the leaf behind.
    if let Some(next) = next(0) {
        let next = next.as_chunks::<{ LEAF_SIDE * LEAF_SIDE }>().0;
        changes[0][LEAF_SIDE - 1] = positive[LEAF_SIDE - 1] ^ self::positive(&next[0]);
    }
    for axis in [1, 2] {
        let Some(next) = next(axis) else { continue };
        let stride = [0, 1, LEAF_SIDE][axis];
        for x in 0..LEAF_SIDE {
            for along in 0..LEAF_SIDE {
                let first = along * stride;
                let last = first + (LEAF_SIDE - 1) * [0, LEAF_SIDE, 1][axis];
                let ahead = next[x * LEAF_SIDE * LEAF_SIDE + first] > 0.0;
                let differs = (positive[x] >> last & 1 == 1) != ahead;
                changes[axis][x] |= u64::from(differs) << last;
            }
        }
    }
    changes
}

/// One bit for each value: whether it is positive.
fn positive(values: &[f32; LEAF_SIDE * LEAF_SIDE]) -> u64 {
    values.iter().rev().fold(0, |bits, &value| bits << 1 | u64::from(value > 0.0))
}

/// The leaves within `reach` nodes of the cells that points lie in, given in
/// nodes; sorted.
pub fn near_points(points: &[[f64; 3]], reach: i32) -> Vec<[i32; 3]> {
    const CHUNK: usize = 1024;
    let range = |at: &[f64; 3]| {
        let node = node_below(*at);
        [node.map(|along| along - reach), node.map(|along| along + 1 + reach)].map(leaf_of)
    };
    let of_chunk = |points: &[[f64; 3]]| {
        // Neighbouring points mostly lie in the same leaves.
        let mut ranges: Vec<[[i32; 3]; 2]> = points.iter().map(range).collect();
        ranges.dedup();
        ranges.into_iter().flat_map(leaves_between)
    };
    let mut leaves: Vec<[i32; 3]> = points.par_chunks(CHUNK).flat_map_iter(of_chunk).collect();
    leaves.par_sort_unstable();
    leaves.dedup();
    leaves
}

/// All leaves from one to another.
pub fn leaves_between([low, high]: [[i32; 3]; 2]) -> impl Iterator<Item = [i32; 3]> {
    (low[0]..=high[0]).flat_map(move |x| {
        (low[1]..=high[1]).flat_map(move |y| (low[2]..=high[2]).map(move |z| [x, y, z]))
    })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::grid::invariant::node_offset;
    use crate::grid::lattice::Resolution;
    use crate::plane::Bounds;

    fn level(voxels: u32, is_open: bool) -> Level {
        let bounds = Bounds { min: DVec3::new(-1.0, 2.0, 0.0), max: DVec3::new(1.0, 3.5, 1.0) };
        Level::new(Lattice::new(bounds, Resolution::Voxels(voxels)).unwrap(), is_open)
    }

    /// Fills a level with a function of world points, in its voxels.
    fn fill(level: &mut Level, value: impl Fn(DVec3) -> f64 + Sync) {
        let all: Vec<[i32; 3]> = level.grid.all_places().collect();
        let settle = |lattice: &Lattice, _: &Domain, leaf: [i32; 3], values: &mut LeafNodes| {
            for (node, own) in values.iter_mut().enumerate() {
                let offset = node_offset(node);
                let at = std::array::from_fn(|axis| leaf[axis] * SIDE + offset[axis] as i32);
                *own = (value(lattice.position(at)) / lattice.voxel) as f32;
            }
        };
        ensure(std::slice::from_mut(level), all, &settle);
    }

    #[test]
    fn quadratics_are_interpolated_as_they_are() {
        let value = |p: DVec3| 0.3 - p.x * p.y + 0.5 * p.z * p.z - p.y;
        for (coarse, fine, is_open) in [(24, 48, false), (24, 33, false), (24, 48, true)] {
            let mut levels = [level(coarse, is_open), level(fine, is_open)];
            fill(&mut levels[0], value);
            let leaf = [1, 1, 1];
            ensure(&mut levels, [leaf], &|_, _, _, _| ());
            let [_, fine] = &levels;
            let slot = fine.grid.slot(leaf);
            for (node, &found) in fine.grid.leaf(slot).iter().enumerate() {
                let offset = node_offset(node);
                let at = std::array::from_fn(|axis| leaf[axis] * SIDE + offset[axis] as i32);
                let expected = value(fine.lattice.position(at)) / fine.lattice.voxel;
                assert!((f64::from(found) - expected).abs() < 1e-4, "{found} {expected}");
            }
        }
    }

    #[test]
    fn beyond_an_open_box_lines_go_on() {
        let value = |p: DVec3| 0.3 - p.x + 2.0 * p.y - 0.7 * p.z;
        let mut levels = [level(24, true), level(48, true)];
        fill(&mut levels[0], value);
        let all: Vec<[i32; 3]> = levels[1].grid.all_places().collect();
        ensure(&mut levels, all, &|_, _, _, _| ());
        let fine = &levels[1];
        let [x, y, z] = fine.lattice.dims;
        for node in [[0, 0, 0], [x - 1, y - 1, z - 1], [0, y - 1, 5], [9, 0, z - 1]] {
            let expected = value(fine.lattice.position(node)) / fine.lattice.voxel;
            let found = f64::from(fine.grid.value(node).unwrap());
            assert!((found - expected).abs() < 1e-3, "{node:?}: {found} {expected}");
        }
    }

    #[test]
    fn leaves_near_a_change_of_sign_are_marked() {
        let mut level = level(64, false);
        let plane = level.lattice.position([20, 0, 0]).x + 1e-9;
        fill(&mut level, |p| p.x - plane);
        // Between nodes 20 and 21, in the leaf of 16 to 23: with a reach of 2 nodes
        // 18 to 23, with one of 3 also 24.
        let marked = |reach| {
            let mut along: Vec<i32> =
                near_changes(&level.grid, reach).iter().map(|leaf| leaf[0]).collect();
            along.dedup();
            along
        };
        assert_eq!(marked(2), [2]);
        assert_eq!(marked(3), [2, 3]);
        assert_eq!(marked(5), [1, 2, 3]);
        assert_eq!(near_points(&[[20.5, 3.0, 9.5]], 2), [[2, 0, 0], [2, 0, 1]]);
    }
}
