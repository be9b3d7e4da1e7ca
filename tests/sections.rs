//! Files of sections, good and bad: the corpus by table, real data by count,
//! round trips, and damaged text.

mod common;
#[path = "common/patchwork.rs"]
mod patchwork;
#[path = "common/random.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod random;

use std::path::{Path, PathBuf};

use common::data;
use glam::DVec3;
use random::Random;
use transect::error::Result;
use transect::inspect::{Inspection, inspect};
use transect::io::{csl, json, read_all, read_sections};
use transect::label::Label;
use transect::section::{Rules, Section, Sections};

/// The number that stands for *unknown* in the table.
const UNKNOWN: u32 = u32::MAX;

/// What a good file holds.
struct Good {
    file: &'static str,
    sections: usize,
    vertices: usize,
    edges: usize,
    /// Areas by label.
    areas: &'static [(u32, f64)],
    warnings: usize,
    left_out: usize,
}

const fn good(
    file: &'static str,
    [sections, vertices, edges]: [usize; 3],
    areas: &'static [(u32, f64)],
    [warnings, left_out]: [usize; 2],
) -> Good {
    Good { file, sections, vertices, edges, areas, warnings, left_out }
}

const GOOD: &[Good] = &[
    good("square.csl", [1, 4, 4], &[(1, 4.0)], [0, 0]),
    good("hole.csl", [1, 8, 8], &[(1, 12.0)], [0, 0]),
    good("organs.csl", [2, 12, 12], &[(1, 16.0), (2, 8.0), (4, 1.0)], [0, 0]),
    good("touching.csl", [1, 7, 9], &[(1, 10.0)], [0, 0]),
    good("degenerate.csl", [1, 4, 4], &[(1, 4.0)], [0, 3]),
    good("bowtie.csl", [1, 5, 6], &[(1, 2.0)], [1, 0]),
    // 100 × 100.4 / 0.8 on the tilted plane.
    good("utm.csl", [2, 8, 8], &[(1, 11_057.989_583), (2, 12_550.0)], [0, 0]),
    good("merged.csl", [2, 4, 4], &[(1, 1.0)], [1, 1]),
    good("junction.contour", [1, 7, 9], &[(1, 1.5), (2, 2.0), (3, 0.5)], [0, 0]),
    good("mirrored.contour", [2, 7, 7], &[(1, 1.0), (2, 2.0)], [0, 0]),
    good("loops.json", [2, 14, 15], &[(3, 15.0), (4, 4.0), (UNKNOWN, 1.0)], [0, 0]),
    good("graph.json", [1, 3, 3], &[(1, 2.0), (UNKNOWN, 0.0)], [0, 0]),
    // What reaches beyond the extents, 2 and 1 units of area, is left out.
    good("extent_beyond.json", [2, 20, 22], &[(1, 4.0), (2, 1.0), (UNKNOWN, 0.0)], [2, 0]),
    good("unknown.json", [2, 0, 0], &[(UNKNOWN, 0.0)], [0, 0]),
];

/// Bad files, and words that their errors must hold beside the file's name.
const BAD: &[(&str, &[&str])] = &[
    ("missing.csl", &["no such file"]),
    ("empty.csl", &["empty"]),
    ("binary.csl", &["no text file", "byte 0"]),
    ("kind.csl", &["line 1", "begins with CSLC", "\"solid\""]),
    ("none.csl", &["no section", "at least one"]),
    ("truncated.csl", &["section 1, line 9", "the file ends where loop 0 of 1", "truncated"]),
    ("huge.csl", &["section 1, line 4", "vertex 1 of 18446744073709551615", "truncated"]),
    ("planes.csl", &["plane 1 should follow", "truncated"]),
    ("nan.csl", &["section 1, line 7", "vertex 1 is NaN", "finite"]),
    ("zero_normal.csl", &["section 1, line 4", "normal (A, B, C) is zero"]),
    ("index.csl", &["section 1, line 11", "index 4 is out of range", "4 vertices, from 0"]),
    ("count.csl", &["section 1, line 11", "promises 4 vertices, the line has 3"]),
    ("parent.csl", &["section 1, line 11", "a hole of loop 3", "1 loops"]),
    ("label.csl", &["section 1, line 11", "label", "\"-1\""]),
    ("off_plane.csl", &["section 1 (line 4)", "vertex 2 of loop 0", "0.010000 off its plane"]),
    ("coordinate.csl", &["section 1, line 9", "vertex 3 has 3 entries, this line has 2"]),
    (
        "overlap.csl",
        &["section 12 (line 3)", "loops 0 (label 1) and 1 (label 2) overlap", "near ["],
    ),
    ("coincident.csl", &["section 3 (line 10)", "plane of section 1", "2.500e-1", "near ["]),
    ("contradiction.contour", &["section 1 (line 2)", "contradictory labels around vertex"]),
    ("dangling.contour", &["section 1 (line 2)", "contradictory labels around vertex"]),
    ("index.contour", &["section 1, line 19", "index 7 is out of range", "7 vertices"]),
    ("version.json", &["version is 2", "only 1"]),
    ("kind.json", &["no sections", "\"transect\""]),
    ("member.json", &["line 2", "unknown field `ofset`"]),
    ("name.json", &["section axial (sections[0])", "\"spleen\""]),
    ("unlabelled.json", &["section axial (sections[0])", "loops[1]", "label"]),
    ("color.json", &["labels[0]", "\"red\"", "#rrggbb"]),
    ("truncated.json", &["line", "EOF"]),
    (
        "extent_crossing.json",
        &["section frame 7 (sections[0])", "its extent crosses itself at [2, 2, 5]"],
    ),
    ("extent_points.json", &["section frame 7 (sections[0])", "its extent has 2 points"]),
    ("extent_flat.json", &["section frame 7 (sections[0])", "its extent encloses no area"]),
    (
        "extent_off_plane.json",
        &["section frame 7 (sections[0])", "vertex 2 of its extent", "0.250000 off its plane"],
    ),
    ("frames.csl", &["section 2 (line 14)", "plane of section 1", "disagrees"]),
    ("square.txt", &["not known", ".csl, .contour, .json"]),
    ("nothing", &["not known"]),
];

fn corpus(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name)
}

fn read(name: &str) -> Sections {
    read_sections(&corpus(name), &Rules::default())
        .unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn failure(name: &str, rules: &Rules) -> String {
    let result = read_sections(&corpus(name), rules).map(|_| ());
    result.expect_err(&format!("{name} should not be readable")).to_string()
}

fn assert_says(text: &str, words: &[&str]) {
    for word in words {
        assert!(text.contains(word), "{text:?} does not say {word:?}");
    }
}

#[test]
fn good_files_hold_what_they_should() {
    for expected in GOOD {
        let name = expected.file;
        let found = inspect(&read(name)).unwrap();
        assert_eq!(
            [found.sections, found.vertices, found.edges],
            [expected.sections, expected.vertices, expected.edges],
            "{name}"
        );
        assert_eq!(found.warnings.len(), expected.warnings, "{name}: {:?}", found.warnings);
        assert_eq!(found.left_out.len(), expected.left_out, "{name}: {:?}", found.left_out);
        assert_areas(name, &found, expected.areas);
    }
}

fn assert_areas(name: &str, found: &Inspection, expected: &[(u32, f64)]) {
    let ids: Vec<u32> = found.labels.iter().map(|label| label.id.unwrap_or(UNKNOWN)).collect();
    let known: Vec<u32> = expected.iter().map(|&(id, _)| id).collect();
    assert_eq!(ids, known, "{name}");
    for (label, &(id, area)) in found.labels.iter().zip(expected) {
        assert!(
            (label.area - area).abs() < 1e-9 * area.max(1e-3) + 1e-6,
            "{name} {id} {}",
            label.area
        );
    }
}

#[test]
fn bad_files_are_refused_by_file_section_and_place() {
    for (name, words) in BAD {
        let error = failure(name, &Rules::default());
        assert_says(&error, &[name]);
        assert_says(&error, words);
    }
}

#[test]
fn strict_refuses_what_is_doubtful() {
    let strict = Rules { strict: true, ..Rules::default() };
    let place = "section 7 (line 3): loop 0 crosses itself at [1, 1, 0]";
    assert_says(
        &failure("bowtie.csl", &strict),
        &["bowtie.csl", place, "an error because warnings are"],
    );
    assert_says(&failure("merged.csl", &strict), &["section 3 (line 10)", "plane of section 1"]);
    for clean in ["square.csl", "hole.csl", "degenerate.csl", "mirrored.contour", "loops.json"] {
        assert!(read_sections(&corpus(clean), &strict).is_ok(), "{clean}");
    }
}

/// A file, a label that means unknown in it, and the areas that are left.
type Forgotten = (&'static str, u32, &'static [(u32, f64)]);

const FORGOTTEN: &[Forgotten] = &[
    ("organs.csl", 2, &[(1, 16.0), (4, 1.0), (UNKNOWN, 8.0)]),
    ("organs.csl", 0, &[(1, 16.0), (2, 8.0), (4, 1.0), (UNKNOWN, 0.0)]),
    ("junction.contour", 2, &[(1, 1.5), (3, 0.5), (UNKNOWN, 2.0)]),
    // Which side is left is told by outside, whatever that means.
    ("mirrored.contour", 0, &[(1, 1.0), (2, 2.0), (UNKNOWN, 0.0)]),
    ("mirrored.contour", 2, &[(1, 1.0), (UNKNOWN, 2.0)]),
    ("loops.json", 4, &[(3, 15.0), (UNKNOWN, 5.0)]),
    // Two frames of one plane: each knows what the other does not.
    ("frames.csl", 9, &[(1, 8.0)]),
];

fn forgetful(label: u32, strict: bool) -> Rules {
    Rules { unknown: Some(Label(label)), strict, ..Rules::default() }
}

#[test]
fn an_ordinary_label_can_mean_unknown_in_every_kind_of_file() {
    for &(file, label, areas) in FORGOTTEN {
        let sections = read_sections(&corpus(file), &forgetful(label, false)).unwrap();
        assert_areas(file, &inspect(&sections).unwrap(), areas);
        assert!(sections.materials.iter().all(|material| material.id != label), "{file}");
        let edges = sections.sections.iter().flat_map(Section::edges);
        assert!(edges.into_iter().all(|edge| edge.left != edge.right), "{file}");
    }
}

#[test]
fn a_label_that_means_unknown_should_occur() {
    for file in ["organs.csl", "junction.contour", "loops.json"] {
        let sections = read_sections(&corpus(file), &forgetful(77, false)).unwrap();
        assert_eq!(sections.warnings.len(), 1);
        assert_says(&sections.warnings[0].what, &["label 77", "unknown", "does not occur"]);
        let error = failure(file, &forgetful(77, true));
        assert_says(&error, &[file, "label 77", "does not occur", "an error because warnings are"]);
    }
    // In one of several files is enough.
    let paths = [corpus("square.csl"), corpus("graph.json"), corpus("junction.contour")];
    assert!(read_all(&paths, &forgetful(3, true)).is_ok());
    let error = read_all(&paths, &forgetful(4, true)).map(|_| ()).unwrap_err().to_string();
    assert_says(&error, &["square.csl", "junction.contour", "label 4"]);
}

#[test]
fn inspection_tells_what_is_unknown() {
    let found = inspect(&read("loops.json")).unwrap();
    // A unit square within the frame of 8 × 6; and a plane of which nothing is known.
    let [frame, bare] = &found.unknown[..] else { panic!("{:?}", found.unknown) };
    assert_eq!((frame.section.as_str(), frame.area, frame.beyond), ("axial", Some(1.0), true));
    assert!((frame.share - 1.0 / 48.0).abs() < 1e-12);
    assert_eq!((bare.section.as_str(), bare.area, bare.share), ("2", None, 1.0));
    assert_says(&found.to_string(), &["unknown       on 2 sections", "2.1 %", "2: everything"]);
    assert!(inspect(&read("organs.csl")).unwrap().unknown.is_empty());
    // Half of the frame: the triangle's hypotenuse is the diagonal.
    let found = inspect(&read("graph.json")).unwrap();
    assert_eq!((found.unknown[0].area, found.unknown[0].share), (Some(2.0), 0.5));
}

/// Sections as JSON with a member more.
fn json_with(member: &str, offset: u32) -> Result<Sections> {
    let text = format!(
        r#"{{"transect": "sections", "version": 1, {member},
            "sections": [{{"normal": [0, 0, 1], "offset": {offset}, "background": 1}}]}}"#
    );
    json::read(&text, Path::new("up.json"), &Rules::default())
}

#[test]
fn json_keeps_what_is_up() {
    for (written, up) in [
        (r#""y""#, DVec3::Y),
        (r#""-z""#, DVec3::NEG_Z),
        ("[0, 1, 0]", DVec3::Y),
        ("[0.1, -3, 1e300]", DVec3::new(0.1, -3.0, 1e300)),
    ] {
        let sections = json_with(&format!(r#""up": {written}"#), 0).expect(written);
        assert_eq!(sections.up, Some(up), "{written}");
        let mut text = Vec::new();
        json::write(&sections, &mut text).expect("writing to memory");
        let text = String::from_utf8(text).expect("text");
        let again = json::read(&text, Path::new("b.json"), &Rules::default()).expect("sections");
        assert_eq!(again.up, Some(up), "{text}");
    }
    for written in [r#""up""#, r#""w""#, "[0, 0, 0]", "[0, 1]", "7", "true"] {
        let error = json_with(&format!(r#""up": {written}"#), 0).expect_err(written).to_string();
        assert!(error.starts_with("up.json") && error.contains("\"up\""), "{error}");
    }
    // null and nothing are the same.
    assert_eq!(json_with(r#""up": null"#, 0).expect("sections").up, None);
}

#[test]
fn files_read_together_agree_on_what_is_up() {
    let join = |[one, other]: [&str; 2]| {
        let parts = [json_with(one, 0), json_with(other, 1)];
        Sections::join(parts.map(|part| part.expect("sections")).to_vec(), &Rules::default())
    };
    let none = r#""frame": """#;
    for parts in [[r#""up": "y""#, r#""up": [0, 2, 0]"#], [none, r#""up": "y""#]] {
        assert_eq!(join(parts).expect("sections").up.map(|up| up.normalize()), Some(DVec3::Y));
    }
    let error = join([r#""up": "y""#, r#""up": "z""#]).expect_err("they differ").to_string();
    assert!(error.contains("\"up\""), "{error}");
}

#[test]
fn json_keeps_names_units_and_frame() {
    let sections = read("loops.json");
    assert_eq!((sections.units.as_str(), sections.frame.as_str()), ("mm", "LPS"));
    let names: Vec<(u32, &str)> =
        sections.materials.iter().map(|material| (material.id, material.name.as_str())).collect();
    assert_eq!(names, [(3, "liver"), (4, "label 4")]);
    assert_eq!(sections.materials[0].color, [0xaa, 0x33, 0x22]);
    let names: Vec<&str> = sections.sections.iter().map(Section::name).collect();
    assert_eq!(names, ["axial", "2"]);
    let backgrounds: Vec<Label> = sections.sections.iter().map(Section::background).collect();
    assert_eq!(backgrounds, [Label::UNKNOWN, Label::UNKNOWN]);
}

#[test]
fn several_files_are_one_set() {
    let paths = [corpus("square.csl"), corpus("loops.json")];
    let error = read_all(&paths, &Rules::default()).map(|_| ()).unwrap_err().to_string();
    // A square of label 1 against the liver, on the same plane z = 5.
    assert_says(&error, &["section loops.json:axial", "plane of section square.csl:1"]);
    let paths = [corpus("square.csl"), corpus("hole.csl"), corpus("graph.json")];
    let all = read_all(&paths, &Rules::default()).unwrap();
    let names: Vec<&str> = all.sections.iter().map(Section::name).collect();
    assert_eq!(names, ["square.csl:1", "hole.csl:1", "graph.json:1"]);
    assert_eq!(all.files, paths);
}

#[test]
fn csl_has_no_word_for_unknown() {
    let error = csl::write(&read("graph.json"), &mut Vec::new()).unwrap_err().to_string();
    assert_says(&error, &["section 1", "unknown", ".csl", ".json"]);
}

#[test]
fn a_failed_write_is_an_error() {
    let sections = read("square.csl");
    for write in [csl::write, json::write] {
        let error = write(&sections, &mut &mut [0_u8; 20][..]).unwrap_err().to_string();
        assert_says(&error, &["cannot be written"]);
    }
}

/// Planes, backgrounds and edges, in an order that does not depend on how the
/// graph is numbered.
fn graph(sections: &Sections) -> Vec<(String, Vec<String>)> {
    sections.sections.iter().map(|section| (plane(section), edges(section))).collect()
}

fn plane(section: &Section) -> String {
    format!("{:?} {}", section.plane(), section.background()).replace("-0.0", "0.0")
}

fn edges(section: &Section) -> Vec<String> {
    let vertices = section.vertices();
    let mut edges: Vec<String> = section
        .edges()
        .iter()
        .map(|edge| {
            let [start, end] = [edge.start, edge.end].map(|i| vertices[i as usize].to_array());
            if start < end {
                format!("{start:?} {end:?} {} {}", edge.left, edge.right)
            } else {
                format!("{end:?} {start:?} {} {}", edge.right, edge.left)
            }
        })
        .collect();
    edges.sort();
    edges
}

type Writer = fn(&Sections, &mut dyn std::io::Write) -> Result<()>;
type Reader = fn(&str, &Path, &Rules) -> Result<Sections>;

fn assert_round_trip(path: &Path, write: Writer, read: Reader) {
    let first = read_sections(path, &Rules::default()).unwrap();
    let mut bytes = Vec::new();
    write(&first, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let second = read(&text, path, &Rules { strict: true, ..Rules::default() }).unwrap();
    assert!(second.left_out.is_empty());
    assert!(graph(&first) == graph(&second), "{} changed on its way", path.display());
}

/// The loops of a `.csl` are numbered as they are traced, but JSON keeps all.
fn assert_stable(path: &Path) {
    let mut first = Vec::new();
    json::write(&read_sections(path, &Rules::default()).unwrap(), &mut first).unwrap();
    let text = String::from_utf8(first).unwrap();
    let mut second = Vec::new();
    json::write(&json::read(&text, path, &Rules::default()).unwrap(), &mut second).unwrap();
    assert!(text.as_bytes() == second, "{} is not written the same twice", path.display());
}

#[test]
fn what_is_written_reads_the_same() {
    for Good { file, areas, .. } in GOOD {
        assert_round_trip(&corpus(file), json::write, json::read);
        assert_stable(&corpus(file));
        if areas.iter().all(|&(id, _)| id != UNKNOWN) {
            assert_round_trip(&corpus(file), csl::write, csl::read);
        }
    }
}

/// Squares at heights 2, 4 and 6, as `.csl` with D of either sign.
fn stack_with(sign: i32, corner: u32) -> Result<Sections> {
    let mut text = "CSLC\n3 1\n".to_owned();
    for height in [2, 4, 6] {
        text += &format!("{height} 4 1 0 0 1 {}\n", sign * height);
        text += &format!("0 0 {height}\n1 0 {height}\n1 1 {height}\n0 {corner} {height}\n");
        text += "4 1 0 1 2 3\n";
    }
    csl::read(&text, Path::new("d.csl"), &Rules::default())
}

#[test]
fn the_sign_of_d_is_read_off_the_vertices() {
    let (expected, turned) = (stack_with(-1, 1).unwrap(), stack_with(1, 1).unwrap());
    assert_eq!(turned.sections, expected.sections);
    assert_eq!((expected.warnings.len(), turned.warnings.len()), (0, 1));
    assert_says(&turned.warnings[0].what, &["D has the other sign throughout"]);
}

#[test]
fn a_section_of_degenerate_contours_alone_is_left_out() {
    let section = |offset: u32, loops: &str| {
        format!(r#"{{"normal": [0, 0, 1], "offset": {offset}, "loops": [{loops}]}}"#)
    };
    let read = |loops: [&str; 3]| {
        let sections: Vec<String> = (0..3).map(|i| section(i, loops[i as usize])).collect();
        let text = format!(
            r#"{{"transect": "sections", "version": 1, "sections": [{}]}}"#,
            sections.join(", ")
        );
        json::read(&text, Path::new("d.json"), &Rules::default())
    };
    let triangle = |z: u32| format!(r#"{{"label": 1, "points": [[0,0,{z}],[1,0,{z}],[0,1,{z}]]}}"#);
    let flat = |z: u32| format!(r#"{{"label": 1, "points": [[0,0,{z}],[1,0,{z}],[0,0,{z}]]}}"#);
    let found = read([&triangle(0), &flat(1), ""]).unwrap();
    let names: Vec<&str> = found.sections.iter().map(Section::name).collect();
    // The last is empty because somebody says so.
    assert_eq!(names, ["1", "3"]);
    let told: Vec<(&str, bool)> = (found.left_out.iter())
        .map(|told| (told.section.as_str(), told.what.contains("the section is left out")))
        .collect();
    assert_eq!(told, [("2", false), ("2", true)]);
    let error = read([&flat(0), &flat(1), &flat(2)]).unwrap_err().to_string();
    assert_says(&error, &["d.json", "no contour of any section encloses an area"]);
}

/// Our own files and real ones: planes, vertices, loops and holes that they hold.
const DATA: &[(&str, [usize; 4])] = &[
    ("vessel.csl", [24, 1257, 37, 0]),
    ("bone.csl", [17, 1128, 32, 15]),
    ("organ.contour", [19, 1743, 0, 0]),
    ("knot.contour", [16, 1300, 0, 0]),
    ("csl/Abdomen.csl", [42, 32_682, 1_130, 484]),
    ("csl/Elephant.csl", [24, 10_429, 68, 1]),
    ("csl/Heart-25-even-better.csl", [25, 4_534, 33, 0]),
    ("csl/ParallelEight.csl", [20, 1_156, 28, 0]),
    ("csl/SideBishop.csl", [10, 1_376, 22, 0]),
    ("csl/Vetebrae.csl", [36, 14_815, 186, 36]),
    ("csl/eight_15.csl", [15, 2_028, 21, 0]),
    ("csl/eight_20.csl", [20, 3_178, 30, 0]),
    ("csl/hand_ok.csl", [15, 4_082, 29, 0]),
    ("contour/liver.contour", [5, 1_297, 0, 0]),
    ("contour/mousebrain.contour", [6, 1_874, 0, 0]),
    ("contour/mug.contour", [5, 1_083, 0, 0]),
    ("contour/ringc.contour", [4, 280, 0, 0]),
];

#[test]
fn whole_files_read_without_doubts() {
    let strict = Rules { strict: true, ..Rules::default() };
    for (name, [planes, vertices, loops, holes]) in DATA {
        let Some(path) = data(name) else { continue };
        let found = inspect(&read_sections(&path, &strict).unwrap()).unwrap();
        assert_eq!([found.sections, found.vertices], [*planes, *vertices], "{name}");
        if name.ends_with(".csl") {
            assert_eq!([found.loops, found.holes], [*loops, *holes], "{name}");
        }
        assert!(found.left_out.is_empty(), "{name}");
        assert!(found.to_string().contains(&format!("sections      {planes}")), "{name}");
    }
}

#[test]
fn whole_files_survive_a_round_trip() {
    for (name, _) in DATA {
        let Some(path) = data(name) else { continue };
        assert_round_trip(&path, json::write, json::read);
        assert_round_trip(&path, csl::write, csl::read);
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut random = Random::new(0x5eed_5eed_5eed_5eed);
    for Good { file, .. } in GOOD {
        let path = corpus(file);
        let bytes = std::fs::read(&path).unwrap();
        let readers: [(&str, Reader); 3] =
            [(".csl", csl::read), (".contour", transect::io::contour::read), (".json", json::read)];
        let (_, reader) = readers.iter().find(|(ending, _)| file.ends_with(ending)).unwrap();
        for _ in 0..400 {
            let text = damaged(&bytes, &mut random);
            if let Ok(sections) = reader(&text, &path, &Rules::default()) {
                assert!(inspect(&sections).is_ok(), "{text}");
            }
        }
    }
}

/// The text with one to four bytes replaced, dropped or doubled.
fn damaged(bytes: &[u8], random: &mut Random) -> String {
    const LIKELY: &[u8] = b"0123456789-.eh \n\"[]{},";
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let place = random.below(bytes.len());
        match random.below(3) {
            0 => bytes[place] = LIKELY[random.below(LIKELY.len())],
            1 => bytes[place] = bytes[random.below(bytes.len())],
            _ => bytes.insert(place, LIKELY[random.below(LIKELY.len())]),
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
