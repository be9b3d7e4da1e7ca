//! Meshes as 3MF, for printers: a zip of XML with an object for each label.

use std::io::{BufWriter, Cursor, Result, Write};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::bodies::{Body, bodies};
use super::mesh::About;
use super::text::attribute;
use super::units;
use crate::mesh::Mesh;

const CONTENT_TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;
const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;
const NAMESPACE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";

/// The units of the format, in metres.
const UNITS: [(&str, f64); 6] = [
    ("micron", 1e-6),
    ("millimeter", 1e-3),
    ("centimeter", 1e-2),
    ("inch", 0.0254),
    ("foot", 0.3048),
    ("meter", 1.0),
];
/// The resource that the colours are; objects follow.
const COLORS: usize = 1;
/// More than the XML of a vertex or a triangle.
const MOST_BYTES: u64 = 1 << 10;

/// Writes the surface of every label as an object with its name and colour.
pub fn write(mesh: &Mesh, about: &About, out: &mut dyn Write) -> Result<()> {
    let bodies = bodies(mesh, about);
    // The length of a file in a zip stands before it, and is only known after it.
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let parts =
        bodies.iter().map(|body| body.surface.vertices.len() + body.surface.triangles.len());
    let is_large = parts.sum::<usize>() as u64 * MOST_BYTES > u64::from(u32::MAX);
    let options = SimpleFileOptions::default();
    archive.start_file("[Content_Types].xml", options)?;
    archive.write_all(CONTENT_TYPES.as_bytes())?;
    archive.start_file("_rels/.rels", options)?;
    archive.write_all(RELATIONS.as_bytes())?;
    archive.start_file("3D/3dmodel.model", options.large_file(is_large))?;
    write_model(&bodies, about, &mut BufWriter::new(&mut archive))?;
    out.write_all(archive.finish()?.get_ref())
}

fn write_model(bodies: &[Body], about: &About, out: &mut dyn Write) -> Result<()> {
    let metres = units::metres(about.units);
    let (unit, scale) = UNITS
        .into_iter()
        .find(|&(_, own)| own == metres)
        .map_or(("millimeter", metres / 1e-3), |(unit, _)| (unit, 1.0));
    writeln!(out, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>")?;
    writeln!(out, "<model unit=\"{unit}\" xml:lang=\"en-US\" xmlns=\"{NAMESPACE}\">")?;
    writeln!(out, "<metadata name=\"Application\">transect</metadata>")?;
    if !about.frame.is_empty() {
        let frame = attribute(about.frame);
        writeln!(out, "<metadata name=\"Description\">coordinates: {frame}</metadata>")?;
    }
    writeln!(out, "<resources>")?;
    write_colors(bodies, out)?;
    for (number, body) in bodies.iter().enumerate() {
        write_object(number, body, scale, out)?;
    }
    writeln!(out, "</resources>\n<build>")?;
    for number in 0..bodies.len() {
        writeln!(out, "<item objectid=\"{}\"/>", object(number))?;
    }
    writeln!(out, "</build>\n</model>")?;
    out.flush()
}

/// The number of the resource that a body is.
fn object(number: usize) -> usize {
    COLORS + 1 + number
}

fn write_colors(bodies: &[Body], out: &mut dyn Write) -> Result<()> {
    if bodies.is_empty() {
        return Ok(());
    }
    writeln!(out, "<basematerials id=\"{COLORS}\">")?;
    for Body { material, .. } in bodies {
        let [r, g, b] = material.color;
        let name = attribute(&material.name);
        writeln!(out, "<base name=\"{name}\" displaycolor=\"#{r:02X}{g:02X}{b:02X}\"/>")?;
    }
    writeln!(out, "</basematerials>")
}

fn write_object(number: usize, body: &Body, scale: f64, out: &mut dyn Write) -> Result<()> {
    let Body { material, surface } = body;
    // Only what is closed is a solid.
    let kind = if surface.first_gap().is_none() { "model" } else { "surface" };
    writeln!(
        out,
        "<object id=\"{}\" type=\"{kind}\" name=\"{}\" pid=\"{COLORS}\" pindex=\"{number}\">\n\
         <mesh>\n<vertices>",
        object(number),
        attribute(&material.name)
    )?;
    for &vertex in &surface.vertices {
        let [x, y, z] = (vertex * scale).to_array();
        writeln!(out, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>")?;
    }
    writeln!(out, "</vertices>\n<triangles>")?;
    for [a, b, c] in &surface.triangles {
        writeln!(out, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>")?;
    }
    writeln!(out, "</triangles>\n</mesh>\n</object>")
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use crate::io::bodies::tests::{materials, two_tetrahedra};

    fn model(mesh: &Mesh, units: &str) -> String {
        let materials = materials();
        let about = About { materials: &materials, units, ..About::default() };
        let mut bytes = Vec::new();
        write(mesh, &about, &mut bytes).unwrap();
        let mut archive = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
        let mut text = String::new();
        archive.by_name("3D/3dmodel.model").unwrap().read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn every_label_is_an_object_with_a_colour() {
        let text = model(&two_tetrahedra(), "cm");
        assert!(text.contains("<model unit=\"centimeter\""), "{text}");
        assert!(text.contains("<base name=\"a &lt;b&gt;\" displaycolor=\"#FF8000\"/>"), "{text}");
        assert!(text.contains("id=\"3\" type=\"model\" name=\"c\" pid=\"1\" pindex=\"1\""));
        // The wall between them is of both.
        assert_eq!(text.matches("<triangle ").count(), 8);
        assert_eq!(text.matches("<item ").count(), 2);
    }

    #[test]
    fn units_without_a_word_are_scaled_and_what_is_open_is_no_solid() {
        let text = model(&two_tetrahedra(), "km");
        assert!(
            text.contains("\"millimeter\"") && text.contains("<vertex x=\"1000000\""),
            "{text}"
        );
        let mut open = two_tetrahedra();
        open.triangles.pop();
        open.sides.pop();
        let text = model(&open, "");
        let kinds = ["model", "surface"].map(|kind| text.matches(&format!("\"{kind}\"")).count());
        assert_eq!(kinds, [1, 1], "{text}");
        // A material without any triangle has nothing to be printed.
        assert!(!model(&Mesh::default(), "").contains("<object"));
    }
}
