use std::f64::consts::PI;

use super::*;
use crate::grid::samples::Lattice;
use crate::label::Label;
use crate::mesh::shapes::{assert_edge_manifold, cylinder, open_samples, samples, solid};
use crate::plane::Bounds;
use crate::progress::Silent;
use crate::random::Random;

/// In [0, 1).
fn unit(random: &mut Random) -> f32 {
    (random.bits() >> 40) as f32 / (1 << 24) as f32
}

fn unit_lattice(dims: [i32; 3]) -> Lattice {
    Lattice { origin: DVec3::ZERO, voxel: 1.0, dims }
}

/// Closed per label, vertices apart from each other only where they must be,
/// and volumes that together are exactly the lattice.
fn assert_sound(mesh: &Mesh) {
    let mut labels = mesh.labels();
    for &label in &labels {
        assert!(mesh.surface(label).volume() > 0.0, "label {label} is inside out");
    }
    labels.push(Label::OUTSIDE);
    let volumes: f64 = labels.iter().map(|&label| mesh.surface(label).volume()).sum();
    assert!(volumes.abs() < 1e-9, "volumes with outside's: {volumes}");
    labels.iter().for_each(|&label| assert_edge_manifold(mesh, label));
}

/// Nodes with one label each, surrounded by outside, with random certainty.
fn mesh_of_labels(inner: [i32; 3], count: u32, random: &mut Random) -> Mesh {
    let dims = inner.map(|side| side + 2);
    let nodes = dims.iter().product::<i32>();
    let values: Vec<Vec<f32>> = (0..nodes)
        .map(|_| {
            let label = random.bits() % u64::from(count + 1);
            let certainty = 0.05 + 0.95 * unit(random);
            (1..=u64::from(count)).map(|of| if of == label { certainty } else { -1.0 }).collect()
        })
        .collect();
    let lattice = unit_lattice(dims);
    let at = |node: [i32; 3]| (node[0] * dims[1] + node[1]) * dims[2] + node[2];
    let inside = |node: [i32; 3]| (0..3).all(|axis| node[axis] < dims[axis]);
    let nothing = vec![-1.0; count as usize];
    let samples = samples(lattice, |node| {
        if inside(node) { values[at(node) as usize].clone() } else { nothing.clone() }
    });
    dual(&samples, &Silent).unwrap()
}

#[test]
fn all_patterns_of_two_cells_are_edge_manifold() {
    // 2 × 2 × 3 nodes, each inside or outside, on a padded lattice; the values
    // vary so that checkerboards are resolved either way.
    let mut random = Random::new(1);
    for pattern in 0u32..1 << 12 {
        let certainty: Vec<f32> = (0..12).map(|_| 0.05 + 0.9 * unit(&mut random)).collect();
        let samples = samples(unit_lattice([4, 4, 5]), |[x, y, z]| {
            let inner = (1..3).contains(&x) && (1..3).contains(&y) && (1..4).contains(&z);
            let bit = (((x - 1) * 2 + y - 1) * 3 + z - 1).clamp(0, 11) as usize;
            let sign = if inner && pattern >> bit & 1 == 1 { 1.0 } else { -1.0 };
            vec![sign * certainty[bit]]
        });
        let mesh = dual(&samples, &Silent).unwrap();
        assert_eq!(mesh.labels().is_empty(), pattern == 0);
        assert_sound(&mesh);
    }
}

#[test]
fn random_labels_are_edge_manifold() {
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let count = 1 + (seed % 5) as u32;
        // Larger than a leaf along x, so that cells lie in several blocks.
        let mesh = mesh_of_labels([9, 5, 4], count, &mut random);
        assert_eq!(mesh.labels().len(), count as usize);
        assert_sound(&mesh);
    }
}

#[test]
fn triangles_face_from_back_to_front() {
    let mesh = solid(20, 1.0, |point| 0.7 - point.length());
    for (triangle, &sides) in mesh.sides.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        assert_eq!(sides, [Label(1), Label::OUTSIDE]);
        assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
    }
}

#[test]
fn a_sphere_has_its_volume_and_place() {
    let radius = 0.8;
    let mesh = solid(65, 1.0, |point| radius - point.length());
    let voxel = 2.0 / 64.0;
    let volume = mesh.surface(Label(1)).volume();
    let exact = 4.0 / 3.0 * PI * radius.powi(3);
    let off = mesh.vertices.iter().map(|point| (point.length() - radius).abs() / voxel);
    let off = off.fold(0.0, f64::max);
    println!("volume off by {:.2e}, vertices by {off:.3} voxels", volume / exact - 1.0);
    println!("worst angle {:.1}°", worst_angle(&mesh));
    assert!((volume / exact - 1.0).abs() < 2e-3);
    assert!(off < 0.05);
}

/// The smallest angle of all triangles, in degrees.
fn worst_angle(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len())
        .flat_map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            [[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| (b - a).angle_between(c - a))
        })
        .fold(PI, f64::min)
        .to_degrees()
}

#[test]
fn tiles_without_values_close_the_surface() {
    // A material tile amid tiles of outside: its faces are halfway between
    // nodes, so a cube of 8³ voxels less its rounded edges.
    let lattice = unit_lattice([24; 3]);
    let mut tiles = vec![Label::OUTSIDE; 27];
    tiles[13] = Label(3);
    let samples = Samples::new(lattice, tiles, None, Default::default());
    let mesh = dual(&samples, &Silent).unwrap();
    assert_sound(&mesh);
    let volume = mesh.surface(Label(3)).volume();
    assert!((485.0..512.0).contains(&volume), "{volume}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mesh = || mesh_of_labels([20, 9, 11], 3, &mut Random::new(7));
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(mesh);
    let many = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap().install(mesh);
    assert_eq!(one, many);
}

/// Neither the lattice nor the leaves divide it evenly.
const OPEN: Bounds = Bounds { min: DVec3::new(-1.0, -1.0, -0.73), max: DVec3::new(1.0, 1.0, 0.9) };

#[test]
fn a_cylinder_ends_flat_on_an_open_box() {
    let (radius, voxels) = (0.61, 60);
    let voxel = 2.0 / f64::from(voxels);
    let mesh = dual(&open_samples(OPEN, voxels, cylinder(radius, voxel)), &Silent).unwrap();
    assert_sound(&mesh);
    let disc = PI * radius * radius;
    let volume = mesh.surface(Label(1)).volume();
    assert!((volume / (disc * 1.63) - 1.0).abs() < 2e-3, "{volume}");

    let (caps, rest): (Vec<usize>, Vec<usize>) =
        (0..mesh.triangles.len()).partition(|&triangle| mesh.is_cap(triangle, OPEN, 0.0));
    for &cap in &caps {
        let heights = mesh.corners(cap).map(|corner| corner.z);
        assert!(heights == [-0.73; 3] || heights == [0.9; 3], "{heights:?}");
    }
    let area = |triangle: &usize| {
        let [a, b, c] = mesh.corners(*triangle);
        (b - a).cross(c - a).length() / 2.0
    };
    let (caps, rest): (f64, f64) = (caps.iter().map(area).sum(), rest.iter().map(area).sum());
    assert!((caps / (2.0 * disc) - 1.0).abs() < 2e-3, "{caps}");
    assert!((rest / (2.0 * PI * radius * 1.63) - 1.0).abs() < 2e-3, "{rest}");
}

#[test]
fn without_caps_a_cylinder_is_as_wide_at_the_box_as_inside() {
    let (radius, voxels) = (0.61, 60);
    let voxel = 2.0 / f64::from(voxels);
    let samples = open_samples(OPEN, voxels, cylinder(radius, voxel));
    let open = dual(&samples, &Silent).unwrap().without_caps(OPEN, 0.0);
    let off = |vertex: &DVec3| (vertex.truncate().length() - radius).abs() / voxel;
    assert!(open.vertices.iter().map(off).fold(0.0, f64::max) < 0.1);
    let surface = open.surface(Label(1));
    let edges = surface.open_edges();
    assert!(!edges.is_empty());
    let mut ends = [0.0; 2];
    for [start, end] in edges.iter().map(|edge| edge.map(|v| surface.vertices[v as usize])) {
        assert!(start.z == end.z && (start.z == -0.73 || start.z == 0.9), "{start} {end}");
        ends[usize::from(start.z > 0.0)] += start.distance(end);
    }
    for length in ends {
        assert!((length / (2.0 * PI * radius) - 1.0).abs() < 2e-3, "{length}");
    }
}

#[test]
fn two_materials_fill_an_open_box_to_its_corners() {
    let samples = open_samples(OPEN, 21, |point| {
        let first = (0.13 - point.x - 0.3 * point.y).clamp(-1.0, 1.0) as f32;
        vec![first, -first]
    });
    let mesh = dual(&samples, &Silent).unwrap();
    assert_sound(&mesh);
    let volumes = [1, 2].map(|label| mesh.surface(Label(label)).volume());
    assert!((volumes[0] + volumes[1] - OPEN.volume()).abs() < 1e-12, "{volumes:?}");
    // The plane x = 0.13 − 0.3 y divides the box's sides 2 at 0.13 on average.
    assert!((volumes[0] / OPEN.volume() - 1.13 / 2.0).abs() < 2e-3, "{volumes:?}");
    let between = mesh.without_caps(OPEN, 0.0);
    assert!(between.sides.iter().all(|&sides| sides == [Label(1), Label(2)]));
    // From the box to the next cell's middle, a voxel of 2 / 21, it leans half as
    // much: √(1 + 0.15²) in place of √(1 + 0.3²) twice, of 21 √(1 + 0.3²): 0.3 %.
    let area = 2.0 * 1.09f64.sqrt() * 1.63;
    assert!((between.surface(Label(1)).area() / area - 0.997).abs() < 2e-3);
}

#[test]
fn random_labels_in_an_open_box_are_edge_manifold() {
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let count = 1 + seed % 4;
        let size = DVec3::new(9.0, 4.0 + (seed % 3) as f64 / 3.0, 3.3);
        let bounds = Bounds { min: DVec3::ZERO, max: size };
        let certain = |own: bool, certainty: f32| if own { certainty } else { -1.0 };
        let values: Vec<Vec<f32>> = (0..9 * 5 * 4)
            .map(|_| {
                let (label, certainty) =
                    (random.bits() % (count + 1), 0.05 + 0.95 * unit(&mut random));
                (1..=count).map(|own| certain(own == label, certainty)).collect()
            })
            .collect();
        let samples = open_samples(bounds, 9, |point| {
            let [x, y, z] = point.to_array().map(|at| at as usize);
            values[((x * 5 + y) * 4 + z).min(values.len() - 1)].clone()
        });
        let mesh = dual(&samples, &Silent).unwrap();
        assert_sound(&mesh);
        let open = mesh.without_caps(bounds, 0.0);
        for &label in &open.labels() {
            let surface = open.surface(label);
            for edge in surface.open_edges() {
                let ends = edge.map(|vertex| surface.vertices[vertex as usize]);
                assert!(bounds.on_one_face(&ends, 0.0), "seed {seed}: {ends:?}");
            }
        }
    }
}

/// Where leaves are as they were their blocks are taken over, and the mesh is the same to the
/// last bit as one without a past.
#[test]
fn what_was_meshed_before_does_not_show() {
    let lattice = unit_lattice([34, 18, 18]);
    let two_balls = |second: f64| {
        samples(lattice, |node| {
            let at = DVec3::from_array(node.map(f64::from));
            let ball = |x: f64, radius: f64| {
                ((radius - at.distance(DVec3::new(x, 8.5, 8.5))) / 3.0).clamp(-1.0, 1.0) as f32
            };
            vec![ball(8.5, 6.2), ball(25.5, second)]
        })
    };
    let before = two_balls(5.1);
    let (_, blocks) = dual_again(&before, None, &Silent).unwrap();
    let mut other = two_balls(5.7);
    for (now, is_other_grid) in [(other.clone(), false), (two_balls(0.0), false), {
        other.lattice.origin.x = 1.0;
        (other, true)
    }] {
        let (mesh, kept) = dual_again(&now, Some((&before, &blocks)), &Silent).unwrap();
        assert_eq!(mesh, dual(&now, &Silent).unwrap());
        let is_taken_over =
            |block: &&Arc<Block>| blocks.0.iter().any(|own| Arc::ptr_eq(own, block));
        let taken_over: Vec<i32> =
            kept.0.iter().filter(is_taken_over).map(|block| block.at[0]).collect();
        // Those of the first ball, but for leaves that touch the second one's.
        assert_eq!(taken_over.is_empty(), is_other_grid);
        assert!(taken_over.iter().all(|&x| x < 2) && taken_over.len() < kept.0.len() + 1);
    }
}
