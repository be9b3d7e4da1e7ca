//! `transect crosscheck` as a user runs it.

#[path = "common/program.rs"]
mod program;
#[path = "common/mod.rs"]
mod shared;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use program::{
    assert_done, assert_refused, entries, folder, phantom, repository, run, stderr, transect,
};
use transect::io::vdb::VdbFile;

/// Three labels on two planes, which are farther apart than what is on them is wide: quick, but
/// between them any method says what it likes, so how far two agree says nothing.
fn organs() -> PathBuf {
    repository("tests/corpus/organs.csl")
}

/// Quick, and all that most tests look at.
const QUICK: &[&str] = &["--resolution", "48", "--meshers", "dual", "--points", "5000"];

fn crosscheck(folder: &Path, sections: &Path, names: &[&str], more: &[&str]) -> Output {
    let mut command = transect();
    command.arg("crosscheck").arg(sections).args(more);
    for name in names {
        command.arg("-o").arg(folder.join(name));
    }
    run(&mut command)
}

/// The report of a quick run.
fn report(more: &[&str]) -> serde_json::Value {
    let folder = folder();
    let quick = [QUICK, &["--json", "--quiet"], more].concat();
    let output = crosscheck(folder.path(), &organs(), &[], &quick);
    assert_done(&output);
    assert_eq!(stderr(&output), "");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn labels_agree_where_they_must_and_all_is_written() {
    let folder = folder();
    let path = folder.path().join("c.json");
    let more = ["--report", path.to_str().expect("UTF-8"), "--json"];
    let names = ["c.vdb", "c.png"];
    let output = crosscheck(folder.path(), &phantom(), &names, &[QUICK, &more].concat());
    assert_done(&output);
    let table = stderr(&output);
    for words in ["labels agree", "must agree       and do", "joined regions", "dual to skeleton"] {
        assert!(table.contains(words), "{table}");
    }
    let written: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&path).expect("the report")).expect("JSON");
    let printed: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(written, printed);
    assert_eq!(written["transect"], "crosscheck");
    assert_eq!(written["points"]["violations"], 0);
    assert!(written["points"]["must_agree"].as_u64() > Some(100), "{}", written["points"]);
    let labels = written["labels"].as_array().expect("labels");
    assert_eq!(labels.len(), 7);
    for label in labels {
        assert_eq!(
            (&label["dual"]["closed"], &label["skeleton"]["closed"]),
            (&true.into(), &true.into())
        );
    }
    // Measured: 0.9924.
    assert!(written["agreement"]["share"].as_f64() > Some(0.99), "{}", written["agreement"]);
    let picture = image::open(folder.path().join("c.png")).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), (1600, 1200));
    let grids =
        VdbFile::read(&folder.path().join("c.vdb")).expect("volumes").grids().expect("grids");
    let names: Vec<&str> = grids.iter().map(|grid| grid.name.as_str()).collect();
    assert_eq!(names, ["disagreement", "label_field", "label_skeleton"]);
}

#[test]
fn volumes_hold_both_labels_and_where_they_differ() {
    let folder = folder();
    let more = ["--resolution", "24", "--meshers", "dual", "--json", "--quiet"];
    let output = crosscheck(folder.path(), &phantom(), &["c.vdb"], &more);
    assert_done(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let file = VdbFile::read(&folder.path().join("c.vdb")).expect("volumes");
    let value = |grid: &str, node| file.value(grid, node).expect("a value");
    let nodes: Vec<i32> = serde_json::from_value(report["nodes"].clone()).expect("three numbers");
    let voxel = report["voxel"].as_f64().expect("a number");
    let mut differing = 0;
    for x in 0..nodes[0] {
        for y in 0..nodes[1] {
            for z in 0..nodes[2] {
                let labels = ["label_field", "label_skeleton"].map(|grid| value(grid, [x, y, z]));
                let far = value("disagreement", [x, y, z]) / voxel;
                assert_eq!(labels[0] != labels[1], far > 0.99, "{x} {y} {z}: {labels:?} {far}");
                differing += u64::from(labels[0] != labels[1]);
            }
        }
    }
    assert_eq!(report["points"]["nodes"].as_u64(), Some(differing));
    assert!(differing > 0);
}

#[test]
fn the_variational_field_is_held_against_the_skeleton_where_asked_for() {
    let folder = folder();
    let more = ["--method", "variational", "--json"];
    let output = crosscheck(folder.path(), &phantom(), &["c.png"], &[QUICK, &more].concat());
    assert_done(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["method"], "variational");
    assert!(report["points"].is_null(), "{}", report["points"]);
    // Measured: 0.9869, and 0.9902 at the sections, where both say what these say.
    assert!(report["agreement"]["share"].as_f64() > Some(0.985), "{}", report["agreement"]);
    let nearest = &report["agreement"]["bins"][0];
    assert!(nearest["share"].as_f64() > Some(0.99), "{nearest}");
    assert!(report["pairing"]["cells"].as_u64() > Some(0), "{}", report["pairing"]);
    assert!(stderr(&output).contains("known of --method mvc alone"), "{}", stderr(&output));
}

#[test]
fn the_same_bytes_come_out_for_any_number_of_threads() {
    let names = ["c.vdb", "c.png"];
    let (one, four) = (folder(), folder());
    for (folder, threads) in [(&one, "1"), (&four, "4")] {
        let more = ["--device", "cpu", "--threads", threads];
        assert_done(&crosscheck(folder.path(), &organs(), &names, &[QUICK, &more].concat()));
    }
    for name in names {
        let bytes =
            |folder: &tempfile::TempDir| fs::read(folder.path().join(name)).expect("a file");
        assert!(bytes(&one) == bytes(&four), "{name} differs");
    }
}

#[test]
fn our_own_surface_is_no_farther_than_nothing() {
    let folder = folder();
    let path = folder.path().join("own.ply");
    let mut reconstruct = transect();
    reconstruct
        .arg("reconstruct")
        .arg(organs())
        .args(&QUICK[..2])
        .args(["--method", "mvc", "--smooth", "0", "-q", "-o"]);
    assert_done(&run(reconstruct.arg(&path)));
    let report = report(&["--against", path.to_str().expect("UTF-8")]);
    let against = &report["against"];
    assert!(against["gap"]["hausdorff"].as_f64() < Some(1e-6), "{against}");
    assert_eq!(against["comparison"]["iou"], 1.0);
    assert_eq!((&against["solid"]["closed"], &against["refused"]), (&true.into(), &().into()));
}

#[test]
fn a_mesh_with_a_hole_is_compared_and_called_open() {
    let folder = folder();
    let path = folder.path().join("open.off");
    // Three faces of a tetrahedron.
    let text = "OFF\n4 3 0\n0 0 0\n9 0 0\n0 9 0\n0 0 9\n3 0 2 1\n3 0 1 3\n3 0 3 2\n";
    fs::write(&path, text).expect("a file");
    let report = report(&["--against", path.to_str().expect("UTF-8")]);
    let against = &report["against"];
    assert_eq!(
        (&against["solid"]["closed"], &against["solid"]["genus"]),
        (&false.into(), &().into())
    );
    assert!(against["gap"]["hausdorff"].as_f64() > Some(1.0));
}

#[test]
fn both_meshers_show_one_surface() {
    let folder = folder();
    let more = ["--resolution", "32", "--json", "--quiet", "--points", "100"];
    let output = crosscheck(folder.path(), &organs(), &[], &more);
    assert_done(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let gap = &report["distances"]["dual_delaunay"];
    assert!(gap["mean"].as_f64() < Some(0.2) && gap["hausdorff"].as_f64() < Some(2.0), "{gap}");
    assert!(report["labels"][0]["delaunay"]["closed"] == true, "{}", report["labels"][0]);
}

#[test]
fn surfaces_are_refused_as_outputs() {
    let folder = folder();
    let output = crosscheck(folder.path(), &organs(), &["c.ply"], &[]);
    assert_refused(&output, &["c.ply", "reconstruct"]);
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn open_boxes_and_unknown_parts_are_checked_too() {
    let folder = folder();
    let masked = folder.path().join("masked.json");
    let mut mask = transect();
    mask.arg("mask").arg(phantom()).args(["--blobs", "0.1", "-q", "-o"]).arg(&masked);
    assert_done(&run(&mut mask));
    let more = ["--resolution", "32", "--meshers", "dual", "--json", "-q", "--box", "unknown"];
    let output = crosscheck(folder.path(), &masked, &["c.vdb"], &more);
    assert_done(&output);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["points"]["violations"], 0);
    assert!(report["points"]["must_agree"].as_u64() > Some(500), "{}", report["points"]);
    assert_eq!(report["skeleton"]["exact"], false);
    // Measured: 0.9924.
    assert!(report["agreement"]["share"].as_f64() > Some(0.99), "{}", report["agreement"]);
}

#[test]
fn drawn_sections_agree_where_they_must() {
    // Measured: 0.9944, 0.9916, 0.9949 and, on six sections far apart, 0.9516.
    for (name, least) in [
        ("vessel.csl", 0.99),
        ("organ.contour", 0.99),
        ("csl/Heart-25-even-better.csl", 0.99),
        ("contour/mousebrain.contour", 0.94),
    ] {
        let Some(path) = shared::data(name) else { continue };
        let folder = folder();
        let more = ["--resolution", "64", "--meshers", "dual", "--json", "--quiet"];
        let output = crosscheck(folder.path(), &path, &[], &more);
        assert_done(&output);
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert!(report["points"]["must_agree"].as_u64() > Some(0), "{name}: {}", report["points"]);
        let share = &report["agreement"]["share"];
        assert!(share.as_f64() > Some(least), "{name}: {share}");
    }
}
