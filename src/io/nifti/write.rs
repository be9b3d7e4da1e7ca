//! NIfTI-1 files.

use std::io::{Error, Result, Write};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::{EARLIEST, HEADER};
use crate::io::volume::write::{Type, VoxelLayer, Voxels, in_frame, turn, write_numbers};

/// How hard to pack: labels are easy.
const LEVEL: u32 = 4;
/// Places are those of a scanner, or of anything else.
const SCANNER: i16 = 1;
const ALIGNED: i16 = 2;

/// Writes voxels; coordinates become RAS, which the format wants, where their frame is known.
///
/// # Errors
/// What the writer says, and where there are more voxels along an axis than the format can tell.
pub fn write(voxels: &Voxels, layer: &VoxelLayer, packed: bool, out: &mut dyn Write) -> Result<()> {
    let kind = Type::of(std::slice::from_ref(layer));
    let mut header = header(voxels, kind)?;
    header.resize(EARLIEST, 0); // no extensions
    if !packed {
        out.write_all(&header)?;
        return write_numbers(&layer.numbers, kind, out);
    }
    let mut packed = GzEncoder::new(out, Compression::new(LEVEL));
    packed.write_all(&header)?;
    write_numbers(&layer.numbers, kind, &mut packed)?;
    packed.finish().map(drop)
}

fn header(voxels: &Voxels, kind: Type) -> Result<Vec<u8>> {
    let mut bytes = vec![0; HEADER];
    let mut put = |at: usize, own: &[u8]| bytes[at..at + own.len()].copy_from_slice(own);
    put(0, &(HEADER as i32).to_le_bytes());
    let mut dims = [3i16, 1, 1, 1, 1, 1, 1, 1];
    for (own, count) in dims[1..].iter_mut().zip(voxels.dims) {
        let what = || format!("{count} voxels along an axis are more than NIfTI-1 can tell");
        *own = i16::try_from(count).map_err(|_| Error::other(what()))?;
    }
    put(40, &dims.map(i16::to_le_bytes).concat());
    let number: i16 = match kind {
        Type::U8 => 2,
        Type::U16 => 512,
        Type::U32 => 768,
        Type::F32 => 16,
    };
    put(70, &number.to_le_bytes());
    put(72, &(8 * kind.size() as i16).to_le_bytes());
    let placement = in_frame(voxels.placement, &voxels.frame, "RAS");
    let steps = placement.steps;
    let lengths = [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| step.length() as f32);
    let [x, y, z] = lengths;
    put(76, &[1.0, x, y, z, 0.0, 0.0, 0.0, 0.0f32].map(f32::to_le_bytes).concat());
    put(108, &(EARLIEST as f32).to_le_bytes());
    put(112, &1.0f32.to_le_bytes()); // the slope
    let unit: u8 = match voxels.units.as_str() {
        "m" => 1,
        "mm" => 2,
        "um" | "µm" => 3,
        _ => 0,
    };
    put(123, &[unit]);
    let note = concat!("transect ", env!("CARGO_PKG_VERSION"));
    put(148, note.as_bytes());
    let code = if turn(&voxels.frame, "RAS").is_some() { SCANNER } else { ALIGNED };
    put(254, &code.to_le_bytes()); // the sform; there is no qform, which can say less
    for (row, at) in [280, 296, 312].into_iter().enumerate() {
        let [a, b, c] = steps.row(row).to_array();
        let row = [a, b, c, placement.origin[row]];
        put(at, &row.map(|number| (number as f32).to_le_bytes()).concat());
    }
    put(344, b"n+1\0");
    Ok(bytes)
}
