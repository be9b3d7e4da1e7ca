//! Every method on solids that are known.

#[path = "../examples/solids/formulas/mod.rs"]
#[allow(dead_code)] // the volumes are tested with the example
mod formulas;
#[path = "common/trials.rs"]
#[allow(dead_code)] // the benchmark shows names and seconds
mod trials;

use std::f64::consts::TAU;

use glam::DVec3;

use transect::label::Label;
use transect::mesh::Mesh;
use transect::plane::Plane;

use formulas::Solid;
use trials::{Cut, Trial, methods, trial};

/// Voxels of the solids and of their reconstructions: coarse, to be quick.
const VOXELS: [u32; 2] = [128, 64];

fn solid(name: &str) -> Solid {
    let mut all = formulas::solids().into_iter();
    all.find(|solid| solid.name == name).expect("a solid of that name")
}

/// For each method what it makes of a solid; closed, whatever else it is.
fn tried(solid: &Mesh, planes: &[Plane]) -> Vec<(&'static str, Trial)> {
    let mut tried = Vec::new();
    for (name, method) in methods() {
        let trial = trial(solid, planes, method, VOXELS[1]).expect("a reconstruction");
        println!("{name}: {trial:?}");
        assert!(trial.facts.closed && trial.facts.outward, "{name}");
        tried.push((name, trial));
    }
    tried
}

fn mesh_of(name: &str) -> Mesh {
    formulas::mesh(&solid(name), VOXELS[0]).expect("a mesh")
}

fn cut(mesh: &Mesh, cut: impl Fn(&transect::plane::Bounds) -> Cut) -> Vec<Plane> {
    let bounds = mesh.bounds().expect("vertices");
    cut(&bounds).planes(&bounds).expect("planes")
}

/// Every method has at least its part of the volume in common with the solid; one
/// that is not listed, as much as the worst.
fn assert_common(tried: &[(&str, Trial)], parts: &[(&str, f64)]) {
    let worst = parts.iter().map(|part| part.1).fold(1.0, f64::min);
    for (name, trial) in tried {
        let part = parts.iter().find(|part| part.0 == *name).map_or(worst, |part| part.1);
        assert!(trial.comparison.iou > part, "{name}: {} of {part}", trial.comparison.iou);
    }
}

// The parts are what was measured, less 0.03: 0.615 and 0.643.
#[test]
fn random_planes_through_the_knot() {
    let mesh = mesh_of("knot");
    let tried = tried(&mesh, &cut(&mesh, |_| Cut::random(1)));
    assert_common(&tried, &[("mean-value", 0.585), ("skeleton", 0.613)]);
}

// Measured: 0.715 and 0.856. Mean values shrink between parallel planes.
#[test]
fn parallel_planes_through_the_body() {
    let mesh = mesh_of("body");
    let tried = tried(&mesh, &cut(&mesh, Cut::parallel));
    assert_common(&tried, &[("mean-value", 0.685), ("skeleton", 0.826)]);
}

// Measured: 0.887 and 0.874. All holes are cut, and found.
#[test]
fn planes_along_the_part() {
    let solid = solid("part");
    let mesh = mesh_of("part");
    let tried = tried(&mesh, &cut(&mesh, |_| Cut::axes()));
    assert_common(&tried, &[("mean-value", 0.857), ("skeleton", 0.844)]);
    assert!(tried.iter().all(|(_, trial)| trial.facts.genus == solid.truth.genus));
}

/// A cone of this radius and height that stands on z = 0.
fn cone(radius: f64, height: f64) -> Mesh {
    const SIDES: u32 = 180;
    let around = |side: u32| TAU * f64::from(side) / f64::from(SIDES);
    let ring = |side| radius * DVec3::new(around(side).cos(), around(side).sin(), 0.0);
    let mut mesh = Mesh { vertices: (0..SIDES).map(ring).collect(), ..Mesh::default() };
    mesh.vertices.extend([DVec3::ZERO, height * DVec3::Z]);
    for side in 0..SIDES {
        let next = (side + 1) % SIDES;
        mesh.triangles.extend([[side, next, SIDES + 1], [next, side, SIDES]]);
        mesh.sides.extend([[Label(1), Label::OUTSIDE]; 2]);
    }
    mesh
}

/// A cone that rises by 4 on 3 is atan(4/3) = 53.13° steep. The nearest section
/// makes stairs of it, whose walls have 90° and are 36.87° off. Sections are 0.4
/// apart, so up to a 128th of 3.0 from one of them, 0.023, these walls, no more
/// than 0.018 away, are nearer than the next stair's floor.
#[test]
fn stairs_of_a_cone_are_walls() {
    let cone = cone(1.5, 2.0);
    let planes: Vec<Plane> =
        [0.2, 0.6, 1.0, 1.4, 1.8].map(|offset| Plane { normal: DVec3::Z, offset }).into();
    for (name, trial) in tried(&cone, &planes) {
        let found = trial.leaning.expect("points near the planes");
        assert!((found.true_steepness - 53.13).abs() < 0.1, "{found:?}");
        match name {
            "skeleton" => {
                assert!((found.steepness - 90.0).abs() < 0.5, "{found:?}");
                assert!((found.error - 36.87).abs() < 0.5, "{found:?}");
            }
            _ => assert!(found.error < 36.87, "{name}: {found:?}"),
        }
    }
}
