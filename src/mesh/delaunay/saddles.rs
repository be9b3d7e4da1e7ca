//! What is connected across a checkerboard: a lattice face with one label at
//! two opposite corners, and others at the other two.
//!
//! The dual mesh decides that from the samples. Distances interpolated across
//! the face decide it from their saddle: let f0 … f3 be by how much the first
//! label leads at the corners, f0 and f2 positive; then that label is connected
//! when f0 f2 > f1 f3. Where the two do not agree a piece would come apart
//! here, or two become one. All distances at a node may be multiplied by the
//! same factor: the surface crosses the same lattice edges, and every
//! cell at the node sees the same. So factors are found for the corners with
//! which each face is connected as in the dual mesh, clearly enough to be
//! sampled.

use std::collections::HashMap;

use rayon::prelude::*;

use super::oracle::{Borders, global};
use crate::grid::samples::LEAF_NODES;
use crate::label::Label;
use crate::mesh::dual::block::{corner_nodes, face_links};
use crate::mesh::dual::cell::{FACE_CORNERS, Links};
use crate::mesh::dual::patch::{Leaves, Patch};

/// How many times f1 f3 the product f0 f2 must be: what connects is then four
/// fifths of a voxel wide where all distances are alike.
const CLEARLY: f64 = 4.0;
/// The largest factor, and the smallest is one over it.
const MOST: f64 = 16.0;
/// Faces share corners, so each is looked at more than once.
const SWEEPS: usize = 16;

/// A checkerboard face: the corners that are connected, and the others.
struct Face {
    connected: [[i32; 3]; 2],
    apart: [[i32; 3]; 2],
    /// The products of the leads at each two.
    products: [f64; 2],
}

/// What the distances at a node are to be multiplied by, where it is not 1.
pub struct Factors(HashMap<[i32; 3], f64>);

impl Factors {
    /// For all checkerboards of the samples.
    pub fn new(leaves: &Leaves, borders: &Borders) -> Self {
        let faces: Vec<Face> = (0..leaves.count())
            .into_par_iter()
            .flat_map_iter(|place| {
                let at = leaves.at(place);
                let patch = Patch::gather(leaves, at).map(Patch::extended);
                patch.map_or(vec![], |patch| checkerboards(&patch, at, borders))
            })
            .collect();
        let mut factors: HashMap<[i32; 3], f64> = HashMap::new();
        let factor = |factors: &HashMap<_, _>, node| factors.get(&node).copied().unwrap_or(1.0);
        for _ in 0..SWEEPS {
            let mut is_settled = true;
            for face in &faces {
                let [connected, apart] = [face.connected, face.apart].map(|nodes| {
                    nodes.into_iter().map(|node| factor(&factors, node)).product::<f64>()
                });
                let ratio = CLEARLY * (apart * face.products[1]) / (connected * face.products[0]);
                if ratio <= 1.0 + 1e-9 || ratio.is_nan() {
                    continue;
                }
                is_settled = false;
                let share = ratio.powf(0.25);
                for (nodes, share) in [(face.connected, share), (face.apart, 1.0 / share)] {
                    for node in nodes {
                        let new = factor(&factors, node) * share;
                        factors.insert(node, new.clamp(1.0 / MOST, MOST));
                    }
                }
            }
            if is_settled {
                break;
            }
        }
        Self(factors)
    }

    /// The factor of a node.
    pub fn at(&self, node: [i32; 3]) -> f32 {
        self.0.get(&node).map_or(1.0, |&factor| factor as f32)
    }
}

/// The checkerboards among the low faces of a leaf's cells.
fn checkerboards(patch: &Patch, at: [i32; 3], borders: &Borders) -> Vec<Face> {
    let mut faces = Vec::new();
    for place in 0..LEAF_NODES {
        let node = [place / 64, place / 8 % 8, place % 8];
        let nodes = corner_nodes(node);
        let labels = nodes.map(|corner| patch.label(corner));
        if labels.iter().all(|&label| label == labels[0]) {
            continue;
        }
        for side in [0, 2, 4] {
            let corners = FACE_CORNERS[side];
            let (connected, apart) = match face_links(patch, node, &labels, side) {
                Links::Together => continue,
                Links::AroundOdd => ([corners[0], corners[2]], [corners[1], corners[3]]),
                Links::AroundEven => ([corners[1], corners[3]], [corners[0], corners[2]]),
            };
            let label = labels[connected[0]];
            let others = [labels[apart[0]], labels[apart[1]]];
            let lead =
                |corner: usize| lead(borders, at, nodes[corner], labels[corner], label, others);
            let product = |corners: [usize; 2]| corners.map(lead).into_iter().product::<f64>();
            let global = |corner: usize| global(at, nodes[corner]);
            faces.push(Face {
                connected: connected.map(global),
                apart: apart.map(global),
                products: [product(connected), product(apart)],
            });
        }
    }
    faces
}

/// By how much a label is nearer than the nearest of two others at a node of
/// a leaf.
fn lead(
    borders: &Borders,
    at: [i32; 3],
    node: [usize; 3],
    own: Label,
    label: Label,
    others: [Label; 2],
) -> f64 {
    let distance = |label: Label| {
        let distance = f64::from(borders.distance(label, at, node));
        if label == own { -distance } else { distance }
    };
    others.map(distance).into_iter().fold(f64::INFINITY, f64::min) - distance(label)
}
