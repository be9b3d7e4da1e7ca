//! Surfaces with exact coordinates, as JSON (`docs/formats.md`).

use std::io::{self, Write};

use serde::Serialize;

use crate::mesh::Mesh;
use crate::skeleton::{Details, Kind};

/// The version of the form.
const VERSION: u32 = 1;

/// A file as it is written.
#[derive(Serialize)]
struct Exact<'a> {
    transect: &'static str,
    version: u32,
    vertices: Vec<[[&'a str; 2]; 3]>,
    triangles: &'a [[u32; 3]],
    /// Back and front; 0 is outside.
    labels: Vec<[u32; 2]>,
    kinds: Vec<Kind>,
    /// Of a roof the two sections it lies between; null is the box.
    sections: Vec<[Option<u32>; 2]>,
    cells: Vec<u32>,
}

/// Writes a surface whose exact coordinates were kept.
///
/// # Errors
/// When writing fails.
pub fn write_exact(mesh: &Mesh, details: &Details, out: &mut dyn Write) -> io::Result<()> {
    let Some(exact) = &details.exact else {
        return Err(io::Error::other("exact coordinates were not kept"));
    };
    let origins = &details.origins;
    let file = Exact {
        transect: "exact surface",
        version: VERSION,
        vertices: exact.iter().map(|point| point.each_ref().map(|text| fraction(text))).collect(),
        triangles: &mesh.triangles,
        labels: mesh.sides.iter().map(|sides| sides.map(|label| label.0)).collect(),
        kinds: origins.iter().map(|origin| origin.kind).collect(),
        sections: origins.iter().map(|origin| origin.sections).collect(),
        cells: origins.iter().map(|origin| origin.cell).collect(),
    };
    serde_json::to_writer(&mut *out, &file)?;
    out.write_all(b"\n")
}

/// Numerator and denominator.
fn fraction(text: &str) -> [&str; 2] {
    text.split_once('/').map_or([text, "1"], |(above, below)| [above, below])
}
