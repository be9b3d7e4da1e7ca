use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::*;
use crate::plane::Bounds;

/// A header by hand, little endian, of 2 × 3 × 2 voxels of one byte each.
fn header() -> Vec<u8> {
    let mut bytes = vec![0u8; EARLIEST];
    put(&mut bytes, 0, &348i32.to_le_bytes());
    put(&mut bytes, 40, &[3i16, 2, 3, 2, 1, 1, 1, 1].map(i16::to_le_bytes).concat());
    put(&mut bytes, 70, &[2i16, 8].map(i16::to_le_bytes).concat()); // uint8, 8 bits
    put(&mut bytes, 76, &[1.0f32, 2.0, 3.0, 4.0].map(f32::to_le_bytes).concat());
    put(&mut bytes, 108, &352f32.to_le_bytes());
    bytes[123] = 2; // mm
    put(&mut bytes, 344, b"n+1\0");
    bytes
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// x to −y, y to x, z up: a quarter turn about z, and spacings 2, 3, 4.
fn with_sform(mut bytes: Vec<u8>) -> Vec<u8> {
    put(&mut bytes, 254, &1i16.to_le_bytes());
    let rows = [[0.0f32, 3.0, 0.0, 10.0], [-2.0, 0.0, 0.0, 20.0], [0.0, 0.0, 4.0, 30.0]];
    put(
        &mut bytes,
        280,
        &rows.as_flattened().iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<_>>(),
    );
    bytes
}

/// The same turn as a quaternion: −90° about z, so d = −sin 45°.
fn with_qform(mut bytes: Vec<u8>) -> Vec<u8> {
    put(&mut bytes, 252, &1i16.to_le_bytes());
    let numbers = [0.0, 0.0, -(0.5f32.sqrt()), 10.0, 20.0, 30.0];
    put(&mut bytes, 256, &numbers.map(f32::to_le_bytes).concat());
    bytes
}

fn read_voxels(mut header: Vec<u8>, voxels: &[u8]) -> Result<LabelVolume> {
    header.extend(voxels);
    read(&header, Path::new("a.nii"))
}

fn error(change: impl Fn(&mut Vec<u8>)) -> String {
    let mut bytes = header();
    change(&mut bytes);
    read_voxels(bytes, &[1; 12]).unwrap_err().to_string()
}

const VOXELS: [u8; 12] = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2];

#[test]
fn sform_and_qform_place_voxels_alike() {
    let by_sform = read_voxels(with_sform(header()), &VOXELS).unwrap();
    // Voxels (0, 0, 0) and (1, 2, 1) have their centres at (10, 20, 30) and
    // (10 + 2·3, 20 − 2, 30 + 4); half a voxel is (1.5, 1, 2) here.
    let expected = Bounds { min: DVec3::new(8.5, 17.0, 28.0), max: DVec3::new(17.5, 21.0, 36.0) };
    assert_eq!(by_sform.bounds(), Some(expected));
    assert_eq!((by_sform.frame.as_str(), by_sform.units.as_str()), ("RAS", "mm"));
    let by_qform = read_voxels(with_qform(header()), &VOXELS).unwrap();
    let found = by_qform.bounds().unwrap();
    assert!(found.min.distance(expected.min) < 1e-5, "{found:?}");
    assert!(found.max.distance(expected.max) < 1e-5, "{found:?}");
    // Where both are given, the sform counts.
    let mut both = with_sform(with_qform(header()));
    put(&mut both, 268, &99f32.to_le_bytes());
    assert_eq!(read_voxels(both, &VOXELS), Ok(by_sform));
}

#[test]
fn a_negative_first_pixdim_turns_the_third_axis() {
    let mut bytes = with_qform(header());
    put(&mut bytes, 76, &(-1f32).to_le_bytes());
    let bounds = read_voxels(bytes, &VOXELS).unwrap().bounds().unwrap();
    assert!((bounds.min.z - 24.0).abs() < 1e-5 && (bounds.max.z - 32.0).abs() < 1e-5);
}

#[test]
fn spacings_alone_are_in_no_frame() {
    let volume = read_voxels(header(), &VOXELS).unwrap();
    assert_eq!(volume.frame, "");
    let bounds = volume.bounds().unwrap();
    assert_eq!((bounds.min, bounds.max), (DVec3::new(-1.0, -1.5, -2.0), DVec3::new(3.0, 7.5, 6.0)));
}

#[test]
fn compressed_and_scaled_files_hold_the_same() {
    let plain = read_voxels(with_sform(header()), &VOXELS).unwrap();
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&[&with_sform(header())[..], &VOXELS].concat()).unwrap();
    let compressed = encoder.finish().unwrap();
    assert_eq!(read(&compressed, Path::new("a.nii.gz")), Ok(plain.clone()));
    let mut floats = with_sform(header());
    put(&mut floats, 70, &[16i16, 32].map(i16::to_le_bytes).concat());
    put(&mut floats, 112, &[0.5f32, 1.0].map(f32::to_le_bytes).concat());
    // ½ · n + 1 = label.
    let voxels = VOXELS.map(|label| (2.0 * (f32::from(label) - 1.0)).to_le_bytes());
    assert_eq!(read_voxels(floats, voxels.as_flattened()), Ok(plain));
    let cut = read(&compressed[..compressed.len() - 20], Path::new("a.nii.gz")).unwrap_err();
    assert!(cut.to_string().contains("end after"), "{cut}");
}

#[test]
fn big_endian_files_are_read() {
    let mut bytes = vec![0u8; EARLIEST];
    put(&mut bytes, 0, &348i32.to_be_bytes());
    put(&mut bytes, 40, &[3i16, 2, 1, 1, 1, 1, 1, 1].map(i16::to_be_bytes).concat());
    put(&mut bytes, 70, &[512i16, 16].map(i16::to_be_bytes).concat());
    put(&mut bytes, 76, &[1.0f32; 4].map(f32::to_be_bytes).concat());
    put(&mut bytes, 108, &352f32.to_be_bytes());
    put(&mut bytes, 344, b"n+1\0");
    let volume = read_voxels(bytes, &[1, 2, 0, 3]).unwrap();
    assert_eq!(volume.labels(), [3, 258].map(crate::label::Label));
}

#[test]
fn what_is_no_volume_of_labels_is_refused() {
    let dims = |bytes: &mut Vec<u8>, dims: [i16; 5]| {
        put(bytes, 40, &dims.map(i16::to_le_bytes).concat());
    };
    assert!(error(|bytes| dims(bytes, [4, 2, 3, 2, 5])).contains("series"));
    assert!(error(|bytes| dims(bytes, [2, 2, 3, 1, 1])).contains("2 axes"));
    assert!(error(|bytes| dims(bytes, [3, 2, 0, 2, 1])).contains("sizes"));
    assert!(error(|bytes| dims(bytes, [3, -5, -5, -5, 1])).contains("truncated"));
    assert!(error(|bytes| dims(bytes, [3, 2, 3, 3, 1])).contains("truncated"));
    assert!(error(|bytes| put(bytes, 70, &128i16.to_le_bytes())).contains("datatype 128"));
    assert!(error(|bytes| put(bytes, 0, &540i32.to_le_bytes())).contains("NIfTI-2"));
    assert!(error(|bytes| put(bytes, 344, b"ni1\0")).contains("in one file"));
    assert!(error(|bytes| put(bytes, 108, &f32::NAN.to_le_bytes())).contains("begin at"));
    assert!(error(|bytes| put(bytes, 76 + 4, &0f32.to_le_bytes())).contains("no volume"));
    assert!(error(|bytes| bytes.truncate(100)).contains("NIfTI-1"));
    let mut floats = header();
    put(&mut floats, 70, &256i16.to_le_bytes());
    let negative = read_voxels(floats, &[0xff; 12]).unwrap_err().to_string();
    assert!(negative.contains("[0, 0, 0] holds -1"), "{negative}");
    // Four-dimensional with a single volume is fine.
    let mut single = header();
    dims(&mut single, [4, 2, 3, 2, 1]);
    assert!(read_voxels(single, &VOXELS).is_ok());
}
