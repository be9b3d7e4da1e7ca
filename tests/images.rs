//! Sections from pictures and from volumes of labels.

#[path = "common/program.rs"]
mod program;

use std::f64::consts::PI;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use glam::DVec3;
use png::{BitDepth, ColorType};
use program::*;
use tempfile::TempDir;
use tiff::encoder::{TiffEncoder, colortype};

use transect::io::{read_all, read_sections};
use transect::section::{ImageRules, Spacing, VolumeAxis};
use transect::{Change, Context, Label, Model, Options, Resolution, Rules, Sections};

const SIZE: [usize; 3] = [48, 44, 40];
const SPACING: [f64; 3] = [0.5, 0.6, 0.5];
const RADIUS: f64 = 9.0;

fn center() -> DVec3 {
    DVec3::from([0, 1, 2].map(|axis| SPACING[axis] * (SIZE[axis] as f64 / 2.0 - 0.3)))
}

/// A ball whose upper half (by x) is another material.
fn ball(voxel: [usize; 3]) -> u8 {
    let at = DVec3::from([0, 1, 2].map(|axis| SPACING[axis] * voxel[axis] as f64));
    let from = at - center();
    match (from.length() < RADIUS, from.x > 0.0) {
        (false, _) => 0,
        (true, false) => 1,
        (true, true) => 2,
    }
}

/// The pixels of slice k.
fn slice(k: usize) -> Vec<u8> {
    let [width, height, _] = SIZE;
    (0..width * height).map(|pixel| ball([pixel % width, pixel / width, k])).collect()
}

fn picture_size() -> [u32; 2] {
    [SIZE[0] as u32, SIZE[1] as u32]
}

/// A PNG; `palette` is three bytes a colour.
fn png(size: [u32; 2], kind: (ColorType, BitDepth), palette: &[u8], data: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(kind.0);
    encoder.set_depth(kind.1);
    if !palette.is_empty() {
        encoder.set_palette(palette.to_vec());
    }
    let mut writer = encoder.write_header().expect("memory");
    writer.write_image_data(data).expect("memory");
    writer.finish().expect("memory");
    bytes
}

const GREY: (ColorType, BitDepth) = (ColorType::Grayscale, BitDepth::Eight);

fn grey(data: &[u8]) -> Vec<u8> {
    png(picture_size(), GREY, &[], data)
}

fn write(folder: &TempDir, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.path().join(name);
    fs::write(&path, bytes).expect("a file");
    path
}

/// Every fourth slice of the ball, numbered so.
fn stack(change: impl Fn(Vec<u8>) -> Vec<u8>) -> TempDir {
    let folder = folder();
    for k in (2..SIZE[2]).step_by(4) {
        write(&folder, &format!("ball_{k}.png"), &grey(&change(slice(k))));
    }
    folder
}

/// With slices four voxels apart.
fn rules() -> Rules {
    let [x, y, z] = SPACING;
    let images = ImageRules { spacing: Some(Spacing::All([x, y, 4.0 * z])), ..Default::default() };
    Rules { images, ..Rules::default() }
}

fn read(path: &Path, rules: &Rules) -> Sections {
    read_sections(path, rules).expect("sections")
}

/// The volume of every label.
fn volumes(sections: Sections) -> Vec<f64> {
    let options = Options { resolution: Resolution::Voxels(48), ..Options::default() };
    let (mut model, mut context) = (Model::new(options), Context::default());
    model.apply(Change::Add(sections), &mut context).expect("it reconstructs");
    let check = model.check(&mut context).expect("it can be checked");
    assert!(check.is_sound());
    check.labels.iter().map(|label| label.facts.volume).collect()
}

/// The ball and both its halves, within parts of their volume. Where they meet is known to half a
/// pixel, which is 2 % of a half.
fn assert_ball(sections: Sections, [whole, halves]: [f64; 2]) {
    let volumes = volumes(sections);
    let half = 2.0 / 3.0 * PI * RADIUS.powi(3);
    assert_eq!(volumes.len(), 2);
    let is_near = |volume: f64, right: f64, part: f64| (volume / right - 1.0).abs() < part;
    assert!(is_near(volumes.iter().sum(), 2.0 * half, whole), "{volumes:?}, twice {half}");
    assert!(volumes.iter().all(|&own| is_near(own, half, halves)), "{volumes:?}, twice {half}");
}

fn names(sections: &Sections) -> Vec<&str> {
    sections.sections.iter().map(|section| section.name()).collect()
}

#[test]
fn a_folder_of_pictures_is_a_stack() {
    let folder = stack(|pixels| pixels);
    let sections = read(folder.path(), &rules());
    assert_eq!(names(&sections)[..3], ["ball_2.png", "ball_6.png", "ball_10.png"]);
    assert_eq!(sections.sections[1].plane().offset, 4.0 * SPACING[2]);
    assert!(sections.warnings.is_empty() && sections.left_out.is_empty());
    let note = &sections.notes[0].what;
    assert!(note.contains("numbered 2 to 38 by 4") && note.contains("2 labels"), "{note}");
    let bounds = sections.bounds().expect("contours");
    // The first of the pictures is on z = 0, which is slice 2 of the ball.
    let middle = center() - DVec3::Z * 2.0 * SPACING[2];
    let reach = (bounds.max - middle).max(middle - bounds.min);
    assert!((reach.truncate() - RADIUS).abs().max_element() < 0.3, "{reach}");
    assert_ball(sections, [0.03, 0.05]);
}

#[test]
fn pages_and_files_that_are_named_are_the_same_stack() {
    let folder = stack(|pixels| pixels);
    let expected = read(folder.path(), &rules());
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes).expect("memory");
    for k in (2..SIZE[2]).step_by(4) {
        let [width, height] = picture_size();
        encoder.write_image::<colortype::Gray8>(width, height, &slice(k)).expect("memory");
    }
    let pages = self::folder();
    let path = write(&pages, "ball.TIF", bytes.get_ref());
    let found = read(&path, &rules());
    assert_eq!(names(&found)[0], "ball.TIF, page 1");
    let named: Vec<PathBuf> =
        entries(folder.path()).iter().rev().map(|name| folder.path().join(name)).collect();
    let named = read_all(&named, &rules()).expect("sections");
    assert_eq!(names(&named), names(&expected));
    for sections in [found, named] {
        for (one, other) in sections.sections.iter().zip(&expected.sections) {
            assert_eq!((one.plane(), one.vertices()), (other.plane(), other.vertices()));
            assert_eq!(one.edges(), other.edges());
        }
    }
}

#[test]
fn white_is_a_label_and_palettes_are_colours() {
    let mask = stack(|pixels| pixels.into_iter().map(|label| 255 * label.min(1)).collect());
    let sections = read(mask.path(), &rules());
    assert!(sections.notes[0].what.contains("white (255) is label 1"));
    assert_eq!(sections.materials.iter().map(|one| one.id).collect::<Vec<_>>(), [1]);
    // Where white means unknown, it is no mask.
    let unknown = Rules { unknown: Some(Label(255)), ..rules() };
    let sections = read(mask.path(), &unknown);
    assert!(sections.sections[0].is_partial() && sections.materials.is_empty());

    let folder = folder();
    let palette = [[0; 3], [200, 10, 20], [1, 2, 3]].concat();
    let bits: Vec<u8> = slice(20)
        .chunks(SIZE[0])
        .flat_map(|row| row.chunks(4))
        .map(|four| four.iter().fold(0, |bits, label| bits << 2 | label))
        .collect();
    let indexed = png(picture_size(), (ColorType::Indexed, BitDepth::Two), &palette, &bits);
    write(&folder, "a.png", &indexed);
    let sections = read(folder.path(), &rules());
    assert_eq!(sections.materials[0].color, [200, 10, 20]);
    assert_eq!(sections.materials[1].color, [1, 2, 3]);

    let wide: Vec<u8> =
        slice(20).iter().flat_map(|&label| (1000 * u16::from(label)).to_be_bytes()).collect();
    let wide = png(picture_size(), (ColorType::Grayscale, BitDepth::Sixteen), &[], &wide);
    write(&folder, "a.png", &wide);
    let sections = read(folder.path(), &rules());
    assert_eq!(sections.materials.iter().map(|one| one.id).collect::<Vec<_>>(), [1000, 2000]);
}

#[test]
fn missing_and_empty_pictures_are_unknown() {
    let folder = stack(|pixels| pixels);
    fs::remove_file(folder.path().join("ball_18.png")).expect("it exists");
    let sections = read(folder.path(), &rules());
    assert!(sections.warnings[0].what.contains("number 18 is missing"));
    let offsets: Vec<f64> = sections.sections.iter().map(|one| one.plane().offset).collect();
    assert_eq!(offsets[..5], [0.0, 2.0, 4.0, 6.0, 10.0]);
    let strict = Rules { strict: true, ..rules() };
    let error = read_sections(folder.path(), &strict).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("number 18"), "{error}");

    for k in 0..SIZE[2] {
        let pixels = if k % 4 == 2 { slice(k) } else { vec![0; SIZE[0] * SIZE[1]] };
        write(&folder, &format!("ball_{k}.png"), &grey(&pixels));
    }
    let images = ImageRules { spacing: Some(Spacing::All(SPACING)), ..Default::default() };
    let sections = read(folder.path(), &Rules { images, ..Rules::default() });
    assert_eq!(sections.sections.len(), 9);
    assert!(sections.notes[0].what.contains("empty ones show is unknown"));
    assert_ball(sections, [0.03, 0.05]);
}

/// An NRRD of what is drawn of the ball.
fn nrrd(is_drawn: impl Fn([usize; 3]) -> bool) -> Vec<u8> {
    let ([x, y, z], [dx, dy, dz]) = (SIZE, SPACING);
    let header = format!(
        "NRRD0005\ntype: uint8\ndimension: 3\nspace: RAS\nsizes: {x} {y} {z}\n\
         space directions: ({dx},0,0) (0,{dy},0) (0,0,{dz})\nspace origin: (0,0,0)\n\
         encoding: raw\nSegment0_ID:=s\nSegment0_LabelValue:=1\nSegment0_Name:=left\n\n"
    );
    let voxel = |index: usize| [index % x, index / x % y, index / (x * y)];
    let voxels = (0..x * y * z).map(voxel);
    let voxels = voxels.map(|voxel| if is_drawn(voxel) { ball(voxel) } else { 0 });
    header.into_bytes().into_iter().chain(voxels).collect()
}

#[test]
fn volumes_that_are_drawn_on_slices_are_read_there() {
    let folder = folder();
    for (axis, name) in ["i", "j", "k"].into_iter().enumerate() {
        let path = write(&folder, "ball.nrrd", &nrrd(|voxel| voxel[axis] % 5 == 3));
        let sections = read(&path, &Rules::default());
        assert!(names(&sections).iter().all(|found| found.starts_with(name)));
        let note = &sections.notes[0].what;
        assert!(note.contains(&format!("drawn on slices {name} =")), "{note}");
        assert_eq!((sections.frame.as_str(), sections.materials[0].name.as_str()), ("RAS", "left"));
        let bounds = sections.bounds().expect("contours");
        let middle = (bounds.min + bounds.max) / 2.0;
        let mut off = (middle - center()).abs();
        off[axis] = 0.0;
        assert!(off.max_element() < 0.3, "{off}");
        // Nobody drew where the halves meet when slices lie along that.
        assert_ball(sections, [0.05, if axis == 0 { 0.2 } else { 0.06 }]);
    }
}

#[test]
fn a_volume_that_is_drawn_on_two_axes_gives_sections_on_both() {
    let folder = folder();
    let path = write(&folder, "ball.nrrd", &nrrd(|[i, _, k]| i % 8 == 4 || k % 8 == 4));
    let sections = read(&path, &Rules::default());
    let count = |axis: &str| names(&sections).iter().filter(|name| name.starts_with(axis)).count();
    assert_eq!([count("i"), count("j"), count("k")], [4, 0, 5]);
    assert!(sections.warnings.is_empty(), "{:?}", sections.warnings);
    assert_ball(sections, [0.05, 0.06]);
    let images = ImageRules { axis: Some(VolumeAxis::World(2)), ..Default::default() };
    let sections = read(&path, &Rules { images, ..Rules::default() });
    assert_eq!(sections.sections.len(), 5);
}

#[test]
fn a_full_volume_gives_every_slice_or_every_so_many_th() {
    let folder = folder();
    let path = write(&folder, "ball.nrrd", &nrrd(|_| true));
    let sections = |axis, every| {
        let images = ImageRules { axis, every, ..Default::default() };
        read(&path, &Rules { images, ..Rules::default() })
    };
    // Rows are farthest apart.
    assert_eq!(names(&sections(None, 0))[0], "j = 7 (y = 4.2)");
    assert_eq!(sections(None, 0).sections.len(), 30);
    let some = sections(Some(VolumeAxis::Voxels(2)), 4);
    assert_eq!(names(&some)[..2], ["k = 2 (z = 1)", "k = 6 (z = 3)"]);
    assert_ball(some, [0.04, 0.05]);
}

#[test]
fn labels_at_the_border_are_told() {
    let folder = folder();
    write(&folder, "a.png", &png([4, 2], GREY, &[], &[0, 3, 0, 0, 0, 3, 0, 0]));
    let sections = read(folder.path(), &rules());
    assert!(
        sections.warnings[0]
            .what
            .contains("label 3 may be cut off by the border of the image in a.png")
    );
    let strict = Rules { strict: true, ..rules() };
    assert!(read_sections(folder.path(), &strict).is_err());
}

#[test]
fn bad_pictures_are_refused_by_name() {
    let refused = |files: &[(&str, &[u8])], spacing: &[&str], words: &[&str]| {
        let folder = folder();
        for (name, bytes) in files {
            write(&folder, name, bytes);
        }
        let mut command = transect();
        command.arg("inspect").arg(folder.path()).args(spacing);
        assert_refused(&run(&mut command), words);
    };
    let spacing = &["--spacing-xyz", "1,1,2"][..];
    let good = grey(&slice(20));
    let picture = |data: &[u8]| png([32, 32], GREY, &[], data);
    let any = |value: fn(usize) -> u8| (0..32 * 32).map(value).collect::<Vec<u8>>();
    let all = |kind: ColorType, samples: usize| {
        png([4, 4], (kind, BitDepth::Eight), &[], &vec![9; 16 * samples])
    };

    refused(&[], spacing, &["empty"]);
    refused(&[("notes.txt", b"a")], spacing, &["no pictures", "notes.txt"]);
    refused(&[("a.jpg", b"a")], spacing, &["JPEG", "PNG or TIFF"]);
    refused(&[("a.png", &good)], &[], &["apart", "--spacing-xyz DX,DY,DZ"]);
    refused(&[("a.png", &good)], &["--spacing-xyz", "2"], &["that of pixels", "--spacing-xyz"]);
    refused(&[("a.png", &good), ("b.png", b"")], spacing, &["b.png", "empty"]);
    refused(&[("a.png", &good), ("b.png", b"GIF89a")], spacing, &["b.png", "no PNG"]);
    for end in [8, 20, 33, 41, 60, good.len() / 2, good.len() - 30] {
        refused(&[("a.png", &good), ("b.png", &good[..end])], spacing, &["b.png", "no PNG"]);
    }
    refused(
        &[("a.png", &good), ("b.png", &picture(&any(|_| 1)))],
        spacing,
        &["b.png", "32 × 32", "a.png", "48 × 44", "one size"],
    );
    refused(&[("a.png", &picture(&any(|_| 0)))], spacing, &["all of its pixels are 0"]);
    refused(&[("a.png", &all(ColorType::Rgb, 3))], spacing, &["a.png", "red", "no labels"]);
    refused(&[("a.png", &all(ColorType::Rgba, 4))], spacing, &["a.png", "transparency"]);
    refused(&[("a.png", &all(ColorType::GrayscaleAlpha, 2))], spacing, &["a.png", "transparency"]);
    // A picture of measurements, in 16 bits and in 8.
    let wide: Vec<u8> = (0..32u16 * 32).flat_map(|pixel| (pixel * 37).to_be_bytes()).collect();
    let wide = png([32, 32], (ColorType::Grayscale, BitDepth::Sixteen), &[], &wide);
    refused(&[("a.png", &wide)], spacing, &["a.png", "256 different values", "segment"]);
    let noise = picture(&any(|pixel| (pixel * 89 % 200) as u8));
    refused(&[("a.png", &noise)], spacing, &["grey picture", "segment"]);
    let soft = picture(&any(|pixel| match (pixel % 32, pixel / 32) {
        (5..25, 5..25) => 255,
        (4, row) => (row * 7) as u8,
        _ => 0,
    }));
    refused(&[("a.png", &soft)], spacing, &["soft", "anti-aliasing"]);
}

#[test]
fn bad_tiffs_are_refused_by_name() {
    let refused = |bytes: &[u8], words: &[&str]| {
        let folder = folder();
        let path = write(&folder, "a.tif", bytes);
        let mut command = transect();
        command.args(["inspect", "--spacing-xyz", "1,1,2"]).arg(path);
        assert_refused(&run(&mut command), &[&["a.tif"], words].concat());
    };
    fn encoded<C: colortype::ColorType>(size: [u32; 2], data: &[C::Inner]) -> Vec<u8>
    where
        [C::Inner]: tiff::encoder::TiffValue,
    {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes).expect("memory");
        encoder.write_image::<C>(size[0], size[1], data).expect("memory");
        bytes.into_inner()
    }
    refused(b"", &["empty"]);
    refused(b"II*\0", &["no TIFF"]);
    refused(&encoded::<colortype::RGB8>([2, 2], &[1; 12]), &["colour"]);
    refused(&encoded::<colortype::CMYK8>([2, 2], &[1; 16]), &["inks"]);
    refused(&encoded::<colortype::Gray32Float>([2, 1], &[1.0, 0.5]), &["pixel [1, 0]", "0.5"]);
    refused(&encoded::<colortype::GrayI16>([2, 1], &[1, -5]), &["pixel [1, 0]", "-5"]);
    let good = encoded::<colortype::Gray8>(picture_size(), &slice(20));
    for end in [4, 8, 100, good.len() - 60] {
        refused(&good[..end], &["no TIFF"]);
    }
}

#[test]
fn options_about_images_need_images() {
    let refused = |file: &Path, more: &[&str], words: &[&str]| {
        let mut command = transect();
        assert_refused(&run(command.arg("inspect").arg(file).args(more)), words);
    };
    refused(&phantom(), &["--spacing-xyz", "1,1,1"], &["--spacing-xyz", "pictures"]);
    refused(&phantom(), &["--axis", "k"], &["--axis", "volumes of labels"]);
    refused(&phantom(), &["--every", "2"], &["--every"]);
    let folder = folder();
    let volume = write(&folder, "ball.nrrd", &nrrd(|_| true));
    refused(&volume, &["--spacing-xyz", "1,1,1"], &["--spacing-xyz", "pictures"]);
    let wrong = |more: &[&str]| {
        let output = run(transect().arg("inspect").arg(&volume).args(more));
        assert_eq!(output.status.code(), Some(2), "{more:?}");
    };
    for value in ["0", "1,1", "1,1,0", "-1,1,1", "nan", "x", "1,1,1,1", ""] {
        wrong(&["--spacing-xyz", value]);
    }
    wrong(&["--axis", "w"]);
    wrong(&["--every", "0"]);
}

#[test]
fn pictures_say_how_far_their_pixels_are_apart() {
    let folder = folder();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture_size()[0], picture_size()[1]);
    encoder.set_color(ColorType::Grayscale);
    let dims = png::PixelDimensions { xppu: 2000, yppu: 4000, unit: png::Unit::Meter };
    encoder.set_pixel_dims(Some(dims));
    let mut writer = encoder.write_header().expect("memory");
    writer.write_image_data(&slice(20)).expect("memory");
    writer.finish().expect("memory");
    write(&folder, "a1.png", &bytes);
    write(&folder, "a2.png", &bytes);
    write(&folder, "notes.txt", b"a");
    let mut command = transect();
    command.args(["inspect", "--json", "--spacing-xyz", "-3"]).arg(folder.path());
    let output = run(&mut command);
    assert_done(&output);
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(found["units"], "mm");
    let length = |axis: usize| {
        let at = |end: usize| found["bounds"][end][axis].as_f64().expect("a number");
        at(1) - at(0)
    };
    // 35 pixels of half a millimetre, 30 of a quarter.
    assert!((length(0) - 17.5).abs() < 0.6 && (length(1) - 7.5).abs() < 0.3);
    assert_eq!((length(2), found["bounds"][0][2].as_f64()), (3.0, Some(-3.0)));
    assert!(found["left_out"][0]["what"].as_str().expect("a text").contains("notes.txt"));
    assert!(found["notes"][0]["what"].as_str().expect("a text").contains("0.5 × 0.25"));
}
