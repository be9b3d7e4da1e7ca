//! What is the GPU's alone; the contract has the rest.

use super::layout::{DeviceLeaf, State, Tables};
use super::*;
use crate::error::Error;
use crate::gpu::shader::Shader;
use crate::variational::contract::{cases, right};
use crate::variational::system::SIDE;

const LIMITS: Limits = Limits { iterations: 20, tolerance: 1e-6, of: 0.0 };

fn any_gpu() -> Option<Gpu> {
    match Gpu::new(Adapter::Any) {
        Ok(gpu) => Some(gpu),
        Err(Error::Device(_)) => {
            crate::skipped::skipped("no wgpu adapter");
            None
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn the_shader_is_valid_and_its_layouts_are_the_hosts() {
    let shader = Shader::new(SHADER);
    shader.require_sizes(&[
        ("Leaf", size_of::<DeviceLeaf>()),
        ("Sample", size_of::<Sample>()),
        ("State", size_of::<State>()),
    ]);
    assert_eq!(shader.constant("SIDE") as i32, SIDE);
    let invocations = shader.constant("GROUP");
    assert_eq!(2 * invocations, LEAF_NODES);
    assert!(shader.workgroups().iter().all(|&own| own as usize == invocations));
}

/// Every leaf keeps its samples, those of a cell together.
#[test]
fn samples_are_sorted_leaf_by_leaf() {
    let system = cases().swap_remove(0).system();
    let tables = Tables::new(&system);
    assert!((0..system.leaves.len()).any(|leaf| system.samples_of(leaf).len() > 256));
    for leaf in 0..system.leaves.len() {
        let range = system.starts[leaf] as usize..system.starts[leaf + 1] as usize;
        let found = &tables.samples[range];
        assert!(found.is_sorted_by_key(|sample| sample.node));
        let own = system.samples_of(leaf);
        assert!(own.iter().all(|sample| found.contains(sample)));
    }
}

/// More leaves than there may be workgroups along an axis: 5 leaves in rows of 2.
#[test]
fn rows_of_workgroups_change_nothing() {
    let Some(wide) = any_gpu() else { return };
    let Some(mut narrow) = any_gpu() else { return };
    narrow.widest = 2;
    let case = cases().swap_remove(0);
    assert_eq!(case.leaves.len(), 5);
    let b = case.flat(&right(&case, 1));
    let [one, other] =
        [wide, narrow].map(|gpu| gpu.correct(&case.system(), b.clone(), LIMITS).unwrap());
    assert_eq!(one, other);
}

/// Small systems are the CPU's where that is asked for.
#[test]
fn few_unknowns_stay_on_the_cpu() {
    let Some(gpu) = any_gpu() else { return };
    let case = cases().swap_remove(0);
    let (system, b) = (case.system(), case.flat(&right(&case, 2)));
    let gpu = gpu.sparing(system.unknowns() + 1);
    let expected = Cpu::new().correct(&system, b.clone(), LIMITS).unwrap();
    assert_eq!(gpu.correct(&system, b.clone(), LIMITS).unwrap(), expected);
    let gpu = gpu.sparing(system.unknowns());
    assert_ne!(gpu.correct(&system, b, LIMITS).unwrap(), expected, "not the very same bytes");
}

/// Labels are solved at the same time, all on one GPU.
#[test]
fn threads_share_it() {
    use rayon::prelude::*;
    let Some(gpu) = any_gpu() else { return };
    let cases = cases();
    let solve = |index: usize| {
        let case = &cases[index % cases.len()];
        gpu.correct(&case.system(), case.flat(&right(case, 3)), LIMITS).unwrap()
    };
    let expected: Vec<Correction> = (0..12).map(solve).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    let found: Vec<Correction> = pool.install(|| (0..12).into_par_iter().map(solve).collect());
    assert_eq!(found, expected);
}

/// A driver that did nothing, and one that handed back what was there before.
#[test]
fn wrong_results_are_noticed() {
    let Some(gpu) = any_gpu() else { return };
    let case = cases().swap_remove(0);
    let (system, b) = (case.system(), case.flat(&right(&case, 4)));
    let probes = probes(&system, &b);
    let solved = gpu.correct(&system, b.clone(), LIMITS).unwrap();
    let mut product = gpu.cpu.apply(&system, &solved.values).unwrap();
    product.iter_mut().zip(&b).for_each(|(product, b)| *product = b - *product);
    let left = probes.iter().flat_map(|&leaf| &product[leaf * LEAF_NODES..][..LEAF_NODES]);
    let mut state = State::new(&system, LIMITS, 1.0);
    let unfinished = Outcome { values: solved.values, left: left.copied().collect(), state };
    let is_noticed = |outcome: &Outcome| match gpu.check(&system, &b, &probes, outcome) {
        Ok(()) => false,
        Err(error) => error.to_string().contains("use the CPU"),
    };
    assert!(is_noticed(&unfinished));
    state.is_done = 1;
    let right = Outcome { state, ..unfinished };
    assert!(!is_noticed(&right));
    let empty = vec![0.0; b.len()];
    assert!(is_noticed(&Outcome { values: empty, left: right.left.clone(), state }));
    let stale = right.values.iter().map(|value| 0.9 * value).collect();
    assert!(is_noticed(&Outcome { values: stale, left: right.left.clone(), state }));
    let mut unknown = right.values.clone();
    unknown[7] = f32::NAN;
    assert!(is_noticed(&Outcome { values: unknown, left: right.left.clone(), state }));
}
