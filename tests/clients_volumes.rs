//! Volumes of labels and structure sets as other programs write and see them: `volumes.py` of
//! `tests/clients` has SimpleITK, nibabel, pynrrd, VTK and pydicom.

#[path = "common/program.rs"]
mod program;
#[path = "common/python.rs"]
mod python;
#[path = "common/skipped.rs"]
mod skipped;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use program::*;
use python::{python, result, script};
use serde::Deserialize;
use transect::io::read_mesh;
use transect::{DVec3, Label};

/// A tenth of the shortest side of a voxel, in millimetres.
const TENTH: f64 = 0.08;
/// How far a body between slices that are drawn may be from what it was.
const GUESSED: f64 = 1.0;

/// A body as a program has it, in millimetres and LPS.
#[derive(Debug, Deserialize)]
struct Body {
    volume: f64,
    centroid: [f64; 3],
}

type Bodies = BTreeMap<u32, Body>;

/// The bodies of a mesh whose frame is RAS or LPS.
fn bodies(path: &Path, is_ras: bool) -> Bodies {
    let mesh = read_mesh(path).expect("a mesh");
    let body = |label: u32| {
        let surface = mesh.surface(Label(label));
        let base = surface.vertices[0];
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for triangle in 0..surface.triangles.len() {
            let [a, b, c] = surface.corners(triangle).map(|corner| corner - base);
            let part = a.dot(b.cross(c)) / 6.0;
            volume += part;
            moment += part * (a + b + c) / 4.0;
        }
        let sign = if is_ras { DVec3::new(-1.0, -1.0, 1.0) } else { DVec3::ONE };
        (label, Body { volume, centroid: (sign * (base + moment / volume)).to_array() })
    };
    [1, 2, 3].map(body).into()
}

fn assert_near(found: &Bodies, wanted: &Bodies, off: f64, share: f64, place: &str) {
    assert!(found.keys().eq(wanted.keys()), "{place}: {found:?}");
    for (label, body) in wanted {
        let own = &found[label];
        let place = format!("{place}, label {label}: {own:?} and not {body:?}");
        assert!(DVec3::from(own.centroid).distance(body.centroid.into()) < off, "{place}");
        assert!((own.volume / body.volume - 1.0).abs() < share, "{place}");
    }
}

/// Straight, oblique and left-handed volumes, in LPS and RAS, in and out: mesh, volumes and
/// contours lie in the same place, which is that of what was drawn.
#[test]
fn every_program_sees_the_same_place() {
    let modules = "SimpleITK, nibabel, nrrd, pydicom, vtk";
    let Some(python) = python(modules) else { return };
    let folder = folder();
    let client = || {
        let mut client = Command::new(&python);
        client.arg(script("volumes.py")).current_dir(folder.path());
        client
    };
    let written: BTreeMap<String, Bodies> = result(client().args(["write", "."]));
    let endings = ["mha", "nrrd", "seg.nrrd", "nii.gz", "vti", "dcm"];
    let mut expected = BTreeMap::new();
    for (placement, body) in &written {
        for ending in ["mha", "nrrd", "nii.gz", "seg.nrrd"] {
            let stem = format!("{placement}_{}", ending.replace('.', "_"));
            let mut command = transect();
            command.arg("reconstruct").arg(format!("{placement}.{ending}")).arg("--quiet");
            let like = format!("{placement}.like.nrrd");
            command.args(["--resolution", "48", "--like", &like, "--planes-like", &like]);
            for ending in endings.iter().chain(&["ply"]) {
                command.arg("-o").arg(format!("{stem}.{ending}"));
            }
            assert_done(&run(command.current_dir(folder.path())));
            let is_ras = ending != "mha" && ending != "nrrd";
            let mesh = bodies(&folder.path().join(format!("{stem}.ply")), is_ras);
            assert_near(&mesh, body, GUESSED, 0.1, &stem);
            expected.insert(stem, mesh);
        }
    }
    let files: Vec<String> =
        expected.keys().flat_map(|stem| endings.map(|ending| format!("{stem}.{ending}"))).collect();
    let found: BTreeMap<String, Bodies> = result(client().arg("read").args(&files));
    // Two programs for each of three.
    assert_eq!(found.len(), 16 * 9);
    for (file, found) in &found {
        let (stem, _) = file.split_once('.').expect("an ending");
        assert_near(found, &expected[stem], TENTH, 0.03, file);
    }
}
