//! `transect compare` as a user runs it: label by label, of meshes and volumes.

#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;

use program::*;
use serde_json::Value;

fn compared(files: [&Path; 2], more: &[&str]) -> Value {
    let output = run(transect().args(["compare", "--json"]).args(files).args(more));
    assert_done(&output);
    serde_json::from_slice(&output.stdout).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A reconstruction, its mesh and volumes of it are the same, in whichever frame.
#[test]
fn a_result_is_like_itself_in_every_kind_of_file() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let names = ["a.ply", "a.seg.nrrd", "a.nii.gz", "a.mha", "{name}.stl"];
    assert_done(&reconstruct(folder.path(), &names, &["--quiet"]));
    for (one, other) in [("a.nii.gz", "a.mha"), ("a.seg.nrrd", "a.nii.gz"), ("a.mha", "a.mha")] {
        let found = compared([&path(one), &path(other)], &[]);
        assert_eq!(found["warnings"], Value::Array(Vec::new()), "{one} {other}");
        assert_eq!((&found["exact_overlap"], &found["unit"]), (&true.into(), &"mm".into()));
        assert_eq!((number(&found["iou"]), number(&found["union"]["dice"])), (1.0, 1.0));
        let labels = found["labels"].as_array().expect("labels");
        assert_eq!(labels.len(), 7);
        for label in labels {
            assert_eq!(number(&label["agreement"]["dice"]), 1.0, "{label}");
            // NIfTI has places in single precision.
            assert!(number(&label["agreement"]["hausdorff"]) < 1e-3, "{label}");
        }
    }
    // Voxels are large there: 6.3 mm.
    let found = compared([&path("a.ply"), &path("a.seg.nrrd")], &["--tolerance", "5.5"]);
    assert_eq!((&found["exact_overlap"], &found["unit"]), (&false.into(), &"mm".into()));
    for label in found["labels"].as_array().expect("labels") {
        let own = &label["agreement"];
        assert!(number(&own["dice"]) > 0.8, "{label}");
        assert!(number(&own["surface_dice"]) > 0.99, "{label}");
        assert!(label["name"].is_string(), "{label}");
    }
    // The one label of a file of its own is known by its number.
    let found = compared([&path("liver.stl"), &path("a.ply")], &[]);
    let liver = found["labels"].as_array().expect("labels").iter().find(|own| own["label"] == 3);
    assert!(number(&liver.expect("the liver")["agreement"]["dice"]) > 0.999, "{liver:?}");
    let text = run(transect().arg("compare").args([path("a.ply"), path("a.mha")]));
    assert_done(&text);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    for words in ["3 liver", "Hausdorff", "lengths are in mm", "IoU", "on a grid"] {
        assert!(text.contains(words), "{words} is not in {text}");
    }
}

#[test]
fn what_cannot_be_compared_is_refused_in_one_line() {
    let folder = folder();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("a file");
        path
    };
    let header = "NRRD0004\ntype: uint8\ndimension: 3\nencoding: ascii\n";
    let good = write("good.nrrd", &format!("{header}sizes: 2 1 1\n\n1 0\n"));
    let refused = |name: &str, text: &str, words: &[&str]| {
        let bad = write(name, text);
        for files in [[&bad, &good], [&good, &bad]] {
            assert_refused(&run(transect().arg("compare").args(files)), words);
        }
    };
    refused("empty.nrrd", &format!("{header}sizes: 2 1 1\n\n0 0\n"), &["empty.nrrd", "all of its"]);
    refused("huge.nrrd", &format!("{header}sizes: 99999 99999 99999\n\n1\n"), &["huge.nrrd"]);
    refused("none.nrrd", "", &["none.nrrd", "empty"]);
    refused("a.off", "OFF\n3 1 0\nnan 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", &["a.off", "finite"]);
    refused("a.vti", "x", &["a.vti", "kind", ".nrrd"]);
    let flat = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    refused("flat.off", flat, &["encloses no volume"]);
    let output = run(transect().arg("compare").args([&good, &good]).args(["--tolerance", "0"]));
    assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
}
