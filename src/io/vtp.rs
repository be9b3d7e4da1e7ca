//! Contours in VTK's polygonal data (`.vtp`): its lines, by the planes they lie on.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

use glam::DVec3;
use roxmltree::Document;

use super::mesh::{About, welded};
use super::polygons;
use super::vtk::write_lines;
use super::vtk_xml::{Checked, Parts, VtkFile, array, child};
use super::{unwritten, writable};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::section::{Rules, Sections, Warning};

/// What arrays of labels are called.
const LABELS: [&str; 8] =
    ["label", "labels", "labelid", "label_id", "regionid", "region_id", "materialid", "material"];

/// A file of whatever has cells, in pieces.
#[derive(Default)]
struct Lines {
    points: Vec<DVec3>,
    /// The corners of each line and its label.
    lines: Vec<(Vec<u32>, u32)>,
    /// Cells that are no lines.
    others: usize,
}

/// Reads the bytes of a file; `file` is for errors.
///
/// # Errors
/// Where it is damaged or holds no lines, or where contours lie on no plane.
pub fn read(bytes: &[u8], file: &Path, rules: &Rules) -> Result<Sections> {
    let Lines { points, lines, others } = lines(bytes).map_err(|what| Error::file(file, what))?;
    if lines.is_empty() {
        return Err(Error::file(
            file,
            match others {
                0 => "there is no line in it: export the contours again",
                _ => {
                    "it holds a surface and no lines: cut it by planes first (transect slice), or \
                     export its contours as lines"
                }
            },
        ));
    }
    let (points, same) = welded(points.iter().copied());
    let mut of_labels: BTreeMap<u32, Vec<Vec<u32>>> = BTreeMap::new();
    for (line, label) in lines {
        let line = line.into_iter().map(|at| same[at as usize]).collect();
        of_labels.entry(label).or_default().push(line);
    }
    let outside = of_labels.remove(&Label::OUTSIDE.0).map_or(0, |lines| lines.len());
    let materials = of_labels.keys().map(|&label| Material::numbered(Label(label))).collect();
    let (mut polygons, mut left) = (Vec::new(), 0);
    for (label, pieces) in of_labels {
        let place = format!("the lines of label {label}");
        let (found, open) = polygons::joined(file, &place, Label(label), pieces, &points)?;
        left += open;
        polygons.extend(found);
    }
    let mut sections = polygons::sections(file, polygons, rules)?;
    for (count, what) in [
        (left, "lines that do not close"),
        (outside, "lines of label 0, which is outside"),
        (others, "cells that are no lines: only lines are contours"),
    ] {
        if count > 0 {
            let what = format!("{count} {what}");
            sections.left_out.push(Warning { section: String::new(), what });
        }
    }
    sections.name_materials(materials);
    Ok(sections)
}

/// Writes the boundaries of all regions as closed lines, each with its `label`; materials, unit and
/// frame are field data.
///
/// # Errors
/// Where a section has unknown regions, or reaches to infinity with a material, and where writing
/// fails.
pub fn write(sections: &Sections, out: &mut dyn Write) -> Result<()> {
    let (mut points, mut lines) = (Vec::new(), Vec::new());
    for section in &sections.sections {
        let first = points.len() as u32;
        points.extend((0..section.vertices().len()).map(|vertex| section.point(vertex as u32)));
        for region in writable(section, ".vtp")? {
            for walk in region.outer.iter().chain(&region.holes) {
                let around = walk.iter().chain(walk.first()).map(|vertex| first + vertex);
                lines.push((around.collect(), region.label));
            }
        }
    }
    write_lines(&points, &lines, &About::from(sections), out)
        .map_err(|error| unwritten(".vtp", &error))
}

/// All lines of a file.
fn lines(bytes: &[u8]) -> Checked<Lines> {
    let parts = Parts::of(bytes)?;
    let document = Document::parse(&parts.text)
        .map_err(|error| format!("it is no XML ({error}): export it again"))?;
    let data = VtkFile::new(&document, &parts, "PolyData")?;
    let mut all = Lines::default();
    for piece in data.pieces() {
        let first = all.points.len() as u32;
        let points = child(piece, "Points").and_then(|points| array(points, |_| true));
        let points = data.numbers(points)?;
        if points.len() % 3 != 0 {
            return Err(format!("{} coordinates are no points", points.len()));
        }
        let count = points.len() / 3;
        if all.points.len() + count > u32::MAX as usize {
            return Err("it has too many points".to_owned());
        }
        all.points.extend(points.chunks(3).map(DVec3::from_slice));
        let cells = |kind: &str| -> Checked<(Vec<f64>, Vec<f64>)> {
            let Some(cells) = child(piece, kind) else { return Ok(Default::default()) };
            let of = |name: &str| data.numbers(array(cells, |own| own == name));
            Ok((of("connectivity")?, of("offsets")?))
        };
        let before = cells("Verts")?.1.len();
        let (corners, ends) = cells("Lines")?;
        all.others += before + cells("Strips")?.1.len() + cells("Polys")?.1.len();
        let is_label = |name: &str| LABELS.contains(&name.to_ascii_lowercase().as_str());
        let labels = child(piece, "CellData").and_then(|cells| array(cells, is_label));
        let labels = labels.map(|labels| data.numbers(Some(labels))).transpose()?;
        let mut start = 0;
        for (line, &end) in ends.iter().enumerate() {
            let own = whole(end, corners.len())?;
            if own < start {
                return Err(format!("line {line} ends before it begins"));
            }
            let line_corners = corners[start..own].iter().map(|&corner| {
                let corner = whole(corner, count.saturating_sub(1))?;
                Ok(first + corner as u32)
            });
            let line_corners = line_corners.collect::<Checked<Vec<u32>>>()?;
            start = own;
            let label = match &labels {
                None => 1,
                Some(labels) => {
                    let label = labels.get(before + line).copied().unwrap_or(0.0);
                    whole(label, Label::LARGEST.0 as usize)? as u32
                }
            };
            if line_corners.len() > 1 {
                all.lines.push((line_corners, label));
            }
        }
    }
    if let Some(bad) = all.points.iter().position(|point| !point.is_finite()) {
        return Err(format!("a coordinate of point {bad} is not a finite number"));
    }
    Ok(all)
}

/// A number that counts or names something, up to `most`.
fn whole(number: f64, most: usize) -> Checked<usize> {
    match number {
        own if own.fract() == 0.0 && (0.0..=most as f64).contains(&own) => Ok(own as usize),
        own => Err(format!("{own} is no number from 0 to {most}: the file is damaged")),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use base64::Engine;
    use base64::prelude::BASE64_STANDARD;
    use flate2::Compression;
    use flate2::write::ZlibEncoder;

    use super::*;

    /// How arrays are written.
    #[derive(Debug, Clone, Copy, PartialEq)]
    enum Format {
        Ascii,
        Inline { packed: bool, big: bool },
        Appended { base64: bool, packed: bool },
    }

    const POINTS: [f64; 24] = [
        0.0, 0.0, 1.0, 4.0, 0.0, 1.0, 4.0, 4.0, 1.0, 0.0, 4.0, 1.0, // a square at z = 1
        0.0, 0.0, 5.0, 2.0, 0.0, 5.0, 2.0, 2.0, 5.0, 9.0, 9.0, 5.0, // a triangle, and a point
    ];

    /// A file of a vertex and of lines: a square in two pieces, a closed triangle, and one that
    /// does not close.
    fn file(format: Format) -> Vec<u8> {
        let mut appended: Vec<u8> = Vec::new();
        let mut array = |name: &str, kind: &str, numbers: &[f64]| {
            let big = matches!(format, Format::Inline { big: true, .. });
            let raw: Vec<u8> = numbers
                .iter()
                .flat_map(|&own| {
                    let mut bytes = match kind {
                        "Float64" => own.to_le_bytes().to_vec(),
                        _ => (own as i64).to_le_bytes().to_vec(),
                    };
                    if big {
                        bytes.reverse();
                    }
                    bytes
                })
                .collect();
            let lengths = |lengths: &[usize]| -> Vec<u8> {
                let one = |&own: &usize| match big {
                    true => (own as u32).to_be_bytes(),
                    false => (own as u32).to_le_bytes(),
                };
                lengths.iter().flat_map(one).collect()
            };
            let pack = |bytes: &[u8]| {
                let mut packed = ZlibEncoder::new(Vec::new(), Compression::default());
                packed.write_all(bytes).unwrap();
                packed.finish().unwrap()
            };
            // Blocks of 40 bytes, the last one shorter.
            let blocks: Vec<Vec<u8>> = raw.chunks(40).map(pack).collect();
            let sizes: Vec<usize> = blocks.iter().map(Vec::len).collect();
            let heads = lengths(&[&[blocks.len(), 40, raw.len() % 40], &sizes[..]].concat());
            let packed = blocks.concat();
            let whole = [lengths(&[raw.len()]), raw].concat();
            let encode = |bytes: &[u8]| BASE64_STANDARD.encode(bytes);
            let head = format!("<DataArray type=\"{kind}\" Name=\"{name}\" ");
            match format {
                Format::Ascii => {
                    let words: Vec<String> = numbers.iter().map(|own| own.to_string()).collect();
                    format!("{head} format=\"ascii\">\n{}\n</DataArray>", words.join(" "))
                }
                Format::Inline { packed: true, .. } => {
                    let text = encode(&heads) + &encode(&packed);
                    format!("{head} format=\"binary\">\n  {text}\n</DataArray>")
                }
                Format::Inline { .. } => {
                    format!("{head} format=\"binary\">\n  {}\n</DataArray>", encode(&whole))
                }
                Format::Appended { base64, packed: is_packed } => {
                    let offset = appended.len();
                    appended.extend(match (base64, is_packed) {
                        (true, true) => (encode(&heads) + &encode(&packed)).into_bytes(),
                        (true, false) => encode(&whole).into_bytes(),
                        (false, true) => [heads, packed].concat(),
                        (false, false) => whole,
                    });
                    format!("{head} format=\"appended\" offset=\"{offset}\"/>")
                }
            }
        };
        let points = array("Points", "Float64", &POINTS);
        let labels = array("Label", "Int64", &[9.0, 3.0, 3.0, 7.0, 7.0]);
        let verts = array("connectivity", "Int64", &[7.0]) + &array("offsets", "Int64", &[1.0]);
        let corners = [0.0, 1.0, 2.0, 2.0, 3.0, 0.0, 4.0, 5.0, 6.0, 4.0, 5.0, 7.0];
        let lines = array("connectivity", "Int64", &corners)
            + &array("offsets", "Int64", &[3.0, 6.0, 10.0, 12.0]);
        let is_packed = matches!(
            format,
            Format::Inline { packed: true, .. } | Format::Appended { packed: true, .. }
        );
        let compressor = if is_packed { "compressor=\"vtkZLibDataCompressor\"" } else { "" };
        let order = match format {
            Format::Inline { big: true, .. } => "BigEndian",
            _ => "LittleEndian",
        };
        let mut bytes = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" byte_order=\"{order}\" \
             header_type=\"UInt32\" {compressor}><PolyData><Piece><CellData>{labels}</CellData>\
             <Points>{points}</Points><Verts>{verts}</Verts><Lines>{lines}</Lines></Piece>\
             </PolyData>"
        )
        .into_bytes();
        if let Format::Appended { base64, .. } = format {
            let encoding = if base64 { "base64" } else { "raw" };
            bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n _").bytes());
            bytes.extend(appended);
            bytes.extend(b"\n</AppendedData>");
        }
        bytes.extend(b"</VTKFile>\n");
        bytes
    }

    const FORMATS: [Format; 8] = [
        Format::Ascii,
        Format::Inline { packed: false, big: false },
        Format::Inline { packed: false, big: true },
        Format::Inline { packed: true, big: false },
        Format::Inline { packed: true, big: true },
        Format::Appended { base64: false, packed: false },
        Format::Appended { base64: true, packed: false },
        Format::Appended { base64: true, packed: true },
    ];

    fn read_file(bytes: &[u8]) -> Result<Sections> {
        read(bytes, Path::new("a.vtp"), &Rules::default())
    }

    #[test]
    fn lines_are_read_whichever_way_they_are_written() {
        for format in FORMATS {
            let sections = read_file(&file(format)).unwrap();
            let area = |section: usize| -> f64 {
                let regions = sections.sections[section].regions().unwrap();
                regions.iter().filter(|own| own.label.is_material()).map(|own| own.area).sum()
            };
            assert_eq!((area(0), area(1)), (16.0, 2.0), "{format:?}");
            let labels: Vec<u32> = sections.materials.iter().map(|own| own.id).collect();
            assert_eq!(labels, [3, 7]);
            let told: Vec<&str> = sections.left_out.iter().map(|own| own.what.as_str()).collect();
            assert_eq!(
                told,
                ["1 lines that do not close", "1 cells that are no lines: only lines are contours"]
            );
        }
    }

    #[test]
    fn damaged_files_are_refused() {
        for format in FORMATS {
            let bytes = file(format);
            for length in (0..bytes.len()).step_by(7) {
                let mut cut = bytes[..length].to_vec();
                let _ = read_file(&cut); // it returns
                cut.extend(&bytes[(length + 3).min(bytes.len())..]);
                let _ = read_file(&cut);
            }
            for at in 0..bytes.len() {
                let mut changed = bytes.clone();
                changed[at] ^= 1 << (at % 8);
                let _ = read_file(&changed);
            }
        }
        let surface = "<VTKFile type=\"PolyData\"><PolyData><Piece><Polys><DataArray Name=\"offsets\" \
                       format=\"ascii\">3</DataArray></Polys></Piece></PolyData></VTKFile>";
        for (text, word) in [
            (surface, "holds a surface and no lines"),
            ("<VTKFile type=\"ImageData\"><ImageData/></VTKFile>", "it holds ImageData"),
            ("<a/>", "no file of VTK"),
            ("no", "no XML"),
        ] {
            let error = read_file(text.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        }
    }
}
