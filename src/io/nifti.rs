//! NIfTI-1 (`.nii`, `.nii.gz`), as volumes of labels.

mod write;

use std::borrow::Cow;
use std::path::Path;

use ::nifti::{Endianness, NiftiHeader, NiftiType};
use glam::{DMat3, DQuat, DVec3};

use super::volume::write::Voxels;
use super::volume::{Scalar, Storage, inflated};
use crate::error::{Error, Result};
use crate::volume::{LabelVolume, Placement};

pub use write::write;

/// The length of the header.
const HEADER: usize = 348;
/// The length of the header of NIfTI-2, with which it begins.
const HEADER_2: u32 = 540;
/// Where the voxels are at the earliest: a file with its header in it has four
/// bytes more.
const EARLIEST: usize = 352;

/// Reads a file, compressed or not; `file` is for errors.
///
/// # Errors
/// Where it is no NIfTI-1, is damaged, or holds no labels.
pub fn read(bytes: &[u8], file: &Path) -> Result<LabelVolume> {
    let compressed = bytes.starts_with(&[0x1f, 0x8b]);
    let bad = |what: String| Error::file(file, what);
    let at = |what: String| Error::input(file, "the header", what);
    let start = match compressed {
        true => Cow::Owned(inflated(bytes, HEADER).map_err(bad)?),
        false => Cow::Borrowed(bytes),
    };
    let header = header(&start).map_err(at)?;
    let storage = storage(&header).map_err(at)?;
    let first = offset(&header).map_err(at)?;
    let end = storage.bytes().ok().and_then(|length| length.checked_add(first));
    let end = end.ok_or_else(|| at("its sizes are too large: correct them".to_owned()))?;
    storage.require_memory(file, bytes.len(), compressed)?;
    let content = if compressed { Cow::Owned(inflated(bytes, end).map_err(bad)?) } else { start };
    let labels = storage.labels(content.get(first..).unwrap_or_default()).map_err(bad)?;
    let mut volume = LabelVolume::new(storage.dims, labels, placement(&header)).map_err(at)?;
    volume.units = units(&header).to_owned();
    if header.sform_code > 0 || header.qform_code > 0 {
        "RAS".clone_into(&mut volume.frame);
    }
    Ok(volume)
}

/// Where the voxels of an image are, whatever is in them.
pub fn read_voxels(bytes: &[u8]) -> std::result::Result<Voxels, String> {
    let start = match bytes.starts_with(&[0x1f, 0x8b]) {
        true => Cow::Owned(inflated(bytes, HEADER)?),
        false => Cow::Borrowed(bytes),
    };
    let header = header(&start)?;
    let dims = header.dim().map_err(|error| format!("{error}: correct the sizes"))?;
    let &[x, y, z, ..] = dims else {
        return Err(format!("it has {} axes, and a volume has three", dims.len()));
    };
    let is_placed = header.sform_code > 0 || header.qform_code > 0;
    Ok(Voxels {
        dims: [x, y, z].map(usize::from),
        placement: placement(&header),
        units: units(&header).to_owned(),
        frame: if is_placed { "RAS".to_owned() } else { String::new() },
    })
}

fn header(bytes: &[u8]) -> std::result::Result<NiftiHeader, String> {
    let first = bytes.first_chunk::<4>().copied().unwrap_or_default();
    if [u32::from_le_bytes(first), u32::from_be_bytes(first)].contains(&HEADER_2) {
        return Err("this is NIfTI-2, and only NIfTI-1 can be read: convert it".to_owned());
    }
    let header = NiftiHeader::from_reader(bytes)
        .map_err(|error| format!("this is no NIfTI-1 ({error}): export it again"))?;
    if header.sizeof_hdr != HEADER as i32 || header.magic != *b"n+1\0" {
        return Err("this is no NIfTI-1 in one file: export it again, as .nii".to_owned());
    }
    Ok(header)
}

fn storage(header: &NiftiHeader) -> std::result::Result<Storage, String> {
    let dims = header.dim().map_err(|error| format!("{error}: correct the sizes"))?;
    let (&[x, y, z], rest) = dims.split_first_chunk::<3>().ok_or_else(|| {
        format!("it has {} axes, and a volume has three: export it again", dims.len())
    })?;
    if rest.iter().any(|&count| count != 1) {
        return Err(format!("it has sizes {dims:?}: only one volume can be read, not a series"));
    }
    let slope = f64::from(header.scl_slope);
    let intercept = f64::from(header.scl_inter);
    let scales = slope != 0.0 && slope.is_finite() && intercept.is_finite();
    Ok(Storage {
        dims: [x, y, z].map(usize::from),
        scalar: scalar(header)?,
        big_endian: header.endianness == Endianness::Big,
        scaling: (scales && [slope, intercept] != [1.0, 0.0]).then_some([slope, intercept]),
    })
}

fn scalar(header: &NiftiHeader) -> std::result::Result<Scalar, String> {
    Ok(match header.data_type() {
        Ok(NiftiType::Uint8) => Scalar::U8,
        Ok(NiftiType::Int8) => Scalar::I8,
        Ok(NiftiType::Uint16) => Scalar::U16,
        Ok(NiftiType::Int16) => Scalar::I16,
        Ok(NiftiType::Uint32) => Scalar::U32,
        Ok(NiftiType::Int32) => Scalar::I32,
        Ok(NiftiType::Uint64) => Scalar::U64,
        Ok(NiftiType::Int64) => Scalar::I64,
        Ok(NiftiType::Float32) => Scalar::F32,
        Ok(NiftiType::Float64) => Scalar::F64,
        _ => {
            let code = header.datatype;
            return Err(format!(
                "its voxels (datatype {code}) are no labels: export whole numbers"
            ));
        }
    })
}

fn offset(header: &NiftiHeader) -> std::result::Result<usize, String> {
    let offset = header.vox_offset;
    if offset == 0.0 {
        return Ok(EARLIEST);
    }
    // Beyond 2³¹ not every whole number is a single-precision one.
    let valid = offset.fract() == 0.0 && (EARLIEST as f32..2f32.powi(31)).contains(&offset);
    if valid { Ok(offset as usize) } else { Err(format!("its voxels cannot begin at {offset}")) }
}

/// The sform, else the qform, else the spacings alone.
fn placement(header: &NiftiHeader) -> Placement {
    let [_, x, y, z, ..] = header.pixdim.map(f64::from);
    if header.sform_code > 0 {
        let rows = [header.srow_x, header.srow_y, header.srow_z].map(|row| row.map(f64::from));
        let column = |i: usize| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
        let steps = DMat3::from_cols(column(0), column(1), column(2));
        return Placement { origin: column(3), steps };
    }
    let spacings = DMat3::from_diagonal(DVec3::new(x, y, z));
    if header.qform_code > 0 {
        let [b, c, d] = [header.quatern_b, header.quatern_c, header.quatern_d].map(f64::from);
        let a = (1.0 - (b * b + c * c + d * d)).max(0.0).sqrt();
        let rotation = DMat3::from_quat(DQuat::from_xyzw(b, c, d, a).normalize());
        // The sign of the third axis.
        let side = if header.pixdim[0] < 0.0 { -1.0 } else { 1.0 };
        let steps = rotation * spacings * DMat3::from_diagonal(DVec3::new(1.0, 1.0, side));
        let shift = [header.quatern_x, header.quatern_y, header.quatern_z].map(f64::from);
        return Placement { origin: DVec3::from(shift), steps };
    }
    Placement { origin: DVec3::ZERO, steps: spacings }
}

/// The unit of length, from the lowest three bits.
fn units(header: &NiftiHeader) -> &'static str {
    match header.xyzt_units & 7 {
        1 => "m",
        2 => "mm",
        3 => "um",
        _ => "",
    }
}

#[cfg(test)]
mod tests;
