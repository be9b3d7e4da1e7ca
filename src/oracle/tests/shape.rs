//! Distances, certainty, and the oracle on a lattice.

use super::*;
use crate::grid::lattice::Resolution;
use crate::grid::samples::Lattice;
use crate::mesh::dual::dual;
use crate::progress::Silent;

/// Two squares, one above the other.
fn pair(halves: [f64; 2], labels: [Label; 2]) -> [Section; 2] {
    [0, 1].map(|at| {
        let floor = plane([0.0, 0.0, 1.0], at as f64 - 0.5);
        partition(floor, &[(square(halves[at]), [labels[at], O])], O)
    })
}

#[test]
fn every_label_has_a_distance() {
    let sections = pair([0.5, 0.25], [A, B]);
    let oracle = Oracle::new(&sections, cube(2.0), O).unwrap();
    let close = |point: [f64; 3], expected: [f64; 3]| {
        let found = oracle.distances(point.into());
        assert_eq!(found.iter().map(|(label, _)| *label).collect::<Vec<_>>(), [O, A, B]);
        for ((label, distance), expected) in found.into_iter().zip(expected) {
            assert!((distance - expected).abs() < 1e-12, "{point:?} {label}: {distance}");
        }
    };
    // Outside is nearest at the upper square's side: √(0.5² + 0.25²).
    close([0.0, 0.0, 0.0], [0.3125_f64.sqrt(), 0.5, 0.5]);
    // Beside both: 1 above the floor, at (0.75, 1, 0.5) from A's corner.
    close([1.25, 1.5, 0.0], [0.5, 1.8125_f64.sqrt(), (1.0 + 1.5625 + 0.25_f64).sqrt()]);
    // Near the box's face.
    close([0.0, 0.0, 1.75], [0.25, 2.25, 1.25]);
    close([0.0, 0.0, 5.0], [0.0, 5.5, 4.5]);
}

#[test]
fn labels_without_an_edge_have_distances_too() {
    let sections = [
        partition(floor(), &[], B),
        partition(plane([1.0, 0.0, 0.0], 1.0), &[(square(1.0), [A, U])], U),
    ];
    let oracle = Oracle::new(&sections, cube(9.0), U).unwrap();
    assert_eq!(oracle.known_labels(), [A, B]);
    assert_eq!(oracle.distances(DVec3::new(-3.0, 4.0, 0.5)), [(A, 5.0), (B, 0.5)]);
    assert_eq!(oracle.distances(DVec3::new(1.0, 0.0, -7.0)), [(A, 6.0), (B, 7.0)]);
}

#[test]
fn certainty_is_relative_to_the_nearest_planes() {
    let sections = pair([0.4, 0.4], [A, A]);
    let oracle = Oracle::new(&sections, cube(1.5), O).unwrap();
    // The foot is 0.4 from the square's side; of both planes the distances are
    // 0.25 and 0.75, or 0.05 and 0.95.
    let middle = oracle.certainty(DVec3::new(0.0, 0.0, 0.25));
    assert!((middle.rho - 1.0 / 3.0).abs() < 1e-12 && (middle.alpha - 1.6).abs() < 1e-12);
    assert!(middle.known && !middle.must_agree());
    let near = oracle.certainty(DVec3::new(0.0, 0.0, 0.45));
    assert!((near.rho - 1.0 / 19.0).abs() < 1e-12 && (near.alpha - 8.0).abs() < 1e-12);
    assert!(near.must_agree());
    // Beside the square the box's face is nearer than the side.
    let beside = oracle.certainty(DVec3::new(1.25, 0.0, 0.375));
    assert!((beside.rho - 0.5).abs() < 1e-12 && (beside.alpha - 2.0).abs() < 1e-12);
    assert!(oracle.certainty(DVec3::new(0.0, 0.0, 0.5)).must_agree());
    assert!(!oracle.certainty(DVec3::new(0.4, 0.0, 0.5)).must_agree());
    // Near a face of the box that nothing is known of.
    let open = Oracle::new(&sections, cube(1.5), U).unwrap();
    assert!(!open.certainty(DVec3::new(0.0, 0.0, 0.45)).known);
}

#[test]
fn a_plane_of_another_direction_cuts_the_certain_part() {
    // x + z = ½ meets the plane z = ½ in x = 0; at the foot (-0.1, 0, ½) the line
    // is 0.1 away.
    let mut sections = pair([0.4, 0.4], [A, A]).to_vec();
    sections.push(partition(plane([1.0, 0.0, 1.0], 0.5), &[], A));
    let oracle = Oracle::new(&sections, cube(1.5), O).unwrap();
    let found = oracle.certainty(DVec3::new(-0.1, 0.0, 0.48));
    assert!((found.alpha - 5.0).abs() < 1e-9);
    assert!((found.rho - 0.02 / (0.12 / 2.0_f64.sqrt())).abs() < 1e-9);
}

#[test]
fn cells_with_unknown_walls_are_not_certain() {
    // The upper plane is unknown in a square around (1, 0); a plane x = 0.5 and
    // one x = 0.25 bound cells of which only that beyond 0.5 has it on a wall.
    let upper = plane([0.0, 0.0, 1.0], 0.5);
    let sections = [
        partition(plane([0.0, 0.0, 1.0], -0.5), &[], A),
        partition(upper, &[(rectangle([0.75, -0.2], [1.25, 0.2]), [U, A])], A),
        partition(plane([1.0, 0.0, 0.0], 0.5), &[], A),
        partition(plane([1.0, 0.0, 0.0], 0.25), &[], A),
    ];
    let oracle = Oracle::new(&sections, cube(1.5), O).unwrap();
    let known = |x, z| oracle.certainty(DVec3::new(x, 0.0, z)).known;
    for (x, z) in [(0.3, 0.4), (-1.0, 0.4), (-1.0, 1.4), (1.0, -1.0)] {
        assert!(known(x, z), "{x} {z}");
    }
    for (x, z) in [(0.6, 0.4), (1.0, 0.4), (1.0, 1.0), (0.6, -0.4)] {
        assert!(!known(x, z), "{x} {z}");
    }
}

#[test]
fn its_samples_make_terraces() {
    // The nearest plane's label: a block over [−1, 0] under one over [0, 1].
    let sections = pair([0.4, 0.8], [A, A]);
    let bounds = cube(1.5);
    let oracle = Oracle::new(&sections, bounds, O).unwrap();
    let lattice = Lattice::new(bounds, Resolution::Voxels(61)).unwrap();
    let samples = oracle.sample(&lattice, &Silent).unwrap();
    samples.sanity_check().unwrap();
    let mesh = dual(&samples, &Silent).unwrap();
    let surface = mesh.surface(A);
    let facts = surface.facts(true).unwrap();
    assert!(facts.closed && facts.outward);
    assert_eq!((facts.components, facts.genus), (1, 0));
    assert_eq!(facts.self_intersections, Some(0));
    let voxel = lattice.voxel;
    let block = |half: f64, low: f64| Bounds {
        min: DVec3::new(-half, -half, low),
        max: DVec3::new(half, half, low + 1.0),
    };
    let blocks = [block(0.4, -1.0), block(0.8, 0.0)];
    let in_any = |point, margin| blocks.iter().any(|block| block.grown(margin).contains(point));
    for &vertex in &mesh.vertices {
        assert!(in_any(vertex, voxel) && !in_any(vertex, -voxel), "{vertex}");
    }
    // 0.8² + 1.6², up to half a voxel on the area of 4·0.8 + 4·1.6 + 2·2.56.
    let volume = surface.volume();
    assert!((volume - 3.2).abs() < 0.5 * voxel * 14.72, "{volume}");
}
