//! Sequences of tracked frames, as Plus and 3D Slicer write them.

mod common;
#[path = "common/program.rs"]
mod program;

use std::f64::consts::PI;
use std::fs;
use std::path::{Path, PathBuf};

use glam::{DMat4, DVec3};
use program::*;
use tempfile::TempDir;

use transect::io::metaimage::sequence_facts;
use transect::io::read_sections;
use transect::section::ImageRules;
use transect::{Bounds, Change, Context, Label, Model, Options, Resolution, Rules, Sections};

/// Pixels of a row, and rows.
const SIZE: [usize; 2] = [60, 52];
const COUNT: usize = 26;
const PIXEL: f64 = 0.5;
const CENTER: DVec3 = DVec3::new(40.0, -20.0, 65.0);
const RADIUS: f64 = 9.0;
/// These were not tracked, and their transforms lead elsewhere.
const LOST: [usize; 2] = [7, 19];

/// From the pixels of a frame to the world: a sweep that leans to and fro.
fn pose(number: usize) -> DMat4 {
    let part = number as f64 / (COUNT - 1) as f64;
    let lean =
        DMat4::from_axis_angle(DVec3::new(0.2, 1.0, 0.0).normalize(), 0.3 * (9.0 * part).sin());
    let at = CENTER + DVec3::new(0.3, -0.4, 22.0 * (part - 0.5));
    let middle = DVec3::new(SIZE[0] as f64, SIZE[1] as f64, 0.0) / 2.0;
    DMat4::from_translation(at)
        * lean
        * DMat4::from_scale(DVec3::splat(PIXEL))
        * DMat4::from_translation(-middle)
}

/// Where the probe's calibration puts pixels, and where the reference is as the tracker sees it.
fn calibration() -> DMat4 {
    DMat4::from_axis_angle(DVec3::ONE.normalize(), 1.1)
        * DMat4::from_scale(DVec3::splat(PIXEL))
        * DMat4::from_translation(DVec3::new(3.0, 4.0, 5.0))
}

fn reference(number: usize) -> DMat4 {
    DMat4::from_axis_angle(DVec3::Z, 0.1 * number as f64)
        * DMat4::from_translation(DVec3::new(100.0, number as f64, 7.0))
}

/// A ball whose upper half (by x) is another material.
fn ball(at: DVec3) -> u8 {
    let from = at - CENTER;
    match (from.length() < RADIUS, from.x > 0.0) {
        (false, _) => 0,
        (true, false) => 1,
        (true, true) => 2,
    }
}

fn words(matrix: &DMat4) -> String {
    let numbers = matrix.transpose().to_cols_array();
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// The sequence: what a header says besides, which way its pictures lie, and what pixels hold.
fn sequence(more: &str, orientation: &str, label: impl Fn(DVec3) -> u8) -> Vec<u8> {
    let letters: Vec<char> = orientation.chars().collect();
    let is_turned = "FN".contains(letters[0]);
    let size = if is_turned { [SIZE[1], SIZE[0]] } else { SIZE };
    let mut header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = False\nDimSize = {} {} {COUNT}\nElementSpacing = 7 7 7\nOffset = 1 2 3\n\
         TransformMatrix = 0 1 0 1 0 0 0 0 1\nElementType = MET_UCHAR\n\
         UltrasoundImageOrientation = {orientation}\n{more}",
        size[0], size[1]
    );
    let mut pixels = Vec::new();
    for number in 0..COUNT {
        let is_lost = LOST.contains(&number);
        let (own, reference) = (pose(number), reference(number));
        let probe =
            if is_lost { DMat4::IDENTITY } else { reference * own * calibration().inverse() };
        for (name, matrix, is_lost) in
            [("ProbeToTracker", probe, is_lost), ("ReferenceToTracker", reference, false)]
        {
            let status = if is_lost { "OUT_OF_VIEW" } else { "OK" };
            let begin = format!("Seq_Frame{number:04}_{name}Transform");
            header += &format!("{begin} = {}\n{begin}Status = {status}\n", words(&matrix));
        }
        header += &format!("Seq_Frame{number:04}_ImageStatus = OK\n");
        for j in 0..size[1] {
            for i in 0..size[0] {
                let mut at = [0.0; 2];
                for (letter, (index, count)) in letters.iter().zip([(i, size[0]), (j, size[1])]) {
                    let back = (count - 1 - index) as f64;
                    match letter {
                        'M' => at[0] = index as f64,
                        'U' => at[0] = back,
                        'F' => at[1] = index as f64,
                        _ => at[1] = back,
                    }
                }
                pixels.push(label(own.transform_point3(DVec3::new(at[0], at[1], 0.0))));
            }
        }
    }
    header += "ElementDataFile = LOCAL\n";
    [header.as_bytes(), &pixels].concat()
}

fn calibrated() -> String {
    format!("ImageToProbeTransform = {}\n", words(&calibration()))
}

fn write(folder: &TempDir, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join("sweep.igs.mha");
    fs::write(&path, bytes).expect("a file");
    path
}

fn read(path: &Path) -> Sections {
    read_sections(path, &Rules::default()).expect("sections")
}

#[test]
fn a_ball_comes_back_from_a_tilted_sweep_with_its_volume_and_place() {
    let folder = folder();
    let path = write(&folder, &sequence(&calibrated(), "MF", ball));
    let sections = read(&path);
    assert_eq!((sections.frame.as_str(), sections.units.as_str()), ("Reference", "mm"));
    assert!(sections.warnings.is_empty(), "{:?}", sections.warnings);
    assert!(
        sections.left_out[0].what.starts_with("2 frames are not OK"),
        "{:?}",
        sections.left_out
    );
    let note = &sections.notes[0].what;
    assert!(note.contains("Image → Probe → Tracker → Reference"), "{note}");
    assert!(note.contains("26 frames, 24 of them OK"), "{note}");
    let names: Vec<&str> = sections.sections.iter().map(|section| section.name()).collect();
    assert!(names.contains(&"frame 8") && !names.contains(&"frame 7"), "{names:?}");
    for section in &sections.sections {
        assert_eq!(section.background(), Label::UNKNOWN, "{}", section.name());
    }
    let options = Options { resolution: Resolution::Voxels(64), ..Options::default() };
    let (mut model, mut context) = (Model::new(options), Context::default());
    model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
    let check = model.check(&mut context).expect("it can be checked");
    assert!(check.is_sound());
    let half = 2.0 / 3.0 * PI * RADIUS.powi(3);
    for (label, id) in check.labels.iter().zip(1..) {
        let ratio = label.facts.volume / half;
        assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
        let mesh = &model.derived().expect("a surface").mesh;
        let surface = mesh.surface(Label(id));
        let corners = surface.triangles.iter().flatten().map(|&at| surface.vertices[at as usize]);
        let bounds = Bounds::around(corners).expect("a surface");
        let side = if id == 1 { -0.5 } else { 0.5 };
        let off = (bounds.middle() - CENTER - DVec3::new(side * RADIUS, 0.0, 0.0)).abs();
        assert!(off.max_element() < 0.4, "label {id} is off by {off}");
    }
}

#[test]
fn letters_say_which_way_pictures_lie() {
    let folder = folder();
    let own =
        read(&write(&folder, &sequence(&calibrated(), "MF", ball))).bounds().expect("contours");
    for orientation in ["UF", "MN", "UN", "UNA", "FM", "NU"] {
        let path = write(&folder, &sequence(&calibrated(), orientation, ball));
        let bounds = read(&path).bounds().expect("contours");
        let off = (bounds.min - own.min).abs().max((bounds.max - own.max).abs());
        assert!(off.max_element() < 1e-9, "{orientation}: {off}");
    }
    for wrong in ["FF", "MX", "AMF"] {
        let bytes = sequence(&calibrated(), "MF", ball);
        let text =
            String::from_utf8_lossy(&bytes[..1000]).replace("ion = MF", &format!("ion = {wrong}"));
        let end = sequence(&calibrated(), "MF", ball)
            .windows(8)
            .position(|at| at == b"ion = MF")
            .expect("it is there");
        let bytes = [&text.as_bytes()[..end + 6 + wrong.len()], &bytes[end + 8..]].concat();
        let refused =
            run(transect().arg("reconstruct").arg(write(&folder, &bytes)).args(["-o", "a.ply"]));
        assert_refused(&refused, &["UltrasoundImageOrientation", wrong]);
    }
}

#[test]
fn what_goes_on_beyond_a_frame_is_cut_there_without_a_word() {
    let folder = folder();
    // Beyond a plane that crosses all frames.
    let path = write(&folder, &sequence(&calibrated(), "MF", |at| u8::from(at.x < CENTER.x)));
    let sections = read(&path);
    assert!(sections.warnings.is_empty(), "{:?}", sections.warnings);
    let whole = SIZE[0] as f64 * SIZE[1] as f64 * PIXEL * PIXEL;
    for section in &sections.sections {
        let regions = section.regions().expect("regions");
        let of = |label: Label| -> f64 {
            regions.iter().filter(|own| own.label == label).map(|own| own.area).sum()
        };
        let known = of(Label(1)) + of(Label::OUTSIDE);
        assert!((known / whole - 1.0).abs() < 1e-6, "{}: {known} of {whole}", section.name());
        let number: usize = section.name()["frame ".len()..].parse().expect("a number");
        // The line runs through the middle, but for how far the frame is off.
        let middle = pose(number).transform_point3(DVec3::new(29.5, 25.5, 0.0)).x - CENTER.x;
        let cos = pose(number).transform_vector3(DVec3::X).normalize().x;
        let expected = whole / 2.0 - middle / cos * SIZE[1] as f64 * PIXEL;
        assert!(
            (of(Label(1)) - expected).abs() < 0.02 * whole,
            "{}: {} {expected}",
            section.name(),
            of(Label(1))
        );
    }
}

#[test]
fn what_a_sequence_lacks_is_said_and_inspected() {
    let folder = folder();
    let path = write(&folder, &sequence("", "MF", ball));
    let target = folder.path().join("a.ply");
    let refused = run(transect().arg("reconstruct").arg(&path).arg("-o").arg(&target));
    assert_refused(&refused, &["sweep.igs.mha", "ProbeToTracker", "ImageToProbe is missing"]);
    let inspected = run(transect().arg("inspect").arg(&path));
    assert_done(&inspected);
    let text = String::from_utf8_lossy(&inspected.stdout);
    for words in [
        "26, 24 of them OK",
        "ProbeToTracker, OK in 24",
        "ReferenceToTracker, OK in 26",
        "sections      none",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let path = write(
        &folder,
        &sequence(&calibrated(), "MF", |at| (at.x * 77.0 + at.y * 3.0) as i64 as u8),
    );
    let refused = run(transect().arg("reconstruct").arg(&path).arg("-o").arg(&target));
    assert_refused(&refused, &["it holds no labels", "24 of its 26 frames are OK"]);
    let still = format!(
        "ImageToProbeTransform = {}\nProbeToReferenceTransform = {}\n",
        words(&calibration()),
        words(&DMat4::IDENTITY)
    );
    let refused = run(transect()
        .arg("reconstruct")
        .arg(write(&folder, &sequence(&still, "MF", ball)))
        .arg("-o")
        .arg(&target));
    assert_refused(&refused, &["lie in one place in Reference"]);
    let sliced = run(transect()
        .arg("slice")
        .arg(&path)
        .args(["--axis", "z", "--count", "3", "-o"])
        .arg(folder.path().join("a.csl")));
    assert_refused(&sliced, &["tracked frames"]);
    let axis = run(transect()
        .arg("inspect")
        .arg("--axis")
        .arg("k")
        .arg(write(&folder, &sequence(&calibrated(), "MF", ball))));
    assert_done(&axis);
    assert!(String::from_utf8_lossy(&axis.stdout).contains("an axis is chosen for volumes"));
}

#[test]
fn every_so_many_th_frame_is_taken_and_json_tells_the_chain() {
    let folder = folder();
    let path = write(&folder, &sequence(&calibrated(), "MF", ball));
    let all = read(&path).sections.len();
    let images = ImageRules { every: 3, ..Default::default() };
    let some = read_sections(&path, &Rules { images, ..Rules::default() }).expect("sections");
    assert_eq!(some.sections.len(), all.div_ceil(3));
    let inspected = run(transect().args(["inspect", "--json"]).arg(&path));
    assert_done(&inspected);
    let told: serde_json::Value = serde_json::from_slice(&inspected.stdout).expect("JSON");
    let chain = ["Image", "Probe", "Tracker", "Reference"];
    assert_eq!(told["sequences"][0]["chain"], serde_json::json!(chain));
    assert_eq!(told["sections"], all);
}

#[test]
fn a_recorded_sweep_of_greys_is_told_but_not_reconstructed() {
    let Some(path) = common::data("ultrasound/SpinePhantomFreehand.igs.mha") else { return };
    let facts = sequence_facts(&path).expect("it can be read").expect("a sequence");
    assert_eq!((facts.size, facts.frames, facts.orientation.as_str()), ([820, 616], 21, "MFA"));
    let names: Vec<&str> = facts.transforms.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["ProbeToTracker", "ReferenceToTracker", "StylusToTracker"]);
    assert!(
        facts.missing.expect("nothing leads from its pixels").contains("ImageToProbe is missing")
    );
    let folder = folder();
    let refused =
        run(transect().arg("reconstruct").arg(&path).arg("-o").arg(folder.path().join("a.ply")));
    let words = format!("{} of its 21 frames are OK", facts.ok);
    assert_refused(&refused, &["it holds no labels", &words]);
}
