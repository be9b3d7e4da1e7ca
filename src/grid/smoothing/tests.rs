use glam::{DVec2, DVec3};

use super::*;
use crate::ffi::threads::limit_threads;
use crate::plane::Plane;
use crate::section::Edge;

const LABEL: Label = Label(1);
const EVERYWHERE: Bounds = Bounds { min: DVec3::splat(-1e9), max: DVec3::splat(1e9) };

/// A row of leaves along x, of which the first alone has the label: −1 but
/// for one node.
fn spike(leaves: i32, node: [usize; 3]) -> Samples {
    let lattice = Lattice { origin: DVec3::ZERO, voxel: 1.0, dims: [8 * leaves, 8, 8] };
    let mut values = vec![-1.0; LEAF_NODES];
    values[node_index(node)] = 1.0;
    let row = (0..leaves).map(|x| Leaf { at: [x, 0, 0], materials: Vec::new() });
    let tiles = vec![Label::OUTSIDE; leaves as usize];
    let mut samples =
        Samples { lattice, leaves: row.collect(), tiles, open: None, values: Default::default() };
    samples.leaves[0].materials.push(LeafValues { label: LABEL, values });
    samples
}

fn value(samples: &Samples, node: [i32; 3]) -> f32 {
    let leaf = samples.leaf(node.map(|index| index.div_euclid(8))).unwrap();
    let own = leaf.materials.iter().find(|own| own.label == LABEL);
    own.map_or(-1.0, |own| own.values[node_index(node.map(|index| index as usize % 8))])
}

fn assert_near(found: f32, expected: f32) {
    assert!((found - expected).abs() < 1e-6, "{found} {expected}");
}

#[test]
fn one_step_is_the_square_of_the_laplacian() {
    // Δ² of a unit impulse is 42 there, −12 next to it, 2 diagonally and 1
    // two nodes away; the impulse here has the height 2. Its neighbour is in
    // a leaf that did not have the material.
    let samples = smoothed(spike(2, [7, 3, 3]), &[], EVERYWHERE, 1).unwrap();
    assert_near(value(&samples, [7, 3, 3]), 1.0 - 2.0 * 42.0 / 144.0);
    for node in [[6, 3, 3], [8, 3, 3], [7, 4, 3], [7, 3, 2]] {
        assert_near(value(&samples, node), -1.0 + 2.0 * 12.0 / 144.0);
    }
    // Overshoot is cut off.
    for node in [[8, 4, 3], [9, 3, 3], [5, 3, 3], [7, 1, 3], [9, 4, 3]] {
        assert_eq!(value(&samples, node), -1.0);
    }
}

#[test]
fn nothing_flows_out_of_the_region() {
    // Without the neighbour beyond x = 0 the impulse has five: Δ² is 5² + 5.
    let samples = smoothed(spike(1, [0, 3, 3]), &[], EVERYWHERE, 1).unwrap();
    assert_near(value(&samples, [0, 3, 3]), 1.0 - 2.0 * 30.0 / 144.0);
}

#[test]
fn many_steps_reach_far_leaves_and_keep_the_sum() {
    let grid = |steps| {
        let mut grid = Grid::from_samples(spike(4, [7, 3, 3]), &[], EVERYWHERE).unwrap();
        grid.smooth(steps).unwrap();
        let taken = ffi::take_material(grid.trees.pin_mut(), 0).unwrap();
        taken.values.iter().map(|&value| f64::from(value) + 1.0).sum::<f64>()
    };
    for steps in [1, 4, 5, 40] {
        assert!((grid(steps) - 2.0).abs() < 1e-4, "{steps}: {}", grid(steps));
    }
}

#[test]
fn nodes_around_contours_and_outside_the_box_stay() {
    // A contour along x from 5.2 to 6.8 at y = 3.5, z = 3.5.
    let plane = Plane { normal: DVec3::Z, offset: 3.5 };
    let section = Section {
        name: "edge".to_owned(),
        plane,
        vertices: vec![DVec2::new(5.2, 3.5), DVec2::new(6.8, 3.5)],
        edges: vec![Edge { start: 0, end: 1, left: LABEL, right: Label::OUTSIDE }],
        background: Label::OUTSIDE,
    };
    let samples = smoothed(spike(1, [6, 3, 4]), &[section], EVERYWHERE, 3).unwrap();
    for x in 5..=7 {
        for y in [3, 4] {
            for z in [3, 4] {
                let before = if [x, y, z] == [6, 3, 4] { 1.0 } else { -1.0 };
                assert_eq!(value(&samples, [x, y, z]), before);
            }
        }
    }
    assert!(value(&samples, [6, 2, 4]) > -1.0);

    let below = Bounds { min: DVec3::splat(-1.0), max: DVec3::new(6.0, 9.0, 9.0) };
    let samples = smoothed(spike(1, [6, 3, 4]), &[], below, 3).unwrap();
    assert_eq!([value(&samples, [6, 3, 4]), value(&samples, [7, 3, 4])], [1.0, -1.0]);
    assert!(value(&samples, [5, 3, 4]) > -1.0);
}

/// A ball of 24 nodes' width, or its rest, with a ripple on it.
fn rippled(inner: Label, outer: Label) -> Samples {
    let lattice = Lattice { origin: DVec3::splat(-19.5), voxel: 1.0, dims: [40; 3] };
    let indicator = |node: [i32; 3], label: Label| {
        let point = lattice.position(node);
        let ripple = 0.3 * f64::from((node[0] + node[1] + node[2]) % 2 * 2 - 1);
        let f = ((12.0 - point.length()) / 4.0 + ripple).clamp(-1.0, 1.0) as f32;
        let beyond = point.abs().max_element() > 18.0;
        match (label == inner, beyond) {
            (_, true) => -1.0,
            (true, _) => f,
            _ => -f,
        }
    };
    let leaf = |index| {
        let at = lattice.leaf_at(index);
        let own = |label: Label| {
            let node = |node| {
                let offset = node_offset(node);
                let node = std::array::from_fn(|axis| at[axis] * 8 + offset[axis] as i32);
                indicator(node, label)
            };
            LeafValues { label, values: (0..LEAF_NODES).map(node).collect() }
        };
        let materials = [inner, outer].into_iter().filter(|label| label.is_material());
        Leaf { at, materials: materials.map(own).collect() }
    };
    let tiles = vec![Label::OUTSIDE; 125];
    Samples {
        lattice,
        leaves: (0..125).map(leaf).collect(),
        tiles,
        open: None,
        values: Default::default(),
    }
}

/// How much neighbouring nodes differ, squared and summed up.
fn roughness(samples: &Samples) -> f64 {
    let own = samples.leaves.iter().flat_map(|leaf| &leaf.materials);
    let rows = own.flat_map(|own| own.values.chunks(8));
    rows.flat_map(|row| row.windows(2)).map(|pair| f64::from(pair[0] - pair[1]).powi(2)).sum()
}

#[test]
fn ripples_go_and_the_volume_stays() {
    let bounds = Bounds { min: DVec3::splat(-18.0), max: DVec3::splat(18.0) };
    let rough = rippled(LABEL, Label::OUTSIDE);
    rough.sanity_check().unwrap();
    let count = |samples: &Samples| {
        let labels = samples.leaves.iter().flat_map(Leaf::labels);
        labels.filter(|&label| label == LABEL).count() as f64
    };
    let before = (roughness(&rough), count(&rough));
    let smooth = smoothed(rough, &[], bounds, 5).unwrap();
    smooth.sanity_check().unwrap();
    assert!(roughness(&smooth) < 0.3 * before.0, "{} {}", roughness(&smooth), before.0);
    assert!((count(&smooth) / before.1 - 1.0).abs() < 0.03, "{} {}", count(&smooth), before.1);
}

#[test]
fn indicators_still_add_up_to_one() {
    let bounds = Bounds { min: DVec3::splat(-18.0), max: DVec3::splat(18.0) };
    let smooth = smoothed(rippled(LABEL, Label(2)), &[], bounds, 7).unwrap();
    smooth.sanity_check().unwrap();
    // Where values are not cut off, and away from the box's faces.
    for x in -8..8 {
        let node = [x + 20, 20, 20].map(|index: i32| index as usize);
        let leaf = smooth.leaf(node.map(|index| (index / 8) as i32)).unwrap();
        let sum: f64 = leaf
            .materials
            .iter()
            .map(|own| f64::from(own.values[node_index(node.map(|index| index % 8))]) + 1.0)
            .sum();
        assert!((sum - 2.0).abs() < 1e-5, "{x}: {sum}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let bounds = Bounds { min: DVec3::splat(-18.0), max: DVec3::splat(18.0) };
    let run = || smoothed(rippled(LABEL, Label(2)), &[], bounds, 6).unwrap();
    let free = run();
    limit_threads(1).unwrap();
    let single = run();
    limit_threads(64).unwrap();
    assert_eq!(free, single);
}

#[test]
fn a_surface_that_reaches_a_tile_is_closed() {
    // The label fills the last layer of the leaf: smoothing cannot be trusted
    // to keep away from the tile next to it.
    let mut samples = spike(2, [7, 3, 3]);
    samples.leaves.truncate(1);
    close(&mut samples);
    assert_eq!(samples.leaves.len(), 2);
    assert_eq!(samples.leaves[1], Leaf { at: [1, 0, 0], materials: Vec::new() });
}
