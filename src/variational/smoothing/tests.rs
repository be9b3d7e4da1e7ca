use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::*;
use crate::change::Change;
use crate::check::shapes::{disc, section};
use crate::context::Context;
use crate::grid::lattice::Resolution;
use crate::mesh::nearest::Nearest;
use crate::mesh::shapes::assert_edge_manifold;
use crate::method::{MeanValue, Method};
use crate::model::{Model, Options};
use crate::plane::{Bounds, Plane};
use crate::section::{Edge, Sections};

const LABEL: Label = Label(1);

fn level(height: f64) -> Plane {
    Plane { normal: DVec3::Z, offset: height }
}

/// Seven equal discs of radius 1, half a unit apart: a cylinder.
fn cylinder() -> Vec<Section> {
    (-3..=3).map(|step| disc(level(0.5 * f64::from(step)), 1.0, 400, LABEL)).collect()
}

struct Made {
    samples: Samples,
    mesh: Mesh,
}

impl Made {
    fn new(sections: &[Section], voxels: u32, smooth: f64, border: Label) -> Self {
        let method = MeanValue { smooth, border, ..MeanValue::default() };
        let resolution = Resolution::Voxels(voxels);
        let mut model = Model::new(Options {
            method: Method::MeanValue(method),
            resolution,
            ..Options::default()
        });
        let sections = Sections { sections: sections.to_vec(), ..Sections::default() };
        let change = Change::Add(sections);
        model.apply(change, &mut Context::default()).unwrap();
        let derived = model.derived().unwrap();
        derived.samples.sanity_check().unwrap();
        Self { samples: derived.samples.clone(), mesh: derived.mesh.clone() }
    }

    fn voxel(&self) -> f64 {
        self.samples.lattice.voxel
    }
}

/// The smallest and the largest distance from the z axis of vertices up to a height.
fn radii(mesh: &Mesh, height: f64) -> [f64; 2] {
    let inner = mesh.vertices.iter().filter(|vertex| vertex.z.abs() < height);
    inner
        .map(|vertex| vertex.truncate().length())
        .fold([f64::INFINITY, 0.0], |[low, high], own| [low.min(own), high.max(own)])
}

/// The largest distance from the sections' vertices to a mesh.
fn off_contours(mesh: &Mesh, sections: &[Section]) -> f64 {
    let points: Vec<DVec3> = sections
        .iter()
        .flat_map(|section| (0..section.vertices.len()).map(|vertex| section.point(vertex as u32)))
        .collect();
    largest(&Nearest::on_mesh(mesh).unwrap().distances(&points).unwrap())
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

#[test]
fn beads_between_equal_discs_go_and_contours_stay() {
    let sections = cylinder();
    let [rough, smooth] =
        [0.0, 1.0].map(|strength| Made::new(&sections, 96, strength, Label::OUTSIDE));
    let [rough_radii, smooth_radii] = [&rough, &smooth].map(|one| radii(&one.mesh, 1.0));
    let contours = off_contours(&smooth.mesh, &sections) / smooth.voxel();
    eprintln!(
        "{rough_radii:?} {smooth_radii:?} {contours} voxels, spacing {}",
        typical_spacing(&rough.mesh, &sections)
    );
    assert!(rough_radii[0] < 0.96, "{rough_radii:?}");
    assert!(smooth_radii[0] > 0.985 && smooth_radii[1] < 1.01, "{smooth_radii:?}");
    assert!(contours < 0.1, "{contours}");
    assert_edge_manifold(&smooth.mesh, LABEL);
}

#[test]
fn the_result_does_not_depend_on_the_resolution() {
    let sections = cylinder();
    let [coarse, fine] = [96, 192].map(|voxels| Made::new(&sections, voxels, 1.0, Label::OUTSIDE));
    let voxel = coarse.voxel();
    let nearest = Nearest::on_mesh(&coarse.mesh).unwrap();
    let distances = nearest.distances(&fine.mesh.vertices).unwrap();
    let volumes = [&coarse, &fine].map(|one| one.mesh.surface(LABEL).volume());
    eprintln!("{} voxels, volumes {volumes:?}", largest(&distances) / voxel);
    assert!(largest(&distances) < 0.5 * voxel, "{}", largest(&distances) / voxel);
    assert!((volumes[0] / volumes[1] - 1.0).abs() < 0.01, "{volumes:?}");
}

#[test]
fn balls_and_rings_keep_their_volume() {
    // A ball of radius 1 by 15 planes, and a ring of radius 1 that is 0.4 thick by
    // planes of its axis, 24 half planes of them.
    let ball: Vec<Section> = (-7..=7)
        .map(|step| {
            let height = f64::from(step) / 8.0;
            disc(level(height), (1.0 - height * height).sqrt(), 200, LABEL)
        })
        .collect();
    let ring: Vec<Section> = (0..12)
        .map(|step| {
            let normal = DVec2::from_angle(PI / 12.0 * f64::from(step)).extend(0.0);
            two_discs(Plane { normal, offset: 0.0 })
        })
        .collect();
    let volumes = [4.0 / 3.0 * PI, 2.0 * PI * PI * 0.4 * 0.4];
    for (sections, volume) in [ball, ring].iter().zip(volumes) {
        let found = [0.0, 1.0].map(|smooth| {
            let made = Made::new(sections, 96, smooth, Label::OUTSIDE);
            assert_edge_manifold(&made.mesh, LABEL);
            made.mesh.surface(LABEL).volume() / volume
        });
        eprintln!("{found:?}");
        assert!((found[1] - 1.0).abs() < 0.02, "{found:?}");
    }
}

/// A ring cut by a plane through its axis.
fn two_discs(plane: Plane) -> Section {
    let corners = 200u32;
    let [first, second] = [plane.unit_normal().cross(DVec3::Z), DVec3::Z];
    let points = [1.0, -1.0].iter().flat_map(|&middle| {
        (0..corners).map(move |at| {
            let turned = 0.4 * DVec2::from_angle(TAU * f64::from(at) / f64::from(corners));
            (middle + turned.x) * first + turned.y * second
        })
    });
    let mut own = section(plane, &[], LABEL);
    own.vertices = points.map(|point| plane.project(point)).collect();
    // Seen along the normal, from the first axis to the second is counter-clockwise
    // or clockwise.
    let is_left = first.cross(second).dot(plane.unit_normal()) > 0.0;
    let sides = if is_left { [LABEL, Label::OUTSIDE] } else { [Label::OUTSIDE, LABEL] };
    let edge = |start: u32| {
        let round = start / corners * corners;
        let end = round + (start + 1 - round) % corners;
        Edge { start, end, left: sides[0], right: sides[1] }
    };
    own.edges = (0..2 * corners).map(edge).collect();
    own
}

/// A body smaller than the voxels of the levels that know where it is, alone or beside a
/// large one, is there when all is smooth.
#[test]
fn what_coarse_levels_cannot_see_stays() {
    let step = |step: i32| level(0.04 * f64::from(step));
    let small: Vec<Section> = (-1..=1).map(|at| disc(step(at), 0.05, 40, LABEL)).collect();
    let bounds = Bounds { min: DVec3::splat(-2.0), max: DVec3::splat(2.0) };
    let resolution = Resolution::Voxels(200);
    let method = Method::MeanValue(MeanValue::default());
    let mut model =
        Model::new(Options { method, resolution, bounds: Some(bounds), ..Options::default() });
    let mut volumes = Vec::new();
    let sections = Sections { sections: small, ..Sections::default() };
    model.apply(Change::Add(sections), &mut Context::default()).unwrap();
    volumes.push(model.derived().unwrap().mesh.surface(LABEL).volume());
    let cylinder: Vec<Section> = [-1.0, 1.0].map(|z| disc(level(z), 0.8, 400, Label(2))).into();
    let sections = Sections { sections: cylinder, ..Sections::default() };
    model.apply(Change::Add(sections), &mut Context::default()).unwrap();
    volumes.push(model.derived().unwrap().mesh.surface(LABEL).volume());
    // As high as the sections are and half a spacing more at either end, or a little less.
    let expected = PI * 0.05 * 0.05 * 0.1;
    assert!(volumes.iter().all(|own| (0.6..1.4).contains(&(own / expected))), "{volumes:?}");
}

#[test]
fn a_cylinder_leaves_an_open_box_as_wide_as_it_is_inside() {
    let open = Made::new(&cylinder(), 64, 1.0, Label::UNKNOWN);
    let voxel = open.voxel();
    let bounds = open.samples.open.unwrap();
    let rims = open.mesh.without_caps(bounds, 1e-3 * voxel);
    let surface = rims.surface(LABEL);
    let found = radii(&rims, bounds.max.z + voxel);
    eprintln!("{found:?}");
    assert!(found[0] > 0.98 && found[1] < 1.02, "{found:?}");
    // Two circles on the box's ends.
    let edges = surface.open_edges();
    let ends = edges.iter().flatten().map(|&vertex| surface.vertices[vertex as usize].z.abs());
    let off = ends.map(|end| (end - bounds.max.z).abs()).fold(0.0, f64::max);
    assert!(!edges.is_empty() && off < 1e-9, "{off}");
}

/// The cylinder, its part with y above 0 being another material.
fn halves() -> Vec<Section> {
    let half = |mut disc: Section| {
        let corners = disc.vertices.len() as u32;
        let places = disc.clone();
        for edge in &mut disc.edges {
            let middle = (places.point(edge.start) + places.point(edge.end)) / 2.0;
            let own = if middle.y > 0.0 { Label(2) } else { LABEL };
            for side in [&mut edge.left, &mut edge.right] {
                *side = if *side == LABEL { own } else { *side };
            }
        }
        let cut = (0..corners).filter(|&at| disc.point(at).y.abs() < 1e-9).collect::<Vec<_>>();
        let [start, end] = cut[..] else { panic!("{cut:?}") };
        // Left of the way from −x to x lies what is above, seen along the normal.
        let [start, end] =
            if disc.point(start).x < disc.point(end).x { [start, end] } else { [end, start] };
        disc.edges.push(Edge { start, end, left: Label(2), right: LABEL });
        disc
    };
    cylinder().into_iter().map(half).collect()
}

#[test]
fn materials_stay_apart() {
    let smooth = Made::new(&halves(), 64, 1.0, Label::OUTSIDE);
    let voxel = smooth.voxel();
    let found = radii(&smooth.mesh, 1.0);
    let volumes = [LABEL, Label(2)].map(|label| {
        assert_edge_manifold(&smooth.mesh, label);
        smooth.mesh.surface(label).volume()
    });
    let wall = smooth.mesh.sides.iter().zip(&smooth.mesh.triangles);
    let wall = wall.filter(|(sides, _)| **sides == [LABEL, Label(2)]);
    let places: Vec<DVec3> = wall
        .flat_map(|(_, triangle)| triangle.map(|vertex| smooth.mesh.vertices[vertex as usize]))
        .collect();
    let off = |is_near: &dyn Fn(&&DVec3) -> bool| {
        places.iter().filter(is_near).fold(0.0, |most: f64, at| most.max(at.y.abs()))
    };
    let off = [off(&|at| at.x.abs() < 0.8 && at.z.abs() < 1.3), off(&|_| true)];
    eprintln!("{volumes:?} {off:?} {voxel} {found:?}");
    assert!((volumes[0] / volumes[1] - 1.0).abs() < 0.01, "{volumes:?}");
    // Where *outside* is near, the lattice shows a little more.
    assert!(off[0] < 0.1 * voxel && off[1] < 0.5 * voxel, "{off:?}");
}

#[test]
fn with_a_length_below_the_voxel_nothing_changes() {
    let sections = cylinder();
    let rough = Made::new(&sections, 48, 0.0, Label::OUTSIDE);
    let voxel = rough.voxel();
    let bounds = Bounds { min: rough.samples.lattice.origin + 0.5 * voxel, max: DVec3::ZERO };
    let bounds = Bounds { max: -bounds.min, ..bounds };
    let frame = Frame { bounds, lattice: rough.samples.lattice, is_fixed: false };
    let original = Original { mesh: &rough.mesh, open: None, length: 0.2 * voxel, finest: voxel };
    let same =
        smoothed_mesh(&rough.samples, original, &sections, &frame, (false, &mut None), &Silent)
            .unwrap();
    let mesh = dual(&same.samples, &Silent).unwrap();
    let nearest = Nearest::on_mesh(&rough.mesh).unwrap();
    let off = largest(&nearest.distances(&mesh.vertices).unwrap()) / voxel;
    eprintln!("{off}");
    assert!(off < 0.2, "{off} voxels");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let sections = halves();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Made::new(&sections, 32, 1.0, Label::OUTSIDE).samples)
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn the_typical_spacing_is_that_of_a_stack() {
    let rough = Made::new(&cylinder(), 48, 0.0, Label::OUTSIDE);
    let spacing = typical_spacing(&rough.mesh, &cylinder());
    // Half a unit, and more for the ends beyond the last discs.
    assert!((spacing / 0.5 - 1.0).abs() < 0.35, "{spacing}");
    assert_eq!(typical_spacing(&Mesh::default(), &cylinder()), 0.0);
}
