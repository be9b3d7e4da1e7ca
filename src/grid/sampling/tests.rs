use glam::{DVec2, DVec3};

use super::*;
use crate::field::Queries;
use crate::grid::labels::LabelGrid;
use crate::grid::lattice::Resolution;
use crate::plane::{Bounds, Plane};
use crate::progress::Silent;
use crate::section::Edge;

/// Balls as labels 1, 2, …: centre and radius.
struct Balls {
    balls: Vec<(DVec3, f64)>,
    labels: [Vec<Label>; 2],
}

/// f = 1 - 2 (|x - c| / r)² / 2, cut off: positive inside the ball.
fn indicator(point: DVec3, (center, radius): (DVec3, f64)) -> f32 {
    (1.0 - ((point - center).length() / radius).powi(2)).clamp(-1.0, 1.0) as f32
}

impl Balls {
    fn new(balls: &[(DVec3, f64)]) -> Self {
        let labels = (0..=balls.len() as u32).map(Label).collect();
        Self { balls: balls.to_vec(), labels: [labels, vec![Label::OUTSIDE]] }
    }

    fn label(&self, point: DVec3) -> Label {
        let inside = self.balls.iter().position(|&ball| indicator(point, ball) > 0.0);
        Label(inside.map_or(0, |index| index as u32 + 1))
    }
}

impl Field for Balls {
    fn labels(&self, cell: u32) -> &[Label] {
        &self.labels[cell as usize]
    }

    fn edges(&self, cell: u32) -> u64 {
        u64::from(cell == 0)
    }

    fn name(&self) -> String {
        "balls".to_owned()
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        let points = queries.runs.iter().flat_map(|run| {
            assert_eq!(run.cell, 0, "a cell of one label needs no evaluation");
            &queries.points[run.points.clone()]
        });
        let values = |&point: &DVec3| {
            let own: Vec<f32> = self.balls.iter().map(|&ball| indicator(point, ball)).collect();
            let outside = 1.0 - own.iter().map(|f| f + 1.0).sum::<f32>();
            std::iter::once(outside).chain(own).collect::<Vec<f32>>()
        };
        Ok(points.flat_map(values).collect())
    }
}

/// Two cells: the second one, beyond x = `split`, is outside all over.
struct Halves {
    bounds: Bounds,
    split: f64,
    open: bool,
}

impl Cells for Halves {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn is_open(&self) -> bool {
        self.open
    }

    fn locate(&self, point: DVec3) -> u32 {
        u32::from(point.x > self.split)
    }

    fn locator<'a>(&'a self, _region: Bounds) -> Box<dyn Fn(DVec3) -> u32 + 'a> {
        Box::new(|point| self.locate(point))
    }
}

fn cube(half: f64) -> Bounds {
    Bounds { min: DVec3::splat(-half), max: DVec3::splat(half) }
}

fn run(balls: &Balls, cells: &Halves, lattice: Lattice, margin: usize) -> Sampling {
    let margin = Margin(margin);
    let sampler = Sampler { cells, field: balls, lattice, margin, before: None, progress: &Silent };
    sampler.run(Vec::new()).unwrap()
}

#[test]
fn every_node_of_two_balls_has_the_right_label() {
    let balls = Balls::new(&[(DVec3::splat(-0.3), 0.45), (DVec3::new(0.5, 0.4, 0.45), 0.4)]);
    let cells = Halves { bounds: cube(1.0), split: 0.95, open: false };
    let lattice = Lattice::new(cells.bounds, Resolution::Voxels(50)).unwrap();
    let Sampling { kept: Kept { samples, .. }, points } = run(&balls, &cells, lattice, 1);
    samples.sanity_check().unwrap();
    assert_eq!(samples.materials(), [Label(1), Label(2)]);
    let labels = LabelGrid::new(&samples);
    let mut inside = 0;
    for x in 0..lattice.dims[0] {
        for y in 0..lattice.dims[1] {
            for z in 0..lattice.dims[2] {
                let expected = balls.label(lattice.position([x, y, z]));
                assert_eq!(labels.at([x, y, z]), expected, "{x} {y} {z}");
                inside += u64::from(expected.is_material());
            }
        }
    }
    assert!(inside > 8000, "{inside}");
    // Less than all leaves, and no node outside the box or in the second cell.
    assert!(samples.valued.len() < 343 && points < samples.valued.len() as u64 * 512);
}

#[test]
fn of_many_labels_leaves_keep_those_that_are_near() {
    let place = |index: i32| f64::from(index) / 4.0 - 0.75;
    let all = (0..343).map(|ball| [ball / 49, ball / 7 % 7, ball % 7].map(place));
    let balls: Vec<(DVec3, f64)> = all.map(|at| (DVec3::from(at), 0.085)).collect();
    let balls = Balls::new(&balls);
    let cells = Halves { bounds: cube(1.0), split: 0.95, open: false };
    let lattice = Lattice::new(cells.bounds, Resolution::Voxels(60)).unwrap();
    let Sampling { kept: Kept { samples, .. }, points } = run(&balls, &cells, lattice, 1);
    samples.sanity_check().unwrap();
    assert_eq!(samples.materials().len(), 343);
    let labels = LabelGrid::new(&samples);
    for node in samples.leaves().flat_map(|leaf| (0..LEAF_NODES).map(move |node| leaf.node(node))) {
        let expected = balls.label(lattice.position(node));
        assert_eq!(labels.at(node), expected, "{node:?}");
    }
    // A leaf is as wide as balls are apart: some of eight are in it, and *outside*.
    let kept: usize = samples.leaves().map(|leaf| leaf.materials.len()).sum();
    assert!(kept < 9 * samples.valued.len(), "{kept} in {} leaves", samples.valued.len());
    assert!(points > 100_000, "{points}");
}

#[test]
fn a_surface_on_the_box_is_closed_outside_of_it() {
    let balls = Balls::new(&[(DVec3::ZERO, 10.0)]);
    let cells = Halves { bounds: cube(1.0), split: 2.0, open: false };
    for resolution in [6, 7, 14, 15, 16, 30] {
        let lattice = Lattice::new(cells.bounds, Resolution::Voxels(resolution)).unwrap();
        let samples = run(&balls, &cells, lattice, 1).kept.samples;
        samples.sanity_check().unwrap();
        let nodes = lattice.dims.map(|nodes| nodes - 2);
        let labels = LabelGrid::new(&samples);
        assert_eq!([nodes, [1; 3]].map(|node| labels.at(node)), [Label(1); 2]);
    }
}

#[test]
fn a_wider_margin_keeps_the_surface_from_tiles() {
    let balls = Balls::new(&[(DVec3::splat(0.1), 0.61)]);
    let cells = Halves { bounds: cube(1.0), split: 2.0, open: false };
    let lattice = Lattice::new(cells.bounds, Resolution::Voxels(64)).unwrap();
    let narrow = run(&balls, &cells, lattice, 1).kept.samples;
    let wide = run(&balls, &cells, lattice, 4).kept.samples;
    assert!(wide.valued.len() > narrow.valued.len());
    wide.sanity_check().unwrap();
    for leaf in wide.leaves() {
        let labels = leaf.labels();
        for (axis, forward) in faces() {
            let next = neighbor(leaf.at, axis, forward);
            if lattice.has_leaf(next) && !wide.is_valued(next) {
                assert!(!differs_near_face(&labels, axis, forward, 4, wide.tile(next)));
            }
        }
    }
}

#[test]
fn contours_find_what_the_coarse_lattice_misses() {
    // A ball of three nodes' width between the coarse nodes.
    let center = DVec3::new(0.02, 0.03, 0.01);
    let balls = Balls::new(&[(center, 0.045)]);
    let cells = Halves { bounds: cube(1.0), split: 2.0, open: false };
    let lattice = Lattice::new(cells.bounds, Resolution::Voxels(64)).unwrap();
    assert!(run(&balls, &cells, lattice, 1).kept.samples.valued.is_empty());

    let plane = Plane { normal: DVec3::Z, offset: 0.01 };
    let around = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    let vertices = around.map(|(x, y)| DVec2::new(0.02 + 0.045 * x, 0.03 + 0.045 * y)).to_vec();
    let edge = |start| Edge { start, end: (start + 1) % 4, left: Label(1), right: Label::OUTSIDE };
    let section = Section {
        name: "middle".to_owned(),
        plane,
        vertices,
        edges: (0..4).map(edge).collect(),
        background: Label::OUTSIDE,
        normals: Vec::new(),
    };
    let edges: Vec<[DVec3; 2]> = section.segments().collect();
    let Starts(starts) = Starts::along(&edges, &lattice);
    let sampler = Sampler {
        cells: &cells,
        field: &balls,
        lattice,
        margin: Margin(1),
        before: None,
        progress: &Silent,
    };
    let samples = sampler.run(starts).unwrap().kept.samples;
    samples.sanity_check().unwrap();
    let labels = samples.leaves().flat_map(|leaf| leaf.labels());
    assert!(labels.filter(|&label| label == Label(1)).count() > 5);
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let balls = Balls::new(&[(DVec3::splat(-0.3), 0.45), (DVec3::new(0.5, 0.4, 0.45), 0.4)]);
    let cells = Halves { bounds: cube(1.0), split: 0.95, open: false };
    let lattice = Lattice::new(cells.bounds, Resolution::Voxels(60)).unwrap();
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&balls, &cells, lattice, 2))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn in_an_open_box_nodes_beyond_it_have_the_nearest_values_inside() {
    // One ball lies on a face of the box, the other one around a corner.
    let balls = Balls::new(&[(DVec3::new(0.0, -0.2, 1.0), 0.5), (DVec3::splat(-1.0), 0.7)]);
    let cells = Halves { bounds: cube(1.0), split: 2.0, open: true };
    for resolution in [47, 48, 55] {
        let lattice = Lattice::new(cells.bounds, Resolution::Voxels(resolution)).unwrap();
        let samples = run(&balls, &cells, lattice, 3).kept.samples;
        samples.sanity_check().unwrap();
        assert_eq!(samples.open, Some(cells.bounds));
        let mut beyond = 0;
        for leaf in samples.leaves() {
            for (node, label) in leaf.labels().into_iter().enumerate() {
                let node = leaf.node(node);
                let nearest = lattice.position(lattice.nearest_inner(node));
                assert_eq!(label, balls.label(nearest), "{node:?}");
                beyond += u64::from(!lattice.is_inner(node) && label.is_material());
            }
        }
        assert!(beyond > 100);
        let mesh = crate::mesh::dual(&samples, &Silent).unwrap();
        let ball = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        // Half of the one, and an eighth of the other.
        for (label, expected) in [(1, ball(0.5) / 2.0), (2, ball(0.7) / 8.0)] {
            let volume = mesh.surface(Label(label)).volume();
            assert!((volume / expected - 1.0).abs() < 0.02, "{volume} for {expected}");
        }
    }
}
