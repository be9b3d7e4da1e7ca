//! NRRD (`.nrrd`, `.nhdr`), as volumes of labels; also the segmentations that
//! 3D Slicer writes (`.seg.nrrd`), as long as their segments do not overlap.

mod header;
mod layers;
mod write;

use std::borrow::Cow;
use std::path::Path;

use glam::{DMat3, DVec3};

use self::header::Header;
use super::volume::write::Voxels;
use super::volume::{Scalar, Storage, distinct, inflated};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::volume::{LabelVolume, Placement};

pub use layers::{has_layers, read_layers};
pub use write::write;

type Checked<T> = std::result::Result<T, String>;

/// Reads a file; `file` is for errors, and names the folder of detached data.
///
/// # Errors
/// Where it is no NRRD, is damaged, stored in a way that is not known, or
/// holds no labels.
pub fn read(bytes: &[u8], file: &Path) -> Result<LabelVolume> {
    let at = |what: String| Error::input(file, "the header", what);
    let (header, rest) = Header::read(bytes).map_err(at)?;
    let storage = storage(&header).map_err(at)?;
    let placement = placement(&header).map_err(at)?;
    let voxels = opened(&header, rest, &storage, file)?;
    let labels =
        labels(&header, &storage, &voxels).map_err(|what| Error::input(file, "the data", what))?;
    let mut volume = LabelVolume::new(storage.dims, labels, placement).map_err(at)?;
    volume.frame = frame(&header);
    volume.units = units(&header);
    let materials = segments(&header).into_iter().map(|(_, material)| material);
    volume.materials = distinct(materials.collect());
    Ok(volume)
}

/// The bytes of the voxels, as they are stored: after the header, or in a file of their own.
fn opened<'a>(
    header: &Header,
    rest: &'a [u8],
    storage: &Storage,
    file: &Path,
) -> Result<Cow<'a, [u8]>> {
    let voxels = match header.get("data file") {
        Some(name) => Cow::Owned(detached(name, file)?),
        None => Cow::Borrowed(rest),
    };
    let is_packed = ["gzip", "gz"].contains(&header.encoding());
    storage.require_memory(file, voxels.len(), is_packed)?;
    Ok(voxels)
}

/// Where the voxels of an image are, whatever is in them; axes without a direction do not count.
pub fn read_voxels(bytes: &[u8]) -> Checked<Voxels> {
    let (header, _) = Header::read(bytes)?;
    let dims = domain(&header)?;
    let placement = placement(&header)?;
    Ok(Voxels { dims, placement, units: units(&header), frame: frame(&header) })
}

/// The sizes along axes that have a direction: a list of layers, or colours, has none.
fn domain(header: &Header) -> Checked<[usize; 3]> {
    let mut sizes = header.numbers::<usize>("sizes")?.ok_or("it has no sizes")?;
    let directions = header.get("space directions").unwrap_or_default();
    let parts: Vec<&str> = directions.split_whitespace().collect();
    if parts.len() == sizes.len() {
        let mut has_direction = parts.iter().map(|part| *part != "none");
        sizes.retain(|_| has_direction.next().unwrap_or(true));
    }
    let axes = sizes.len();
    sizes.try_into().map_err(|_| format!("it has {axes} axes in space, and a volume has three"))
}

fn detached(name: &str, file: &Path) -> Result<Vec<u8>> {
    if name.starts_with("LIST") || name.contains('%') {
        let what = "its voxels are spread over several files: save it as one .nrrd";
        return Err(Error::input(file, "the header", what));
    }
    let path = file.parent().unwrap_or(Path::new("")).join(name);
    super::read_bytes(&path)
}

fn storage(header: &Header) -> Checked<Storage> {
    let sizes = header.numbers::<usize>("sizes")?.ok_or("it has no sizes")?;
    let dims: [usize; 3] = sizes.as_slice().try_into().map_err(|_| {
        let axes = sizes.len();
        format!(
            "it has {axes} axes, and a volume of labels has three: export it as one volume with a \
             number for each segment"
        )
    })?;
    scalar_storage(header, dims)
}

/// How numbers are stored, of so many voxels.
fn scalar_storage(header: &Header, dims: [usize; 3]) -> Checked<Storage> {
    let scalar = scalar(header.get("type").ok_or("it has no type")?)?;
    let text = ["ascii", "text", "txt"].contains(&header.encoding());
    let big_endian = match header.get("endian") {
        Some("big") => true,
        Some("little") => false,
        None if scalar.size() == 1 || text => false,
        Some(other) => return Err(format!("endian is {other:?}: it is little or big")),
        None => return Err("it has no endian: add \"endian: little\" or big".to_owned()),
    };
    Ok(Storage { dims, scalar, big_endian, scaling: None })
}

fn scalar(name: &str) -> Checked<Scalar> {
    Ok(match name {
        "signed char" | "int8" | "int8_t" => Scalar::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Scalar::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Scalar::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Scalar::U16,
        "int" | "signed int" | "int32" | "int32_t" => Scalar::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Scalar::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Scalar::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            Scalar::U64
        }
        "float" => Scalar::F32,
        "double" => Scalar::F64,
        other => return Err(format!("voxels of type {other:?} are no labels")),
    })
}

/// The labels in the data, which begin where the header ends.
fn labels(header: &Header, storage: &Storage, data: &[u8]) -> Checked<Vec<u32>> {
    if header.get("line skip").is_some_and(|lines| lines != "0") {
        return Err("lines before the voxels (line skip) are not read: save it anew".to_owned());
    }
    let skip = header.numbers::<i64>("byte skip")?.and_then(|all| all.first().copied());
    let needed = storage.bytes()?;
    match (header.encoding(), skip.unwrap_or(0)) {
        ("raw", -1) => storage.labels_exactly(&data[data.len().saturating_sub(needed)..]),
        ("raw", skip) => {
            let skip = usize::try_from(skip).map_err(|_| format!("byte skip is {skip}"))?;
            storage.labels_exactly(data.get(skip..).unwrap_or_default())
        }
        (_, 1..) => Err("compressed voxels with a byte skip are not read: save it anew".to_owned()),
        ("gzip" | "gz", _) => storage.labels_exactly(&inflated(data, needed)?),
        ("ascii" | "text" | "txt", _) => {
            let text = std::str::from_utf8(data).map_err(|_| "the voxels are no text")?;
            storage.labels_of_words(text)
        }
        (other, _) => {
            Err(format!("its encoding {other:?} is not read: save it as raw, gzip or ascii"))
        }
    }
}

fn placement(header: &Header) -> Checked<Placement> {
    let origin = header.vectors("space origin")?;
    let origin = origin.and_then(|all| all.first().copied()).unwrap_or(DVec3::ZERO);
    if let Some(steps) = header.vectors("space directions")? {
        let &[x, y, z] = steps.as_slice() else {
            return Err(format!("it has {} space directions for three axes", steps.len()));
        };
        return Ok(Placement { origin, steps: DMat3::from_cols(x, y, z) });
    }
    if header.get("axis mins").is_some() || header.get("axis maxs").is_some() {
        return Err("places by \"axis mins\" are not read: save it with space directions".into());
    }
    let spacings = match header.numbers::<f64>("spacings")? {
        None => DVec3::ONE,
        Some(spacings) => {
            let spacings: [f64; 3] =
                spacings.try_into().map_err(|_| "it has not three spacings for three axes")?;
            // Not known is written as nan.
            DVec3::from(spacings.map(|spacing| if spacing.is_nan() { 1.0 } else { spacing }))
        }
    };
    Ok(Placement { origin, steps: DMat3::from_diagonal(spacings) })
}

fn frame(header: &Header) -> String {
    let space = header.get("space").unwrap_or_default();
    let short = match space.to_lowercase().as_str() {
        "left-posterior-superior" | "lps" => "LPS",
        "right-anterior-superior" | "ras" => "RAS",
        "left-anterior-superior" | "las" => "LAS",
        _ => space,
    };
    short.to_owned()
}

/// The unit of length, where all axes have the same.
fn units(header: &Header) -> String {
    let text = header.get("space units").or_else(|| header.get("units")).unwrap_or_default();
    let mut units = text.split('"').skip(1).step_by(2);
    let first = units.next().unwrap_or_default();
    if units.all(|unit| unit == first) { first.to_owned() } else { String::new() }
}

/// The segments that 3D Slicer describes: `Segment0_LabelValue:=1`,
/// `Segment0_Name:=liver`, `Segment0_Color:=0.8 0.4 0.3`.
/// Each with its number there.
fn segments(header: &Header) -> Vec<(usize, Material)> {
    let mut found = Vec::new();
    for number in 0.. {
        let entry = |key: &str| header.key(&format!("Segment{number}_{key}"));
        let Some(value) = entry("LabelValue") else { return found };
        let Ok(id) = value.trim().parse() else { continue };
        let mut material = Material::numbered(Label(id));
        if let Some(name) = entry("Name") {
            name.clone_into(&mut material.name);
        }
        let channels = entry("Color").unwrap_or_default().split_whitespace();
        let channels: Option<Vec<f64>> = channels.map(|channel| channel.parse().ok()).collect();
        if let Some(Ok(color)) = channels.map(<[f64; 3]>::try_from) {
            material.color = color.map(|channel| (channel * 255.0).round() as u8);
        }
        found.push((number, material));
    }
    found
}

#[cfg(test)]
mod tests;
