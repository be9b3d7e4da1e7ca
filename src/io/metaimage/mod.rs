//! MetaImage (`.mha`, `.mhd`), as volumes of labels, and as sequences of tracked frames.

mod header;
mod sequence;
mod write;

use std::borrow::Cow;
use std::path::Path;

use glam::{DMat3, DVec3};

use self::header::Header;
use super::text::shortened;
use super::volume::write::Voxels;
use super::volume::{Scalar, Storage, inflated_zlib};
use crate::error::{Error, Result};
use crate::volume::{LabelVolume, Placement};

pub use sequence::{Chain, Facts, Sequence, TransformFacts};
pub use write::write;

type Checked<T> = std::result::Result<T, String>;

/// Keys that mean the same, as ITK takes them.
const ORIGIN: [&str; 3] = ["Offset", "Position", "Origin"];
const DIRECTIONS: [&str; 3] = ["TransformMatrix", "Orientation", "Rotation"];
const SPACING: [&str; 2] = ["ElementSpacing", "ElementSize"];
const BIG_ENDIAN: [&str; 2] = ["BinaryDataByteOrderMSB", "ElementByteOrderMSB"];

/// Reads a file; `file` is for errors, and names the folder of detached voxels.
///
/// # Errors
/// Where it is no MetaImage, is damaged, stored in a way that is not known, or holds no labels.
pub fn read(bytes: &[u8], file: &Path) -> Result<LabelVolume> {
    let at = |what: String| Error::input(file, "the header", what);
    let (header, rest) = Header::read(bytes).map_err(at)?;
    if Sequence::read(&header).map_err(at)?.is_some() {
        let what = "it holds a sequence of tracked frames, which are sections and no volume";
        return Err(Error::file(file, what));
    }
    let storage = storage(&header).map_err(at)?;
    let placement = placement(&header).map_err(at)?;
    let labels = voxels(&header, &storage, [bytes, rest], file)?;
    let mut volume = LabelVolume::new(storage.dims, labels, placement).map_err(at)?;
    "LPS".clone_into(&mut volume.frame);
    "mm".clone_into(&mut volume.units);
    Ok(volume)
}

/// Where the voxels of an image are, whatever is in them.
pub fn read_voxels(bytes: &[u8]) -> Checked<Voxels> {
    let (header, _) = Header::read(bytes)?;
    if header.number("NDims")? != Some(3) {
        return Err("it has not three axes: a volume has".to_owned());
    }
    let dims = header.numbers(&["DimSize"], 3)?.ok_or("it has no DimSize")?;
    let dims = [dims[0], dims[1], dims[2]];
    let (units, frame) = ("mm".to_owned(), "LPS".to_owned());
    Ok(Voxels { dims, placement: placement(&header)?, units, frame })
}

/// A sequence of tracked frames with the numbers in their pixels.
#[derive(Debug)]
pub struct Frames {
    /// Where they are.
    pub sequence: Sequence,
    /// Pixels of a row, and rows.
    pub size: [usize; 2],
    /// Of one frame after the other, row by row.
    pub labels: Vec<u32>,
}

/// Whether a file is a MetaImage by the ending of its name.
pub fn is_metaimage(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ["mha", "mhd"].contains(&ending.as_str())
}

/// Reads a sequence of tracked frames; `None` where it is none.
///
/// # Errors
/// As [`read`].
pub fn read_frames(bytes: &[u8], file: &Path) -> Result<Option<Frames>> {
    let at = |what: String| Error::input(file, "the header", what);
    let (header, rest) = Header::read(bytes).map_err(at)?;
    let Some(sequence) = Sequence::read(&header).map_err(at)? else { return Ok(None) };
    let storage = storage(&header).map_err(at)?;
    let labels = voxels(&header, &storage, [bytes, rest], file)?;
    let [width, height, _] = storage.dims;
    Ok(Some(Frames { sequence, size: [width, height], labels }))
}

/// What a file says of tracked frames, whatever their pixels hold; `None` where it is no sequence.
///
/// # Errors
/// Where the file or its header cannot be read.
pub fn sequence_facts(file: &Path) -> Result<Option<Facts>> {
    if !is_metaimage(file) {
        return Ok(None);
    }
    let bytes = super::read_bytes(file)?;
    let at = |what: String| Error::input(file, "the header", what);
    let (header, _) = Header::read(&bytes).map_err(at)?;
    let Some(sequence) = Sequence::read(&header).map_err(at)? else { return Ok(None) };
    let [width, height, _] = storage(&header).map_err(at)?.dims;
    Ok(Some(sequence.facts(file.display().to_string(), [width, height])))
}

/// The numbers of all voxels; `bytes` are the file, and what follows its header.
fn voxels(
    header: &Header,
    storage: &Storage,
    [bytes, rest]: [&[u8]; 2],
    file: &Path,
) -> Result<Vec<u32>> {
    let at = |what: String| Error::input(file, "the header", what);
    // That many bytes from the beginning of the file, which holds the header, too.
    let is_skipped = header.number("HeaderSize").map_err(at)?.is_some_and(|size| size > 0);
    let data = data(header, if is_skipped { bytes } else { rest }, file)?;
    labels(header, storage, &data, file)
}

fn storage(header: &Header) -> Checked<Storage> {
    if let Some(kind) = header.get("ObjectType").filter(|&kind| kind != "Image") {
        return Err(format!("it holds an object of type {kind:?}, and only Image is read"));
    }
    let axes = header.number("NDims")?.ok_or("it has no NDims")?;
    if axes != 3 {
        return Err(format!("it has {axes} axes, and a volume has three: export it as one volume"));
    }
    if let Some(channels) = header.number("ElementNumberOfChannels")?.filter(|&count| count != 1) {
        return Err(format!(
            "it has {channels} channels, and labels are one number for each voxel: export one \
             channel"
        ));
    }
    let dims = header.numbers(&["DimSize"], 3)?.ok_or("it has no DimSize")?;
    Ok(Storage {
        dims: [dims[0], dims[1], dims[2]],
        scalar: scalar(header.get("ElementType").ok_or("it has no ElementType")?)?,
        big_endian: header.is_true(&BIG_ENDIAN),
        scaling: None,
    })
}

fn scalar(name: &str) -> Checked<Scalar> {
    Ok(match name {
        "MET_CHAR" => Scalar::I8,
        "MET_UCHAR" => Scalar::U8,
        "MET_SHORT" => Scalar::I16,
        "MET_USHORT" => Scalar::U16,
        // Long is four bytes there, whatever it is elsewhere.
        "MET_INT" | "MET_LONG" => Scalar::I32,
        "MET_UINT" | "MET_ULONG" => Scalar::U32,
        "MET_LONG_LONG" => Scalar::I64,
        "MET_ULONG_LONG" => Scalar::U64,
        "MET_FLOAT" => Scalar::F32,
        "MET_DOUBLE" => Scalar::F64,
        other => return Err(format!("voxels of type {other:?} are no labels")),
    })
}

/// Every row of the matrix is the direction of one axis.
fn placement(header: &Header) -> Checked<Placement> {
    let three = |keys: &[&str], default| -> Checked<DVec3> {
        let numbers = header.numbers(keys, 3)?;
        Ok(numbers.map_or(default, |numbers| DVec3::from_slice(&numbers)))
    };
    let (origin, spacing) = (three(&ORIGIN, DVec3::ZERO)?, three(&SPACING, DVec3::ONE)?);
    let directions = header.numbers(&DIRECTIONS, 9)?;
    let directions = directions.map_or(DMat3::IDENTITY, |rows| DMat3::from_cols_slice(&rows));
    Ok(Placement { origin, steps: directions * DMat3::from_diagonal(spacing) })
}

/// The bytes of the voxels, as they are stored: after the header, or in a file of their own.
fn data<'a>(header: &Header, rest: &'a [u8], file: &Path) -> Result<Cow<'a, [u8]>> {
    let name = header.get("ElementDataFile").unwrap_or_default();
    if name.eq_ignore_ascii_case("local") {
        return Ok(Cow::Borrowed(rest));
    }
    let what = match name {
        "" => "ElementDataFile says no file: correct it",
        _ if name.starts_with("LIST") || name.contains('%') => {
            "its voxels are spread over several files: save it as one .mha"
        }
        _ => {
            let path = file.parent().unwrap_or(Path::new("")).join(name);
            let words = |error| match error {
                Error::File { what, .. } => {
                    let what = format!("its voxels should be in {:?}: {what}", shortened(name));
                    Error::input(file, "the header", what)
                }
                other => other,
            };
            return super::read_bytes(&path).map(Cow::Owned).map_err(words);
        }
    };
    Err(Error::input(file, "the header", what))
}

/// The label of every voxel.
fn labels(header: &Header, storage: &Storage, data: &[u8], file: &Path) -> Result<Vec<u32>> {
    let at = |what: String| Error::input(file, "the header", what);
    let is_packed = header.is_true(&["CompressedData"]);
    let needed = storage.bytes().map_err(at)?;
    let data = match header.number("HeaderSize").map_err(at)?.unwrap_or(0) {
        0 => data,
        -1 if !is_packed => &data[data.len().saturating_sub(needed)..],
        size => {
            let size = usize::try_from(size);
            let size = size.map_err(|_| at("HeaderSize is negative: correct it".to_owned()))?;
            data.get(size..).unwrap_or_default()
        }
    };
    storage.require_memory(file, data.len(), is_packed)?;
    let is_text = header.get("BinaryData").is_some() && !header.is_true(&["BinaryData"]);
    let labels = match (is_text, is_packed) {
        (true, _) => storage.labels_of_words(&String::from_utf8_lossy(data)),
        (_, true) => inflated_zlib(data, needed).and_then(|data| storage.labels_exactly(&data)),
        _ => storage.labels_exactly(data),
    };
    labels.map_err(|what| Error::input(file, "the data", what))
}

#[cfg(test)]
mod tests;
