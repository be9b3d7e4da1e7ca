//! Surfaces as the programs that people open them with see them: the scripts in `tests/clients`
//! open files with trimesh, VTK, lib3mf and Blender, and say what is in them.

#[path = "common/program.rs"]
mod program;
#[path = "common/python.rs"]
mod python;
#[path = "common/skipped.rs"]
mod skipped;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::sync::OnceLock;

use program::*;
use python::{python, result, script};
use serde::Deserialize;
use tempfile::TempDir;
use transect::io::{read_mesh, read_sections};
use transect::{DVec3, Label, Rules};

/// How far places may be off, in millimetres: single precision, and no more.
const OFF: f64 = 1e-3;

/// A body as a client has it, in world units.
#[derive(Debug, Clone, Deserialize)]
struct Solid {
    closed: bool,
    volume: f64,
    centroid: [f64; 3],
    min: [f64; 3],
    max: [f64; 3],
    color: Option<[u8; 3]>,
}

/// For every file the bodies in it, by name.
type Found = BTreeMap<String, BTreeMap<String, Solid>>;

/// The bundled example in every kind of file, and what is to be found in them.
struct Written {
    folder: TempDir,
    expected: BTreeMap<String, Solid>,
}

fn written() -> &'static Written {
    static WRITTEN: OnceLock<Written> = OnceLock::new();
    WRITTEN.get_or_init(|| {
        let folder = folder();
        let names = [
            "all.ply",
            "all.glb",
            "all.3mf",
            "all.vtm",
            "all.vtp",
            "all.vtu",
            "all.obj",
            "{name}.stl",
            "{name}.ply",
            "{name}.glb",
            "{name}.obj",
            "{name}.off",
        ];
        assert_done(&reconstruct(folder.path(), &names, &["--quiet"]));
        let expected = expected(&folder.path().join("all.ply"));
        Written { folder, expected }
    })
}

/// What the network says, measured by its closed surfaces.
fn expected(network: &Path) -> BTreeMap<String, Solid> {
    let mesh = read_mesh(network).expect("a mesh");
    let sections = read_sections(&phantom(), &Rules::default()).expect("sections");
    let solid = |label| {
        let surface = mesh.surface(label);
        let base = surface.vertices[0];
        let (mut volume, mut moment) = (0.0, DVec3::ZERO);
        for triangle in 0..surface.triangles.len() {
            let [a, b, c] = surface.corners(triangle).map(|corner| corner - base);
            let part = a.dot(b.cross(c)) / 6.0;
            volume += part;
            moment += part * (a + b + c) / 4.0;
        }
        let vertices = || surface.vertices.iter().copied();
        Solid {
            closed: true,
            volume,
            centroid: (base + moment / volume).to_array(),
            min: vertices().reduce(DVec3::min).expect("a vertex").to_array(),
            max: vertices().reduce(DVec3::max).expect("a vertex").to_array(),
            color: None,
        }
    };
    let solids = sections.materials.iter().map(|material| {
        let solid = Solid { color: Some(material.color), ..solid(Label(material.id)) };
        (material.name.clone(), solid)
    });
    solids.collect()
}

/// The files of every material, by a pattern's ending.
fn each(ending: &str) -> Vec<String> {
    written().expected.keys().map(|name| format!("{name}.{ending}")).collect()
}

/// What a client finds in files.
fn found(command: &mut Command, files: &[String]) -> Found {
    let folder = written().folder.path();
    result(command.args(files).current_dir(folder))
}

/// Every file holds what it should: all bodies, or the one that it is called after.
fn assert_as_expected(found: &Found) {
    let near = |one: [f64; 3], other: [f64; 3]| DVec3::from(one).distance(other.into()) < OFF;
    for (file, solids) in found {
        let stem = Path::new(file).file_stem().expect("a name").to_string_lossy();
        for (name, expected) in &written().expected {
            if stem != "all" && stem != name.as_str() {
                continue;
            }
            let Some(solid) = solids.get(name) else {
                panic!("{file}: {name} is not among {:?}", solids.keys());
            };
            let place = format!("{file}: {name}: {solid:?} and not {expected:?}");
            assert!(solid.closed, "{place}");
            assert!((solid.volume / expected.volume - 1.0).abs() < 1e-5, "{place}");
            assert!(near(solid.centroid, expected.centroid), "{place}");
            assert!(near(solid.min, expected.min) && near(solid.max, expected.max), "{place}");
            if let (Some(one), Some(other)) = (solid.color, expected.color) {
                assert!((0..3).all(|at| one[at].abs_diff(other[at]) <= 1), "{place}");
            }
        }
        let count = if stem == "all" { written().expected.len() } else { 1 };
        assert_eq!(solids.len(), count, "{file}");
    }
}

#[test]
fn trimesh_finds_every_label_closed_and_in_its_colour() {
    let Some(python) = python("trimesh") else { return };
    let mut files = ["all.glb", "all.3mf", "all.obj"].map(str::to_owned).to_vec();
    files.extend(["stl", "ply", "glb", "obj", "off"].into_iter().flat_map(each));
    assert_as_expected(&found(Command::new(python).arg(script("trimesh_client.py")), &files));
}

#[test]
fn vtk_finds_every_label_and_slicer_its_frame() {
    let Some(python) = python("vtk") else { return };
    let mut files = ["all.vtm", "all.vtp", "all.vtu"].map(str::to_owned).to_vec();
    files.extend(each("stl"));
    let mut client = Command::new(&python);
    assert_as_expected(&found(client.arg(script("vtk_client.py")), &files));
    // Of these the frame is looked at alone.
    let files = ["all.ply", "all.obj"].map(str::to_owned);
    found(Command::new(&python).arg(script("vtk_client.py")), &files);
}

#[test]
fn lib3mf_finds_nothing_wrong() {
    let Some(python) = python("lib3mf") else { return };
    let files = ["all.3mf".to_owned()];
    assert_as_expected(&found(Command::new(python).arg(script("lib3mf_client.py")), &files));
}

/// What SimpleITK measures between two volumes, of a label.
#[derive(Debug, Deserialize)]
struct Measured {
    dice: f64,
    jaccard: f64,
    hausdorff: f64,
    surface_hausdorff: f64,
    assd: f64,
    volume: f64,
}

/// Its distances are between centres of voxels, ours between faces: a voxel's diagonal apart at
/// most, and much less on the average.
#[test]
fn simpleitk_measures_the_same_of_labels() {
    let Some(python) = python("SimpleITK") else { return };
    let folder = folder();
    let [one, other] = ["one.mha", "other.mha"].map(|name| folder.path().join(name));
    assert_done(&reconstruct(folder.path(), &["one.mha"], &["--quiet"]));
    let more = ["--quiet", "--method", "mvc", "--smooth", "0", "--like"];
    let mut again = transect();
    again.arg("reconstruct").arg(phantom()).args(COARSE).args(more).arg(&one).arg("-o").arg(&other);
    assert_done(&run(&mut again));
    let output = run(transect().args(["compare", "--json"]).args([&one, &other]));
    assert_done(&output);
    let ours: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(ours["exact_overlap"], true);
    let output = run(Command::new(python).arg(script("simpleitk_client.py")).args([&one, &other]));
    let text = String::from_utf8_lossy(&output.stdout);
    let result = text.lines().find_map(|line| line.strip_prefix("RESULT "));
    let result = result.unwrap_or_else(|| panic!("no result: {text}{}", stderr(&output)));
    let theirs: BTreeMap<u32, Measured> = serde_json::from_str(result).expect("figures");
    let labels = ours["labels"].as_array().expect("labels");
    assert_eq!(labels.len(), theirs.len());
    for own in labels {
        let label = own["label"].as_u64().expect("a number") as u32;
        let (own, theirs) = (&own["agreement"], &theirs[&label]);
        let number = |name: &str| own[name].as_f64().unwrap_or_else(|| panic!("{name}: {own}"));
        let place = format!("label {label}: {own} and {theirs:?}");
        assert!((number("dice") - theirs.dice).abs() < 1e-12, "{place}");
        assert!((number("iou") - theirs.jaccard).abs() < 1e-12, "{place}");
        let volume = own["volumes"][0].as_f64().expect("a volume");
        assert!((volume / theirs.volume - 1.0).abs() < 1e-9, "{place}");
        let voxel = voxel(&one);
        let diagonal = voxel * 3f64.sqrt();
        assert!((number("hausdorff") - theirs.surface_hausdorff).abs() < diagonal, "{place}");
        assert!((number("hausdorff") - theirs.hausdorff).abs() < 2.0 * diagonal, "{place}");
        assert!((number("assd") - theirs.assd).abs() < 0.5 * voxel, "{place}");
    }
}

/// The side of the voxels of a MetaImage.
fn voxel(file: &Path) -> f64 {
    let bytes = std::fs::read(file).expect("a file");
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(1000)]).into_owned();
    let line = header.lines().find(|line| line.starts_with("ElementSpacing"));
    let word = line.and_then(|line| line.split_whitespace().nth(2)).expect("a spacing");
    word.parse().expect("a number")
}

/// By hand: `cargo test --release --test clients -- --ignored`.
#[test]
#[ignore = "needs Blender, which is large"]
fn blender_finds_every_label_upright_and_in_its_colour() {
    let mut files = ["all.glb", "all.obj"].map(str::to_owned).to_vec();
    files.extend(each("ply"));
    let mut blender = Command::new("blender");
    blender.args(["--background", "--python-exit-code", "1", "--python"]);
    assert_as_expected(&found(blender.arg(script("blender_client.py")).arg("--"), &files));
}
