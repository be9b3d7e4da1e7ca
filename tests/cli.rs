//! The command line: what it writes, what it refuses, and how it ends.

mod common;
#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use program::*;
use tempfile::TempDir;

#[test]
fn every_kind_of_output_is_written_and_stdout_stays_empty() {
    let folder = folder();
    let names = [
        "a.3mf", "a.glb", "a.obj", "a.off", "a.ply", "a.png", "a.stl", "a.vdb", "a.vtm", "a.vtp",
        "a.vtu",
    ];
    let report = folder.path().join("report.json");
    let more = ["--report", report.to_str().expect("a path in UTF-8")];
    let output = reconstruct(folder.path(), &names, &more);
    assert_done(&output);
    assert!(output.stdout.is_empty());
    // With the folder that belongs to a.vtm, and a.mtl to a.obj.
    let mut expected: Vec<&str> = [&["a", "a.mtl", "report.json"], &names[..]].concat();
    expected.sort_unstable();
    assert_eq!(entries(folder.path()), expected);
    let blocks: Vec<String> = (1..=7).map(|label| format!("a_{label}.vtp")).collect();
    assert_eq!(entries(&folder.path().join("a")), blocks);
    // Two of these kinds tell no labels apart.
    let text = stderr(&output);
    let warnings: Vec<&str> = text.lines().filter(|line| line.starts_with("warning: ")).collect();
    assert_eq!(warnings.len(), 2, "{text}");
    assert!(warnings[0].contains("a_{label}.off") && warnings[1].contains("a_{label}.stl"));
    let output = reconstruct(folder.path(), &["b.stl"], &["--strict"]);
    assert_refused(&output, &["b.stl", "7 labels", "b_{label}.stl", "--strict"]);
    for name in names {
        let size = fs::metadata(folder.path().join(name)).expect("it exists").len();
        let least = if name == "a.vtm" { 500 } else { 1000 };
        assert!(size > least, "{name} has {size} bytes");
    }
}

#[test]
fn the_report_says_what_the_result_is_worth() {
    let folder = folder();
    let path = folder.path().join("report.json");
    let more = ["--quiet", "--report", path.to_str().expect("a path in UTF-8")];
    let output = reconstruct(folder.path(), &["a.ply"], &more);
    assert_done(&output);
    assert_eq!(stderr(&output), "");
    let text = fs::read_to_string(path).expect("the report");
    let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let labels = report["check"]["labels"].as_array().expect("labels");
    assert_eq!(labels.len(), 7, "the phantom has seven organs");
    let volumes = labels.iter().map(|label| {
        assert_eq!((&label["closed"], &label["outward"]), (&true.into(), &true.into()));
        label["volume"].as_f64().expect("a volume")
    });
    let sum = volumes.sum::<f64>() + report["check"]["outside_volume"].as_f64().expect("a volume");
    let whole = report["check"]["box_volume"].as_f64().expect("a volume");
    assert!((sum / whole - 1.0).abs() < 1e-9, "{sum} {whole}");
    for stage in ["read", "field", "mesh", "check", "surfaces"] {
        let stages = report["stages"].as_array().expect("stages");
        assert!(stages.iter().any(|found| found["name"] == stage), "{stage}");
    }
}

#[test]
fn the_same_bytes_come_out_for_any_number_of_threads() {
    let names = ["a.ply", "a.vdb", "a.png", "a.glb", "a.3mf"];
    let (one, four) = (folder(), folder());
    assert_done(&reconstruct(one.path(), &names, &["--device", "cpu", "--threads", "1"]));
    assert_done(&reconstruct(four.path(), &names, &["--device", "cpu", "--threads", "4"]));
    for name in names {
        let bytes = |folder: &TempDir| fs::read(folder.path().join(name)).expect("it exists");
        assert!(bytes(&one) == bytes(&four), "{name} differs");
    }
}

#[test]
fn bad_sections_are_refused_by_name_and_nothing_is_written() {
    let cases: &[(&str, &[&str])] = &[
        ("missing.csl", &["missing.csl", "no such file"]),
        ("empty.csl", &["empty.csl", "empty"]),
        ("truncated.csl", &["truncated.csl", "section 1", "line 9", "truncated"]),
        ("nan.csl", &["nan.csl", "section 1", "vertex 1 is NaN"]),
        ("zero_normal.csl", &["zero_normal.csl", "section 1", "normal"]),
        ("index.csl", &["index.csl", "section 1", "line 11", "out of range"]),
        ("overlap.csl", &["overlap.csl", "section 12", "overlap", "near ["]),
        ("off_plane.csl", &["off_plane.csl", "section 1", "vertex 2 of loop 0", "off its plane"]),
        ("coincident.csl", &["coincident.csl", "section 3", "plane of section 1"]),
        ("unknown.json", &["unknown.json", "everything is unknown"]),
    ];
    for (name, words) in cases {
        let folder = folder();
        let mut command = transect();
        command.arg("reconstruct").arg(repository("tests/corpus").join(name));
        let output = run(command.arg("-o").arg(folder.path().join("a.ply")));
        assert_refused(&output, words);
        assert!(entries(folder.path()).is_empty(), "{name}");
    }
}

#[test]
fn a_loop_that_crosses_itself_is_a_warning_and_with_strict_an_error() {
    let folder = folder();
    let bowtie = |more: &[&str]| {
        let mut command = transect();
        command.arg("reconstruct").arg(repository("tests/corpus/bowtie.csl")).args(COARSE);
        run(command.args(more).arg("-o").arg(folder.path().join("a.ply")))
    };
    assert_refused(
        &bowtie(&["--strict"]),
        &["bowtie.csl", "section", "crosses itself", "--strict"],
    );
    assert!(entries(folder.path()).is_empty());
    let output = bowtie(&[]);
    assert_done(&output);
    assert!(stderr(&output).contains("warning: section"), "{}", stderr(&output));
}

#[test]
fn outputs_that_cannot_be_written_are_refused_before_the_work() {
    let folder = folder();
    let missing = folder.path().join("missing");
    assert_refused(&reconstruct(&missing, &["a.ply"], &[]), &["a.ply", "does not exist"]);
    assert_refused(&reconstruct(folder.path(), &["a.xyz"], &[]), &["a.xyz", ".vdb, .nvdb"]);
    fs::create_dir(folder.path().join("b.ply")).expect("a folder");
    assert_refused(&reconstruct(folder.path(), &["b.ply"], &[]), &["b.ply", "is a folder"]);
    assert_refused(&reconstruct(folder.path(), &["a.ply", "a.ply"], &[]), &["a.ply", "twice"]);
    fs::write(folder.path().join("file"), "").expect("a file");
    let inside = folder.path().join("file");
    assert_refused(&reconstruct(&inside, &["a.ply"], &[]), &["a.ply", "not a folder"]);
    assert_eq!(entries(folder.path()), ["b.ply", "file"]);
}

#[test]
#[cfg(unix)]
fn a_folder_without_write_permission_is_refused() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).expect("permissions");
    // Root may write there, but not where the kernel alone makes files.
    let is_root = fs::write(folder.path().join("probe"), "").is_ok();
    let closed = if is_root { Path::new("/sys") } else { folder.path() };
    let output = reconstruct(closed, &["a.ply"], &[]);
    assert_refused(&output, &["a.ply", "cannot be written to"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_an_error_and_no_other_output_appears() {
    for full in ["full.ply", "full.vdb", "full.png"] {
        let folder = folder();
        std::os::unix::fs::symlink("/dev/full", folder.path().join(full)).expect("a link");
        let output = reconstruct(folder.path(), &["a.obj", "a.vtm", full], &["--quiet"]);
        assert_refused(&output, &[full, "disk is full"]);
        assert_eq!(entries(folder.path()), [full]);
    }
    let folder = folder();
    let output = reconstruct(folder.path(), &["a.obj"], &["--report", "/dev/full"]);
    assert_refused(&output, &["/dev/full", "disk is full"]);
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn a_grid_that_does_not_fit_is_refused_with_its_size() {
    let folder = folder();
    let mut command = transect();
    command.arg("reconstruct").arg(phantom()).args(["--resolution", "200000"]);
    let output = run(command.arg("-o").arg(folder.path().join("a.ply")));
    assert_refused(&output, &["would take about", "GiB", "--resolution"]);
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn wrong_usage_ends_with_two() {
    let usages: &[&[&str]] = &[
        &[],
        &["reconstruct"],
        &["reconstruct", "a.csl"],
        &["reconstruct", "a.csl", "-o", "a.ply", "--resolution", "0"],
        &["reconstruct", "a.csl", "-o", "a.ply", "--voxel-size", "-1"],
        &["reconstruct", "a.csl", "-o", "a.ply", "--method", "guess"],
        &["slice", "a.ply", "-o", "a.csl"],
        &["slice", "a.ply", "-o", "a.csl", "--plane", "0,0,0,1"],
        &["slice", "a.ply", "-o", "a.csl", "--axis", "x"],
        &["slice", "a.ply", "-o", "a.csl", "--axis", "x", "--random", "3"],
        &["slice", "a.ply", "-o", "a.csl", "--count", "3", "--sweep", "3", "--axis", "x"],
        &["slice", "a.ply", "-o", "a.json", "--sweep", "3", "--tilt", "61"],
        &["slice", "a.ply", "-o", "a.json", "--random", "3", "--extent", "1,1"],
        &["mask", "a.csl", "-o", "a.json"],
        &["mask", "a.csl", "-o", "a.json", "--blobs", "1"],
        &["mask", "a.csl", "-o", "a.json", "--blobs", "0.2", "--blob-size", "0"],
        &["mask", "a.csl", "-o", "a.json", "--extent", "3"],
        &["mask", "a.csl", "-o", "a.json", "--extent", "3,-1"],
        &["inspect", "a.csl", "--unknown-label", "4294967295"],
        &["compare", "a.ply"],
    ];
    for usage in usages {
        let output = run(transect().args(*usage));
        assert_eq!(output.status.code(), Some(2), "{usage:?}");
    }
}

#[test]
fn unknown_grids_are_refused() {
    let folder = folder();
    let output = reconstruct(folder.path(), &["a.vdb"], &["--grids", "surface,magic"]);
    assert_refused(&output, &["magic", "surface_, density_"]);
    let output = reconstruct(folder.path(), &["a.vdb"], &["--grids", "surface_99"]);
    assert_refused(&output, &["99"]);
    assert!(entries(folder.path()).is_empty());
}

#[test]
fn slices_of_a_result_reconstruct_to_nearly_the_same() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    assert_done(&reconstruct(folder.path(), &["a.ply"], &["--quiet"]));
    let mut slice = transect();
    slice.arg("slice").arg(path("a.ply")).args(["--axis", "z", "--count", "24"]);
    assert_done(&run(slice.arg("-o").arg(path("cuts.csl"))));
    let mut again = transect();
    again.arg("reconstruct").arg(path("cuts.csl")).args(COARSE).arg("--quiet");
    assert_done(&run(again.arg("-o").arg(path("b.ply"))));
    let mut compare = transect();
    let output = run(compare.args(["compare", "--json"]).arg(path("b.ply")).arg(path("a.ply")));
    assert_done(&output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let iou = found["iou"].as_f64().expect("a number");
    assert!((0.9..=1.0).contains(&iou), "{iou}");
}

#[test]
fn methods_are_compared_side_by_side() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    assert_done(&reconstruct(folder.path(), &["a.ply"], &["--quiet"]));
    let mut slice = transect();
    slice.arg("slice").arg(path("a.ply")).args(["--axis", "z", "--count", "12"]);
    assert_done(&run(slice.arg("-o").arg(path("cuts.csl"))));
    let compare = |sections: &str, more: &[&str]| {
        let mut compare = transect();
        compare.arg("compare-methods").arg(path(sections)).args(COARSE).args(more);
        run(compare.arg("-o").arg(path("all.png")).arg("--reference").arg(path("a.ply")))
    };
    let output = compare("cuts.csl", &["--json"]);
    assert_done(&output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let entries = found.as_array().expect("a list");
    let names: Vec<_> = entries.iter().map(|entry| entry["method"].as_str().unwrap()).collect();
    assert_eq!(names, ["variational", "mvc", "hermite", "skeleton", "stack"]);
    for entry in entries {
        let iou = entry["figures"]["reference"]["iou"].as_f64().expect("a number");
        assert!((0.8..=1.0).contains(&iou), "{entry}");
        assert!(entry["figures"]["normals"]["away"].is_number(), "{entry}");
    }
    // Five results and the reference, in three columns.
    let picture = std::fs::read(path("all.png")).expect("a picture");
    let size = |at: usize| u32::from_be_bytes(picture[at..at + 4].try_into().expect("four bytes"));
    assert_eq!([size(16), size(20)], [2400, 1200]);
    // One that does not apply says why, and none at all is an error.
    let mut slice = transect();
    slice.arg("slice").arg(path("a.ply")).args(["--random", "6"]);
    assert_done(&run(slice.arg("-o").arg(path("random.csl"))));
    let output = compare("random.csl", &["--methods", "mvc,stack"]);
    assert_done(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("stack does not apply") && text.contains("not parallel"), "{text}");
    assert_refused(&compare("random.csl", &["--methods", "stack"]), &["no method applies"]);
    let mut wrong = transect();
    wrong.arg("compare-methods").arg(path("cuts.csl")).arg("-o").arg(path("all.vdb"));
    assert_refused(&run(&mut wrong), &["all.vdb", ".png"]);
}

#[test]
fn a_sweep_is_partial_frames_that_reconstruct_to_the_solid() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    assert_done(&reconstruct(folder.path(), &["a.ply"], &["--quiet"]));
    let sweep = |name: &str, more: &[&str]| {
        let mut slice = transect();
        slice.arg("slice").arg(path("a.ply")).args(["--sweep", "40"]).args(more);
        run(slice.arg("-o").arg(path(name)))
    };
    assert_refused(&sweep("a.csl", &[]), &["a.csl", ".json", "unknown"]);
    assert_done(&sweep("whole.json", &["--extent", "400,400"]));
    assert_done(&sweep("part.json", &["--axis", "x", "--seed", "3"]));
    for name in ["whole.json", "part.json"] {
        let output = run(transect().args(["inspect", "--json"]).arg(path(name)));
        assert_done(&output);
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(found["sections"], 40);
        let beyond = found["unknown"].as_array().expect("a list").iter();
        assert_eq!(beyond.filter(|section| section["beyond"] == true).count(), 40);
        assert_eq!(found["disagreements"].as_array().map(Vec::len), Some(0), "{name}");
    }
    // Frames that reach beyond the solid say as much as whole planes.
    let mut again = transect();
    again.arg("reconstruct").arg(path("whole.json")).args(COARSE).arg("--quiet");
    assert_done(&run(again.arg("-o").arg(path("b.ply"))));
    let mut compare = transect();
    let output = run(compare.args(["compare", "--json"]).arg(path("b.ply")).arg(path("a.ply")));
    assert_done(&output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let iou = found["iou"].as_f64().expect("a number");
    assert!((0.9..=1.0).contains(&iou), "{iou}");
}

#[test]
fn a_mask_makes_its_part_of_every_section_unknown() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let mask = |name: &str, more: &[&str]| {
        let mut command = transect();
        command.arg("mask").arg(phantom()).args(more);
        run(command.arg("-o").arg(path(name)))
    };
    assert_refused(&mask("a.csl", &["--blobs", "0.2"]), &["a.csl", ".json", "unknown"]);
    assert_done(&mask("a.json", &["--blobs", "0.2", "--seed", "7"]));
    assert_done(&mask("b.json", &["--blobs", "0.2", "--seed", "7"]));
    assert_done(&mask("c.json", &["--blobs", "0.2", "--seed", "8"]));
    assert_done(&mask("frames.json", &["--extent", "150,100"]));
    let read = |name: &str| fs::read(path(name)).expect("it exists");
    assert!(read("a.json") == read("b.json"));
    assert!(read("a.json") != read("c.json"));
    let inspected = |name: &str| -> serde_json::Value {
        let output = run(transect().args(["inspect", "--json"]).arg(path(name)));
        assert_done(&output);
        serde_json::from_slice(&output.stdout).expect("JSON")
    };
    let found = inspected("a.json");
    let unknown = found["unknown"].as_array().expect("a list");
    assert_eq!(unknown.len(), 37);
    for section in unknown {
        let share = section["share"].as_f64().expect("a number");
        assert!((share - 0.2).abs() < 1e-3, "{section}");
    }
    assert_eq!((&found["units"], &found["frame"]), (&"mm".into(), &"LPS".into()));
    assert_eq!(found["labels"][0]["name"], "vessels");
    let frames = inspected("frames.json");
    let beyond = frames["unknown"].as_array().expect("a list").iter();
    assert_eq!(beyond.filter(|section| section["beyond"] == true).count(), 37);
}

#[test]
fn a_mesh_is_no_distance_from_itself() {
    let folder = folder();
    assert_done(&reconstruct(folder.path(), &["a.off"], &["--quiet"]));
    let mesh = folder.path().join("a.off");
    let output = run(transect().args(["compare", "--json"]).args([&mesh, &mesh]));
    assert_done(&output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["iou"], 1.0);
    assert_eq!(found["volume_ratio"], 1.0);
    assert!(found["hausdorff"].as_f64().expect("a number") < 1e-12);
}

#[test]
fn inspection_goes_to_stdout_and_shows_no_bar_in_a_pipe() {
    let output = run(transect().arg("inspect").arg(phantom()));
    assert_done(&output);
    assert_eq!(stderr(&output), "");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("37"), "37 sections: {text}");
    let output = run(transect().args(["inspect", "--json"]).arg(phantom()));
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["sections"], 37);
}

#[test]
#[cfg(unix)]
fn an_interrupt_ends_promptly_and_leaves_nothing() {
    let folder = folder();
    let mut command = transect();
    command.arg("reconstruct").arg(phantom()).args(["--resolution", "700"]);
    command.arg("-o").arg(folder.path().join("a.vdb")).stderr(Stdio::null());
    let mut child = command.spawn().expect("the program runs");
    // Wait until it has begun: its temporary file is there.
    while entries(folder.path()).is_empty() {
        assert!(child.try_wait().expect("a child").is_none(), "it ended before the interrupt");
        std::thread::sleep(Duration::from_millis(5));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(killed.expect("kill runs").success());
    let start = Instant::now();
    let status = child.wait().expect("it ends");
    assert_eq!(status.code(), Some(130));
    assert!(start.elapsed() < Duration::from_secs(5), "an interrupt waits for nothing");
    assert!(entries(folder.path()).is_empty(), "{:?}", entries(folder.path()));
}

#[test]
fn contour_files_reconstruct() {
    let real =
        ["ringc", "mug", "liver", "mousebrain"].map(|name| format!("contour/{name}.contour"));
    for name in ["organ.contour", "knot.contour"].map(str::to_owned).into_iter().chain(real) {
        let Some(path) = common::data(&name) else { continue };
        let folder = folder();
        let mut command = transect();
        command.arg("reconstruct").arg(path).args(COARSE);
        assert_done(&run(command.arg("-o").arg(folder.path().join("a.ply"))));
    }
}

#[test]
fn a_surface_for_each_label_appears_with_the_others() {
    let folder = folder();
    let outputs =
        ["a.vtp", "a_{label}.off", "b_{name}.vtu", "c_{label}.obj", "c_{name}.vtm", "d_{name}.glb"];
    let output = reconstruct(folder.path(), &outputs, &[]);
    assert_done(&output);
    assert!(!stderr(&output).contains("warning"), "{}", stderr(&output));
    let names = entries(folder.path());
    assert_eq!(names.len(), 1 + 7 + 7 + 2 * 7 + 2 * 7 + 7, "{names:?}");
    assert_eq!(entries(&folder.path().join("c_liver")), ["c_liver_3.vtp"]);
    for name in ["c_3.mtl", "c_liver.vtm", "d_liver.glb"] {
        assert!(names.contains(&name.to_owned()), "{names:?}");
    }
    for label in 1..=7 {
        // Every one is closed and faces outward: it is no distance from
        // itself, without a warning.
        let mesh = folder.path().join(format!("a_{label}.off"));
        let output = run(transect().args(["compare", "--json"]).args([&mesh, &mesh]));
        assert_done(&output);
        assert_eq!(stderr(&output), "");
        let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(found["iou"], 1.0);
    }
    assert!(names.contains(&"b_liver.vtu".to_owned()), "{names:?}");
}

#[test]
fn names_for_labels_that_cannot_be_are_refused() {
    let folder = folder();
    assert_refused(&reconstruct(folder.path(), &["{label}.vdb"], &[]), &["only surfaces"]);
    let taken = reconstruct(folder.path(), &["a_3.ply", "a_{label}.ply"], &[]);
    assert_refused(&taken, &["a_3.ply", "named twice"]);
    assert_refused(&reconstruct(folder.path(), &["no/{label}.ply"], &[]), &["does not exist"]);
    assert!(entries(folder.path()).is_empty());
}
