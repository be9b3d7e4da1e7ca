use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};

use super::*;
use crate::label::Label;
use crate::plane::Bounds;

const HEADER: &str = "ObjectType = Image\nNDims = 3\nBinaryData = True\n\
    BinaryDataByteOrderMSB = False\nCompressedData = False\n\
    TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 10 20 30\nCenterOfRotation = 5 5 5\n\
    AnatomicalOrientation = RAI\nElementSpacing = 0.5 0.5 2\nDimSize = 2 2 2\n\
    ElementType = MET_UCHAR\nElementDataFile = LOCAL\n";

const VOXELS: [u8; 8] = [0, 1, 0, 0, 0, 0, 0, 7];

fn read_with(header: &str, data: &[u8]) -> Result<LabelVolume> {
    read(&[header.as_bytes(), data].concat(), Path::new("a.mha"))
}

fn error(header: &str, data: &[u8]) -> String {
    read_with(header, data).unwrap_err().to_string()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn voxels_are_where_the_header_says() {
    let volume = read_with(HEADER, &VOXELS).unwrap();
    // From voxel (1, 0, 0) to (1, 1, 1), half a voxel more on every side.
    let expected =
        Bounds { min: DVec3::new(10.25, 19.75, 29.0), max: DVec3::new(10.75, 20.75, 33.0) };
    assert_eq!(volume.bounds(), Some(expected));
    assert_eq!(volume.labels(), [Label(1), Label(7)]);
    assert_eq!((volume.frame.as_str(), volume.units.as_str()), ("LPS", "mm"));
    for (key, synonym) in [("Offset", "Position"), ("Offset", "Origin")] {
        assert_eq!(read_with(&HEADER.replace(key, synonym), &VOXELS).as_ref(), Ok(&volume));
    }
}

#[test]
fn rows_of_the_matrix_are_the_directions_of_axes() {
    // The first axis goes along z, the second along x, the third along y.
    let turned = HEADER.replace("1 0 0 0 1 0 0 0 1", "0 0 1 1 0 0 0 1 0");
    for key in DIRECTIONS {
        let header = turned.replace("TransformMatrix", key);
        let bounds = read_with(&header, &VOXELS).unwrap().bounds().unwrap();
        assert_eq!(bounds.min, DVec3::new(9.75, 19.0, 30.25), "{key}");
        assert_eq!(bounds.max, DVec3::new(10.75, 23.0, 30.75), "{key}");
    }
}

#[test]
fn every_encoding_holds_the_same() {
    let raw = read_with(HEADER, &VOXELS).unwrap();
    let packed = HEADER.replace("CompressedData = False", "CompressedData = True");
    assert_eq!(read_with(&packed, &zlib(&VOXELS)).as_ref(), Ok(&raw));
    let mut gzip = GzEncoder::new(Vec::new(), Compression::default());
    gzip.write_all(&VOXELS).unwrap();
    assert_eq!(read_with(&packed, &gzip.finish().unwrap()).as_ref(), Ok(&raw));
    let text = HEADER.replace("BinaryData = True", "BinaryData = False");
    assert_eq!(read_with(&text, b"0 1 0 0\n0 0 0 7\n").as_ref(), Ok(&raw));
    let shorts = HEADER.replace("MET_UCHAR", "MET_SHORT");
    let little: Vec<u8> = VOXELS.iter().flat_map(|&voxel| [voxel, 0]).collect();
    let big: Vec<u8> = VOXELS.iter().flat_map(|&voxel| [0, voxel]).collect();
    assert_eq!(read_with(&shorts, &little).as_ref(), Ok(&raw));
    let shorts = shorts.replace("MSB = False", "MSB = True");
    assert_eq!(read_with(&shorts, &big).as_ref(), Ok(&raw));
    let shorts = shorts.replace("BinaryDataByte", "ElementByte");
    assert_eq!(read_with(&shorts, &big).as_ref(), Ok(&raw));
    let long = HEADER.replace("MET_UCHAR", "MET_ULONG");
    let four: Vec<u8> = VOXELS.iter().flat_map(|&voxel| [voxel, 0, 0, 0]).collect();
    assert_eq!(read_with(&long, &four).as_ref(), Ok(&raw));
    // From the beginning of the file, as ITK counts.
    let skipped = HEADER.replace("ElementDataFile", "HeaderSize = 000\nElementDataFile");
    let skipped = skipped.replace("000", &(skipped.len() + 3).to_string());
    assert_eq!(read_with(&skipped, &[&[9; 3], &VOXELS[..]].concat()).as_ref(), Ok(&raw));
    let skipped = HEADER.replace("ElementDataFile", "HeaderSize = -1\nElementDataFile");
    assert_eq!(read_with(&skipped, &[&[9; 5], &VOXELS[..]].concat()).as_ref(), Ok(&raw));
    let windows = "\u{feff}".to_owned() + &HEADER.replace('\n', "\r\n");
    assert_eq!(read_with(&windows, &VOXELS), Ok(raw));
}

#[test]
fn detached_voxels_are_found_beside_the_header() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mhd");
    let header = HEADER.replace("LOCAL\n", "a.raw");
    let missing = read(header.as_bytes(), &path).unwrap_err().to_string();
    assert!(missing.contains("a.raw") && missing.contains("no such file"), "{missing}");
    std::fs::write(folder.path().join("a.raw"), VOXELS).unwrap();
    assert_eq!(read(header.as_bytes(), &path), read_with(HEADER, &VOXELS));
    for spread in ["LIST", "a%03d.raw 1 2 1"] {
        let header = HEADER.replace("LOCAL", spread);
        assert!(error(&header, &VOXELS).contains("several files"));
    }
}

#[test]
fn what_is_no_volume_of_labels_is_refused() {
    let with = |from: &str, to: &str| error(&HEADER.replace(from, to), &VOXELS);
    assert!(error("", b"\x89PNG\r\n").contains("no MetaImage"));
    assert!(with("ElementDataFile = LOCAL\n", "").contains("not of the form"));
    assert!(error(&HEADER[..HEADER.len() - 25], b"").contains("truncated"));
    assert!(with("= Image", "= Tube").contains("Tube"));
    assert!(with("NDims = 3", "NDims = 4").contains("4 axes"));
    assert!(with("NDims = 3", "NDims = x").contains("NDims is"));
    assert!(with("NDims", "ElementNumberOfChannels = 3\nNDims").contains("3 channels"));
    assert!(with("DimSize = 2 2 2", "DimSize = 2 2").contains("3 numbers belong there"));
    assert!(with("DimSize = 2 2 2", "DimSize = 2 2 3").contains("truncated"));
    assert!(with("DimSize = 2 2 2", "DimSize = 2 2 1").contains("more than"));
    assert!(with("DimSize = 2 2 2", "DimSize = 2 0 2").contains("no volume"));
    assert!(with("DimSize = 2 2 2", "DimSize = -2 2 2").contains("DimSize is"));
    assert!(with("MET_UCHAR", "MET_OTHER").contains("MET_OTHER"));
    assert!(with("0 0 0 1\nOffset", "0 1 0 0\nOffset").contains("span no volume"));
    assert!(with("= 10 20 30", "= 10 nan 30").contains("span no volume"));
    assert!(with("LOCAL", "").contains("says no file"));
    let negative = HEADER.replace("MET_UCHAR", "MET_CHAR");
    assert!(error(&negative, &[0, 0xfe, 0, 0, 0, 0, 0, 0]).contains("[1, 0, 0] holds -2"));
}

#[test]
fn a_large_claim_with_few_bytes_takes_no_memory() {
    let header = HEADER.replace("DimSize = 2 2 2", "DimSize = 100000 100000 100000");
    assert!(error(&header, &VOXELS).contains("truncated"));
    let packed = |header: &str| header.replace("CompressedData = False", "CompressedData = True");
    assert!(error(&packed(&header), &zlib(&VOXELS)).contains("cannot hold"));
    let cut = zlib(&[3, 1, 4, 1, 5, 9, 2, 6]);
    assert!(error(&packed(HEADER), &cut[..cut.len() - 8]).contains("end after"));
    assert!(error(&packed(HEADER), &zlib(&[3; 100_000])).contains("more than"));
}
