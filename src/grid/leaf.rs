//! One leaf of samples, with what all labels that are near have in it.

use std::ops::Deref;

use crate::label::Label;

use super::invariant::node_offset;
use super::samples::{LEAF_NODES, LEAF_SIDE};

/// The values of a leaf's nodes: node (x, y, z) of the leaf is at
/// `x * 64 + y * 8 + z`, as in OpenVDB.
pub type LeafNodes = [f32; LEAF_NODES];

/// One label's values in one leaf.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafValues<V> {
    /// The label: a material, or *outside* where it has values of its own.
    pub label: Label,
    /// A [`LeafNodes`], or where one is.
    pub values: V,
}

/// A leaf whose nodes have values of their own, wherever these are.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafOf<V> {
    /// Its first node, divided by [`LEAF_SIDE`].
    pub at: [i32; 3],
    /// The labels that are near, sorted. Where *outside* is not among them it is
    /// implied: (f + 1) / 2 summed up over all labels makes 1, so beside a single
    /// material it is −f.
    pub materials: Vec<LeafValues<V>>,
}

/// A leaf of samples.
pub type Leaf<'a> = LeafOf<&'a LeafNodes>;
/// A leaf of samples, to be changed.
pub type LeafMut<'a> = LeafOf<&'a mut LeafNodes>;
/// A leaf that is not in samples yet.
pub type NewLeaf = LeafOf<Box<LeafNodes>>;

impl<V: Deref<Target = LeafNodes>> LeafOf<V> {
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
    fn own_materials(&self) -> &[LeafValues<V>] {
        let own = self.materials.first().is_some_and(|first| first.label == Label::OUTSIDE);
        &self.materials[usize::from(own)..]
    }

    /// One of its nodes in the lattice.
    pub fn node(&self, node: usize) -> [i32; 3] {
        let offset = node_offset(node);
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

fn share<V: Deref<Target = LeafNodes>>(own: &LeafValues<V>, node: usize) -> f64 {
    (f64::from(own.values[node]) + 1.0) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_margin_is_the_lead_over_the_second_best() {
        let own = |label, value| LeafValues {
            label: Label(label),
            values: Box::new([value; LEAF_NODES]),
        };
        let margin = |materials| LeafOf { at: [0; 3], materials }.margins()[100];
        // Shares of 0.6, 0.3 and, outside, 0.1.
        assert!((margin(vec![own(1, 0.2), own(2, -0.4)]) - 0.6).abs() < 1e-6);
        // Shares of 0.25 and, outside, 0.75.
        assert!((margin(vec![own(4, -0.5)]) - 1.0).abs() < 1e-6);
        assert_eq!(margin(vec![own(4, 1.0)]), 2.0);
        assert_eq!(margin(vec![]), 2.0);
    }
}
