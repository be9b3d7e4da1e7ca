//! Shapes for tests: samples of known solids, and what a sound mesh is.

use std::collections::HashMap;

use glam::DVec3;

use super::{Mesh, dual};
use crate::grid::lattice::Resolution;
use crate::grid::leaf::{LeafOf, LeafValues};
use crate::grid::samples::{LEAF_NODES, Lattice, Samples, Values};
use crate::label::Label;
use crate::plane::Bounds;
use crate::progress::Silent;

/// Samples of materials 1, 2, … whose indicators `values` gives at a node,
/// all leaves in full.
pub fn samples(lattice: Lattice, values: impl Fn([i32; 3]) -> Vec<f32>) -> Samples {
    let closed = |node| {
        let values = values(node);
        if lattice.is_inner(node) { values } else { vec![-1.0; values.len()] }
    };
    all_leaves(lattice, None, closed)
}

/// Samples in an open box, with so many voxels on its longest side and the
/// indicators that `values` gives at a point.
pub fn open_samples(bounds: Bounds, voxels: u32, values: impl Fn(DVec3) -> Vec<f32>) -> Samples {
    let lattice = Lattice::new(bounds, Resolution::Voxels(voxels)).unwrap();
    let nearest = |node| values(lattice.position(lattice.nearest_inner(node)));
    all_leaves(lattice, Some(bounds), nearest)
}

fn all_leaves(
    lattice: Lattice,
    open: Option<Bounds>,
    values: impl Fn([i32; 3]) -> Vec<f32>,
) -> Samples {
    let count = lattice.leaf_count() as usize;
    let leaf = |index| {
        let mut leaf = LeafOf { at: lattice.leaf_at(index), materials: Vec::new() };
        let nodes: Vec<Vec<f32>> = (0..LEAF_NODES).map(|node| values(leaf.node(node))).collect();
        let material = |index: usize| LeafValues {
            label: Label(index as u32 + 1),
            values: Box::new(std::array::from_fn(|node| nodes[node][index])),
        };
        leaf.materials = (0..nodes[0].len()).map(material).collect();
        leaf
    };
    let tiles = vec![Label::OUTSIDE; count];
    let mut samples = Samples::new(lattice, tiles, open, Values::Indicators);
    samples.add((0..count).map(leaf));
    samples
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

/// A cylinder around the z axis as a material's indicator.
pub fn cylinder(radius: f64, voxel: f64) -> impl Fn(DVec3) -> Vec<f32> {
    move |point| {
        let inside = (radius - point.truncate().length()) / (3.0 * voxel);
        vec![inside.clamp(-1.0, 1.0) as f32]
    }
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
