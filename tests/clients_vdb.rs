//! Volumes as other programs see them: `vdb_client.py` of `tests/clients` has tinyvdb, which shares
//! no code with OpenVDB, and Pixar's USD.

#[path = "common/program.rs"]
mod program;
#[path = "common/python.rs"]
mod python;
#[path = "common/skipped.rs"]
mod skipped;

use std::collections::BTreeMap;
use std::process::Command;

use program::*;
use python::{python, result, script};
use serde::Deserialize;
use transect::DVec3;
use transect::io::vdb::VdbFile;

/// A grid as tinyvdb has it: nodes with values.
#[derive(Debug, Deserialize)]
struct Grid {
    r#type: String,
    voxel: [f64; 3],
    origin: [f64; 3],
    half: bool,
    values: Vec<(i32, i32, i32, f64)>,
}

#[derive(Debug, Deserialize)]
struct NanoGrid {
    active: u64,
    voxel: f64,
    values: Vec<(i32, i32, i32, f64)>,
}

#[derive(Debug, Deserialize)]
struct Field {
    class: String,
    r#type: String,
    file: String,
    label: Option<String>,
}

#[derive(Debug, Deserialize)]
struct Scene {
    up: String,
    point: [f64; 3],
    fields: BTreeMap<String, Field>,
}

#[derive(Debug, Deserialize)]
struct Found {
    volumes: BTreeMap<String, BTreeMap<String, Grid>>,
    others: BTreeMap<String, BTreeMap<String, NanoGrid>>,
    scenes: BTreeMap<String, Scene>,
}

#[test]
fn a_second_reader_finds_the_same_values_in_the_same_places() {
    let Some(python) = python("tinyvdb, pxr") else { return };
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mut names = vec!["whole.vdb", "half.vdb", "scene.usda", "scene.vdb"];
    let more = ["--grids", "all", "--quiet"];
    assert_done(&reconstruct(folder.path(), &["whole.vdb", "scene.usda"], &more));
    let more = ["--grids", "all", "--quiet", "--half"];
    assert_done(&reconstruct(folder.path(), &["half.vdb"], &more));
    if transect::io::vdb::has_nano() {
        assert_done(&reconstruct(folder.path(), &["whole.nvdb"], &more[..3]));
        let one = ["--grids", "density_3", "--quiet"];
        assert_done(&reconstruct(folder.path(), &["one.nvdb"], &one));
        names.extend(["whole.nvdb", "one.nvdb"]);
    } else {
        skipped::skipped("NanoVDB was not there when this was built");
    }
    let mut command = Command::new(python);
    command.arg(script("vdb_client.py")).args(&names).current_dir(folder.path());
    let found: Found = result(&mut command);
    for (name, is_half) in [("whole.vdb", false), ("half.vdb", true)] {
        let file = VdbFile::read(&path(name)).expect("OpenVDB's own reader");
        let grids = file.grids().expect("grids");
        assert_eq!(grids.len(), 6 + 4 * 7);
        for grid in grids {
            let other = &found.volumes[name][&grid.name];
            assert!(other.r#type.contains(&grid.value_type), "{other:?}");
            assert!(DVec3::from(other.voxel).distance(grid.voxel) < 1e-12, "{other:?}");
            assert!(DVec3::from(other.origin).distance(grid.origin) < 1e-9, "{other:?}");
            assert_eq!(other.half, is_half);
            let is_told = grid.value_type == "float" && grid.active > 512;
            assert!(!is_told || other.values.len() >= 50, "{}: {}", grid.name, other.values.len());
            for &(x, y, z, value) in &other.values {
                let own = file.value(&grid.name, [x, y, z]).expect("a number");
                assert_eq!(value, own, "{name}: {} at {x} {y} {z}", grid.name);
            }
        }
    }
    let file = VdbFile::read(&path("whole.vdb")).expect("OpenVDB's own reader");
    for (name, grids) in &found.others {
        assert_eq!(grids.len(), if name == "one.nvdb" { 1 } else { 6 + 4 * 7 });
        assert!(grids.values().any(|grid| grid.values.len() >= 50), "{name}");
        for grid in file.grids().expect("grids") {
            let Some(other) = grids.get(&grid.name) else { continue };
            assert_eq!(other.active, grid.active, "{name}: {}", grid.name);
            assert!((other.voxel - grid.voxel.x).abs() < 1e-9, "{other:?}");
            for &(x, y, z, value) in &other.values {
                let own = file.value(&grid.name, [x, y, z]).expect("a number");
                assert_eq!(value, own, "{name}: {} at {x} {y} {z}", grid.name);
            }
        }
    }
    // In LPS millimetres, up is z and the front is −y.
    let scene = &found.scenes["scene.usda"];
    assert_eq!(scene.up, "Y");
    assert!(DVec3::from(scene.point).distance(DVec3::new(0.01, 0.03, -0.02)) < 1e-12, "{scene:?}");
    assert_eq!(scene.fields.len(), 6 + 4 * 7);
    for (name, field) in &scene.fields {
        assert!(field.file.ends_with("scene.vdb"), "{field:?}");
        let (kind, class) = match name.split('_').next() {
            Some("surface") => ("float", "levelSet"),
            Some("density") => ("float", "fogVolume"),
            Some("label") => ("int", "unknown"),
            _ => ("float", "unknown"),
        };
        assert_eq!((field.r#type.as_str(), field.class.as_str()), (kind, class), "{name}");
    }
    assert_eq!(scene.fields["density_3"].label.as_deref(), Some("liver"));
}
