//! Real sections through sampling, smoothing and meshing into VDB files.

mod common;

use std::time::Instant;

use common::data;
use transect::complex::Complex;
use transect::field::{self, Boundaries, Device};
use transect::grid::frame::Frame;
use transect::grid::lattice::Resolution;
use transect::grid::memory::estimate_memory;
use transect::grid::sampling::{Margin, Starts, sample};
use transect::io::read_sections;
use transect::io::vdb::{GridName, Storage, VdbContents, VdbFile, write};
use transect::label::Label;
use transect::mesh::dual;
use transect::progress::Silent;
use transect::section::Rules;
use transect::variational::smoothing::smoothed;

/// Seconds since the last call, on standard error.
struct Clock(Instant);

impl Clock {
    fn lap(&mut self, what: &str) {
        eprintln!("    {:6.2} s  {what}", self.0.elapsed().as_secs_f64());
        self.0 = Instant::now();
    }
}

/// Every grid of a reconstruction passes OpenVDB's checks, and smoothing
/// leaves the samples sound.
fn reconstructs(name: &str, voxels: u32) {
    let Some(path) = data(name) else { return };
    eprintln!("{name} at {voxels}");
    let mut clock = Clock(Instant::now());
    let sections = read_sections(&path, &Rules::default()).unwrap();
    let around = sections.bounds().unwrap();
    let bounds = around.grown(0.05 * around.diagonal());
    let complex = Complex::new(&sections.sections, bounds, Label::OUTSIDE).unwrap();
    clock.lap("reading, arrangement");
    let frame = Frame::new(bounds, Resolution::Voxels(voxels)).unwrap();
    let lattice = frame.lattice;
    let estimate = estimate_memory(&lattice, &sections.sections, sections.materials.len());
    let boundaries = Boundaries::new(&complex, 0.02 * lattice.voxel, None).unwrap();
    let field = field::new(&boundaries, Device::Cpu).unwrap();
    clock.lap("field");
    let sections = &sections;
    let list = &sections.sections;
    let starts = Starts::new(list, boundaries.completion(), &lattice);
    let sampling = sample(&complex, field.as_ref(), &starts, &lattice, Margin(1), &Silent).unwrap();
    let (leaves, points) = (sampling.kept.samples.valued.len(), sampling.points);
    clock.lap(&format!(
        "sampling: {leaves} leaves, {points} points, estimate {} MB",
        estimate >> 20
    ));
    sampling.kept.samples.sanity_check().unwrap();
    clock.lap("checking");
    let samples = &sampling.kept.samples;
    let solved = smoothed(samples, list, &frame, 1.0, (false, &mut None), &Silent).unwrap();
    let samples = solved.samples;
    clock.lap("smoothing");
    samples.sanity_check().unwrap();
    clock.lap("checking");
    let mesh = dual(&samples, &Silent).unwrap();
    clock.lap(&format!("mesh: {} triangles", mesh.triangles.len()));

    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.vdb");
    let grids = GridName::default_ones();
    let contents = VdbContents {
        lattice: &lattice,
        mesh: &mesh,
        samples: &samples,
        sections: list,
        materials: &sections.materials,
        units: &sections.units,
        frame: &sections.frame,
        grids: &grids,
    };
    write(&out, &contents, Storage::OpenVdb { half: false }).unwrap();
    let size = std::fs::metadata(&out).unwrap().len();
    clock.lap(&format!("VDB: {} MB", size >> 20));
    check(&VdbFile::read(&out).unwrap());
    clock.lap("checks");
    assert!(samples.leaves().flat_map(|leaf| leaf.labels()).any(Label::is_material));
}

fn check(file: &VdbFile) {
    let mut wrong = Vec::new();
    for grid in file.grids().unwrap() {
        let found = match grid.class.as_str() {
            "level set" => file.check_level_set(&grid.name).unwrap(),
            "fog volume" => file.check_fog_volume(&grid.name).unwrap(),
            _ => String::new(),
        };
        assert!(grid.active > 0, "{} is empty", grid.name);
        if !found.is_empty() {
            wrong.push(format!("{}: {found}", grid.name));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn own_anatomy() {
    reconstructs("vessel.csl", 128);
    reconstructs("organ.contour", 96);
    reconstructs("knot.contour", 90);
}

#[test]
fn vertebrae() {
    reconstructs("csl/Vetebrae.csl", 256);
}

#[test]
fn elephant() {
    reconstructs("csl/Elephant.csl", 100);
}

#[test]
fn abdomen() {
    reconstructs("csl/Abdomen.csl", 128);
}

#[test]
fn mouse_brain() {
    reconstructs("contour/mousebrain.contour", 90);
}
