//! The connected parts in which two reconstructions differ.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;

use super::agreement::Pair;
use crate::grid::runs::{Neighbors, Run, Runs};
use crate::label::Label;

/// How many parts are listed.
const LISTED: usize = 16;

/// Neighbouring nodes with one label in the field and another in the skeleton.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Part {
    /// The label in the field.
    pub field: u32,
    /// The label in the skeleton.
    pub skeleton: u32,
    /// Its nodes times a voxel, in cubic world units.
    pub volume: f64,
    /// The node farthest from where the two agree.
    pub at: [f64; 3],
    /// How far that is, in voxels: about half the part's thickness.
    pub depth: f64,
}

/// How many parts there are, and the deepest of them, at most 16. `differing`
/// are the nodes that differ, `depths` their distances to the nearest that do
/// not, in world units.
pub fn parts(pair: &Pair, differing: &[[i32; 3]], depths: &[f32]) -> (usize, Vec<Part>) {
    let lattice = &pair.field.lattice;
    let mut order: Vec<usize> = (0..differing.len()).collect();
    order.sort_unstable_by_key(|&index| differing[index]);
    let runs = runs(pair, differing, &order);
    let part_of = runs.parts(Neighbors::Six);
    // Runs are in the nodes' order.
    let mut nodes = order.iter();
    let mut parts: BTreeMap<u32, Part> = BTreeMap::new();
    for (run, &number) in runs.runs.iter().zip(&part_of) {
        let [field, skeleton] = run.label;
        for &index in nodes.by_ref().take(run.len() as usize) {
            let part = parts.entry(number).or_insert(Part {
                field: field.0,
                skeleton: skeleton.0,
                volume: 0.0,
                at: lattice.position(differing[index]).to_array(),
                depth: 0.0,
            });
            part.volume += lattice.voxel.powi(3);
            let depth = f64::from(depths[index]) / lattice.voxel;
            if depth > part.depth {
                (part.depth, part.at) = (depth, lattice.position(differing[index]).to_array());
            }
        }
    }
    let count = parts.len();
    let mut parts: Vec<Part> = parts.into_values().collect();
    // Stable: of equals the first.
    parts.sort_by(|one, other| other.depth.total_cmp(&one.depth));
    parts.truncate(LISTED);
    (count, parts)
}

/// Runs of nodes with one pair of labels, from nodes in their order.
fn runs(pair: &Pair, differing: &[[i32; 3]], order: &[usize]) -> Runs<[Label; 2]> {
    let [x, y, _] = pair.field.lattice.dims.map(|nodes| nodes as usize);
    let mut nodes = order.iter().map(|&index| differing[index]).peekable();
    Runs::new([x, y], |row, runs| {
        let first = runs.len();
        let in_row = |node: &[i32; 3]| [node[0] as usize, node[1] as usize] == row;
        while let Some(node) = nodes.next_if(in_row) {
            let label = [pair.field.at(node), pair.skeleton.at(node)];
            match runs[first..].last_mut() {
                Some(run) if run.label == label && run.end == node[2] => run.end += 1,
                _ => runs.push(Run { start: node[2], end: node[2] + 1, label }),
            }
        }
    })
}

/// Where nodes are.
pub fn positions(pair: &Pair, nodes: &[[i32; 3]]) -> Vec<DVec3> {
    nodes.iter().map(|&node| pair.field.lattice.position(node)).collect()
}
