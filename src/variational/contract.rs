//! What every backend must do, run for each of them, against the f64 reference that
//! assembles the matrix from the energy's terms.

use std::collections::BTreeSet;

use glam::DVec3;

use super::backend::{Backend, Limits};
use super::cpu::{Cpu, inverse_diagonal, residual};
use super::gpu::Gpu;
use super::metric::{DIRECTIONS, Direction, Metric};
use super::reference::{Node, Reference, Vector, cube};
use super::system::{Domain, Pull, SIDE, System};
use crate::check::shapes::disc;
use crate::error::Error;
use crate::field::Adapter;
use crate::grid::invariant::node_offset;
use crate::grid::leaf_grid::{LeafGrid, around};
use crate::grid::samples::LEAF_NODES;
use crate::label::Label;
use crate::plane::Plane;
use crate::random::Random;

/// Of a row of A x with absolute values all over: f32 rounds by 6e-8, and to a node's
/// sum a dozen roundings one after another have come, few of them in the same
/// direction. 3e-7 was seen.
const ROUNDING: f64 = 1e-6;
/// Of the largest value of a correction. Every one of 20 iterations rounds anew, its
/// factors too, and conjugate gradients carry that on: 4e-6 was seen.
const DRIFT: f64 = 3e-5;

/// A backend on this machine, or nothing (and a word about it).
type Make = fn() -> Option<Box<dyn Backend>>;

fn cpu() -> Option<Box<dyn Backend>> {
    Some(Box::new(Cpu::new()))
}

fn cpu_baseline() -> Option<Box<dyn Backend>> {
    Some(Box::new(Cpu::baseline()))
}

fn gpu() -> Option<Box<dyn Backend>> {
    match Gpu::new(Adapter::Any) {
        Ok(gpu) => Some(Box::new(gpu)),
        Err(Error::Device(_)) => {
            crate::skipped::skipped("no wgpu adapter");
            None
        }
        Err(other) => panic!("{other}"),
    }
}

macro_rules! contract {
    ($($backend:ident),*) => {
        $(mod $backend {
            contract!(@tests $backend: applies_the_matrix, corrects_as_the_reference,
                ends_at_the_tolerance, gives_the_same_bytes_again, solves_nothing,
                solves_without_iterations);
        })*
    };
    (@tests $backend:ident: $($test:ident),*) => {
        $(#[test]
        fn $test() {
            super::$test(super::$backend);
        })*
    };
}

contract!(cpu, cpu_baseline, gpu);

/// A system with all that it was made from.
pub struct Case {
    name: &'static str,
    pub leaves: Vec<Node>,
    free: BTreeSet<Node>,
    domain: Option<Domain>,
    pulls: Vec<Pull>,
    directions: Vec<Direction>,
    hold: f32,
}

/// Where nodes are held.
const START: f32 = 0.25;

impl Case {
    pub fn system(&self) -> System {
        let is_free = |node| self.free.contains(&node);
        let leaves = self.leaves.clone();
        let system = System::new(leaves, is_free, self.domain, &self.pulls, &self.directions);
        System { hold: self.hold, ..system }
    }

    fn reference(&self) -> Reference {
        let held = (self.hold, START);
        Reference::new(&self.free, self.domain, &self.pulls, &self.directions, held)
    }

    /// A vector as backends have it.
    pub fn flat(&self, values: &Vector) -> Vec<f32> {
        let value = |node: Node| values.get(&node).copied().unwrap_or_default() as f32;
        self.leaves.iter().flat_map(|&leaf| nodes(leaf)).map(value).collect()
    }

    /// The largest difference to what is expected, relative to `scale`, and where.
    fn difference(&self, found: &[f32], expected: &Vector, scale: &dyn Fn(Node) -> f64) -> f64 {
        let mut largest = 0.0_f64;
        let all = self.leaves.iter().flat_map(|&leaf| nodes(leaf));
        assert_eq!(found.len(), self.leaves.len() * LEAF_NODES);
        for (node, &found) in all.zip(found) {
            match expected.get(&node) {
                Some(expected) => {
                    let off = (f64::from(found) - expected).abs() / scale(node).max(1e-30);
                    assert!(off.is_finite(), "{}: {node:?}: {found}", self.name);
                    largest = largest.max(off);
                }
                None => assert_eq!(found, 0.0, "{}: {node:?} is not free", self.name),
            }
        }
        largest
    }
}

fn nodes(leaf: Node) -> impl Iterator<Item = Node> {
    (0..LEAF_NODES).map(move |node| {
        let offset = node_offset(node);
        std::array::from_fn(|axis| leaf[axis] * SIDE + offset[axis] as i32)
    })
}

/// Points that lie among free nodes and beyond them, a few of them right on nodes.
fn pulls(random: &mut Random, count: usize, low: Node, high: Node) -> Vec<Pull> {
    let pull = |index: usize| {
        let at = std::array::from_fn(|axis| {
            let at = f64::from(low[axis])
                + random.unit() * f64::from(high[axis] - 1 - low[axis]).max(0.0);
            if index.is_multiple_of(7) { at.floor() } else { at }
        });
        let weight = if index.is_multiple_of(3) { 10.0 } else { 0.01 };
        Pull { at, weight, target: (2.0 * random.unit() - 1.0) as f32 }
    };
    (0..count).map(pull).collect()
}

/// Those of sections with these normals.
fn along(normals: &[DVec3]) -> Vec<Direction> {
    let disc = |&normal: &DVec3| disc(Plane { normal, offset: 0.0 }, 1.0, 8, Label(1));
    Metric::new(&normals.iter().map(disc).collect::<Vec<_>>()).directions()
}

/// Systems of every kind, each for sections in all directions, for a stack along an axis,
/// and for one that leans.
pub fn cases() -> Vec<Case> {
    let leaning = along(&[DVec3::new(1.0, -2.0, 0.7)]);
    assert_eq!(leaning.len(), DIRECTIONS);
    let all = [along(&[]), along(&[DVec3::Y]), leaning];
    all.iter().flat_map(|directions| cases_along(directions)).collect()
}

fn cases_along(directions: &[Direction]) -> Vec<Case> {
    let directions = || directions.to_vec();
    let mut random = Random::new(1);
    let within = |leaves: &[Node], wanted: &dyn Fn(Node) -> bool| {
        leaves.iter().flat_map(|&leaf| nodes(leaf)).filter(|&node| wanted(node)).collect()
    };
    let inside = |low: Node, high: Node| {
        move |node: Node| (0..3).all(|axis| (low[axis]..high[axis]).contains(&node[axis]))
    };
    let mut cases = Vec::new();
    // A bent row of leaves, one apart, samples all over and around them, and one leaf
    // with more samples than a workgroup has invocations.
    let leaves = vec![[-1, 0, 0], [0, 0, 0], [0, 1, 0], [0, 1, 1], [3, 3, 3]];
    let mut all = pulls(&mut random, 300, [-10, -2, -2], [10, 18, 18]);
    all.extend(pulls(&mut random, 700, [24, 24, 24], [33, 33, 33]));
    let free = within(&leaves, &|_| true);
    cases.push(Case {
        name: "band",
        leaves,
        free,
        domain: None,
        pulls: all,
        directions: directions(),
        hold: 0.0,
    });
    // A closed box whose nodes from (−1, 2, 3) on are free, but for some.
    let leaves: Vec<Node> = cube([-1, 0, 0], 0, 2).collect();
    let wanted = inside([-1, 2, 3], [7, 11, 15]);
    let free: BTreeSet<Node> =
        within(&leaves, &|node| wanted(node) && (node[0] + 2 * node[1] + node[2]) % 5 != 0);
    let all = pulls(&mut random, 100, [-1, 2, 3], [7, 11, 15]);
    for (name, hold) in [("closed box", 0.0), ("held nodes", 0.7)] {
        cases.push(Case {
            name,
            leaves: leaves.clone(),
            free: free.clone(),
            domain: None,
            pulls: all.clone(),
            directions: directions(),
            hold,
        });
    }
    // A natural boundary on all sides, and nothing that pulls; the energy is 0 for
    // linear functions there.
    let boxes: [(_, Node, Node, _); 4] = [
        ("open box", [-3, 0, 2], [10, 9, 15], 0),
        ("open box with samples", [-3, 0, 2], [10, 9, 15], 150),
        ("thin box", [2, -1, 0], [5, 1, 17], 60),
        ("box of one node", [3, 4, -1], [4, 5, 9], 20),
    ];
    for (name, low, high, count) in boxes {
        let first = low.map(|along| along.div_euclid(SIDE));
        let leaves: Vec<Node> = cube(first, 0, 3).collect();
        let free = within(&leaves, &inside(low, high));
        let pulls = pulls(&mut random, count, low, high);
        cases.push(Case {
            name,
            leaves,
            free,
            domain: Some(Domain { low, high }),
            pulls,
            directions: directions(),
            hold: 0.0,
        });
    }
    cases
}

/// Values at random between −1 and 1.
fn values(nodes: impl IntoIterator<Item = Node>, seed: u64) -> Vector {
    let mut random = Random::new(seed);
    nodes.into_iter().map(|node| (node, f64::from((2.0 * random.unit() - 1.0) as f32))).collect()
}

/// What A makes of values at random: with samples missing not every right-hand side
/// has a solution.
pub fn right(case: &Case, seed: u64) -> Vector {
    let image = case.reference().apply(&values(case.free.iter().copied(), seed));
    image.into_iter().map(|(node, value)| (node, f64::from(value as f32))).collect()
}

fn applies_the_matrix(make: Make) {
    let Some(backend) = make() else { return };
    for case in cases() {
        let reference = case.reference();
        let x = values(case.free.iter().copied(), 2);
        let found = backend.apply(&case.system(), &case.flat(&x)).unwrap();
        let magnitude = reference.magnitude(&x);
        let off = case.difference(&found, &reference.apply(&x), &|node| magnitude[&node]);
        assert!(off < ROUNDING, "{}: {off}", case.name);
    }
}

/// After each of several numbers of iterations.
fn corrects_as_the_reference(make: Make) {
    let Some(backend) = make() else { return };
    for case in cases() {
        let (system, reference) = (case.system(), case.reference());
        let b = right(&case, 3);
        for iterations in [1, 2, 5, 20] {
            let limits = Limits { iterations, tolerance: 1e-6, of: 0.0 };
            let found = backend.correct(&system, case.flat(&b), limits).unwrap();
            // In a box of few nodes it may have ended before.
            assert!(found.iterations == iterations || case.free.len() < 20, "{}", case.name);
            let expected = reference.solve(&b, found.iterations);
            let largest = expected.values().fold(0.0, |sum: f64, value| sum.max(value.abs()));
            let off = case.difference(&found.values, &expected, &|_| largest);
            assert!(off < DRIFT, "{}, {iterations} iterations: {off}", case.name);
        }
    }
}

/// What it ended with has a residual as small as was asked for, and it did not go on
/// much longer than the reference must.
fn ends_at_the_tolerance(make: Make) {
    let Some(backend) = make() else { return };
    let case = cases().swap_remove(0);
    let reference = case.reference();
    let b = right(&case, 4);
    let limits = Limits { iterations: 500, tolerance: 1e-4, of: 0.0 };
    let found = backend.correct(&case.system(), case.flat(&b), limits).unwrap();
    // More than are submitted at once to a device.
    assert!((33..500).contains(&found.iterations), "{}", found.iterations);
    let diagonal = reference.diagonal();
    let size = |residual: &Vector| -> f64 {
        residual.iter().map(|(node, value)| value * value / diagonal[node]).sum::<f64>().sqrt()
    };
    let left = |iterations: u32| {
        let product = reference.apply(&reference.solve(&b, iterations));
        size(&b.iter().map(|(node, value)| (*node, value - product[node])).collect()) / size(&b)
    };
    // One part in a hundred for rounding.
    assert!(left(found.iterations) < 1.01e-4, "{}", left(found.iterations));
    assert!(left(found.iterations - 1) > 0.99e-4, "{}", left(found.iterations - 1));
}

fn gives_the_same_bytes_again(make: Make) {
    let Some(backend) = make() else { return };
    let limits = Limits { iterations: 20, tolerance: 1e-6, of: 0.0 };
    let solve = |case: &Case| {
        let b = right(case, 5);
        let found = backend.correct(&case.system(), case.flat(&b), limits).unwrap();
        found.values.iter().map(|value| value.to_bits()).collect::<Vec<_>>()
    };
    // Whatever is left in a device's memory by other systems.
    let cases = cases();
    let first: Vec<_> = cases.iter().map(solve).collect();
    let again: Vec<_> = cases.iter().rev().map(solve).collect();
    assert!(first.iter().eq(again.iter().rev()));
}

fn solves_nothing(make: Make) {
    let Some(backend) = make() else { return };
    let system = System::new(Vec::new(), |_| true, None, &[], &along(&[]));
    let limits = Limits { iterations: 20, tolerance: 1e-6, of: 0.0 };
    assert!(backend.apply(&system, &[]).unwrap().is_empty());
    assert!(backend.correct(&system, Vec::new(), limits).unwrap().values.is_empty());
    // A residual of 0.
    let case = cases().swap_remove(1);
    let zeros = vec![0.0; case.leaves.len() * LEAF_NODES];
    let found = backend.correct(&case.system(), zeros.clone(), limits).unwrap();
    assert_eq!((found.iterations, found.values), (0, zeros));
}

fn solves_without_iterations(make: Make) {
    let Some(backend) = make() else { return };
    let case = cases().swap_remove(1);
    let b = right(&case, 6);
    let limits = Limits { iterations: 0, tolerance: 1e-6, of: 0.0 };
    let found = backend.correct(&case.system(), case.flat(&b), limits).unwrap();
    assert_eq!(found.iterations, 0);
    assert!(found.values.iter().all(|&value| value == 0.0));
}

/// b − A x for a grid with values all around.
#[test]
fn the_residual_is_the_references() {
    for case in cases() {
        let reference = case.reference();
        let mut grid = LeafGrid::new([-32; 3], [64; 3]);
        grid.add(case.leaves.iter().flat_map(|&leaf| around(leaf)));
        let all: Vec<Node> = grid.leaves().iter().flat_map(|&leaf| nodes(leaf)).collect();
        let x = values(all.iter().copied(), 7);
        let flat: Vec<f32> = all.iter().map(|node| x[node] as f32).collect();
        grid.values_mut().copy_from_slice(&flat);
        let mut starts = grid.clone();
        starts.values_mut().fill(START);
        let found = residual(&case.system(), &grid, &starts);
        let magnitude = reference.magnitude(&x);
        let off = case.difference(&found, &reference.residual(&x), &|node| magnitude[&node]);
        assert!(off < ROUNDING, "{}: {off}", case.name);
    }
}

#[test]
fn the_diagonal_is_the_references() {
    for case in cases() {
        let expected: Vector = case
            .reference()
            .diagonal()
            .into_iter()
            .map(|(node, own)| (node, if own > 0.0 { 1.0 / own } else { 0.0 }))
            .collect();
        let found = inverse_diagonal(&case.system());
        let off = case.difference(&found, &expected, &|node| expected[&node].max(1e-3));
        assert!(off < ROUNDING, "{}: {off}", case.name);
    }
}
