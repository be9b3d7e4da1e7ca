use super::*;
use crate::grid::samples::LEAF_NODES;

/// An octahedron refined onto a sphere, seen from outside counter-clockwise.
pub(crate) fn sphere(center: DVec3, radius: f64, rounds: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let mut faces = Vec::new();
    for (a, b, c) in [(x, y, z), (y, -x, z), (-x, -y, z), (-y, x, z)] {
        faces.push([a, b, c]);
        faces.push([b, a, -c]);
    }
    for _ in 0..rounds {
        let split = |[a, b, c]: [DVec3; 3]| {
            let middle = |p: DVec3, q: DVec3| (p + q).normalize();
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    // Shared vertices are bitwise equal: the same sum in either order.
    let vertices: Vec<DVec3> =
        faces.iter().flatten().map(|&corner| center + radius * corner).collect();
    let triangles = (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]);
    (vertices, triangles.collect())
}

fn lattice(voxel: f64) -> Lattice {
    let nodes = (4.0 / voxel) as i32;
    Lattice { origin: DVec3::new(-2.03, -1.98, -2.01), voxel, dims: [nodes; 3] }
}

#[test]
fn distances_to_a_sphere_are_right() {
    let center = DVec3::new(0.11, -0.07, 0.05);
    let (vertices, triangles) = sphere(center, 1.0, 6);
    let lattice = lattice(0.05);
    let band = narrow_band(&lattice, &vertices, &triangles);
    let mut in_band = 0;
    for (at, values) in band.leaves().iter().zip(band.values().chunks(LEAF_NODES)) {
        for (node, &value) in values.iter().enumerate() {
            let offset = crate::grid::invariant::node_offset(node);
            let place = std::array::from_fn(|axis| at[axis] * SIDE + offset[axis] as i32);
            let exact = ((lattice.position(place) - center).length() - 1.0) / lattice.voxel;
            let exact = exact.clamp(-HALF_WIDTH, HALF_WIDTH);
            // The triangles' sagitta: (edge / 2)² / 2 ≈ 3e-4, 0.006 voxels.
            assert!((f64::from(value) - exact).abs() < 0.008, "{place:?}: {value} {exact}");
            in_band += usize::from(value.abs() < HALF_WIDTH as f32);
        }
    }
    // 6 voxels deep: 4π · 20² · 6 nodes.
    assert!((29_500..31_000).contains(&in_band), "{in_band}");
    assert!(band.leaves().is_sorted());
}

#[test]
fn the_band_is_the_same_for_any_number_of_threads() {
    let (vertices, triangles) = sphere(DVec3::ZERO, 1.3, 4);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| narrow_band(&lattice(0.11), &vertices, &triangles))
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn large_triangles_count_once_and_everywhere() {
    // A tetrahedron many leaves wide.
    let vertices = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|corner| corner * 40.0);
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let lattice = Lattice { origin: DVec3::splat(-4.5), voxel: 1.0, dims: [50; 3] };
    let band = narrow_band(&lattice, &vertices, &triangles);
    for (at, values) in band.leaves().iter().zip(band.values().chunks(LEAF_NODES)) {
        for (node, &value) in values.iter().enumerate() {
            let offset = crate::grid::invariant::node_offset(node);
            let place = std::array::from_fn(|axis| at[axis] * SIDE + offset[axis] as i32);
            let point = lattice.position(place);
            let planes = [-point.x, -point.y, -point.z, (point.element_sum() - 40.0) / 3f64.sqrt()];
            let outermost = planes.into_iter().fold(f64::MIN, f64::max);
            if outermost <= 0.0 {
                let expected = outermost.max(-HALF_WIDTH);
                assert!((f64::from(value) - expected).abs() < 1e-4, "{point}: {value}");
            } else {
                assert!(f64::from(value) >= outermost.min(HALF_WIDTH) - 1e-4);
            }
        }
    }
}
