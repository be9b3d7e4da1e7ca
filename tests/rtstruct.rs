//! Structure sets (DICOM RTSTRUCT): structures that overlap, and how people draw them.

mod common;
#[path = "common/program.rs"]
mod program;
#[path = "common/structure_set.rs"]
mod structure_set;

use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use dicom_dictionary_std::uids;
use glam::DVec3;
use program::*;
use serde_json::Value;
use structure_set::*;

use transect::io::read_layers;
use transect::io::structures::Chosen;
use transect::{Label, Plane, Rules, Sections};

const SYNTAX: &str = uids::EXPLICIT_VR_LITTLE_ENDIAN;
const RADIUS: f64 = 20.0;
const CORE: f64 = 8.0;

/// A cylinder along a direction, in slices, with a smaller one in its middle, a tube that is drawn
/// in three ways, and what encloses nothing.
fn drawn(along: DVec3) -> Vec<Structure> {
    let sides = Plane { normal: along, offset: 0.0 }.tangents();
    let center = DVec3::new(-30.0, 120.0, -700.0);
    let slices = |radius: f64, from: DVec3| -> Vec<Contour> {
        let at = (0..12).map(|k| center + from + 3.0 * f64::from(k) * along);
        at.map(|at| closed(circle(at, radius, sides))).collect()
    };
    let beside = 60.0 * sides[0];
    let mut tube = Vec::new();
    for (k, Contour { points, .. }) in slices(RADIUS, beside).into_iter().enumerate() {
        let inner = slices(CORE, beside).swap_remove(k).points;
        match k % 3 {
            0 => tube.extend([closed(points), closed(inner)]),
            1 => {
                tube.push(Contour { kind: "CLOSEDPLANAR_XOR", points });
                tube.push(Contour { kind: "CLOSEDPLANAR_XOR", points: inner });
            }
            _ => {
                // To the hole and around it the other way, and back.
                let mut keyhole = points.clone();
                keyhole.push(points[0]);
                keyhole.extend(std::iter::once(inner[0]).chain(inner.iter().rev().copied()));
                tube.push(closed(keyhole));
            }
        }
    }
    let mut odd = slices(5.0, -beside);
    let [first, second] = [0, 1].map(|k| odd[k].points[0]);
    odd.push(Contour { kind: "POINT", points: vec![first] });
    odd.push(Contour { kind: "OPEN_PLANAR", points: vec![first, second, center] });
    odd.push(closed(vec![first, second]));
    odd.push(closed(vec![first, second, first]));
    vec![
        Structure { number: 3, name: "Body", contours: slices(RADIUS, DVec3::ZERO) },
        Structure { number: 1, name: "Core", contours: slices(CORE, DVec3::ZERO) },
        Structure { number: 7, name: "Tube", contours: tube },
        Structure { number: 9, name: "Odd", contours: odd },
        Structure { number: 10, name: "Empty", contours: Vec::new() },
    ]
}

fn written(
    folder: &Path,
    name: &str,
    structures: &[Structure],
    syntax: &str,
) -> std::path::PathBuf {
    let path = folder.join(name);
    fs::write(&path, structure_set(structures, syntax)).expect("the folder is writable");
    path
}

fn read(path: &Path, chosen: &Chosen) -> transect::Result<Vec<Sections>> {
    read_layers(&[path.to_owned()], chosen, &Rules::default())
}

fn report(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).expect("a report")).expect("JSON")
}

fn volumes(report: &Value) -> Vec<(u64, f64)> {
    let labels = report["check"]["labels"].as_array().expect("labels").iter();
    labels
        .inspect(|label| assert!(label["closed"] == true && label["outward"] == true, "{label}"))
        .map(|label| (label["label"].as_u64().unwrap(), label["volume"].as_f64().unwrap()))
        .collect()
}

#[test]
fn structures_that_overlap_are_solids_of_their_own() {
    let folder = folder();
    let along = DVec3::new(0.3, -0.2, 1.0).normalize();
    // In one transfer syntax that says what values are, and in one that does not.
    let set = written(folder.path(), "RS.1.2.3", &drawn(along), SYNTAX);
    let implicit =
        written(folder.path(), "set.dcm", &drawn(along), uids::IMPLICIT_VR_LITTLE_ENDIAN);
    let of = |path: &Path| {
        let layers = read(path, &Chosen::default()).unwrap();
        layers.iter().map(|layer| layer.sections.clone()).collect::<Vec<_>>()
    };
    assert_eq!(of(&set), of(&implicit));
    let [out, ply, png] = ["r.json", "r.ply", "r.png"].map(|name| folder.path().join(name));
    let mut command = transect();
    command.arg("reconstruct").arg(&set).args(["--resolution", "64", "--caps", "flat"]);
    let output = run(command.arg("-o").arg(&ply).arg("-o").arg(&png).arg("--report").arg(&out));
    assert_done(&output);
    let told = stderr(&output);
    for what in [
        "Tube: holes: 4 as contours within others, 4 as contours that say so (XOR), 4 as keyholes",
        "is a point",
        "is open (OPEN_PLANAR)",
        "Empty: nothing of it encloses an area",
    ] {
        assert!(told.contains(what), "{what:?} is not in {told}");
    }
    let report = report(&out);
    assert_eq!((&report["units"], &report["frame"]), (&"mm".into(), &"LPS".into()));
    assert_eq!(report["layers"].as_array().unwrap().len(), 4);
    let names = report["materials"].as_array().unwrap().iter().map(|one| &one["name"]);
    assert_eq!(names.collect::<Vec<_>>(), ["Core", "Body", "Tube", "Odd"]);
    assert_eq!(report["materials"][1]["color"], serde_json::json!([200, 3, 30]));
    // Twelve slices, half a spacing beyond the outer ones.
    let disc = |radius: f64| PI * radius * radius * 36.0;
    let [body, core] = [RADIUS, CORE].map(disc);
    for ((label, volume), (known, wanted)) in
        volumes(&report).into_iter().zip([(1, core), (3, body), (7, body - core), (9, disc(5.0))])
    {
        assert_eq!(label, known);
        assert!((volume / wanted - 1.0).abs() < 0.03, "label {label}: {volume} of {wanted}");
    }
    assert!(report["check"]["dice"]["min"].as_f64().unwrap() > 0.97);
}

#[test]
fn structures_can_exclude_each_other() {
    let folder = folder();
    let set = written(folder.path(), "set.dcm", &drawn(DVec3::Z), SYNTAX);
    let reconstructed = |more: &[&str]| {
        let [out, ply] = ["p.json", "p.ply"].map(|name| folder.path().join(name));
        let mut command = transect();
        command.arg("reconstruct").arg(&set).args(["--resolution", "64", "--caps", "flat"]);
        let output =
            run(command.args(more).arg("-q").arg("-o").arg(&ply).arg("--report").arg(&out));
        assert_done(&output);
        volumes(&report(&out))
    };
    let [(1, core), (3, ring)] = reconstructed(&["--structures", "body,Core", "--partition"])[..]
    else {
        panic!("two labels")
    };
    let whole = PI * RADIUS * RADIUS * 36.0;
    assert!(((core + ring) / whole - 1.0).abs() < 0.03, "{core} {ring} {whole}");
    assert!((core / (PI * CORE * CORE * 36.0) - 1.0).abs() < 0.05, "{core}");
    // Now the body takes all of it, and nothing of the core is left.
    let taken = reconstructed(&["--structures", "Body,Core", "--partition=Body"]);
    assert!(matches!(taken[..], [(3, body)] if (body / whole - 1.0).abs() < 0.03), "{taken:?}");
    let mut command = transect();
    let refused = run(command.arg("crosscheck").arg(&set));
    assert_refused(&refused, &["set.dcm", "4 structures", "--structures", "--partition"]);
    let mut command = transect();
    let refused = run(command.args(["inspect", "--structures", "Liver"]).arg(&set));
    assert_refused(&refused, &["\"Liver\"", "\"Body\" (3)"]);
    let mut command = transect();
    let refused = run(command.args(["inspect", "--partition"]).arg(phantom()));
    assert_refused(&refused, &["--partition", "structure sets"]);
}

#[test]
fn what_is_bent_or_overlaps_in_part_is_refused_by_its_name() {
    let folder = folder();
    let sides = [DVec3::X, DVec3::Y];
    let bad = |name: &str, contours: Vec<Contour>| {
        let good = closed(circle(DVec3::ZERO, 9.0, sides));
        let structures = [
            Structure { number: 1, name: "Good", contours: vec![good] },
            Structure { number: 2, name: "Bad", contours },
        ];
        let path = written(folder.path(), name, &structures, SYNTAX);
        let error = read(&path, &Chosen::default()).map(|_| ()).unwrap_err().to_string();
        let good = Chosen { names: vec!["Good".to_owned()], partition: None };
        assert_eq!(read(&path, &good).unwrap().len(), 1, "the others can be read");
        error
    };
    let mut bent = circle(DVec3::ZERO, 9.0, sides);
    bent[5].z += 2.0;
    let error = bad("bent.dcm", vec![closed(bent)]);
    assert!(error.contains("structure Bad: contour 1 is not flat"), "{error}");
    let across = [0.0, 6.0].map(|x| closed(circle(DVec3::X * x, 9.0, sides)));
    let error = bad("across.dcm", across.into());
    assert!(error.contains("contour 1 and contour 2 overlap in part"), "{error}");
}

#[test]
fn slices_off_their_planes_and_missing_ones() {
    let folder = folder();
    let sides = [DVec3::X, DVec3::Y];
    let heights = [0.0, 3.0, 6.02, 9.0, 18.0, 21.0];
    let mut contours: Vec<Contour> =
        heights.map(|z| closed(circle(DVec3::Z * z, 9.0, sides))).into();
    contours.push(closed(circle(DVec3::new(30.0, 0.0, 5.99), 4.0, sides)));
    let structures = [Structure { number: 1, name: "A", contours }];
    let path = written(folder.path(), "uneven.dcm", &structures, SYNTAX);
    let layers = read(&path, &Chosen::default()).unwrap();
    assert_eq!(layers[0].sections.len(), 6);
    assert_eq!(layers[0].sections[3].plane().offset, 9.0);
    let notes: Vec<&str> = layers[0].notes.iter().map(|note| note.what.as_str()).collect();
    assert!(notes[0].contains("2 contours were off their slices, by up to 0.0150 mm"), "{notes:?}");
    assert!(notes[1].contains("are 3 mm apart, but 1 gap is wider, up to 9 mm"), "{notes:?}");
}

#[test]
fn a_bare_data_set_is_one_and_damaged_files_are_told() {
    let folder = folder();
    let bytes = structure_set(&drawn(DVec3::Z), SYNTAX);
    // Behind the file meta information, whose length comes first.
    let length = u32::from_le_bytes(bytes[140..144].try_into().unwrap()) as usize;
    let bare = folder.path().join("bare.dcm");
    fs::write(&bare, &bytes[144 + length..]).unwrap();
    let labels = |layers: &[Sections]| -> Vec<Label> {
        let materials = layers.iter().flat_map(|layer| &layer.materials);
        materials.map(|material| Label(material.id)).collect()
    };
    let layers = read(&bare, &Chosen::default()).unwrap();
    assert_eq!(labels(&layers), [3, 1, 7, 9].map(Label));
    let cut = folder.path().join("cut.dcm");
    for part in 1..50 {
        fs::write(&cut, &bytes[..bytes.len() * part / 50]).unwrap();
        let error = read(&cut, &Chosen::default()).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains("cut.dcm"), "{error}");
    }
}

#[test]
fn a_set_of_a_planning_system() {
    let Some(path) = common::data("dicom/rtss.dcm") else { return };
    let folder = folder();
    let [out, ply] = ["r.json", "r.ply"].map(|name| folder.path().join(name));
    let mut command = transect();
    command.arg("reconstruct").arg(path).args(["--resolution", "128", "-q"]);
    assert_done(&run(command.arg("-o").arg(&ply).arg("--report").arg(&out)));
    let report = report(&out);
    assert_eq!(volumes(&report).len(), 9, "all but the one without contours");
    let body = &report["check"]["labels"][0];
    let ratio = body["cavalieri"]["ratio"].as_f64().expect("a stack");
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

/// Whether a point given by its two coordinates on a section's plane is in a material: by the
/// edges that a ray from it crosses.
fn is_inside(section: &transect::Section, at: glam::DVec2) -> bool {
    let mut inside = false;
    for edge in section.edges() {
        if edge.left.is_material() == edge.right.is_material() {
            continue;
        }
        let [start, end] = [edge.start, edge.end].map(|vertex| section.vertices()[vertex as usize]);
        if (start.y > at.y) != (end.y > at.y) {
            let part = (at.y - start.y) / (end.y - start.y);
            inside ^= start.x + part * (end.x - start.x) > at.x;
        }
    }
    inside
}

/// 2 · common / sum of two sections' areas, by points on a grid of this step.
fn dice(one: &transect::Section, other: &transect::Section, step: f64) -> f64 {
    let all = one.vertices().iter().chain(other.vertices());
    let [low, high] = all.fold([glam::DVec2::INFINITY, glam::DVec2::NEG_INFINITY], |ends, own| {
        [ends[0].min(*own), ends[1].max(*own)]
    });
    let counts = ((high - low) / step).ceil();
    let (mut common, mut sum) = (0, 0);
    for place in 0..(counts.x * counts.y) as usize {
        let [i, j] = [place % counts.x as usize, place / counts.x as usize];
        let at = low + step * glam::DVec2::new(i as f64 + 0.37, j as f64 + 0.41);
        let both = [one, other].map(|section| is_inside(section, at));
        common += usize::from(both == [true; 2]);
        sum += both.iter().filter(|inside| **inside).count();
    }
    2.0 * common as f64 / sum as f64
}

#[test]
fn contours_go_back_into_a_structure_set() {
    let folder = folder();
    let along = DVec3::new(0.1, 0.2, 1.0).normalize();
    let set = written(folder.path(), "set.dcm", &drawn(along), SYNTAX);
    let back = folder.path().join("back.dcm");
    let mut command = transect();
    command.arg("reconstruct").arg(&set).args(["--resolution", "256", "-q"]);
    command.args(["--structures", "Tube"]);
    assert_done(&run(command.arg("-o").arg(&back)));
    let chosen = Chosen { names: vec!["Tube".into()], partition: None };
    let [before, after] = [&set, &back].map(|path| read(path, &chosen).expect("a structure set"));
    assert_eq!((before.len(), after.len()), (1, 1));
    for layer in &before {
        let material = &layer.materials[0];
        let own = after.iter().find(|other| other.materials[0] == *material);
        let own = own.unwrap_or_else(|| panic!("{material:?} is gone, or has other colours"));
        assert_eq!(own.sections.len(), layer.sections.len(), "{}", material.name);
        for (one, other) in layer.sections.iter().zip(&own.sections) {
            let apart = one.plane().unit().offset - other.plane().unit().offset;
            assert!(apart.abs() < 1e-3, "{} and {}", one.name(), other.name());
            let dice = dice(one, other, 0.1);
            assert!(dice >= 0.999, "{}: {dice}", one.name());
        }
    }
    // On planes between them, without anything to take over.
    let sections = folder.path().join("between.json");
    let sides = Plane { normal: along, offset: 0.0 }.tangents();
    let text = |point: DVec3| serde_json::json!(point.to_array()).to_string();
    let center = DVec3::new(-30.0, 120.0, -700.0) + 4.5 * along;
    let corners = circle(center, 1.0, sides).into_iter().map(text).collect::<Vec<_>>().join(", ");
    let json = format!(
        "{{\"transect\": \"sections\", \"version\": 1, \"units\": \"mm\", \"frame\": \"LPS\", \
         \"sections\": [{{\"name\": \"a\", \"normal\": {}, \"offset\": {}, \
         \"loops\": [{{\"label\": 1, \"points\": [{corners}]}}]}}]}}",
        text(along),
        along.dot(center)
    );
    fs::write(&sections, json).unwrap();
    let mut command = transect();
    command.arg("reconstruct").arg(&set).args(["--resolution", "64", "-q", "--structures", "Tube"]);
    command.arg("--planes-like").arg(&sections);
    assert_done(&run(command.arg("-o").arg(&back)));
    let tube = read(&back, &Chosen::default()).expect("a structure set");
    assert_eq!((tube.len(), tube[0].sections.len()), (1, 1));
    let regions = tube[0].sections[0].regions().unwrap();
    let area: f64 = regions.iter().filter(|own| own.label == Label(7)).map(|own| own.area).sum();
    let wanted = PI * (RADIUS * RADIUS - CORE * CORE);
    assert!((area / wanted - 1.0).abs() < 0.02, "{area} of {wanted}");
}
