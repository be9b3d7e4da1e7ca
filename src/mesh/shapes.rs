//! Shapes for tests: samples of known solids, and what a sound mesh is.

use std::collections::HashMap;

use glam::DVec3;

use super::{Mesh, dual};
use crate::grid::samples::{LEAF_NODES, LEAF_SIDE, Lattice, Leaf, LeafValues, Samples};
use crate::label::Label;
use crate::progress::Silent;

/// Samples of materials 1, 2, … whose indicators `values` gives at a node,
/// all leaves in full.
pub fn samples(lattice: Lattice, values: impl Fn([i32; 3]) -> Vec<f32>) -> Samples {
    let [x, y, z] = lattice.leaf_dims();
    let mut leaves = Vec::new();
    for at in (0..x).flat_map(|x| (0..y).flat_map(move |y| (0..z).map(move |z| [x, y, z]))) {
        let nodes: Vec<Vec<f32>> = (0..LEAF_NODES as i32)
            .map(|node| [node / 64, node / 8 % 8, node % 8])
            .map(|node| {
                let node = [0, 1, 2].map(|axis| at[axis] * LEAF_SIDE as i32 + node[axis]);
                let inner =
                    (0..3).all(|axis| 0 < node[axis] && node[axis] < lattice.dims[axis] - 1);
                let values = values(node);
                if inner { values } else { vec![-1.0; values.len()] }
            })
            .collect();
        let material = |index: usize| LeafValues {
            label: Label(index as u32 + 1),
            values: nodes.iter().map(|values| values[index]).collect(),
        };
        leaves.push(Leaf { at, materials: (0..nodes[0].len()).map(material).collect() });
    }
    let tiles = vec![Label::OUTSIDE; (x * y * z) as usize];
    Samples { lattice, leaves, tiles, open: None }
}

/// The mesh of one solid, from a signed distance that is positive inside, on
/// a lattice with `nodes` nodes over [−`reach`, `reach`]³.
pub fn solid(nodes: i32, reach: f64, distance: impl Fn(DVec3) -> f64) -> Mesh {
    let voxel = 2.0 * reach / f64::from(nodes - 1);
    let lattice = Lattice { origin: DVec3::splat(-reach), voxel, dims: [nodes; 3] };
    let samples = samples(lattice, |node| {
        let scaled = distance(lattice.position(node)) / (3.0 * voxel);
        vec![scaled.clamp(-1.0, 1.0) as f32]
    });
    dual(&samples, &Silent).unwrap()
}

/// Panics unless the boundary of `label` has, for every edge, one triangle in
/// each direction.
pub fn assert_edge_manifold(mesh: &Mesh, label: Label) {
    let mut sides: HashMap<[u32; 2], u32> = HashMap::new();
    for (&[a, b, c], &[back, front]) in mesh.triangles.iter().zip(&mesh.sides) {
        assert_ne!(back, front);
        if back == label || front == label {
            let [a, b, c] = if back == label { [a, b, c] } else { [a, c, b] };
            for side in [[a, b], [b, c], [c, a]] {
                *sides.entry(side).or_default() += 1;
            }
        }
    }
    for (&[start, end], &count) in &sides {
        assert_eq!(count, 1, "label {label}: edge {start} → {end} has {count} triangles");
        assert!(sides.contains_key(&[end, start]), "label {label}: a border at {start} → {end}");
    }
}
