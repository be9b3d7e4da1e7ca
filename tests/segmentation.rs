//! Segmentations (DICOM SEG) of tests' own making, read and reconstructed.

#[path = "common/program.rs"]
mod program;
#[path = "common/structure_set.rs"]
mod structure_set;

use std::fs;
use std::path::Path;

use dicom_core::{DataElement, PrimitiveValue, Tag, VR};
use dicom_dictionary_std::{tags, uids};
use dicom_object::{FileMetaTableBuilder, InMemDicomObject};
use glam::DVec3;
use program::*;
use structure_set::{object, sequence, text};
use transect::io::read_layers;
use transect::io::structures::Chosen;
use transect::{Label, Rules};

/// Pixels along a row and along a column.
const WIDTH: usize = 30;
const HEIGHT: usize = 26;
/// The centre of the first pixel of slice 0, and the steps to the next pixel, row and slice: tilted.
const ORIGIN: DVec3 = DVec3::new(-40.0, 12.0, 30.0);
const STEPS: [DVec3; 3] =
    [DVec3::new(1.2, 0.0, 0.0), DVec3::new(0.0, 0.8, 0.6), DVec3::new(0.0, -1.8, 2.4)];

/// A frame: of which segment, on which slice, and its pixels.
struct Frame {
    segment: u16,
    slice: usize,
    pixels: Vec<u8>,
}

/// How pixels are written.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Binary,
    Fractional,
    Labels,
}

fn place(column: usize, row: usize, slice: usize) -> DVec3 {
    let [x, y, z] = STEPS;
    ORIGIN + column as f64 * x + row as f64 * y + slice as f64 * z
}

/// A frame of what lies in a ball about a place given in voxels; 3 mm are at least a voxel.
fn ball(segment: u16, slice: usize, center: [f64; 3], radius: f64) -> Frame {
    let [x, y, z] = STEPS;
    let center = ORIGIN + center[0] * x + center[1] * y + center[2] * z;
    let is_in = |at: usize| place(at % WIDTH, at / WIDTH, slice).distance(center) < radius;
    Frame { segment, slice, pixels: (0..WIDTH * HEIGHT).map(|at| u8::from(is_in(at))).collect() }
}

fn numbers(tag: Tag, numbers: &[f64]) -> DataElement<InMemDicomObject> {
    let words: Vec<String> = numbers.iter().map(|number| number.to_string()).collect();
    text(tag, VR::DS, words.join("\\"))
}

fn short(tag: Tag, number: usize) -> DataElement<InMemDicomObject> {
    DataElement::new(tag, VR::US, PrimitiveValue::from(number as u16))
}

fn write(path: &Path, kind: Kind, frames: &[Frame]) {
    let names = [(1u16, "Kidney"), (2, "Cyst"), (3, "Stone")].map(|(number, name)| {
        let lab = DataElement::new(
            tags::RECOMMENDED_DISPLAY_CIE_LAB_VALUE,
            VR::US,
            PrimitiveValue::U16([35578u16, 53670, 50860][..].into()), // red
        );
        object(vec![
            short(tags::SEGMENT_NUMBER, number.into()),
            text(tags::SEGMENT_LABEL, VR::LO, name),
            lab,
        ])
    });
    let group = |tag: Tag, element| sequence(tag, vec![object(vec![element])]);
    let own = frames.iter().map(|frame| {
        let at = place(0, 0, frame.slice).to_array();
        let mut groups =
            vec![group(tags::PLANE_POSITION_SEQUENCE, numbers(tags::IMAGE_POSITION_PATIENT, &at))];
        if kind != Kind::Labels {
            let number = short(tags::REFERENCED_SEGMENT_NUMBER, frame.segment.into());
            groups.push(group(tags::SEGMENT_IDENTIFICATION_SEQUENCE, number));
        }
        let image = object(vec![
            text(tags::REFERENCED_SOP_CLASS_UID, VR::UI, uids::CT_IMAGE_STORAGE),
            text(tags::REFERENCED_SOP_INSTANCE_UID, VR::UI, format!("2.25.7{}", frame.slice)),
        ]);
        let source = sequence(tags::SOURCE_IMAGE_SEQUENCE, vec![image]);
        groups.push(group(tags::DERIVATION_IMAGE_SEQUENCE, source));
        object(groups)
    });
    let directions = [STEPS[0].normalize().to_array(), STEPS[1].normalize().to_array()].concat();
    let shared = object(vec![
        group(
            tags::PLANE_ORIENTATION_SEQUENCE,
            numbers(tags::IMAGE_ORIENTATION_PATIENT, &directions),
        ),
        group(
            tags::PIXEL_MEASURES_SEQUENCE,
            numbers(tags::PIXEL_SPACING, &[STEPS[1].length(), STEPS[0].length()]),
        ),
    ]);
    let all = frames.iter().flat_map(|frame| &frame.pixels).copied();
    let pixels: Vec<u8> = match kind {
        Kind::Labels => all.collect(),
        Kind::Fractional => all.map(|part| 200 * part).collect(),
        Kind::Binary => {
            let bits: Vec<u8> = all.collect();
            let byte = |bits: &[u8]| {
                bits.iter().enumerate().fold(0, |byte, (place, bit)| byte | bit << place)
            };
            bits.chunks(8).map(byte).collect()
        }
    };
    let [word, bits] = match kind {
        Kind::Binary => ["BINARY", "1"],
        Kind::Fractional => ["FRACTIONAL", "8"],
        Kind::Labels => ["LABELMAP", "8"],
    };
    let set = object(vec![
        text(tags::SOP_CLASS_UID, VR::UI, uids::SEGMENTATION_STORAGE),
        text(tags::SOP_INSTANCE_UID, VR::UI, "2.25.1"),
        text(tags::MODALITY, VR::CS, "SEG"),
        text(tags::PATIENT_NAME, VR::PN, "Doe^Jane"),
        text(tags::FRAME_OF_REFERENCE_UID, VR::UI, "2.25.99"),
        text(tags::SEGMENTATION_TYPE, VR::CS, word),
        short(tags::ROWS, HEIGHT),
        short(tags::COLUMNS, WIDTH),
        short(tags::BITS_ALLOCATED, bits.parse().expect("a number")),
        short(tags::MAXIMUM_FRACTIONAL_VALUE, 200),
        text(tags::NUMBER_OF_FRAMES, VR::IS, frames.len().to_string()),
        sequence(tags::SEGMENT_SEQUENCE, names.to_vec()),
        sequence(tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE, vec![shared]),
        sequence(tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE, own.collect()),
        DataElement::new(tags::PIXEL_DATA, VR::OB, PrimitiveValue::U8(pixels.into())),
    ]);
    let meta = FileMetaTableBuilder::new().transfer_syntax(uids::EXPLICIT_VR_LITTLE_ENDIAN);
    let file = set.with_meta(meta).expect("a file");
    file.write_to_file(path).expect("the folder is writable");
}

/// A kidney with a cyst beside it, and a stone within the kidney, in no order.
fn frames(stone: bool) -> Vec<Frame> {
    let mut frames = Vec::new();
    for slice in (1..9).rev() {
        frames.push(ball(1, slice, [12.0, 13.0, 4.5], 8.0));
        frames.push(ball(2, slice, [24.0, 13.0, 4.5], 5.0));
        if stone {
            frames.push(ball(3, slice, [12.0, 13.0, 4.5], 3.5));
        }
    }
    frames.retain(|frame| frame.pixels.contains(&1));
    frames
}

#[test]
fn segments_that_overlap_are_in_layers() {
    let folder = folder();
    let path = folder.path().join("seg.dcm");
    write(&path, Kind::Binary, &frames(true));
    let layers =
        read_layers(std::slice::from_ref(&path), &Chosen::default(), &Rules::default()).unwrap();
    let names: Vec<Vec<&str>> = layers
        .iter()
        .map(|layer| layer.materials.iter().map(|own| own.name.as_str()).collect())
        .collect();
    assert_eq!(names, [vec!["Kidney", "Cyst"], vec!["Stone"]]);
    assert_eq!(layers[0].materials[0].color, [255, 0, 0]);
    assert_eq!((layers[0].units.as_str(), layers[0].frame.as_str()), ("mm", "LPS"));
    // Every slice with a voxel is a section, in its place.
    let normal = STEPS[0].cross(STEPS[1]).normalize();
    let slices: std::collections::BTreeSet<i64> = layers[0]
        .sections
        .iter()
        .map(|section| {
            let plane = section.plane().unit();
            let sign = plane.normal.dot(normal).signum();
            assert!((sign * plane.normal).distance(normal) < 1e-9);
            let slice = (sign * plane.offset - normal.dot(ORIGIN)) / 3.0;
            assert!((slice - slice.round()).abs() < 1e-6, "{slice}");
            slice.round() as i64
        })
        .collect();
    assert_eq!(slices, (2..8).collect());
    let chosen = Chosen { names: vec!["Stone".to_owned()], partition: None };
    let stone = read_layers(&[path], &chosen, &Rules::default()).unwrap();
    assert_eq!(stone.len(), 1);
}

/// The volume is the ball's, in its place, whichever way pixels are written; and the way back names
/// patient, frame of reference and images.
#[test]
fn a_segmentation_is_reconstructed_where_it_is() {
    let folder = folder();
    for (kind, name) in
        [(Kind::Binary, "binary"), (Kind::Fractional, "fractional"), (Kind::Labels, "labels")]
    {
        let mut all = frames(false);
        if kind == Kind::Labels {
            // A frame has all segments.
            let mut merged: Vec<Frame> = Vec::new();
            for frame in all {
                let pixels = frame.pixels.iter().map(|&own| own * frame.segment as u8);
                let pixels: Vec<u8> = pixels.collect();
                match merged.iter_mut().find(|known| known.slice == frame.slice) {
                    None => merged.push(Frame { pixels, ..frame }),
                    Some(known) => {
                        known.pixels.iter_mut().zip(pixels).for_each(|(all, own)| *all |= own);
                    }
                }
            }
            all = merged;
        }
        let path = folder.path().join(format!("{name}.dcm"));
        write(&path, kind, &all);
        let mesh = folder.path().join(format!("{name}.ply"));
        let set = folder.path().join(format!("{name}_out.dcm"));
        let mut command = transect();
        command.arg("reconstruct").arg(&path).args(["--resolution", "64", "-o"]).arg(&mesh);
        let output = run(command.arg("-o").arg(&set));
        assert_done(&output);
        let is_told = stderr(&output).contains("at least half in it");
        assert_eq!(is_told, kind == Kind::Fractional, "{}", stderr(&output));
        let mesh = transect::io::read_mesh(&mesh).unwrap();
        for (label, center, radius) in [(1, [12.0, 13.0, 4.5], 8.0f64), (2, [24.0, 13.0, 4.5], 5.0)]
        {
            let surface = mesh.surface(Label(label));
            let count = surface.vertices.len() as f64;
            let middle = surface.vertices.iter().sum::<DVec3>() / count;
            let [x, y, z] = STEPS;
            let center = ORIGIN + center[0] * x + center[1] * y + center[2] * z;
            assert!(middle.distance(center) < 0.5, "{name}: {middle} {center}");
            let far = surface.vertices.iter().map(|vertex| vertex.distance(center));
            let mean = far.sum::<f64>() / count;
            assert!((mean - radius).abs() < 0.6, "{name}: {mean} {radius}");
        }
        let set = dicom_object::open_file(&set).unwrap();
        let text = |tag| set.element(tag).unwrap().to_str().unwrap().into_owned();
        assert_eq!(text(tags::PATIENT_NAME), "Doe^Jane");
        assert_eq!(text(tags::FRAME_OF_REFERENCE_UID), "2.25.99");
        assert_eq!(text(tags::SOP_CLASS_UID), uids::RT_STRUCTURE_SET_STORAGE);
        assert!(set.element(tags::PIXEL_DATA).is_err());
        let contours = set.element(tags::ROI_CONTOUR_SEQUENCE).unwrap().items().unwrap();
        let contours = contours[0].element(tags::CONTOUR_SEQUENCE).unwrap().items().unwrap();
        let images = contours.iter().map(|contour| {
            let image = contour.element(tags::CONTOUR_IMAGE_SEQUENCE).unwrap().items().unwrap();
            let image = image[0].element(tags::REFERENCED_SOP_INSTANCE_UID).unwrap();
            image.to_str().unwrap().into_owned()
        });
        let images: std::collections::BTreeSet<String> = images.collect();
        assert!(images.contains("2.25.74") && images.len() >= 5, "{images:?}");
    }
}

#[test]
fn what_cannot_be_read_is_refused() {
    let folder = folder();
    let path = folder.path().join("seg.dcm");
    let refused = |word: &str| {
        let mut command = transect();
        let output = run(command.arg("inspect").arg(&path));
        assert_refused(&output, &["seg.dcm", word]);
    };
    // Frames on no lattice: every place is moved but one.
    let mut all = frames(false);
    all.iter_mut().for_each(|frame| frame.pixels.fill(0));
    write(&path, Kind::Binary, &all);
    refused("which is outside");
    write(&path, Kind::Binary, &[]);
    refused("frames");
    write(&path, Kind::Binary, &frames(false));
    let bytes = fs::read(&path).expect("a file");
    // One pixel more in every row than there are.
    let columns = [0x28, 0, 0x11, 0, b'U', b'S', 2, 0];
    let at = bytes.windows(8).position(|window| window == columns).expect("columns");
    let mut long = bytes.clone();
    long[at + 8] += 1;
    fs::write(&path, &long).expect("the folder is writable");
    refused("do not fit");
    let mut other = bytes;
    let at = other.windows(6).position(|window| window == b"BINARY").expect("a type");
    other[at..at + 6].copy_from_slice(b"TERNAR");
    fs::write(&path, &other).expect("the folder is writable");
    refused("\"TERNAR\"");
}
