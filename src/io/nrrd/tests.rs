use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::*;
use crate::plane::Bounds;

const HEADER: &str = "NRRD0004\n# by hand\ntype: unsigned char\ndimension: 3\nsizes: 2 2 2\n\
    space: left-posterior-superior\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,2)\n\
    space origin: (10,20,30)\nencoding: raw\n";

const VOXELS: [u8; 8] = [0, 1, 0, 0, 0, 0, 0, 7];

fn file(header: &str, data: &[u8]) -> Vec<u8> {
    [header.as_bytes(), b"\n", data].concat()
}

fn read_bytes(bytes: &[u8]) -> Result<LabelVolume> {
    read(bytes, Path::new("a.nrrd"))
}

fn error(header: &str, data: &[u8]) -> String {
    read_bytes(&file(header, data)).unwrap_err().to_string()
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

#[test]
fn voxels_are_where_the_header_says() {
    let volume = read_bytes(&file(HEADER, &VOXELS)).unwrap();
    // From voxel (1, 0, 0) to (1, 1, 1), half a voxel more on every side.
    let expected =
        Bounds { min: DVec3::new(10.25, 19.75, 29.0), max: DVec3::new(10.75, 20.75, 33.0) };
    assert_eq!(volume.bounds(), Some(expected));
    assert_eq!(volume.labels(), [Label(1), Label(7)]);
    assert_eq!((volume.frame.as_str(), volume.units.as_str()), ("LPS", ""));
}

#[test]
fn every_encoding_holds_the_same() {
    let raw = read_bytes(&file(HEADER, &VOXELS)).unwrap();
    let gz = HEADER.replace("raw", "gzip");
    assert_eq!(read_bytes(&file(&gz, &gzip(&VOXELS))), Ok(raw.clone()));
    let text = HEADER.replace("raw", "ascii");
    assert_eq!(read_bytes(&file(&text, b"0 1 0 0\n0 0 0 7\n")), Ok(raw.clone()));
    let shorts = HEADER.replace("unsigned char", "int16") + "endian: big\n";
    let data: Vec<u8> = VOXELS.iter().flat_map(|&voxel| [0, voxel]).collect();
    assert_eq!(read_bytes(&file(&shorts, &data)), Ok(raw.clone()));
    let windows = file(&HEADER.replace('\n', "\r\n"), &VOXELS);
    let end = HEADER.replace('\n', "\r\n").len();
    let windows = [&windows[..end], b"\r", &windows[end..]].concat();
    assert_eq!(read_bytes(&windows), Ok(raw.clone()));
    let skipped = HEADER.to_owned() + "byte skip: -1\n";
    assert_eq!(read_bytes(&file(&skipped, &[&[9; 5], &VOXELS[..]].concat())), Ok(raw));
}

#[test]
fn detached_data_are_found_beside_the_header() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.nhdr");
    let header = HEADER.to_owned() + "data file: a.raw\n";
    let missing = read(header.as_bytes(), &path).unwrap_err().to_string();
    assert!(missing.contains("a.raw") && missing.contains("no such file"), "{missing}");
    std::fs::write(folder.path().join("a.raw"), VOXELS).unwrap();
    assert_eq!(read(header.as_bytes(), &path), read_bytes(&file(HEADER, &VOXELS)));
}

#[test]
fn segments_name_the_materials() {
    let header = HEADER.to_owned()
        + "space units: \"mm\" \"mm\" \"mm\"\nSegment0_LabelValue:=7\nSegment0_Name:=a: b\n\
           Segment0_Color:=1 0.5 0\nSegment1_LabelValue:=1\nSegment1_Name:=a: b\n";
    let volume = read_bytes(&file(&header, &VOXELS)).unwrap();
    assert_eq!(volume.units, "mm");
    let expected = Material { id: 7, name: "a: b".to_owned(), color: [255, 128, 0] };
    assert_eq!(volume.materials[0], expected);
    assert_eq!(volume.materials[1].name, "a: b 1");
}

#[test]
fn spacings_place_voxels_without_directions() {
    let header = HEADER
        .replace("space directions: (0.5,0,0) (0,0.5,0) (0,0,2)\n", "spacings: 1 2 3\n")
        .replace("space: left-posterior-superior\n", "space dimension: 3\n");
    let bounds = read_bytes(&file(&header, &[1; 8])).unwrap().bounds().unwrap();
    assert_eq!(bounds.min, DVec3::new(9.5, 19.0, 28.5));
    assert_eq!(bounds.max, DVec3::new(11.5, 23.0, 34.5));
}

#[test]
fn what_is_no_volume_of_labels_is_refused() {
    let with = |from: &str, to: &str| error(&HEADER.replace(from, to), &VOXELS);
    assert!(with("NRRD0004", "P6").contains("begins with"));
    assert!(with("dimension: 3\nsizes: 2 2 2", "dimension: 4\nsizes: 2 2 2 1").contains("4 axes"));
    assert!(with("sizes: 2 2 2", "sizes: 2 two 2").contains("sizes is"));
    assert!(with("sizes: 2 2 2", "sizes: 2 2 3").contains("truncated"));
    assert!(with("sizes: 2 2 2", "sizes: 2 2 1").contains("more than"));
    assert!(with("sizes: 2 2 2", "sizes: 2 0 2").contains("no volume"));
    assert!(with("sizes: 2 2 2", "sizes: 99999999999 99999999999 9").contains("no volume"));
    assert!(with("unsigned char", "block").contains("block"));
    assert!(with("unsigned char", "short").contains("endian"));
    assert!(with("raw", "bzip2").contains("bzip2"));
    assert!(with("raw", "gzip").contains("compressed"));
    assert!(with("(0,0,2)", "(0.5,0.5,0)").contains("span no volume"));
    assert!(with("(0,0,2)", "none").contains("2 space directions"));
    assert!(with("(0,0,2)", "").contains("2 space directions"));
    let negative = HEADER.replace("unsigned char", "signed char");
    assert!(error(&negative, &[0, 0xfe, 0, 0, 0, 0, 0, 0]).contains("[1, 0, 0] holds -2"));
    let text = HEADER.replace("raw", "ascii");
    assert!(error(&text, b"1 2 3").contains("there are 3"));
    assert!(error(&text, b"1 2 x").contains("number 3"));
    assert!(error(&text, b"0 0 0 1.5 0 0 0 0").contains("[1, 1, 0] holds 1.5"));
    assert!(read_bytes(HEADER.as_bytes()).unwrap_err().to_string().contains("truncated"));
}

#[test]
fn a_large_claim_with_few_bytes_takes_no_memory() {
    let header = HEADER.replace("sizes: 2 2 2", "sizes: 100000 100000 100000");
    assert!(error(&header, &VOXELS).contains("truncated"));
    let gz = header.replace("raw", "gzip");
    assert!(error(&gz, &gzip(&VOXELS)).contains("cannot hold"));
    let cut = gzip(&[3; 8]);
    let gz = HEADER.replace("raw", "gzip");
    assert!(error(&gz, &cut[..cut.len() - 12]).contains("end after"));
}
