//! Voxels as VTK's `ImageData` (`.vti`).

use std::io::{Result, Write};

use glam::{DMat3, DVec3};

use super::{About, write_fields};
use crate::io::volume::write::{Type, VoxelLayer, Voxels, write_numbers};

/// Writes voxels as point data called `label`, or `distance`, and materials as field data. Programs older than
/// VTK 9 do not know of directions.
///
/// # Errors
/// What the writer says.
pub fn write_image(voxels: &Voxels, layer: &VoxelLayer, out: &mut dyn Write) -> Result<()> {
    let kind = Type::of(std::slice::from_ref(layer));
    let word = kind.word(["UInt8", "UInt16", "UInt32", "Float32"]);
    let name = if kind == Type::F32 { "distance" } else { "label" };
    let steps = voxels.placement.steps;
    let columns = [steps.x_axis, steps.y_axis, steps.z_axis];
    let spacing = DVec3::from(columns.map(DVec3::length));
    let [a, b, c] = columns.map(|step| step / step.length());
    let directions = DMat3::from_cols(a, b, c);
    let rows = [0, 1, 2].map(|row| words(directions.row(row))).join(" ");
    let [x, y, z] = voxels.dims.map(|count| count.saturating_sub(1));
    let extent = format!("0 {x} 0 {y} 0 {z}");
    writeln!(
        out,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" \
         byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<ImageData WholeExtent=\"{extent}\" \
         Origin=\"{}\" Spacing=\"{}\" Direction=\"{rows}\">",
        words(voxels.placement.origin),
        words(spacing)
    )?;
    let Voxels { units, frame, .. } = voxels;
    let about = About { materials: &layer.materials, units, frame, ..About::default() };
    write_fields(&about, out)?;
    writeln!(
        out,
        "<Piece Extent=\"{extent}\">\n<PointData Scalars=\"{name}\">\n<DataArray type=\"{word}\" \
         Name=\"{name}\" format=\"appended\" offset=\"0\"></DataArray>\n</PointData>\n</Piece>\n\
         </ImageData>\n<AppendedData encoding=\"raw\">"
    )?;
    write!(out, "_")?;
    out.write_all(&((layer.numbers.len() * kind.size()) as u64).to_le_bytes())?;
    write_numbers(&layer.numbers, kind, out)?;
    writeln!(out, "\n</AppendedData>\n</VTKFile>")
}

fn words(vector: DVec3) -> String {
    vector.to_array().map(|number| (number + 0.0).to_string()).join(" ") // no -0
}
