//! The field's values at lattice nodes near the surface, a [`LeafGrid`] for each
//! label: what fields are sampled into, and what meshers read.

use glam::DVec3;
use rayon::prelude::*;

use crate::label::Label;
use crate::plane::Bounds;

use super::leaf::{Leaf, LeafMut, LeafNodes, LeafOf, LeafValues, NewLeaf};
use super::leaf_grid::{LeafGrid, leaf_after};

/// Nodes of a leaf along each axis, as in OpenVDB.
pub const LEAF_SIDE: usize = 8;
/// Nodes of a leaf.
pub const LEAF_NODES: usize = LEAF_SIDE * LEAF_SIDE * LEAF_SIDE;

/// Node (i, j, k) lies at `origin + voxel * (i, j, k)`, for every component
/// in `0..dims`. The outermost layer of nodes lies outside the box, or on it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lattice {
    /// Node (0, 0, 0), in world units.
    pub origin: DVec3,
    /// The spacing, in world units.
    pub voxel: f64,
    /// Nodes along each axis.
    pub dims: [i32; 3],
}

impl Lattice {
    /// Where a node is.
    pub fn position(&self, node: [i32; 3]) -> DVec3 {
        self.origin + self.voxel * DVec3::new(node[0].into(), node[1].into(), node[2].into())
    }

    /// Whether a node is neither on the lattice's border nor beyond it.
    pub fn is_inner(&self, node: [i32; 3]) -> bool {
        (0..3).all(|axis| 0 < node[axis] && node[axis] < self.dims[axis] - 1)
    }

    /// The nearest node that [is inner](Self::is_inner), if there is any.
    pub fn nearest_inner(&self, node: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|axis| node[axis].min(self.dims[axis] - 2).max(1))
    }

    /// Leaves along each axis.
    pub fn leaf_dims(&self) -> [i32; 3] {
        self.dims.map(|nodes| (nodes + LEAF_SIDE as i32 - 1) / LEAF_SIDE as i32)
    }
}

/// What samples are values of.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Values {
    /// The indicators of all labels, in [−1, 1]: next to a section s/√(s² + γ²), s
    /// being the distance to the contour and γ that to the section.
    #[default]
    Indicators,
    /// Functions that near the surface are about the distance to it, in voxels,
    /// positive inside.
    Distances,
}

impl Values {
    /// The lead of one label over another as something that is linear along an edge
    /// of the lattice; for indicators d/√(1 − d²) is.
    pub fn straightened(self, lead: f64) -> f64 {
        match self {
            Self::Indicators => lead / (1.0 - lead * lead).max(1e-6).sqrt(),
            Self::Distances => lead,
        }
    }

    /// The lead of a label at a distance in voxels before a plane on which it ends: the
    /// inverse of [`Self::straightened`].
    pub fn lead_of(self, distance: f64) -> f64 {
        match self {
            Self::Indicators => distance / (1.0 + distance * distance).sqrt(),
            Self::Distances => distance,
        }
    }

    /// A value as an indicator.
    pub fn indicator(self, value: f32) -> f32 {
        match self {
            Self::Indicators => value,
            Self::Distances => value / (1.0 + value * value).sqrt(),
        }
    }
}

/// One label's values, in all leaves that it is near to.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelValues {
    /// The label: a material, or *outside* where it has values of its own.
    pub label: Label,
    /// The values.
    pub grid: LeafGrid,
}

impl LabelValues {
    fn in_leaf(&self, at: [i32; 3]) -> Option<LeafValues<&LeafNodes>> {
        Some(LeafValues { label: self.label, values: self.grid.get(at)? })
    }

    fn in_leaf_mut(&mut self, at: [i32; 3]) -> Option<LeafValues<&mut LeafNodes>> {
        Some(LeafValues { label: self.label, values: self.grid.get_mut(at)? })
    }
}

/// Leaves near the surface, and one label for each of the others.
///
/// Invariant: where two neighbouring nodes have different labels, both lie in
/// leaves of [`Samples::valued`] or have the labels of [`Samples::tiles`]; the
/// label of every node of the lattice is thus defined. The outermost nodes of
/// the lattice are outside, unless the box is open.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Where the nodes are.
    pub lattice: Lattice,
    /// The leaves whose nodes have values of their own, sorted.
    pub valued: Vec<[i32; 3]>,
    /// The labels that are near some of them, sorted; each has values in those.
    pub fields: Vec<LabelValues>,
    /// For every leaf of the lattice its label where it is not in `valued`,
    /// x slowest, z fastest.
    pub tiles: Vec<Label>,
    /// The box, when it is open: materials reach up to its faces, and nodes
    /// that are not inside have the values of the nearest nodes that are. What
    /// lies beyond the box is outside all the same, and meshers end the
    /// surface on its faces.
    pub open: Option<Bounds>,
    /// What the leaves hold.
    pub values: Values,
}

impl Samples {
    /// Of tiles alone: no leaf has values.
    pub fn new(lattice: Lattice, tiles: Vec<Label>, open: Option<Bounds>, values: Values) -> Self {
        Self { lattice, valued: Vec::new(), fields: Vec::new(), tiles, open, values }
    }

    /// Adds leaves of the lattice that have no values yet.
    pub fn add(&mut self, leaves: impl IntoIterator<Item = NewLeaf>) {
        for LeafOf { at, materials } in leaves {
            self.valued.push(at);
            for LeafValues { label, values } in materials {
                self.grid_of(label).insert(at, &values);
            }
        }
        // Those that were there are in order, which this kind of sorting makes use of.
        self.valued.sort();
    }

    /// A label's values, without any if there are none so far.
    fn grid_of(&mut self, label: Label) -> &mut LeafGrid {
        let place = self.fields.partition_point(|field| field.label < label);
        if self.fields.get(place).is_none_or(|field| field.label != label) {
            let grid = LeafGrid::new([0; 3], self.lattice.dims);
            self.fields.insert(place, LabelValues { label, grid });
        }
        &mut self.fields[place].grid
    }

    /// The same on another lattice, on which leaves are `by` farther on; those that it does not
    /// have are left out, and where there was none it is outside.
    pub fn moved(&self, by: [i32; 3], lattice: Lattice) -> Self {
        let tile = |index| {
            let was = leaf_after(lattice.leaf_at(index), by.map(|along| -along));
            self.lattice.tile(&self.tiles, was)
        };
        let field = |field: &LabelValues| LabelValues {
            label: field.label,
            grid: field.grid.moved(by, [0; 3], lattice.dims),
        };
        let valued = self.valued.iter().map(|&leaf| leaf_after(leaf, by));
        Self {
            lattice,
            valued: valued.filter(|&leaf| lattice.has_leaf(leaf)).collect(),
            fields: self.fields.iter().map(field).collect(),
            tiles: (0..lattice.leaf_count() as usize).map(tile).collect(),
            ..*self
        }
    }

    /// Takes the values of leaves away; they are then what their tiles are.
    pub fn retain(&mut self, keep: impl Fn([i32; 3]) -> bool + Sync) {
        self.valued.retain(|&at| keep(at));
        self.fields.par_iter_mut().for_each(|field| field.grid.retain(|at, _| keep(at)));
        self.fields.retain(|field| !field.grid.leaves().is_empty());
    }

    /// Whether a leaf has values of its own.
    pub fn is_valued(&self, at: [i32; 3]) -> bool {
        self.valued.binary_search(&at).is_ok()
    }

    /// The label of a leaf's nodes, where they have no values of their own.
    pub fn tile(&self, at: [i32; 3]) -> Label {
        self.lattice.tile(&self.tiles, at)
    }

    /// The leaf at `at`, where it has values of its own.
    pub fn leaf(&self, at: [i32; 3]) -> Option<Leaf<'_>> {
        self.is_valued(at).then(|| self.view(at))
    }

    /// The same, to be changed.
    pub fn leaf_mut(&mut self, at: [i32; 3]) -> Option<LeafMut<'_>> {
        self.is_valued(at).then(|| {
            let own = self.fields.iter_mut().filter_map(|field| field.in_leaf_mut(at));
            LeafOf { at, materials: own.collect() }
        })
    }

    /// All leaves with values of their own, in their order.
    pub fn leaves(&self) -> impl Iterator<Item = Leaf<'_>> {
        self.valued.iter().map(|&at| self.view(at))
    }

    /// The same for all threads.
    pub fn par_leaves(&self) -> impl IndexedParallelIterator<Item = Leaf<'_>> {
        self.valued.par_iter().map(|&at| self.view(at))
    }

    /// The same, to be changed by whichever thread.
    pub fn leaves_mut(&mut self) -> Vec<LeafMut<'_>> {
        let leaf = |&at: &[i32; 3]| LeafOf { at, materials: Vec::new() };
        let mut leaves: Vec<LeafMut> = self.valued.iter().map(leaf).collect();
        for LabelValues { label, grid } in &mut self.fields {
            for (at, values) in grid.iter_mut() {
                if let Ok(place) = self.valued.binary_search(&at) {
                    leaves[place].materials.push(LeafValues { label: *label, values });
                }
            }
        }
        leaves
    }

    fn view(&self, at: [i32; 3]) -> Leaf<'_> {
        let own = self.fields.iter().filter_map(|field| field.in_leaf(at));
        LeafOf { at, materials: own.collect() }
    }

    /// The materials that occur, sorted.
    pub fn materials(&self) -> Vec<Label> {
        let valued = self.fields.iter().map(|field| field.label);
        let mut labels: Vec<Label> =
            valued.chain(self.tiles.iter().copied()).filter(|label| label.is_material()).collect();
        labels.sort_unstable();
        labels.dedup();
        labels
    }

    /// Whether everything that the type promises holds.
    ///
    /// # Errors
    /// What does not, and where.
    pub fn sanity_check(&self) -> std::result::Result<(), String> {
        super::invariant::check(self)
    }
}
