//! Meshes as VTK XML, for ParaView: `PolyData` (`.vtp`) and
//! `UnstructuredGrid` (`.vtu`).
//!
//! The XML comes first and says where each array begins in the binary part
//! after it, so that everything is written in one pass. An array there is its
//! length in bytes as `UInt64`, and then its numbers, little endian.

mod image;

use std::io::{Error, Result, Write};

use glam::DVec3;

use super::mesh::About;
use super::text::shortest;
use crate::label::Label;
use crate::mesh::Mesh;

pub use image::write_image;

/// VTK's number for a triangle among the kinds of cells.
const TRIANGLE: u8 = 5;

/// What VTK calls the two kinds of data sets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataSet {
    /// Polygons.
    PolyData,
    /// Cells of any kind, here triangles.
    UnstructuredGrid,
}

/// Writes all triangles with the cell arrays `label_back` and `label_front`, both once more as
/// `boundary_labels`, which is what VTK's own filters and pyvista call them, and the materials as
/// field data.
pub fn write(set: DataSet, mesh: &Mesh, about: &About, out: &mut dyn Write) -> Result<()> {
    let kind = match set {
        DataSet::PolyData => "PolyData",
        DataSet::UnstructuredGrid => "UnstructuredGrid",
    };
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<{kind}>"
    )?;
    write_fields(about, out)?;
    write_piece(set, mesh, &mut Arrays { out, offset: 0 })?;
    writeln!(out, "</{kind}>\n<AppendedData encoding=\"raw\">")?;
    write!(out, "_")?;
    write_data(set, mesh, out)?;
    writeln!(out, "\n</AppendedData>\n</VTKFile>")
}

/// The beginnings of the arrays of the binary part.
struct Arrays<'a> {
    out: &'a mut dyn Write,
    offset: u64,
}

impl Arrays<'_> {
    /// An array of `count` numbers of `size` bytes.
    fn add(&mut self, attributes: &str, count: usize, size: u64) -> Result<()> {
        let offset = self.offset;
        self.offset += 8 + count as u64 * size;
        writeln!(
            self.out,
            "<DataArray {attributes} format=\"appended\" offset=\"{offset}\"></DataArray>"
        )
    }
}

fn write_piece(set: DataSet, mesh: &Mesh, arrays: &mut Arrays) -> Result<()> {
    let [points, cells] = [mesh.vertices.len(), mesh.triangles.len()];
    let (counts, element) = match set {
        DataSet::PolyData => (
            format!(
                "NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
                 NumberOfPolys=\"{cells}\""
            ),
            "Polys",
        ),
        DataSet::UnstructuredGrid => (format!("NumberOfCells=\"{cells}\""), "Cells"),
    };
    writeln!(arrays.out, "<Piece NumberOfPoints=\"{points}\" {counts}>\n<Points>")?;
    arrays.add("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", 3 * points, 8)?;
    writeln!(arrays.out, "</Points>\n<{element}>")?;
    arrays.add("type=\"Int32\" Name=\"connectivity\"", 3 * cells, 4)?;
    arrays.add("type=\"Int32\" Name=\"offsets\"", cells, 4)?;
    if set == DataSet::UnstructuredGrid {
        arrays.add("type=\"UInt8\" Name=\"types\"", cells, 1)?;
    }
    writeln!(arrays.out, "</{element}>\n<CellData Scalars=\"label_back\">")?;
    arrays.add("type=\"Int32\" Name=\"label_back\"", cells, 4)?;
    arrays.add("type=\"Int32\" Name=\"label_front\"", cells, 4)?;
    arrays.add("type=\"Int32\" Name=\"boundary_labels\" NumberOfComponents=\"2\"", 2 * cells, 4)?;
    writeln!(arrays.out, "</CellData>\n</Piece>")
}

/// The arrays in the order in which they were announced.
fn write_data(set: DataSet, mesh: &Mesh, out: &mut dyn Write) -> Result<()> {
    let [points, cells] = [mesh.vertices.len() as u64, mesh.triangles.len() as u64];
    out.write_all(&(24 * points).to_le_bytes())?;
    for number in mesh.vertices.iter().flat_map(|vertex| vertex.to_array()) {
        out.write_all(&number.to_le_bytes())?;
    }
    write_numbers(12 * cells, mesh.triangles.as_flattened().iter().map(|&v| u64::from(v)), out)?;
    write_numbers(4 * cells, (1..=cells).map(|cell| 3 * cell), out)?;
    if set == DataSet::UnstructuredGrid {
        out.write_all(&cells.to_le_bytes())?;
        mesh.triangles.iter().try_for_each(|_| out.write_all(&[TRIANGLE]))?;
    }
    for side in 0..2 {
        let labels = mesh.sides.iter().map(|sides| u64::from(sides[side].0));
        write_numbers(4 * cells, labels, out)?;
    }
    let pairs = mesh.sides.as_flattened().iter().map(|label| u64::from(label.0));
    write_numbers(8 * cells, pairs, out)
}

/// Writes lines with the cell array `label`, as words, and the materials as field data.
pub(super) fn write_lines(
    points: &[DVec3],
    lines: &[(Vec<u32>, Label)],
    about: &About,
    out: &mut dyn Write,
) -> Result<()> {
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>"
    )?;
    write_fields(about, out)?;
    writeln!(
        out,
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"0\" NumberOfLines=\"{}\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
        points.len(),
        lines.len()
    )?;
    let labels = lines.iter().map(|(_, label)| label.to_string());
    writeln!(out, "<CellData Scalars=\"label\">")?;
    write_words("type=\"Int64\" Name=\"label\"", labels, out)?;
    writeln!(out, "</CellData>\n<Points>")?;
    let places = points.iter().map(|point| point.to_array().map(shortest).join(" "));
    write_words("type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"", places, out)?;
    writeln!(out, "</Points>\n<Lines>")?;
    let corners = lines
        .iter()
        .map(|(line, _)| line.iter().map(ToString::to_string).collect::<Vec<_>>().join(" "));
    write_words("type=\"Int64\" Name=\"connectivity\"", corners, out)?;
    let ends = lines.iter().scan(0, |end, (line, _)| {
        *end += line.len();
        Some(end.to_string())
    });
    write_words("type=\"Int64\" Name=\"offsets\"", ends, out)?;
    writeln!(out, "</Lines>\n</Piece>\n</PolyData>\n</VTKFile>")
}

/// An array of words, a line each.
fn write_words(
    attributes: &str,
    mut words: impl Iterator<Item = String>,
    out: &mut dyn Write,
) -> Result<()> {
    writeln!(out, "<DataArray {attributes} format=\"ascii\">")?;
    words.try_for_each(|word| writeln!(out, "{word}"))?;
    writeln!(out, "</DataArray>")
}

fn write_numbers(
    bytes: u64,
    numbers: impl Iterator<Item = u64>,
    out: &mut dyn Write,
) -> Result<()> {
    out.write_all(&bytes.to_le_bytes())?;
    for number in numbers {
        out.write_all(&int(number)?.to_le_bytes())?;
    }
    Ok(())
}

fn int(number: u64) -> Result<i32> {
    i32::try_from(number)
        .map_err(|_| Error::other(format!("the number {number} is too large for VTK's Int32")))
}

/// Numbers, names and colours of the materials; units and frame.
fn write_fields(about: &About, out: &mut dyn Write) -> Result<()> {
    writeln!(out, "<FieldData>")?;
    let materials = about.materials;
    let count = materials.len();
    if count > 0 {
        let ids = materials.iter().map(|material| int(material.id.into()).map(|id| id.to_string()));
        let ids = ids.collect::<Result<Vec<_>>>()?.join(" ");
        let field = |kind: &str, name: &str, more: &str, values: &str| {
            format!(
                "<DataArray type=\"{kind}\" Name=\"{name}\"{more} NumberOfTuples=\"{count}\" \
                 format=\"ascii\">{values}</DataArray>"
            )
        };
        writeln!(out, "{}", field("Int32", "label_ids", "", &ids))?;
        let colors: Vec<u8> = materials.iter().flat_map(|material| material.color).collect();
        let three = " NumberOfComponents=\"3\"";
        writeln!(out, "{}", field("UInt8", "label_colors", three, &spaced(&colors)))?;
        let names: Vec<&str> = materials.iter().map(|material| material.name.as_str()).collect();
        write_strings("label_names", &names, out)?;
    }
    // What Slicer looks for.
    let space = about.space().unwrap_or_default();
    for (name, text) in [("units", about.units), ("frame", about.frame), ("SPACE", space)] {
        if !text.is_empty() {
            write_strings(name, &[text], out)?;
        }
    }
    writeln!(out, "</FieldData>")
}

/// Texts as VTK writes them into XML: the codes of their bytes, each text
/// ended by a 0. So there is nothing to escape.
fn write_strings(name: &str, texts: &[&str], out: &mut dyn Write) -> Result<()> {
    let codes: Vec<u8> = texts.iter().flat_map(|text| text.bytes().chain([0])).collect();
    writeln!(
        out,
        "<Array type=\"String\" Name=\"{name}\" NumberOfTuples=\"{}\" format=\"ascii\">{}</Array>",
        texts.len(),
        spaced(&codes)
    )
}

fn spaced(numbers: &[u8]) -> String {
    numbers.iter().map(u8::to_string).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::label::{Label, Material};
    use glam::DVec3;

    fn square() -> Mesh {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::ONE, DVec3::Y];
        let sides = vec![[Label(1), Label::OUTSIDE], [Label(1), Label(7)]];
        Mesh { vertices, triangles: vec![[0, 1, 2], [0, 2, 3]], sides }
    }

    /// The array called `name` as the file's own offset and length say.
    fn array(bytes: &[u8], name: &str) -> Vec<u8> {
        let text = String::from_utf8_lossy(bytes);
        let (_, rest) = text.split_once(&format!("Name=\"{name}\"")).unwrap();
        let (_, rest) = rest.split_once("offset=\"").unwrap();
        let offset: usize = rest.split('"').next().unwrap().parse().unwrap();
        let marker = b"encoding=\"raw\">\n_";
        let start = bytes.windows(marker.len()).position(|window| window == marker).unwrap()
            + marker.len()
            + offset;
        let (length, data) = bytes[start..].split_first_chunk::<8>().unwrap();
        data[..u64::from_le_bytes(*length) as usize].to_vec()
    }

    #[test]
    fn offsets_lead_to_the_arrays() {
        let material = Material { id: 7, name: "a<b".to_owned(), color: [1, 2, 3] };
        let about = About { materials: &[material], units: "mm", frame: "lps", ..About::default() };
        for set in [DataSet::PolyData, DataSet::UnstructuredGrid] {
            let mut bytes = Vec::new();
            write(set, &square(), &about, &mut bytes).unwrap();
            let ints = |name: &str| -> Vec<i32> {
                let data = array(&bytes, name);
                data.as_chunks::<4>().0.iter().map(|&number| i32::from_le_bytes(number)).collect()
            };
            assert_eq!(ints("connectivity"), [0, 1, 2, 0, 2, 3]);
            assert_eq!(ints("offsets"), [3, 6]);
            assert_eq!(ints("label_back"), [1, 1]);
            assert_eq!(ints("label_front"), [0, 7]);
            assert_eq!(ints("boundary_labels"), [1, 0, 1, 7]);
            assert_eq!(array(&bytes, "Points")[9 * 8 - 8..9 * 8], 1.0f64.to_le_bytes());
            let text = String::from_utf8_lossy(&bytes);
            assert!(text.contains(">97 60 98 0</Array>"), "a name needs no escapes: {text}");
            let space = "Name=\"SPACE\" NumberOfTuples=\"1\" format=\"ascii\">76 80 83 0<";
            assert!(text.contains(space), "{text}");
            if set == DataSet::UnstructuredGrid {
                assert_eq!(array(&bytes, "types"), [5, 5]);
            }
        }
    }

    #[test]
    fn a_label_beyond_int32_is_refused() {
        let mut mesh = square();
        mesh.sides[0][0] = Label(1 << 31);
        let written = write(DataSet::PolyData, &mesh, &About::default(), &mut Vec::new());
        assert!(written.unwrap_err().to_string().contains("2147483648"));
    }
}
