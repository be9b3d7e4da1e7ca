//! One function on a lattice, kept in leaves of 8 × 8 × 8 nodes: the values as
//! one flat slice, found by a leaf's place.

use super::invariant::node_index;
use super::leaf::LeafNodes;
use super::samples::{LEAF_NODES, LEAF_SIDE};

/// In place of a slot where a leaf has none.
pub const NO_SLOT: u32 = u32::MAX;
/// [`LEAF_SIDE`] for node indices.
const SIDE: i32 = LEAF_SIDE as i32;

/// Leaves with values. A leaf is named by its first node divided by
/// [`LEAF_SIDE`], and its values lie in the *slot* that it got when it was added.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafGrid {
    /// The first leaf that may be there, and how many along each axis.
    first: [i32; 3],
    dims: [i32; 3],
    /// For every leaf its slot, x slowest, z fastest.
    slots: Vec<u32>,
    /// For every slot its leaf.
    leaves: Vec<[i32; 3]>,
    /// For every slot the values of a [`LeafNodes`].
    values: Vec<f32>,
}

impl LeafGrid {
    /// Without leaves, for nodes from `low` up to, and without, `high`.
    pub fn new(low: [i32; 3], high: [i32; 3]) -> Self {
        let first = low.map(|node| node.div_euclid(SIDE));
        let end = high.map(|node| (node - 1).div_euclid(SIDE) + 1);
        let dims: [i32; 3] = std::array::from_fn(|axis| (end[axis] - first[axis]).max(0));
        let count: usize = dims.iter().map(|&side| side as usize).product();
        Self { first, dims, slots: vec![NO_SLOT; count], leaves: Vec::new(), values: Vec::new() }
    }

    /// With some leaves, their values zero, and no room for others.
    pub fn with_leaves(leaves: &[[i32; 3]]) -> Self {
        let along = |axis: usize| leaves.iter().map(move |leaf| leaf[axis]);
        let low = std::array::from_fn(|axis| along(axis).min().unwrap_or(0) * SIDE);
        let high = std::array::from_fn(|axis| along(axis).max().map_or(0, |last| last + 1) * SIDE);
        let mut grid = Self::new(low, high);
        grid.add(leaves.iter().copied());
        grid
    }

    /// Leaves by their slots alone, without values.
    pub fn indexed(low: [i32; 3], high: [i32; 3], leaves: &[[i32; 3]]) -> Self {
        let mut grid = Self::new(low, high);
        for (slot, &leaf) in leaves.iter().enumerate() {
            let place = grid.place(leaf);
            grid.slots[place] = slot as u32;
        }
        grid.leaves = leaves.to_vec();
        grid
    }

    /// Whether a leaf may be there.
    pub fn may_hold(&self, leaf: [i32; 3]) -> bool {
        (0..3).all(|axis| (0..self.dims[axis]).contains(&(leaf[axis] - self.first[axis])))
    }

    /// All leaves that may be there, x slowest, z fastest.
    pub fn all_places(&self) -> impl Iterator<Item = [i32; 3]> + use<> {
        let ([x, y, z], [nx, ny, nz]) = (self.first, self.dims);
        (x..x + nx)
            .flat_map(move |x| (y..y + ny).flat_map(move |y| (z..z + nz).map(move |z| [x, y, z])))
    }

    /// A leaf's slot, or [`NO_SLOT`].
    pub fn slot(&self, leaf: [i32; 3]) -> u32 {
        if self.may_hold(leaf) { self.slots[self.place(leaf)] } else { NO_SLOT }
    }

    /// The leaves there are, by slot.
    pub fn leaves(&self) -> &[[i32; 3]] {
        &self.leaves
    }

    /// The values in a slot.
    pub fn leaf(&self, slot: u32) -> &LeafNodes {
        &self.values.as_chunks().0[slot as usize]
    }

    /// The values in a slot, to be changed.
    pub fn leaf_mut(&mut self, slot: u32) -> &mut LeafNodes {
        &mut self.values.as_chunks_mut().0[slot as usize]
    }

    /// The values of a leaf, where it is there.
    pub fn get(&self, leaf: [i32; 3]) -> Option<&LeafNodes> {
        let slot = self.slot(leaf);
        (slot != NO_SLOT).then(|| self.leaf(slot))
    }

    /// The same, to be changed.
    pub fn get_mut(&mut self, leaf: [i32; 3]) -> Option<&mut LeafNodes> {
        let slot = self.slot(leaf);
        (slot != NO_SLOT).then(|| self.leaf_mut(slot))
    }

    /// All leaves with their values, slot by slot, these to be changed.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = ([i32; 3], &mut LeafNodes)> {
        self.leaves.iter().copied().zip(self.values.as_chunks_mut().0)
    }

    /// All values, slot by slot.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// All values, slot by slot, to be changed.
    pub fn values_mut(&mut self) -> &mut [f32] {
        &mut self.values
    }

    /// The value of a node, where its leaf is there.
    pub fn value(&self, node: [i32; 3]) -> Option<f32> {
        let inner = node.map(|along| along.rem_euclid(SIDE) as usize);
        self.get(leaf_of(node)).map(|leaf| leaf[node_index(inner)])
    }

    /// Adds leaves that are not there and may be, in their order, with values
    /// of zero; says which were added.
    pub fn add(&mut self, leaves: impl IntoIterator<Item = [i32; 3]>) -> std::ops::Range<usize> {
        let before = self.leaves.len();
        for leaf in leaves {
            if self.slot(leaf) == NO_SLOT && self.may_hold(leaf) {
                let place = self.place(leaf);
                self.slots[place] = self.leaves.len() as u32;
                self.leaves.push(leaf);
            }
        }
        self.values.resize(self.leaves.len() * LEAF_NODES, 0.0);
        before..self.leaves.len()
    }

    /// Adds a leaf that is not there and may be, with its values.
    pub fn insert(&mut self, leaf: [i32; 3], values: &LeafNodes) {
        let added = self.add([leaf]);
        if !added.is_empty() {
            *self.leaf_mut(added.start as u32) = *values;
        }
    }

    /// Removes the leaves that are not to be kept; the others move up, in their order.
    pub fn retain(&mut self, keep: impl Fn([i32; 3], &LeafNodes) -> bool) {
        let mut kept = 0;
        for slot in 0..self.leaves.len() {
            let leaf = self.leaves[slot];
            let is_kept = keep(leaf, self.leaf(slot as u32));
            let place = self.place(leaf);
            self.slots[place] = if is_kept { kept as u32 } else { NO_SLOT };
            if is_kept {
                self.leaves[kept] = leaf;
                let start = slot * LEAF_NODES;
                self.values.copy_within(start..start + LEAF_NODES, kept * LEAF_NODES);
                kept += 1;
            }
        }
        self.leaves.truncate(kept);
        self.values.truncate(kept * LEAF_NODES);
    }

    /// The same leaves under other names, `by` farther on, for nodes from `low` up to, and
    /// without, `high`: those that may not be there then are left out.
    pub fn moved(&self, by: [i32; 3], low: [i32; 3], high: [i32; 3]) -> Self {
        let mut moved = Self::new(low, high);
        for (leaf, values) in self.leaves.iter().zip(self.values.as_chunks().0) {
            moved.insert(leaf_after(*leaf, by), values);
        }
        moved
    }

    /// Gives back the memory that others would be added in.
    pub fn shrink_to_fit(&mut self) {
        self.values.shrink_to_fit();
    }

    /// The values of the `SIDES`³ nodes from `low` on, in a buffer of that
    /// size, z fastest; 0 where there is no leaf.
    pub fn gather<const SIDES: usize>(&self, low: [i32; 3], out: &mut [f32]) {
        let leaf_of = |along: i32| along.div_euclid(SIDE);
        out[..SIDES * SIDES * SIDES].fill(0.0);
        let high = low.map(|along| along + SIDES as i32);
        for x in leaf_of(low[0])..=leaf_of(high[0] - 1) {
            for y in leaf_of(low[1])..=leaf_of(high[1] - 1) {
                for z in leaf_of(low[2])..=leaf_of(high[2] - 1) {
                    if let Some(leaf) = self.get([x, y, z]) {
                        copy_common::<SIDES>(leaf, [x, y, z], low, out);
                    }
                }
            }
        }
    }

    fn place(&self, leaf: [i32; 3]) -> usize {
        let [x, y, z] = std::array::from_fn(|axis| (leaf[axis] - self.first[axis]) as usize);
        (x * self.dims[1] as usize + y) * self.dims[2] as usize + z
    }
}

/// A set of leaves.
#[derive(Debug, Clone)]
pub struct LeafSet {
    first: [i32; 3],
    dims: [i32; 3],
    has: Vec<bool>,
}

impl LeafSet {
    /// Empty, for leaves that a grid may hold.
    pub fn new(grid: &LeafGrid) -> Self {
        Self { first: grid.first, dims: grid.dims, has: vec![false; grid.slots.len()] }
    }

    /// Adds a leaf, if the grid may hold it; says whether it is new.
    pub fn insert(&mut self, leaf: [i32; 3]) -> bool {
        match self.place(leaf) {
            Some(place) => !std::mem::replace(&mut self.has[place], true),
            None => false,
        }
    }

    /// Its leaves, sorted.
    pub fn sorted(&self) -> Vec<[i32; 3]> {
        let [_, y, z] = self.dims.map(|side| side as usize);
        let places = self.has.iter().enumerate().filter(|(_, has)| **has);
        let leaf = |(place, _): (usize, &bool)| {
            let at = [place / (y * z), place / z % y, place % z];
            std::array::from_fn(|axis| at[axis] as i32 + self.first[axis])
        };
        places.map(leaf).collect()
    }

    /// Whether a leaf is there.
    pub fn has(&self, leaf: [i32; 3]) -> bool {
        self.place(leaf).is_some_and(|place| self.has[place])
    }

    fn place(&self, leaf: [i32; 3]) -> Option<usize> {
        let at: [i32; 3] = std::array::from_fn(|axis| leaf[axis] - self.first[axis]);
        let inside = (0..3).all(|axis| (0..self.dims[axis]).contains(&at[axis]));
        inside.then(|| {
            (at[0] as usize * self.dims[1] as usize + at[1] as usize) * self.dims[2] as usize
                + at[2] as usize
        })
    }
}

/// Copies the nodes that a leaf and a cube of `SIDES`³ nodes have in common.
fn copy_common<const SIDES: usize>(
    values: &LeafNodes,
    leaf: [i32; 3],
    low: [i32; 3],
    out: &mut [f32],
) {
    let origin = leaf.map(|along| along * SIDE);
    let range = |axis: usize| {
        origin[axis].max(low[axis])..(origin[axis] + SIDE).min(low[axis] + SIDES as i32)
    };
    let along_z = range(2);
    let count = along_z.len();
    for x in range(0) {
        for y in range(1) {
            let from = node_index([
                (x - origin[0]) as usize,
                (y - origin[1]) as usize,
                (along_z.start - origin[2]) as usize,
            ]);
            let row = (x - low[0]) as usize * SIDES + (y - low[1]) as usize;
            let to = row * SIDES + (along_z.start - low[2]) as usize;
            out[to..to + count].copy_from_slice(&values[from..from + count]);
        }
    }
}

/// The node at or before a place given in nodes, along each axis.
pub fn node_below(at: [f64; 3]) -> [i32; 3] {
    // `f64::floor` is a call where a processor may lack the instruction.
    at.map(|along| {
        let toward_zero = along as i32;
        toward_zero - i32::from(along < f64::from(toward_zero))
    })
}

/// The leaf that holds a node.
pub fn leaf_of(node: [i32; 3]) -> [i32; 3] {
    node.map(|along| along.div_euclid(SIDE))
}

/// The leaf so many leaves farther on.
pub fn leaf_after(leaf: [i32; 3], by: [i32; 3]) -> [i32; 3] {
    std::array::from_fn(|axis| leaf[axis] + by[axis])
}

/// The 27 leaves around a leaf, itself in the middle: x slowest, z fastest.
pub fn around([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..27).map(move |step| [x + step / 9 - 1, y + step / 3 % 3 - 1, z + step % 3 - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number([x, y, z]: [i32; 3]) -> f32 {
        (x * 10_000 + y * 100 + z) as f32
    }

    /// All leaves of nodes −1 to 17 but one, every value the node's number.
    fn grid(left_out: [i32; 3]) -> LeafGrid {
        let mut grid = LeafGrid::new([-1; 3], [18; 3]);
        let places = grid.all_places();
        let added = grid.add(places.filter(|&leaf| leaf != left_out));
        // Leaves −1, 0, 1 and 2 along each axis.
        assert_eq!(added, 0..63);
        for slot in 0..63 {
            let origin = grid.leaves()[slot].map(|along| along * SIDE);
            for node in 0..LEAF_NODES {
                let offset = super::super::invariant::node_offset(node);
                let at = std::array::from_fn(|axis| origin[axis] + offset[axis] as i32);
                grid.values_mut()[slot * LEAF_NODES + node] = number(at);
            }
        }
        grid
    }

    #[test]
    fn nodes_are_found_in_their_leaves() {
        let grid = grid([1, 0, 2]);
        for node in [[-1, 0, 17], [7, 8, 15], [3, -8, 16], [23, 23, 23]] {
            assert_eq!(grid.value(node), Some(number(node)));
        }
        assert_eq!(grid.value([8, 0, 16]), None, "in the leaf that is left out");
        assert_eq!(grid.value([24, 0, 0]), None, "beyond the grid");
    }

    #[test]
    fn a_place_lies_after_the_node_below_it() {
        assert_eq!(node_below([2.75, -0.25, -3.0]), [2, -1, -3]);
        assert_eq!(node_below([0.0, -1e-300, 7.999]), [0, -1, 7]);
    }

    #[test]
    fn what_is_kept_is_found() {
        let all = grid([1, 0, 2]);
        let is_kept = |[x, y, z]: [i32; 3]| (x + y + z) % 2 == 0;
        let mut some = all.clone();
        some.retain(|leaf, values| {
            assert_eq!(values[0], number(leaf.map(|along| along * SIDE)));
            is_kept(leaf)
        });
        assert!(some.leaves().is_sorted() && some.values().len() == 32 * LEAF_NODES);
        for leaf in all.all_places() {
            assert_eq!(some.get(leaf), all.get(leaf).filter(|_| is_kept(leaf)), "{leaf:?}");
        }
        // Others come after them.
        some.insert([1, 0, 2], &[3.0; LEAF_NODES]);
        assert_eq!((some.slot([1, 0, 2]), some.value([8, 0, 16])), (32, Some(3.0)));
        assert_eq!(some.value([0, 0, 0]), Some(number([0, 0, 0])));
    }

    #[test]
    fn leaves_move() {
        let all = grid([1, 0, 2]);
        let moved = all.moved([2, -1, 0], [0; 3], [24, 16, 24]);
        for leaf in moved.all_places() {
            let was = leaf_after(leaf, [-2, 1, 0]);
            assert_eq!(moved.get(leaf), all.get(was), "{leaf:?}");
        }
        // Along y leaves 1 and 2 stayed, along z those from 0 on, along x −1 and 0.
        assert_eq!(moved.leaves().len(), 2 * 2 * 3);
    }

    #[test]
    fn what_is_gathered_crosses_leaves() {
        let grid = grid([1, 0, 2]);
        let low = [5, -3, 9];
        let mut out = vec![f32::NAN; 12 * 12 * 12];
        grid.gather::<12>(low, &mut out);
        for (index, &value) in out.iter().enumerate() {
            let offset = [index / 144, index / 12 % 12, index % 12];
            let node: [i32; 3] = std::array::from_fn(|axis| low[axis] + offset[axis] as i32);
            let expected = if leaf_of(node) == [1, 0, 2] { 0.0 } else { number(node) };
            assert_eq!(value, expected, "{node:?}");
        }
    }
}
