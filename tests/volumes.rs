//! Volumes of labels, cut into sections and reconstructed.

mod common;

use std::f64::consts::PI;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use flate2::Compression;
use flate2::write::GzEncoder;
use glam::{DMat3, DVec3};
use tempfile::TempDir;

use transect::io::volume::read_volume;
use transect::label::Label;
use transect::plane::Plane;
use transect::section::Section;
use transect::slice::{Family, slice_volume};

const DIMS: [usize; 3] = [48, 44, 40];
const CENTER: DVec3 = DVec3::new(3.0, -2.0, 7.0);
const RADIUS: f64 = 9.0;

/// A ball whose upper half (by x) is another material.
fn ball(point: DVec3) -> u8 {
    let from = point - CENTER;
    match (from.length() < RADIUS, from.x > 0.0) {
        (false, _) => 0,
        (true, false) => 1,
        (true, true) => 2,
    }
}

/// Where voxels are: the ball is in the middle.
fn placement(steps: DMat3) -> (DVec3, DMat3) {
    let middle = DVec3::from(DIMS.map(|dim| (dim - 1) as f64 / 2.0));
    (CENTER - steps * middle, steps)
}

fn voxels(origin: DVec3, steps: DMat3) -> Vec<u8> {
    let [x, y, z] = DIMS;
    let mut voxels = Vec::with_capacity(x * y * z);
    for k in 0..z {
        for j in 0..y {
            let row = (0..x).map(|i| DVec3::from([i, j, k].map(|index| index as f64)));
            voxels.extend(row.map(|index| ball(origin + steps * index)));
        }
    }
    voxels
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("memory");
    encoder.finish().expect("memory")
}

fn nrrd(steps: DMat3, encoding: &str) -> Vec<u8> {
    let (origin, steps) = placement(steps);
    let vector = |v: DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let [x, y, z] = DIMS;
    let header = format!(
        "NRRD0005\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: {x} {y} {z}\n\
         space directions: {} {} {}\nspace origin: {}\nencoding: {encoding}\n\n",
        vector(steps.x_axis),
        vector(steps.y_axis),
        vector(steps.z_axis),
        vector(origin)
    );
    let voxels = voxels(origin, steps);
    let data = if encoding == "gzip" { gzip(&voxels) } else { voxels };
    [header.into_bytes(), data].concat()
}

fn metaimage(steps: DMat3) -> Vec<u8> {
    let (origin, steps) = placement(steps);
    let spacing = [0, 1, 2].map(|axis| steps.col(axis).length());
    let words = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let rows = [0, 1, 2].map(|axis| words(&(steps.col(axis) / spacing[axis]).to_array()));
    let [x, y, z] = DIMS;
    let header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = False\nTransformMatrix = {}\nOffset = {}\nElementSpacing = {}\n\
         DimSize = {x} {y} {z}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        rows.join(" "),
        words(&origin.to_array()),
        words(&spacing)
    );
    [header.into_bytes(), voxels(origin, steps)].concat()
}

fn nifti(steps: DMat3) -> Vec<u8> {
    let (origin, steps) = placement(steps);
    let mut bytes = vec![0u8; 352];
    let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
    let [x, y, z] = DIMS.map(|dim| dim as i16);
    put(0, &348i32.to_le_bytes());
    put(40, [3, x, y, z, 1, 1, 1, 1].map(i16::to_le_bytes).as_flattened());
    put(70, [2i16, 8].map(i16::to_le_bytes).as_flattened());
    put(76, [1.0f32; 4].map(f32::to_le_bytes).as_flattened());
    put(108, &352f32.to_le_bytes());
    put(123, &[2]);
    put(254, &1i16.to_le_bytes());
    for row in 0..3 {
        let numbers = [steps.x_axis[row], steps.y_axis[row], steps.z_axis[row], origin[row]];
        put(280 + 16 * row, numbers.map(|number| (number as f32).to_le_bytes()).as_flattened());
    }
    put(344, b"n+1\0");
    bytes.extend(voxels(origin, steps));
    gzip(&bytes)
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    path
}

fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

/// The area of a label on a section, by the shoelace formula.
fn area(section: &Section, label: u32) -> f64 {
    let normal = section.plane().unit_normal();
    let swept = |start: u32, end: u32| {
        (section.point(start) - CENTER).cross(section.point(end) - CENTER).dot(normal) / 2.0
    };
    let edges = section.edges().iter();
    edges
        .map(|edge| match Label(label) {
            own if edge.left == own => swept(edge.start, edge.end),
            own if edge.right == own => swept(edge.end, edge.start),
            _ => 0.0,
        })
        .sum()
}

fn cut(path: &Path, family: &Family) -> Vec<(Plane, Section)> {
    let volume = read_volume(path).expect("a volume");
    let planes = family.planes(&volume.bounds().expect("materials")).expect("planes");
    let sections = slice_volume(&volume, &planes).expect("sections");
    planes.into_iter().zip(sections).collect()
}

/// Both materials together are a disc on every plane.
fn assert_discs(path: &Path, family: &Family) {
    let mut measured = 0;
    for (plane, section) in cut(path, family) {
        let gap = plane.distance(CENTER);
        let exact = PI * (RADIUS * RADIUS - gap * gap);
        // A disc near the pole changes with a part of a voxel.
        if gap.abs() < 0.8 * RADIUS {
            let ratio = (area(&section, 1) + area(&section, 2)) / exact;
            assert!((ratio - 1.0).abs() < 0.015, "{}: {plane:?} {ratio}", path.display());
            measured += 1;
        }
    }
    assert!(measured > 5);
}

/// Spacings 0.5, 0.55 and 0.6 along axes turned by this.
fn steps(turn: DMat3) -> DMat3 {
    turn * DMat3::from_diagonal(DVec3::new(0.5, 0.55, 0.6))
}

#[test]
fn discs_of_a_ball_have_their_area_in_every_format_and_direction() {
    let folder = folder();
    let tilted = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let mirrored = tilted * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    for (number, turn) in [DMat3::IDENTITY, tilted, mirrored].into_iter().enumerate() {
        let steps = steps(turn);
        let files = [
            write(&folder, &format!("{number}.nrrd"), &nrrd(steps, "raw")),
            write(&folder, &format!("{number}gz.nrrd"), &nrrd(steps, "gzip")),
            write(&folder, &format!("{number}.nii.gz"), &nifti(steps)),
            write(&folder, &format!("{number}.mha"), &metaimage(steps)),
        ];
        for file in &files {
            assert_discs(file, &Family::Axis { axis: 2, count: 10 });
            assert_discs(file, &Family::Random { count: 20, seed: 5 });
        }
    }
}

#[test]
fn the_order_of_the_axes_and_their_signs_change_nothing() {
    let folder = folder();
    let upright = DMat3::from_diagonal(DVec3::new(0.5, 0.5, 0.5));
    // The first axis runs down, the second along −x, the third along y.
    let turned = DMat3::from_cols(DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y) * 0.5;
    // A lattice of the same places: the ball is half a step off in none.
    let one = write(&folder, "a.nrrd", &nrrd(upright, "raw"));
    let other = write(&folder, "b.nrrd", &nrrd(turned, "raw"));
    let planes = Family::Random { count: 12, seed: 8 };
    for ((_, one), (_, other)) in cut(&one, &planes).iter().zip(&cut(&other, &planes)) {
        for label in [1, 2] {
            let [a, b] = [one, other].map(|section| area(section, label));
            assert!((a - b).abs() < 1e-6 * (1.0 + a), "{a} {b}");
        }
    }
}

#[test]
fn two_materials_share_the_disc_and_meet_in_junctions() {
    let folder = folder();
    let path = write(&folder, "a.nrrd", &nrrd(steps(DMat3::IDENTITY), "raw"));
    let plane = Plane { normal: DVec3::new(0.0, 0.6, 0.8), offset: 4.4 };
    // 0.6 · −2 + 0.8 · 7 = 4.4: through the centre.
    let (_, section) = cut(&path, &Family::Given(vec![plane])).remove(0);
    let half = PI * RADIUS * RADIUS / 2.0;
    for label in [1, 2] {
        let ratio = area(&section, label) / half;
        assert!((ratio - 1.0).abs() < 0.02, "{label}: {ratio}");
    }
    let junctions = (0..section.vertices().len() as u32).filter(|&vertex| {
        let ends = section.edges().iter().filter(|edge| [edge.start, edge.end].contains(&vertex));
        ends.count() == 3
    });
    assert_eq!(junctions.count(), 2);
    assert_eq!(section.labels(), [Label::OUTSIDE, Label(1), Label(2)]);
}

#[test]
fn all_labels_of_sparse_slices_come_back() {
    assert_all_labels("knot.nrrd", 3);
    assert_all_labels("labels/SevenLabels.nrrd", 7);
}

fn assert_all_labels(name: &str, last: u32) {
    let Some(path) = common::data(name) else { return };
    let volume = read_volume(&path).expect("a volume");
    assert_eq!(volume.labels(), (1..=last).map(Label).collect::<Vec<_>>());
    assert_eq!(volume.frame, "LPS");
    let sections = cut(&path, &Family::Axis { axis: 2, count: 16 });
    let mut found: Vec<Label> = sections.iter().flat_map(|(_, section)| section.labels()).collect();
    found.sort();
    found.dedup();
    assert_eq!(found[1..], volume.labels());
}

fn transect(arguments: &[&str], paths: &[&Path]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_transect"));
    command.args(arguments).args(paths).output().expect("the program runs")
}

fn error(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn a_volume_comes_back_from_fifteen_planes() {
    let folder = folder();
    let volume = write(&folder, "a.nii.gz", &nifti(steps(DMat3::IDENTITY)));
    let [cuts, report] = ["cuts.json", "report.json"].map(|name| folder.path().join(name));
    let cut = transect(&["slice", "--random", "15", "--seed", "2", "-o"], &[&cuts, &volume]);
    assert!(cut.status.success(), "{cut:?}");
    let text = std::fs::read_to_string(&cuts).expect("sections");
    assert!(text.contains("\"frame\": \"RAS\"") && text.contains("\"units\": \"mm\""));
    let surface = folder.path().join("a.ply");
    let arguments = ["reconstruct", "--resolution", "48", "--device", "cpu", "-o"];
    let done = Command::new(env!("CARGO_BIN_EXE_transect"))
        .args(arguments)
        .arg(&surface)
        .arg("--report")
        .args([&report, &cuts])
        .output()
        .expect("the program runs");
    assert!(done.status.success(), "{done:?}");
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&report).expect("a report")).expect("JSON");
    let half = 2.0 / 3.0 * PI * RADIUS.powi(3);
    for label in report["check"]["labels"].as_array().expect("labels") {
        let ratio = label["volume"].as_f64().expect("a volume") / half;
        assert!((ratio - 1.0).abs() < 0.05, "{ratio}");
    }
}

#[test]
fn volumes_that_cannot_be_cut_are_refused_by_name_and_nothing_is_written() {
    let folder = folder();
    let good = nrrd(steps(DMat3::IDENTITY), "raw");
    let header = good.len() - DIMS.iter().product::<usize>();
    let empty = [&good[..header], &vec![0; good.len() - header][..]].concat();
    let cases: [(&str, &[u8], &str); 5] = [
        ("empty.nrrd", b"", "empty"),
        ("outside.nrrd", &empty, "no label but 0"),
        ("cut.nrrd", &good[..good.len() - 100], "truncated"),
        ("text.nii.gz", b"nothing", "NIfTI-1"),
        ("a.mha", b"1", "no MetaImage"),
    ];
    let cuts = folder.path().join("cuts.json");
    for (name, bytes, words) in cases {
        let path = write(&folder, name, bytes);
        let text =
            error(&transect(&["slice", "--axis", "z", "--count", "3", "-o"], &[&cuts, &path]));
        assert!(text.contains(name) && text.contains(words), "{text}");
        assert!(!cuts.exists());
    }
}

#[test]
fn the_same_cuts_come_out_for_any_number_of_threads() {
    let folder = folder();
    let volume = write(&folder, "a.nrrd", &nrrd(steps(DMat3::IDENTITY), "gzip"));
    let cuts = |threads: &str| {
        let path = folder.path().join(format!("{threads}.json"));
        let mut command = Command::new(env!("CARGO_BIN_EXE_transect"));
        command.env("RAYON_NUM_THREADS", threads).args(["slice", "--random", "9", "-o"]);
        let output = command.arg(&path).arg(&volume).output().expect("the program runs");
        assert!(output.status.success(), "{output:?}");
        std::fs::read(path).expect("sections")
    };
    assert!(cuts("1") == cuts("4"));
}

/// An image of greys is no volume of labels, whatever its numbers are; many labels are.
#[test]
fn grey_volumes_are_refused() {
    let folder = folder();
    let header = "NRRD0004\ntype: uint16\ndimension: 3\nsizes: 40 40 12\nspace dimension: 3\n\
                  space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\n\
                  endian: little\nencoding: raw\n\n";
    let read = |name: &str, value: &dyn Fn(usize) -> u16| {
        let numbers = (0..40 * 40 * 12).flat_map(|at| value(at).to_le_bytes());
        let bytes: Vec<u8> = header.bytes().chain(numbers).collect();
        let path = write(&folder, name, &bytes);
        transect::io::read_sections(&path, &transect::Rules::default())
    };
    // A smooth bump with noise, as a scanner sees it.
    let grey = |at: usize| {
        let [x, y] = [at % 40, at / 40 % 40].map(|index| index as f64 - 19.5);
        let noise = (at * 7919 % 101) as f64;
        (1000.0 * (-(x * x + y * y) / 100.0).exp() + noise) as u16
    };
    let error = read("grey.nrrd", &grey).unwrap_err().to_string();
    assert!(error.contains("grey volume") && error.contains("segment it first"), "{error}");
    // A hundred labels of 4 × 4 pixels.
    let atlas = |at: usize| (1 + at % 40 / 4 + 10 * (at / 40 % 40 / 4)) as u16;
    let sections = read("atlas.nrrd", &atlas).expect("labels");
    assert_eq!(sections.materials.len(), 100);
}
