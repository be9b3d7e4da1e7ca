//! Files with faults that nobody would think of, through every reader.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use dicom_dictionary_std::uids;
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use glam::DVec3;
use transect::Rules;
use transect::io::structures::Chosen;
use transect::io::volume::{is_volume, read_volume};
use transect::io::{is_layered, read_layers, read_mesh, read_sections};

use super::judge::{Verdict, refused};
use super::random::Random;
use super::structure_set::{Contour, Structure, circle, closed, structure_set};

/// An error is no longer than this.
const LONGEST: usize = 1000;
/// Numbers that programs stumble over.
const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1",
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "-9223372036854775808",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "1e400",
    "00000000000000000000000000000001",
];

/// A file to read: how its name ends, and what is in it.
#[derive(Debug, Clone, PartialEq)]
pub struct File {
    pub kind: String,
    pub bytes: Vec<u8>,
}

/// The file of a seed: a sound one with some faults, now and then under another's name.
pub fn file(seed: u64) -> File {
    let mut random = Random::new(seed ^ 0x00f1_1e00);
    let all = sound();
    let mut file = all[random.below(all.len())].clone();
    if random.percent(3) {
        file.kind = all[random.below(all.len())].kind.clone();
    }
    // What is packed is spoilt as it is or packed again.
    let is_packed = file.kind == "nii.gz";
    let outside = random.percent(20);
    if is_packed && outside {
        file.bytes = packed(&file.bytes);
    }
    for _ in 0..=random.below(4) {
        spoil(&mut file.bytes, &mut random);
    }
    if is_packed && !outside {
        file.bytes = packed(&file.bytes);
    }
    file
}

/// Reads a file and judges how that went.
pub fn judge(file: &Path) -> Verdict {
    let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
    let words = |error: transect::Error| match refused(&error) {
        Verdict::Refused(words) if words.lines().count() != 1 || words.len() > LONGEST => {
            Verdict::Bad(format!("no good line: {words:?}"))
        }
        Verdict::Refused(words) if !words.contains(&name) => {
            Verdict::Bad(format!("the file is not named: {words}"))
        }
        verdict => verdict,
    };
    let kind = name.rsplit('.').next().unwrap_or_default();
    let read = match kind {
        "csl" | "contour" | "json" | "jser" | "png" | "tiff" => {
            read_sections(file, &Rules::default()).map(drop)
        }
        "dcm" => read_layers(&[file.to_owned()], &Chosen::default(), &Rules::default()).map(drop),
        _ if is_layered(file) => {
            read_layers(&[file.to_owned()], &Chosen::default(), &Rules::default()).map(drop)
        }
        _ if is_volume(file) => {
            read_volume(file).and_then(|_| read_sections(file, &Rules::default())).map(drop)
        }
        "obj" if fs::read(file).is_ok_and(|bytes| bytes.starts_with(b"# lines")) => {
            read_sections(file, &Rules::default()).map(drop)
        }
        _ => read_mesh(file).map(drop),
    };
    read.map_or_else(words, |()| Verdict::Good)
}

/// One fault.
fn spoil(bytes: &mut Vec<u8>, random: &mut Random) {
    if bytes.is_empty() {
        return;
    }
    // Headers come first, and count for more.
    let reach = if random.percent(50) { bytes.len().min(400) } else { bytes.len() };
    let at = random.below(reach);
    let to = (at + 1 + random.below(40)).min(bytes.len());
    match random.below(9) {
        0 => bytes[at] ^= 1 << random.below(8),
        1 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b'\n', b' ', b'-', 0x1b][random.below(9)],
        2 => bytes.truncate(at),
        3 => drop(bytes.drain(at..to)),
        4 => {
            let part = bytes[at..to].to_vec();
            bytes.splice(at..at, part);
        }
        5 => {
            let from = random.below(bytes.len());
            let part = bytes[from..(from + 8).min(bytes.len())].to_vec();
            let end = (at + part.len()).min(bytes.len());
            bytes[at..end].copy_from_slice(&part[..end - at]);
        }
        6 => {
            let number = (random.unit() * f64::from(u32::MAX)) as u32;
            let end = (at + 4).min(bytes.len());
            bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
        }
        // In place of a number, where there is one.
        _ => {
            let is_digit = |byte: &u8| byte.is_ascii_digit() || b"+-.e".contains(byte);
            let Some(first) = bytes[at..].iter().position(u8::is_ascii_digit) else { return };
            let first = at + first;
            let length = bytes[first..].iter().take_while(|byte| is_digit(byte)).count();
            let number = NUMBERS[random.below(NUMBERS.len())];
            bytes.splice(first..first + length, number.bytes());
        }
    }
}

/// Sound files of all kinds.
fn sound() -> Vec<File> {
    let file = |kind: &str, bytes: &[u8]| File { kind: kind.to_owned(), bytes: bytes.to_vec() };
    let mut all = vec![
        file("ply", PLY.as_bytes()),
        file("ply", &binary_ply()),
        file("obj", OBJ.as_bytes()),
        file("obj", LINES.as_bytes()),
        file("jser", JSER.as_bytes()),
        file("off", OFF.as_bytes()),
        file("stl", STL.as_bytes()),
        file("stl", &binary_stl()),
        file("nrrd", &nrrd()),
        file("mha", &metaimage(false)),
        file("mha", &metaimage(true)),
        file("mha", &sequence()),
        file("nrrd", &layered_nrrd()),
        file("nii", &nifti()),
        file("nii.gz", &nifti()),
        file("png", &png()),
        file("tiff", &tiff()),
        file("dcm", &structures(uids::EXPLICIT_VR_LITTLE_ENDIAN)),
        file("dcm", &structures(uids::IMPLICIT_VR_LITTLE_ENDIAN)),
    ];
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus");
    let mut kept: Vec<PathBuf> =
        fs::read_dir(corpus).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    kept.sort();
    for path in kept {
        let kind = path.extension().and_then(|kind| kind.to_str()).unwrap_or_default().to_owned();
        if let Ok(bytes) = fs::read(path) {
            all.push(File { kind, bytes });
        }
    }
    all
}

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n\
    property float z\nelement face 4\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const OBJ: &str = "# four\no body\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\n\
    f 1 3 2\nf 1//1 2//1 \\\n4//1\nf -4 -1 -2\nf 2 3 4\n";
const LINES: &str = "# lines\no a\nv 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nl 1 2 3 4 1\nv 1 1 0\nv 2 1 0\n\
    v 2 2 0\nl 5 6\nl 6 7\nl 7 5\no b\nv 9 0 1\nv 9 3 1\nv 9 3 5\nl -3 -2 \\\n-1 -3\n";
const JSER: &str = r#"{"series": {"alignment": "mine"}, "sections": [null, {"thickness": 0.05,
    "tforms": {"mine": [1, 0, 0, 0, 1, 0]}, "contours": {"d": [[[0, 4, 4, 0], [0, 0, 4, 4],
    [255, 128, 0], true, false, false, ["none", "none"], []], [[1, 2, 2], [1, 1, 2], [1, 2, 3],
    true, true, false, ["none", "none"], []]]}}]}"#;
const OFF: &str = "OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 1 0\n\
    vertex 1 0 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n\
    vertex 1 0 0\nvertex 0 0 1\nendloop\nendfacet\nendsolid a\n";

fn binary_ply() -> Vec<u8> {
    let mut bytes = PLY[..PLY.find("0 0 0\n").unwrap_or_default()]
        .replace("ascii", "binary_little_endian")
        .into_bytes();
    for corner in [[0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
        bytes.extend(corner.iter().flat_map(|own| own.to_le_bytes()));
    }
    for face in [[0i32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|own| own.to_le_bytes()));
    }
    bytes
}

fn binary_stl() -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(4u32.to_le_bytes());
    for corners in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] {
        bytes.extend([0; 12]);
        for corner in corners {
            let place = (1..4).map(|axis| if corner == axis { 1f32 } else { 0.0 });
            bytes.extend(place.flat_map(f32::to_le_bytes));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

/// A block of label 1 in 6³ voxels.
fn voxels() -> Vec<u8> {
    let inside = |at: usize| (1..5).contains(&(at % 6));
    (0..216).map(|at| u8::from(inside(at) && inside(at / 6) && inside(at / 36))).collect()
}

fn nrrd() -> Vec<u8> {
    let mut bytes =
        b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 6 6\nspace: left-posterior-superior\n\
        space directions: (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\
        endian: little\n\n"
            .to_vec();
    bytes.extend(voxels());
    bytes
}

fn metaimage(is_packed: bool) -> Vec<u8> {
    let voxels = if is_packed { zlib(&voxels()) } else { voxels() };
    let compressed = if is_packed { "True" } else { "False" };
    let header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = {compressed}\nCompressedDataSize = {}\n\
         TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 1 2 3\nElementSpacing = 1 1 2\n\
         DimSize = 6 6 6\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        voxels.len()
    );
    [header.as_bytes(), &voxels].concat()
}

/// The slices of the block as tracked frames.
fn sequence() -> Vec<u8> {
    let mut header = "NDims = 3\nDimSize = 6 6 6\nElementType = MET_UCHAR\n\
        UltrasoundImageOrientation = UN\n\
        ImageToProbeTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"
        .to_owned();
    for number in 0..6 {
        let begin = format!("Seq_Frame{number:04}_ProbeToTrackerTransform");
        let matrix = format!("1 0 0 0 0 1 0 0 0 0 1 {number} 0 0 0 1");
        header += &format!("{begin} = {matrix}\n{begin}Status = OK\n");
    }
    header += "ElementDataFile = LOCAL\n";
    [header.as_bytes(), &voxels()].concat()
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

/// The same block in two layers, of which one is empty but for a part.
fn layered_nrrd() -> Vec<u8> {
    let mut bytes =
        b"NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 6 6 6\nspace: left-posterior-superior\n\
        space directions: none (1,0,0) (0,1,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n\
        kinds: list domain domain domain\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n\
        Segment1_LabelValue:=1\nSegment1_Layer:=1\nSegment1_Name:=part\n\n"
            .to_vec();
    let part = |(at, own): (usize, u8)| [own, own * u8::from(at > 108)];
    bytes.extend(voxels().into_iter().enumerate().flat_map(part));
    bytes
}

fn nifti() -> Vec<u8> {
    let mut bytes = vec![0u8; 352];
    bytes[..4].copy_from_slice(&348i32.to_le_bytes());
    for (place, size) in [3i16, 6, 6, 6, 1, 1, 1, 1].into_iter().enumerate() {
        bytes[40 + 2 * place..][..2].copy_from_slice(&size.to_le_bytes());
    }
    bytes[70..72].copy_from_slice(&2i16.to_le_bytes()); // u8
    bytes[72..74].copy_from_slice(&8i16.to_le_bytes());
    for place in 0..4 {
        bytes[76 + 4 * place..][..4].copy_from_slice(&1f32.to_le_bytes());
    }
    bytes[108..112].copy_from_slice(&352f32.to_le_bytes());
    bytes[112..116].copy_from_slice(&1f32.to_le_bytes()); // slope
    bytes[344..348].copy_from_slice(b"n+1\0");
    bytes.extend(voxels());
    bytes
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 6, 6);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    if let Ok(mut writer) = encoder.write_header() {
        let _ = writer.write_image_data(&voxels()[72..108]);
    }
    bytes
}

fn tiff() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    if let Ok(mut encoder) = tiff::encoder::TiffEncoder::new(&mut bytes) {
        for page in 1..5 {
            let pixels = &voxels()[36 * page..][..36];
            let _ = encoder.write_image::<tiff::encoder::colortype::Gray8>(6, 6, pixels);
        }
    }
    bytes.into_inner()
}

/// A disc, a ring and a point.
fn structures(syntax: &str) -> Vec<u8> {
    let around = |radius: f64| circle(DVec3::ZERO, radius, [DVec3::X, DVec3::Y]);
    let ring = vec![closed(around(4.0)), closed(around(2.0))];
    let point = Contour { kind: "POINT", points: vec![DVec3::ONE] };
    let structures = [
        Structure { number: 1, name: "disc", contours: vec![closed(around(3.0)), point] },
        Structure { number: 2, name: "ring", contours: ring },
    ];
    structure_set(&structures, syntax)
}

/// All files with a part less, large parts first.
pub fn smaller(file: &File) -> Vec<File> {
    let whole = file.bytes.len();
    let sizes = std::iter::successors(Some(whole / 2), |size| Some(size / 2));
    let part = |size: usize| {
        (0..whole).step_by(size).map(move |at| {
            let mut bytes = file.bytes.clone();
            bytes.drain(at..(at + size).min(whole));
            File { kind: file.kind.clone(), bytes }
        })
    };
    sizes.take_while(|&size| size > 0).flat_map(part).collect()
}
