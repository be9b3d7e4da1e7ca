//! The field's values at lattice nodes near the surface, as flat arrays: what
//! comes out of sampling and out of the OpenVDB tree, and what the mesher
//! reads.

use glam::DVec3;

use crate::label::Label;
use crate::plane::Bounds;

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

/// One label's values in one leaf.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafValues {
    /// The label: a material, or *outside* where it has values of its own.
    pub label: Label,
    /// [`LEAF_NODES`] values; node (x, y, z) of the leaf is at
    /// `x * 64 + y * 8 + z`, as in OpenVDB.
    pub values: Vec<f32>,
}

/// A leaf whose nodes have values of their own.
#[derive(Debug, Clone, PartialEq)]
pub struct Leaf {
    /// Its first node, divided by [`LEAF_SIDE`].
    pub at: [i32; 3],
    /// The labels that are near, sorted. Where *outside* is not among them it is
    /// implied: (f + 1) / 2 summed up over all labels makes 1, so beside a single
    /// material it is −f.
    pub materials: Vec<LeafValues>,
}

impl Leaf {
    /// How much of a node is this label: (f + 1) / 2, which for indicators is a
    /// share in [0, 1]. A label that is not near has none.
    pub fn share(&self, node: usize, label: Label) -> f64 {
        let own = self.materials.iter().find(|material| material.label == label);
        match own {
            Some(own) => share(own, node),
            None if label == Label::OUTSIDE => {
                1.0 - self.materials.iter().map(|material| share(material, node)).sum::<f64>()
            }
            None => 0.0,
        }
    }

    /// The labels other than *outside* that are near, each with its values.
    fn own_materials(&self) -> &[LeafValues] {
        let own = self.materials.first().is_some_and(|first| first.label == Label::OUTSIDE);
        &self.materials[usize::from(own)..]
    }

    /// One of its nodes in the lattice.
    pub fn node(&self, node: usize) -> [i32; 3] {
        let offset = super::invariant::node_offset(node);
        std::array::from_fn(|axis| self.at[axis] * LEAF_SIDE as i32 + offset[axis] as i32)
    }

    /// How far every node's label leads over the second best: the difference of
    /// their values, for indicators from 0 to 2.
    pub fn margins(&self) -> Vec<f32> {
        let margin = |node: usize| {
            let outside = self.share(node, Label::OUTSIDE);
            let shares = self.own_materials().iter().map(|own| share(own, node));
            let [best, second] = shares.fold([outside, 0.0], |[best, second], share: f64| {
                [best.max(share), second.max(best.min(share))]
            });
            (2.0 * (best - second)).max(0.0) as f32
        };
        (0..LEAF_NODES).map(margin).collect()
    }

    /// The label of every node: the one with the largest share, of equals the
    /// smallest.
    pub fn labels(&self) -> Vec<Label> {
        (0..LEAF_NODES)
            .map(|node| {
                let outside = (Label::OUTSIDE, self.share(node, Label::OUTSIDE));
                let materials = self.own_materials().iter();
                let materials = materials.map(|material| (material.label, share(material, node)));
                materials.fold(outside, |best, next| if next.1 > best.1 { next } else { best }).0
            })
            .collect()
    }
}

fn share(own: &LeafValues, node: usize) -> f64 {
    (f64::from(own.values[node]) + 1.0) / 2.0
}

/// Leaves near the surface, and one label for each of the others.
///
/// Invariant: where two neighbouring nodes have different labels, both lie in
/// leaves of [`Samples::leaves`] or have the labels of [`Samples::tiles`]; the
/// label of every node of the lattice is thus defined. The outermost nodes of
/// the lattice are outside, unless the box is open.
#[derive(Debug, Clone, PartialEq)]
pub struct Samples {
    /// Where the nodes are.
    pub lattice: Lattice,
    /// Sorted by `at`.
    pub leaves: Vec<Leaf>,
    /// For every leaf of the lattice its label where it is not in `leaves`,
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
    /// The leaf at `at`, where it has values of its own.
    pub fn leaf(&self, at: [i32; 3]) -> Option<&Leaf> {
        self.leaves.binary_search_by_key(&at, |leaf| leaf.at).ok().map(|index| &self.leaves[index])
    }

    /// The materials that occur, sorted.
    pub fn materials(&self) -> Vec<Label> {
        let valued = self.leaves.iter().flat_map(|leaf| &leaf.materials).map(|own| own.label);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_margin_is_the_lead_over_the_second_best() {
        let own =
            |label, value| LeafValues { label: Label(label), values: vec![value; LEAF_NODES] };
        let margin = |materials| Leaf { at: [0; 3], materials }.margins()[100];
        // Shares of 0.6, 0.3 and, outside, 0.1.
        assert!((margin(vec![own(1, 0.2), own(2, -0.4)]) - 0.6).abs() < 1e-6);
        // Shares of 0.25 and, outside, 0.75.
        assert!((margin(vec![own(4, -0.5)]) - 1.0).abs() < 1e-6);
        assert_eq!(margin(vec![own(4, 1.0)]), 2.0);
        assert_eq!(margin(vec![]), 2.0);
    }
}
