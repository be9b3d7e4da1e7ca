//! `transect convert`, and texts as other programs write them.

#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;

use program::*;
use transect::Rules;
use transect::io::read_sections;

/// A square with a hole on z = 0, and a triangle on a plane that leans.
const CSL: &str = "CSLC\n2 2\n1 8 2 0 0 1 0\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n1 1 0\n1 2 0\n2 2 0\n2 1 0\n\
    4 1 0 1 2 3\n4h0 1 4 5 6 7\n2 3 1 1 0 1 -5\n5 0 0\n0 0 5\n5 3 0\n3 2 0 2 1\n";

fn convert(from: &Path, to: &Path) -> std::process::Output {
    run(transect().arg("convert").arg(from).arg("-o").arg(to))
}

#[test]
fn there_and_back_again_sections_are_the_same() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("a.csl"), CSL).expect("a file");
    for (from, to) in
        [("a.csl", "b.json"), ("b.json", "c.csl"), ("a.csl", "d.csl"), ("c.csl", "e.json")]
    {
        let output = convert(&at(from), &at(to));
        assert_done(&output);
        assert_eq!(stderr(&output), "");
    }
    let read = |name: &str| read_sections(&at(name), &Rules::default()).expect("sections").sections;
    assert_eq!(read("a.csl").len(), 2);
    for other in ["b.json", "c.csl", "d.csl", "e.json"] {
        assert_eq!(read(other), read("a.csl"), "{other}");
    }
    let bytes = |name: &str| fs::read(at(name)).expect("a file");
    assert!(bytes("c.csl") == bytes("d.csl") && bytes("b.json") == bytes("e.json"));
}

/// The areas of all labels on the planes of a file, by plane and label.
fn areas(path: &Path) -> Vec<([i64; 4], u32, f64)> {
    let sections = read_sections(path, &Rules::default()).expect("sections");
    let mut all = Vec::new();
    for section in &sections.sections {
        let plane = section.plane().unit();
        let sign = plane.normal.to_array().into_iter().find(|own| own.abs() > 1e-6);
        let sign = sign.expect("a normal").signum();
        let [x, y, z] = (sign * plane.normal).to_array();
        let plane = [x, y, z, sign * plane.offset].map(|own| (1e3 * own).round() as i64);
        for region in section.regions().expect("regions") {
            if region.label.is_material() {
                all.push((plane, region.label.0, region.area));
            }
        }
    }
    all.sort_by(|one, other| one.partial_cmp(other).expect("numbers"));
    all
}

#[test]
fn every_kind_of_contours_is_written_and_read() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let wanted = areas(&phantom());
    assert!(wanted.len() > 100);
    for name in ["a.csl", "a.contour", "a.obj", "a.vtp"] {
        assert_done(&convert(&phantom(), &at(name)));
        let found = areas(&at(name));
        assert_eq!(found.len(), wanted.len(), "{name}");
        for (own, other) in found.iter().zip(&wanted) {
            assert_eq!((own.0, own.1), (other.0, other.1), "{name}");
            assert!((own.2 - other.2).abs() < 1e-6 * other.2, "{name}: {own:?} {other:?}");
        }
    }
    // Structures do not exclude each other, and holes are reached by keyholes.
    let output = convert(&phantom(), &at("a.dcm"));
    assert_done(&output);
    assert!(stderr(&output).contains("note: .dcm has no words for names of sections"));
    let rules = Rules::default();
    let layers = transect::io::read_layers(&[at("a.dcm")], &Default::default(), &rules);
    let layers = layers.expect("a structure set");
    assert_eq!(layers.len(), 7);
    let names: Vec<&str> = layers.iter().map(|own| own.materials[0].name.as_str()).collect();
    assert_eq!((names[2], names[6]), ("liver", "body"));
    for (layer, label) in layers.iter().zip(1..) {
        let regions = layer.sections.iter().flat_map(|own| own.regions().expect("regions"));
        let own = regions.filter(|own| own.label.is_material()).map(|own| own.area).sum::<f64>();
        let drawn = wanted.iter().filter(|own| own.1 == label);
        let drawn: f64 = drawn.map(|own| own.2).sum();
        assert!((own - drawn).abs() < 1e-3 * drawn, "{label}: {own} {drawn}");
    }
}

#[test]
fn what_the_other_kind_cannot_say_is_refused_or_told() {
    let folder = folder();
    let target = folder.path().join("a.csl");
    let output = convert(&repository("examples/sweep.json"), &target);
    assert_refused(&output, &["unknown region", ".json"]);
    assert_eq!(entries(folder.path()), [""; 0]);
    let output = convert(&phantom(), &target);
    assert_done(&output);
    let told = stderr(&output);
    assert!(
        told.contains("note: .csl has no words for") && told.contains("names of labels"),
        "{told}"
    );
    let output = run(transect().args(["convert", "-q"]).arg(phantom()).arg("-o").arg(&target));
    assert_eq!((output.status.code(), stderr(&output).as_str()), (Some(0), ""));
    assert_refused(&convert(&phantom(), &folder.path().join("a.ply")), &["written to .json, .csl"]);
    let sweep = convert(&repository("examples/sweep.json"), &folder.path().join("a.obj"));
    assert_refused(&sweep, &["unknown region", "as .obj"]);
    // Several files become one.
    let (other, both) = (folder.path().join("b.csl"), folder.path().join("both.json"));
    fs::write(&other, CSL).expect("a file");
    let mut command = transect();
    assert_done(&run(command.arg("convert").args([&target, &other]).arg("-o").arg(&both)));
    let count =
        |path: &Path| read_sections(path, &Rules::default()).expect("sections").sections.len();
    assert_eq!(count(&both), count(&target) + 2);
}

#[test]
fn a_mark_at_the_beginning_and_ends_of_lines_change_nothing() {
    let folder = folder();
    let contour =
        "1\n0 0 1 0\n4 4\n0 0 0\n4 0 0\n4 4 0\n0 4 0\n0 1 1 0\n1 2 1 0\n2 3 1 0\n3 0 1 0\n";
    let json = "{\"transect\": \"sections\", \"version\": 1, \"sections\": [{\"normal\": [0, 0, 1],\n\
                \"offset\": 0, \"loops\": [{\"label\": 1, \"points\": [[0, 0, 0], [4, 0, 0], [0, 4, 0]]}]}]}\n";
    for (name, text) in [("a.csl", CSL), ("a.contour", contour), ("a.json", json)] {
        let path = folder.path().join(name);
        let read = |text: &str| {
            fs::write(&path, text).expect("a file");
            read_sections(&path, &Rules::default()).expect("sections").sections
        };
        let plain = read(text);
        assert_eq!(read(&format!("\u{feff}{text}")), plain, "{name}");
        assert_eq!(read(&format!("\u{feff}{}", text.replace('\n', "\r\n"))), plain, "{name}");
    }
}

/// A tiny crossing on a border, as tracing by hand leaves it.
#[test]
fn a_tiny_crossing_is_read_alike_in_every_kind() {
    let folder = folder();
    let points = ["0 0 0", "10 0 0", "10 10 0", "5 10 0", "5.3 9.9 0", "5.3 10.1 0", "0 10 0"];
    let edges: Vec<String> = (0..7).map(|at| format!("{at} {} 1 0", (at + 1) % 7)).collect();
    let rows = points.join("\n");
    let contour = format!("1\n0 0 1 0\n7 7\n{rows}\n{}\n", edges.join("\n"));
    let csl = format!("CSLC\n1 1\n1 7 1 0 0 1 0\n{rows}\n7 1 0 1 2 3 4 5 6\n");
    let areas = [("a.contour", contour), ("a.csl", csl)].map(|(name, text)| {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("a file");
        let sections = read_sections(&path, &Rules::default()).expect("sections");
        assert!(sections.warnings[0].what.contains("crosses itself"), "{:?}", sections.warnings);
        let regions = sections.sections[0].regions().expect("regions");
        regions.iter().filter(|own| own.label.is_material()).map(|own| own.area).sum::<f64>()
    });
    assert!((areas[0] - areas[1]).abs() < 1e-12 && areas[0] > 99.0, "{areas:?}");
}

/// What Blender writes for two rings, one in the other, and what it writes for a body.
#[test]
fn polylines_become_sections_and_surfaces_are_sent_elsewhere() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let ring = |half: f64, first: usize| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let points = corners.map(|[x, y]| format!("v {} {} 3\n", half * x, half * y)).concat();
        let ends = (0..4).map(|at| (first + at, first + (at + 1) % 4));
        points + &ends.map(|(from, to)| format!("l {from} {to}\n")).collect::<String>()
    };
    fs::write(at("rings.obj"), format!("o ring\n{}{}", ring(4.0, 1), ring(1.0, 5)))
        .expect("a file");
    let output = convert(&at("rings.obj"), &at("rings.json"));
    assert_done(&output);
    assert!(stderr(&output).contains("note: 1 contours lie in others"), "{}", stderr(&output));
    let sections = read_sections(&at("rings.json"), &Rules::default()).expect("sections");
    assert_eq!(sections.materials[0].name, "ring");
    let regions = sections.sections[0].regions().expect("regions");
    let area: f64 = regions.iter().filter(|own| own.label.is_material()).map(|own| own.area).sum();
    assert_eq!(area, 64.0 - 4.0);
    fs::write(at("body.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("a file");
    assert_refused(&convert(&at("body.obj"), &at("a.json")), &["body.obj", "a surface", "slice"]);
}
