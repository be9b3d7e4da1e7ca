//! The meshes are what the formulas say.

use glam::DVec3;
use rayon::prelude::*;

use transect::mesh::facts::Facts;

use super::*;
use formulas::{STEEPEST, knot};

fn solid(name: &str) -> Solid {
    let mut all = formulas::solids().into_iter();
    all.find(|solid| solid.name == name).expect("a solid of that name")
}

/// Of the mesh that is written.
fn facts(solid: &Solid) -> Facts {
    let mesh = formulas::mesh(solid, VOXELS).expect("a mesh");
    let bounds = mesh.bounds().expect("vertices");
    let voxel = solid.bounds.size().max_element() / f64::from(VOXELS);
    let within = solid.bounds.grown(voxel);
    assert!(within.contains(bounds.min) && within.contains(bounds.max));
    mesh.surface(Label(1)).facts(false).expect("facts")
}

/// The volume by counting the middles of 200 parts on the longest side.
fn counted(solid: &Solid) -> f64 {
    let step = solid.bounds.size().max_element() / 200.0;
    let counts = (solid.bounds.size() / step).ceil();
    let inside = |x: u32| {
        let mut inside = 0u64;
        for y in 0..counts.y as u32 {
            for z in 0..counts.z as u32 {
                let parts = DVec3::new(x.into(), y.into(), z.into()) + 0.5;
                inside += u64::from(solid.distance(solid.bounds.min + step * parts) < 0.0);
            }
        }
        inside
    };
    let inside: u64 = (0..counts.x as u32).into_par_iter().map(inside).sum();
    inside as f64 * step.powi(3)
}

/// Topology as it must be; the volume within `tolerance` of the formula's, or of
/// the counted one where there is none.
fn assert_true(name: &str, tolerance: f64) {
    let solid = solid(name);
    let (facts, truth) = (facts(&solid), solid.truth);
    assert!(facts.closed && facts.outward);
    assert_eq!(
        (facts.components, facts.cavities, facts.genus),
        (truth.components, truth.cavities, truth.genus)
    );
    let volume = truth.volume.unwrap_or_else(|| counted(&solid));
    let error = facts.volume / volume - 1.0;
    assert!(error.abs() < tolerance, "{} for {volume}: off by {error}", facts.volume);
}

// The mesh of a smooth solid loses about its curvature times a voxel squared, so
// most where it is thin: twigs are three voxels thick, and fingers eight. Counting
// errs by a percent there.
#[test]
fn the_vessel_is_one_tree() {
    assert_true("vessel", 3e-2);
}

#[test]
fn no_bone_touches_another() {
    assert_eq!(solid("bones").truth.components, 2 + 5 + 14);
    assert_true("bones", 3e-2);
}

#[test]
fn the_knot_is_one_tube() {
    assert_true("knot", 2e-3);
}

// Edges are rounded off within a voxel.
#[test]
fn the_part_has_its_holes() {
    assert_true("part", 1e-3);
}

#[test]
fn the_arm_makes_a_handle() {
    assert_true("body", 1e-2);
}

#[test]
fn shells_lie_in_shells() {
    assert_true("shells", 1e-3);
}

/// Leaves are left out by this bound.
#[test]
fn distances_are_no_steeper_than_promised() {
    // Roberts' evenly spread sequence.
    let steps =
        DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2);
    for solid in formulas::solids() {
        let voxel = solid.bounds.size().max_element() / f64::from(VOXELS);
        for number in 0..20_000u32 {
            let part = (f64::from(number) * steps).fract();
            let place = solid.bounds.min + part * solid.bounds.size();
            let along = (DVec3::new(part.y, part.z, part.x) - 0.5).normalize();
            // About as far as from a leaf's middle to its corner.
            let ahead = solid.distance(place + 6.0 * voxel * along);
            let slope = (ahead - solid.distance(place)) / (6.0 * voxel);
            // Far from the knot's tube Newton's method may end elsewhere.
            let near = solid.distance(place).abs() < 12.0 * voxel;
            assert!(!near || slope.abs() <= STEEPEST, "{} at {place}: {slope}", solid.name);
        }
    }
}

#[test]
fn the_knot_is_as_far_as_its_nearest_point() {
    let solid = solid("knot");
    // Beside the axis at even angles, within the tube, which is 15 thick; steps of
    // the axis are 0.1 long, so that the nearest of them is no more than
    // 0.05² / 2 / 10 farther than the nearest point.
    let mut worst = 0.0f64;
    for number in 0..400u32 {
        let angle = std::f64::consts::TAU * f64::from(number) / 400.0;
        let point = knot::axis(angle)[0];
        for axis in DVec3::AXES {
            let place = point + 10.0 * axis;
            let brute = (0..20_000)
                .map(|step| std::f64::consts::TAU * f64::from(step) / 20_000.0)
                .map(|angle| knot::axis(angle)[0].distance(place))
                .fold(f64::INFINITY, f64::min);
            worst = worst.max((solid.distance(place) + 15.0 - brute).abs());
        }
    }
    assert!(worst < 1e-3, "{worst}");
}
