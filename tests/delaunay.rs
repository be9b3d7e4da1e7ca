//! The two meshers against each other on real sections.

mod common;

use std::path::Path;

use common::data;
use glam::DVec3;
use transect::change::Change;
use transect::context::Context;
use transect::io::read_sections;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::mesh::delaunay::{Options as Limits, delaunay};
use transect::mesh::nearest::Nearest;
use transect::model::{Model, Options};
use transect::progress::Silent;
use transect::section::Rules;

/// Points on all triangles, about `step` apart.
fn spread(mesh: &Mesh, step: f64) -> Vec<DVec3> {
    let on_triangle = |triangle| {
        let [a, b, c] = mesh.corners(triangle);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let parts = (longest / step).ceil().max(1.0) as u32;
        let point = move |i: u32, j: u32| {
            let [i, j] = [i, j].map(|along| f64::from(along) / f64::from(parts));
            a + i * (b - a) + j * (c - a)
        };
        (0..=parts).flat_map(move |i| (0..=parts - i).map(move |j| point(i, j)))
    };
    (0..mesh.triangles.len()).flat_map(on_triangle).collect()
}

/// The largest distance of a point of one mesh from the other.
fn farthest(from: &Mesh, to: &Mesh, step: f64) -> f64 {
    let nearest = Nearest::on_mesh(to).expect("the mesh has area");
    let distances = nearest.distances(&spread(from, step)).expect("distances are found");
    distances.into_iter().fold(0.0, f64::max)
}

/// In degrees.
fn smallest_angle(mesh: &Mesh) -> f64 {
    (0..mesh.triangles.len())
        .flat_map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            [[a, b, c], [b, c, a], [c, a, b]].map(|[a, b, c]| (b - a).angle_between(c - a))
        })
        .fold(f64::MAX, f64::min)
        .to_degrees()
}

#[test]
fn triangles_are_good_and_at_the_same_surface() {
    for name in ["vessel.csl", "csl/Elephant.csl"] {
        let Some(path) = data(name) else { continue };
        assert_good(&path);
    }
}

fn assert_good(path: &Path) {
    let rules = Rules::default();
    let sections = read_sections(path, &rules).expect("the file can be read");
    let mut model = Model::new(Options::default());
    model.apply(Change::Add(sections), &mut Context::default()).expect("it reconstructs");
    let derived = model.derived().expect("something was derived");
    let mesh = delaunay(&derived.samples, &Limits::default(), &Silent).expect("it is meshed");

    let facts = mesh.surface(Label(1)).facts(true).expect("it can be measured");
    assert!(facts.closed && facts.outward);
    assert_eq!(facts.self_intersections, Some(0));
    let angle = smallest_angle(&mesh);
    let voxel = derived.samples.lattice.voxel;
    let apart = [(&mesh, &derived.mesh), (&derived.mesh, &mesh)]
        .map(|(from, to)| farthest(from, to, 0.3 * voxel) / voxel);
    println!("smallest angle {angle:.1}°; the meshers are {apart:.2?} voxels apart");
    assert!(angle >= 25.0, "{angle}");
    // Points lie at most 0.3 voxels apart, so nothing between them is further
    // than 0.3 more.
    assert!(apart.iter().all(|&apart| apart < 1.0 - 0.3), "{apart:?}");
}
