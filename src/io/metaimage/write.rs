//! MetaImage files.

use std::io::{Result, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::DVec3;

use crate::io::volume::write::{Type, VoxelLayer, Voxels, in_frame, write_numbers};

/// How hard to pack: labels are easy.
const LEVEL: u32 = 4;

/// Writes voxels, packed; coordinates become LPS, which the format wants, where their frame is
/// known.
///
/// # Errors
/// What the writer says.
pub fn write(voxels: &Voxels, layer: &VoxelLayer, out: &mut dyn Write) -> Result<()> {
    let kind = Type::of(std::slice::from_ref(layer));
    // The header says how long they are.
    let mut packed = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    write_numbers(&layer.numbers, kind, &mut packed)?;
    let packed = packed.finish()?;
    let word = kind.word(["MET_UCHAR", "MET_USHORT", "MET_UINT", "MET_FLOAT"]);
    let placement = in_frame(voxels.placement, &voxels.frame, "LPS");
    let steps = [placement.steps.x_axis, placement.steps.y_axis, placement.steps.z_axis];
    let directions = steps.map(|step| words(step / step.length())).join(" ");
    let spacing = DVec3::from(steps.map(DVec3::length));
    let [x, y, z] = voxels.dims;
    writeln!(
        out,
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n\
         CompressedData = True\nCompressedDataSize = {}\nTransformMatrix = {directions}\n\
         Offset = {}\nCenterOfRotation = 0 0 0\nElementSpacing = {}\nDimSize = {x} {y} {z}\n\
         ElementType = {word}\nElementDataFile = LOCAL",
        packed.len(),
        words(placement.origin),
        words(spacing)
    )?;
    out.write_all(&packed)
}

fn words(vector: DVec3) -> String {
    vector.to_array().map(|number| (number + 0.0).to_string()).join(" ") // no -0
}
