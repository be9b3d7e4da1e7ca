use std::collections::{HashMap, HashSet};
use std::f64::consts::PI;

use super::*;
use crate::grid::samples::Lattice;
use crate::mesh::facts::Facts;
use crate::mesh::shapes::{assert_edge_manifold, cylinder, open_samples, samples};
use crate::plane::Bounds;
use crate::progress::Silent;
use crate::random::Random;

const NODES: i32 = 41;
const VOXEL: f64 = 2.0 / 40.0;

/// Samples over [−1, 1]³ from shares of the materials, which add up to at
/// most 1.
fn sampled(shares: impl Fn(DVec3) -> Vec<f64>) -> Samples {
    let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: VOXEL, dims: [NODES; 3] };
    samples(lattice, |node| {
        shares(lattice.position(node)).iter().map(|share| (2.0 * share - 1.0) as f32).collect()
    })
}

/// From 0 to 1 over six voxels around the surface of something, of which
/// `depth` is the signed distance inside.
fn share(depth: f64) -> f64 {
    (0.5 + depth / (6.0 * VOXEL)).clamp(0.0, 1.0)
}

fn meshed(shares: impl Fn(DVec3) -> Vec<f64>) -> Mesh {
    delaunay(&sampled(shares), &Options::default(), &Silent).unwrap()
}

/// Closed, outward and free of self-intersection, outside too; the facts of
/// the materials.
fn assert_sound(mesh: &Mesh) -> Vec<Facts> {
    assert_edge_manifold(mesh, Label::OUTSIDE);
    let facts = |label| {
        assert_edge_manifold(mesh, label);
        let facts = mesh.surface(label).facts(true).unwrap();
        assert!(facts.closed && facts.outward, "label {label}");
        assert_eq!(facts.self_intersections, Some(0), "label {label}");
        facts
    };
    mesh.labels().into_iter().map(facts).collect()
}

fn smallest_angle(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len())
        .flat_map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            [[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| (b - a).angle_between(c - a))
        })
        .fold(PI, f64::min)
        .to_degrees()
}

fn ball(radius: f64) -> f64 {
    4.0 / 3.0 * PI * radius.powi(3)
}

/// How much of a ball's volume is lost when its surface is moved by the facet
/// distance of a tenth of a voxel, and half as much for the oracle's error.
fn tolerance(radius: f64) -> f64 {
    3.0 * 0.15 * VOXEL / radius
}

#[test]
fn a_ball_has_its_volume_and_good_triangles() {
    let mesh = meshed(|point| vec![share(0.7 - point.length())]);
    let facts = &assert_sound(&mesh)[0];
    assert_eq!((facts.components, facts.genus), (1, 0));
    assert!((facts.volume / ball(0.7) - 1.0).abs() < tolerance(0.7), "{}", facts.volume);
    assert!(smallest_angle(&mesh) >= 29.9, "{}", smallest_angle(&mesh));
    for (triangle, sides) in mesh.sides.iter().enumerate() {
        let [a, b, c] = mesh.corners(triangle);
        assert_eq!(*sides, [Label(1), Label::OUTSIDE]);
        assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
    }
}

#[test]
fn a_ball_in_a_shell_has_two_surfaces() {
    // Material 1 is the shell, so that between the two it is at the back.
    let mesh = meshed(|point| {
        let (inner, both) = (share(0.4 - point.length()), share(0.75 - point.length()));
        vec![both - inner, inner]
    });
    let [shell, core] = &assert_sound(&mesh)[..] else { panic!("{:?}", mesh.labels()) };
    assert_eq!((shell.components, shell.cavities, core.components), (2, 1, 1));
    assert!((core.volume / ball(0.4) - 1.0).abs() < tolerance(0.4));
    assert!(((shell.volume + core.volume) / ball(0.75) - 1.0).abs() < tolerance(0.75));
    assert!(smallest_angle(&mesh) >= 29.9);
}

#[test]
fn three_materials_meet_in_shared_curves() {
    // A ball of three wedges around the z axis: inside, three planes meet in
    // the axis; on the sphere, three meridians end at its poles.
    let wedge = |point: DVec3, number: f64| {
        let direction = DVec3::new((number * PI / 1.5).cos(), (number * PI / 1.5).sin(), 0.0);
        point.dot(direction)
    };
    let mesh = meshed(|point| {
        let inside = share(0.7 - point.length());
        let leads: Vec<f64> =
            (0..3).map(|number| (wedge(point, f64::from(number)) / VOXEL).exp()).collect();
        let sum: f64 = leads.iter().sum();
        leads.iter().map(|lead| inside * lead / sum).collect()
    });
    let facts = assert_sound(&mesh);
    assert_eq!(facts.len(), 3);
    for facts in &facts {
        assert_eq!((facts.components, facts.genus), (1, 0));
        // A wedge's two half discs, together π r² for a volume of 4/9 π r³,
        // may be off by a tenth of a voxel, too.
        let tolerance = tolerance(0.7) + 0.1 * VOXEL * 9.0 / (4.0 * 0.7);
        assert!((facts.volume / (ball(0.7) / 3.0) - 1.0).abs() < tolerance, "{}", facts.volume);
    }
    let whole = mesh.surface_of(Label::is_material).volume();
    let sum: f64 = facts.iter().map(|facts| facts.volume).sum();
    assert!((whole - sum).abs() < 1e-12);
    // Four curves: the axis, and three meridians from pole to pole.
    let curves = curves::curves(&mesh, None);
    assert_eq!(curves.len(), 4);
    let length =
        |curve: &Vec<DVec3>| curve.windows(2).map(|two| two[0].distance(two[1])).sum::<f64>();
    let mut lengths: Vec<f64> = curves.iter().map(length).collect();
    lengths.sort_by(f64::total_cmp);
    // Outside wins where it has more than each material: at the axis, where
    // they have a third of the inside each, from 3/4 of it on, that is 1.5
    // voxels below the sphere; at the meridians from 2/3 on, one voxel below.
    assert!((lengths[0] / (2.0 * (0.7 - 1.5 * VOXEL)) - 1.0).abs() < 0.03, "{lengths:?}");
    for meridian in &lengths[1..] {
        assert!((meridian / ((0.7 - VOXEL) * PI) - 1.0).abs() < 0.08, "{lengths:?}");
    }
}

#[test]
fn a_grain_beside_a_ball_is_not_missed() {
    // One node of its own material share.
    let grain = DVec3::new(0.8, 0.8, 0.8);
    let mesh = meshed(|point| {
        let node = point.distance(grain) < 0.1 * VOXEL;
        vec![if node { 0.6 } else { share(0.7 - point.length()) }]
    });
    let facts = &assert_sound(&mesh)[0];
    assert_eq!(facts.components, 2);
}

#[test]
fn nothing_gives_nothing() {
    assert_eq!(meshed(|_| vec![0.0]), Mesh::default());
}

#[test]
fn absurd_options_are_an_error() {
    let samples = sampled(|point| vec![share(0.7 - point.length())]);
    let options = Options { size: 1e-9, ..Options::default() };
    let error = delaunay(&samples, &options, &Silent).unwrap_err();
    assert!(matches!(error, Error::Avoidable { remedy: Remedy::LargerTriangles, .. }), "{error}");
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let mesh = || meshed(|point| vec![share(0.5 - point.x.hypot(point.y).max(point.z.abs()))]);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    assert_eq!(pool(1).install(mesh), pool(4).install(mesh));
}

/// Neither the lattice nor the leaves divide it evenly.
const OPEN: Bounds = Bounds { min: DVec3::new(-1.0, -1.0, -0.73), max: DVec3::new(1.0, 1.0, 0.9) };

/// The area of the caps, which lie flat in the box's faces, and that of the
/// rest, which ends on them.
fn areas(mesh: &Mesh, voxel: f64) -> [f64; 2] {
    let mut areas = [0.0; 2];
    for triangle in 0..mesh.triangles.len() {
        let cap = mesh.face_of_cap(triangle, OPEN, CAP_TOLERANCE * voxel);
        let corners = mesh.corners(triangle);
        // It is there without any tolerance.
        assert_eq!(cap, mesh.face_of_cap(triangle, OPEN, 0.0), "{corners:?}");
        let [a, b, c] = corners;
        areas[usize::from(cap.is_none())] += (b - a).cross(c - a).length() / 2.0;
    }
    let open = mesh.without_caps(OPEN, CAP_TOLERANCE * voxel);
    for label in open.labels() {
        let surface = open.surface(label);
        for edge in surface.open_edges() {
            let ends = edge.map(|vertex| surface.vertices[vertex as usize]);
            assert!(OPEN.on_one_face(&ends, 0.0), "{ends:?}");
        }
    }
    areas
}

#[test]
fn a_cylinder_ends_flat_on_an_open_box() {
    let (radius, voxels) = (0.61, 40);
    let voxel = 2.0 / f64::from(voxels);
    let samples = open_samples(OPEN, voxels, cylinder(radius, voxel));
    let mesh = delaunay(&samples, &Options::default(), &Silent).unwrap();
    let facts = &assert_sound(&mesh)[0];
    assert_eq!((facts.components, facts.genus), (1, 0));
    // A tenth of a voxel on the radius is 2 · 0.1 · 0.05 / 0.61 of the area.
    let disc = PI * radius * radius;
    assert!((facts.volume / (disc * 1.63) - 1.0).abs() < 0.017, "{}", facts.volume);
    let [caps, rest] = areas(&mesh, voxel);
    assert!((caps / (2.0 * disc) - 1.0).abs() < 0.017, "{caps}");
    assert!((rest / (2.0 * PI * radius * 1.63) - 1.0).abs() < 0.017, "{rest}");
    assert!(smallest_angle(&mesh) > 10.0, "{}", smallest_angle(&mesh));
}

#[test]
fn two_materials_fill_an_open_box_to_its_corners() {
    let samples = open_samples(OPEN, 21, |point| {
        let first = (0.13 - point.x - 0.3 * point.y).clamp(-1.0, 1.0) as f32;
        vec![first, -first]
    });
    let mesh = delaunay(&samples, &Options::default(), &Silent).unwrap();
    let facts = assert_sound(&mesh);
    let volume = OPEN.volume();
    assert!(((facts[0].volume + facts[1].volume) / volume - 1.0).abs() < 1e-9);
    // The plane x = 0.13 − 0.3 y divides the box's sides 2 at 0.13 on average.
    assert!((facts[0].volume / volume - 1.13 / 2.0).abs() < 5e-3, "{}", facts[0].volume);
    let [caps, rest] = areas(&mesh, 2.0 / 21.0);
    // Faces of 2 × 2 and 2 × 1.63, twice and four times.
    assert!((caps / (8.0 + 4.0 * 3.26) - 1.0).abs() < 1e-9, "{caps}");
    assert!((rest / (2.0 * 1.09f64.sqrt() * 1.63) - 1.0).abs() < 1e-2, "{rest}");
}

/// Random labels and leads, so that checkerboards abound. Whether the first and
/// the third corner are connected is found by filling the face.
#[test]
fn what_is_connected_across_a_face_is_as_in_the_dual_mesh() {
    const FINE: i32 = 24;
    let lattice = Lattice { origin: DVec3::ZERO, voxel: 1.0, dims: [20; 3] };
    let mut random = Random::new(7);
    let leads: HashMap<[i32; 3], f32> = (0..8000)
        .map(|node| ([node / 400, node / 20 % 20, node % 20], (2.0 * random.unit() - 1.0) as f32))
        .collect();
    let samples = samples(lattice, |node| vec![leads.get(&node).copied().unwrap_or(-1.0)]);
    let oracle = Oracle::new(&samples, &crate::mesh::dual(&samples, &Silent).unwrap());
    let (mut faces, mut agree) = (0, 0);
    for ([x, y, z], lead) in &leads {
        let corner = |u: i32, v: i32| leads.get(&[x + u, y + v, *z]).copied().unwrap_or(-1.0);
        let [b, c, d] = [corner(1, 0), corner(1, 1), corner(0, 1)];
        let is_inner = [x, y, z].iter().all(|at| (1..18).contains(*at));
        if !is_inner || *lead <= 0.0 || b >= 0.0 || c <= 0.0 || d >= 0.0 {
            continue;
        }
        let is_inside = |[u, v]: [i32; 2]| {
            let fraction = |at: i32| f64::from(at) / f64::from(FINE);
            let at = [f64::from(*x) + fraction(u), f64::from(*y) + fraction(v), f64::from(*z)];
            oracle.label_at(at) == Label(1)
        };
        let (mut seen, mut open) = (HashSet::from([[0, 0]]), vec![[0, 0]]);
        while let Some([u, v]) = open.pop() {
            for next in [[u + 1, v], [u - 1, v], [u, v + 1], [u, v - 1]] {
                let is_on_face = next.iter().all(|at| (0..=FINE).contains(at));
                if is_on_face && is_inside(next) && seen.insert(next) {
                    open.push(next);
                }
            }
        }
        faces += 1;
        agree += usize::from(seen.contains(&[FINE; 2]) == (lead * c > b * d));
    }
    assert!(faces > 200, "{faces}");
    // Some cannot agree, where faces around a node ask for opposite things.
    assert!(agree as f64 > 0.99 * faces as f64, "{agree} of {faces}");
}
