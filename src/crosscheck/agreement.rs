//! Where the labels of two reconstructions agree, node by node.

use std::collections::BTreeMap;
use std::ops::AddAssign;

use rayon::prelude::*;
use serde::Serialize;

use crate::grid::evidence::Evidence;
use crate::grid::labels::{LabelGrid, leaf_nodes};
use crate::grid::samples::Lattice;
use crate::label::Label;
use crate::progress::Progress;

/// Leaves that are looked at together.
const TOGETHER: usize = 64;

/// The labels of the field and of the skeleton on one lattice.
#[derive(Debug, Clone)]
pub struct Pair {
    /// The field's.
    pub field: LabelGrid,
    /// The skeleton's.
    pub skeleton: LabelGrid,
}

/// How many of the lattice's nodes in the box agree.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Agreement {
    /// Nodes in the box.
    pub nodes: u64,
    /// Those whose labels agree.
    pub agree: u64,
    /// The same as a share.
    pub share: f64,
    /// By the distance to the nearest known part of a section.
    pub bins: Vec<Bin>,
    /// By label.
    pub labels: Vec<LabelAgreement>,
}

/// Nodes within a range of distances to the sections.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bin {
    /// In voxels; the range begins here.
    pub from: f64,
    /// And ends before this.
    pub to: f64,
    /// Nodes in it.
    pub nodes: u64,
    /// Those whose labels agree.
    pub agree: u64,
    /// The same as a share.
    pub share: f64,
}

/// How many nodes have a label.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelAgreement {
    /// The label.
    pub label: u32,
    /// Nodes that have it in the field.
    pub field: u64,
    /// Nodes that have it in the skeleton.
    pub skeleton: u64,
    /// Nodes that have it in both.
    pub both: u64,
    /// The last over those that have it in either.
    pub iou: f64,
}

/// What a part of the lattice adds.
#[derive(Default)]
struct Tally {
    /// For each bin, nodes and those that agree.
    bins: Vec<[u64; 2]>,
    /// For each label the nodes of the field, of the skeleton, of both.
    labels: BTreeMap<Label, [u64; 3]>,
    differing: Vec<[i32; 3]>,
}

/// Compares all nodes in the box, and tells those that differ, leaf by leaf.
pub fn agreement(
    pair: &Pair,
    evidence: &Evidence,
    progress: &dyn Progress,
) -> (Agreement, Vec<[i32; 3]>) {
    let lattice = &pair.field.lattice;
    let leaves: Vec<usize> = (0..lattice.leaf_count() as usize).collect();
    progress.begin("agreement", leaves.len() as u64);
    let tallies: Vec<Tally> = leaves
        .par_chunks(TOGETHER)
        .map(|leaves| {
            let mut tally = Tally::default();
            leaves.iter().for_each(|&leaf| tally.add_leaf(pair, evidence, leaf));
            progress.advance(leaves.len() as u64);
            tally
        })
        .collect();
    let mut all = Tally::default();
    tallies.into_iter().for_each(|tally| all += tally);
    let agreement = all.agreement();
    (agreement, all.differing)
}

/// The bin of a distance in voxels: up to ½, up to 1, up to 2, up to 4, ….
fn bin(distance: f64) -> usize {
    if distance < 0.5 { 0 } else { (2.0 * distance).log2().floor() as usize + 1 }
}

/// Where a bin begins.
fn bin_start(bin: usize) -> f64 {
    if bin == 0 { 0.0 } else { 0.25 * 2f64.powi(bin as i32) }
}

fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 1.0 } else { part as f64 / whole as f64 }
}

impl Tally {
    fn add_leaf(&mut self, pair: &Pair, evidence: &Evidence, leaf: usize) {
        let lattice: &Lattice = &pair.field.lattice;
        let at = lattice.leaf_at(leaf);
        let distances = evidence.in_leaf(lattice, at);
        let labels = pair.field.leaf(leaf).into_iter().zip(pair.skeleton.leaf(leaf));
        for ((node, labels), distance) in leaf_nodes(at).zip(labels).zip(distances) {
            if lattice.is_inner(node) {
                self.add_node(node, labels, f64::from(distance) / lattice.voxel);
            }
        }
    }

    fn add_node(&mut self, node: [i32; 3], (field, skeleton): (Label, Label), distance: f64) {
        let bin = bin(distance);
        if self.bins.len() <= bin {
            self.bins.resize(bin + 1, [0; 2]);
        }
        let agrees = u64::from(field == skeleton);
        self.bins[bin][0] += 1;
        self.bins[bin][1] += agrees;
        let own = self.labels.entry(field).or_default();
        own[0] += 1;
        own[2] += agrees;
        self.labels.entry(skeleton).or_default()[1] += 1;
        if field != skeleton {
            self.differing.push(node);
        }
    }

    fn agreement(&self) -> Agreement {
        let bins = self.bins.iter().enumerate().map(|(bin, &[nodes, agree])| Bin {
            from: bin_start(bin),
            to: bin_start(bin + 1),
            nodes,
            agree,
            share: share(agree, nodes),
        });
        let labels = self.labels.iter().map(|(label, &[field, skeleton, both])| LabelAgreement {
            label: label.0,
            field,
            skeleton,
            both,
            iou: share(both, field + skeleton - both),
        });
        let [nodes, agree] = self.bins.iter().fold([0; 2], |[n, a], bin| [n + bin[0], a + bin[1]]);
        Agreement {
            nodes,
            agree,
            share: share(agree, nodes),
            bins: bins.collect(),
            labels: labels.collect(),
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, other: Self) {
        self.bins.resize(self.bins.len().max(other.bins.len()), [0; 2]);
        for (own, other) in self.bins.iter_mut().zip(other.bins) {
            (0..2).for_each(|count| own[count] += other[count]);
        }
        for (label, counts) in other.labels {
            let own = self.labels.entry(label).or_default();
            (0..3).for_each(|count| own[count] += counts[count]);
        }
        self.differing.extend(other.differing);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_double() {
        let starts: Vec<f64> = (0..6).map(bin_start).collect();
        assert_eq!(starts, [0.0, 0.5, 1.0, 2.0, 4.0, 8.0]);
        for (distance, expected) in [(0.0, 0), (0.49, 0), (0.5, 1), (1.0, 2), (3.9, 3), (4.0, 4)] {
            assert_eq!(bin(distance), expected, "{distance}");
        }
    }
}
