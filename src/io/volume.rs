//! Files of volumes of labels, by the ending of their name, and what they have
//! in common: many numbers of one type.

pub mod like;
pub mod write;

use std::io::Read;
use std::path::Path;

use flate2::read::{MultiGzDecoder, ZlibDecoder};
use rayon::prelude::*;

use super::{metaimage, nifti, nrrd};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::memory;
use crate::volume::LabelVolume;

/// The kinds of files that volumes are read from.
pub const VOLUME_KINDS: &str = ".nrrd, .nhdr, .nii, .nii.gz, .mha, .mhd";

/// Deflate makes no more bytes than this of one.
const DEFLATE: usize = 1032;

/// However large a number is, rounding explains no more than this.
const MOST_ROUNDING: f64 = 1e-3;

/// Whether a file is a volume by the ending of its name.
pub fn is_volume(path: &Path) -> bool {
    reader(path).is_some()
}

type Reader = fn(&[u8], &Path) -> Result<LabelVolume>;

fn reader(path: &Path) -> Option<Reader> {
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    let ends = |endings: &[&str]| endings.iter().any(|ending| name.ends_with(ending));
    if ends(&[".nrrd", ".nhdr"]) {
        Some(nrrd::read)
    } else if ends(&[".nii", ".nii.gz"]) {
        Some(nifti::read)
    } else if ends(&[".mha", ".mhd"]) {
        Some(metaimage::read)
    } else {
        None
    }
}

/// Reads a volume of labels. The numbers in the file are the labels; 0 is
/// outside.
///
/// # Errors
/// Where the file cannot be read or is damaged, and where it holds something
/// other than labels: fractions, negative numbers, more than three axes.
pub fn read_volume(path: &Path) -> Result<LabelVolume> {
    let Some(read) = reader(path) else {
        let what = format!("this kind of file is not known: volumes are read from {VOLUME_KINDS}");
        return Err(Error::file(path, what));
    };
    read(&super::read_bytes(path)?, path)
}

/// The type of the numbers in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Scalar {
    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// How the voxels of a file are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Storage {
    pub dims: [usize; 3],
    pub scalar: Scalar,
    pub big_endian: bool,
    /// Numbers stand for `slope · number + intercept`.
    pub scaling: Option<[f64; 2]>,
}

impl Storage {
    /// How many voxels there are; an error where no computer could count them.
    pub fn voxels(&self) -> std::result::Result<usize, String> {
        let count = self.dims.iter().try_fold(1usize, |all, &dim| all.checked_mul(dim));
        count
            .filter(|count| count.checked_mul(self.scalar.size()).is_some())
            .filter(|&count| count > 0)
            .ok_or_else(|| format!("{:?} voxels are no volume: correct the sizes", self.dims))
    }

    /// The bytes that the voxels take.
    pub fn bytes(&self) -> std::result::Result<usize, String> {
        Ok(self.voxels()? * self.scalar.size())
    }

    /// Refuses volumes that do not fit into memory, by their bytes and labels. Where a file of
    /// so many bytes cannot hold all voxels there are other words for it.
    pub fn require_memory(&self, file: &Path, length: usize, is_packed: bool) -> Result<()> {
        let voxels = self.voxels().map_err(|what| Error::file(file, what))?;
        let most = if is_packed { length.saturating_mul(DEFLATE) } else { length };
        if most < voxels {
            return Ok(());
        }
        let needed = (voxels as u64).saturating_mul((self.scalar.size() + size_of::<u32>()) as u64);
        let [x, y, z] = self.dims;
        memory::require(needed, || {
            format!("{}: a volume of {x} × {y} × {z} voxels", file.display())
        })
    }

    /// The label of every voxel, from their bytes.
    pub fn labels(&self, bytes: &[u8]) -> std::result::Result<Vec<u32>, String> {
        let needed = self.bytes()?;
        if bytes.len() < needed {
            return Err(format!(
                "{:?} voxels take {needed} bytes, and there are {}: the file is truncated, or its \
                 sizes are wrong",
                self.dims,
                bytes.len()
            ));
        }
        let bytes = &bytes[..needed];
        let numbers = match self.scalar {
            Scalar::U8 => self.decode(bytes, |[byte]| f64::from(byte)),
            Scalar::I8 => self.decode(bytes, |bytes| f64::from(i8::from_le_bytes(bytes))),
            Scalar::U16 => self.decode(bytes, |bytes| f64::from(u16::from_le_bytes(bytes))),
            Scalar::I16 => self.decode(bytes, |bytes| f64::from(i16::from_le_bytes(bytes))),
            Scalar::U32 => self.decode(bytes, |bytes| f64::from(u32::from_le_bytes(bytes))),
            Scalar::I32 => self.decode(bytes, |bytes| f64::from(i32::from_le_bytes(bytes))),
            // What is rounded here is too large for a label anyway.
            Scalar::U64 => self.decode(bytes, |bytes| u64::from_le_bytes(bytes) as f64),
            Scalar::I64 => self.decode(bytes, |bytes| i64::from_le_bytes(bytes) as f64),
            Scalar::F32 => self.decode(bytes, |bytes| f64::from(f32::from_le_bytes(bytes))),
            Scalar::F64 => self.decode(bytes, f64::from_le_bytes),
        };
        numbers.map_err(|(voxel, number)| self.no_label(voxel, number))
    }

    /// The same where no bytes must be left over.
    pub fn labels_exactly(&self, bytes: &[u8]) -> std::result::Result<Vec<u32>, String> {
        if bytes.len() > self.bytes()? {
            let dims = self.dims;
            return Err(format!("there is more than {dims:?} voxels: its sizes or type are wrong"));
        }
        self.labels(bytes)
    }

    /// The labels, or the first number that is none with its place.
    fn decode<const SIZE: usize>(
        &self,
        bytes: &[u8],
        number: impl Fn([u8; SIZE]) -> f64 + Sync,
    ) -> std::result::Result<Vec<u32>, (usize, f64)> {
        let value = |chunk: &[u8; SIZE]| {
            let mut bytes = *chunk;
            if self.big_endian {
                bytes.reverse();
            }
            self.scaled(number(bytes))
        };
        let chunks = bytes.as_chunks::<SIZE>().0;
        let none = Label::UNKNOWN.0;
        let labels: Vec<u32> =
            chunks.par_iter().map(|chunk| label(value(chunk)).unwrap_or(none)).collect();
        match labels.par_iter().position_first(|&label| label == none) {
            Some(voxel) => Err((voxel, value(&chunks[voxel]))),
            None => Ok(labels),
        }
    }

    /// The label of every voxel, from words.
    pub fn labels_of_words(&self, text: &str) -> std::result::Result<Vec<u32>, String> {
        let needed = self.voxels()?;
        let words = text.split(|c: char| c.is_whitespace() || c == ',');
        let mut labels = Vec::new(); // no capacity from sizes that may be wrong
        for word in words.filter(|word| !word.is_empty()) {
            let number = word.parse().map_err(|_| {
                let word = super::text::shortened(word);
                format!("{word:?}, number {}, is none", labels.len() + 1)
            })?;
            let found = label(self.scaled(number));
            labels.push(found.ok_or_else(|| self.no_label(labels.len(), number))?);
        }
        if labels.len() != needed {
            return Err(format!(
                "{:?} voxels are {needed} numbers, and there are {}: the file is truncated, or \
                 its sizes are wrong",
                self.dims,
                labels.len()
            ));
        }
        Ok(labels)
    }

    /// What a number stands for. Slope and intercept have single precision: a number as near to
    /// a whole one as their rounding explains is that one.
    fn scaled(&self, number: f64) -> f64 {
        let Some([slope, intercept]) = self.scaling else { return number };
        let value = slope * number + intercept;
        let rounding = f64::from(f32::EPSILON) * ((slope * number).abs() + intercept.abs());
        let whole = value.round();
        if (value - whole).abs() <= rounding.min(MOST_ROUNDING) { whole } else { value }
    }

    fn no_label(&self, voxel: usize, number: f64) -> String {
        let [x, y, _] = self.dims.map(|dim| dim.max(1));
        let place = [voxel % x, voxel / x % y, voxel / (x * y)];
        format!(
            "voxel {place:?} holds {number}: labels are whole numbers from 0 to {}: this is no \
             volume of labels, or it must be exported as one",
            Label::UNKNOWN.0 - 1
        )
    }
}

pub(super) fn label(number: f64) -> Option<u32> {
    let whole = number.fract() == 0.0 && (0.0..f64::from(Label::UNKNOWN.0)).contains(&number);
    whole.then_some(number as u32)
}

/// What gzip holds, but no more than `limit` bytes and one.
pub(super) fn inflated(bytes: &[u8], limit: usize) -> std::result::Result<Vec<u8>, String> {
    decoded(MultiGzDecoder::new(bytes), bytes, limit)
}

/// What zlib holds, or gzip where there is that instead; no more than `limit` bytes and one.
pub(super) fn inflated_zlib(bytes: &[u8], limit: usize) -> std::result::Result<Vec<u8>, String> {
    match bytes.starts_with(&[0x1f, 0x8b]) {
        true => inflated(bytes, limit),
        false => decoded(ZlibDecoder::new(bytes), bytes, limit),
    }
}

fn decoded(decoder: impl Read, bytes: &[u8], limit: usize) -> std::result::Result<Vec<u8>, String> {
    if bytes.len().saturating_mul(DEFLATE) < limit {
        return Err(format!(
            "{} compressed bytes cannot hold {limit}: the file is truncated, or its sizes are \
             wrong",
            bytes.len()
        ));
    }
    let mut found = Vec::new(); // grows as far as there is something
    match decoder.take(limit as u64 + 1).read_to_end(&mut found) {
        Err(error) if found.len() < limit => Err(format!(
            "its compressed data end after {} bytes of {limit} ({error}): export it again",
            found.len()
        )),
        // What is missing after the last voxel is not needed.
        _ => Ok(found),
    }
}

/// Materials that may be written anywhere: names that are taken or have a
/// meaning of their own get the label's number after them.
pub(super) fn distinct(materials: Vec<Material>) -> Vec<Material> {
    let mut distinct: Vec<Material> = Vec::with_capacity(materials.len());
    for mut material in materials {
        let name = &material.name;
        let taken = |known: &Material| known.name == *name;
        let reserved = ["", "outside", "unknown"].contains(&name.as_str());
        if reserved || distinct.iter().any(taken) {
            material.name = format!("{name} {}", material.id).trim().to_owned();
        }
        if !distinct.iter().any(|known| known.id == material.id) {
            distinct.push(material);
        }
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::*;

    fn storage(scalar: Scalar, big_endian: bool) -> Storage {
        Storage { dims: [3, 1, 1], scalar, big_endian, scaling: None }
    }

    #[test]
    fn every_type_of_number_is_read_in_both_orders() {
        // 1, 2 and 100 in each type, little endian.
        let numbers = |scalar: Scalar| -> Vec<Vec<u8>> {
            let bytes = |number: u8| match scalar {
                Scalar::F32 => f32::from(number).to_le_bytes().to_vec(),
                Scalar::F64 => f64::from(number).to_le_bytes().to_vec(),
                _ => u64::from(number).to_le_bytes()[..scalar.size()].to_vec(),
            };
            [1, 2, 100].map(bytes).to_vec()
        };
        use Scalar::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
        for scalar in [U8, I8, U16, I16, U32, I32, U64, I64, F32, F64] {
            let mut numbers = numbers(scalar);
            let read = |numbers: &[Vec<u8>], big| storage(scalar, big).labels(&numbers.concat());
            assert_eq!(read(&numbers, false), Ok(vec![1, 2, 100]), "{scalar:?}");
            numbers.iter_mut().for_each(|number| number.reverse());
            assert_eq!(read(&numbers, true), Ok(vec![1, 2, 100]), "{scalar:?}");
        }
    }

    #[test]
    fn what_is_no_label_is_named_with_its_place() {
        let error = |scalar, bytes: &[u8]| storage(scalar, false).labels(bytes).unwrap_err();
        assert!(error(Scalar::I8, &[1, 0xff, 3]).contains("voxel [1, 0, 0] holds -1"));
        let half = [0.0f32, 1.0, 1.5].map(f32::to_le_bytes).concat();
        assert!(error(Scalar::F32, &half).contains("voxel [2, 0, 0] holds 1.5"));
        assert!(error(Scalar::F32, &[0xff; 12]).contains("holds NaN"));
        assert!(error(Scalar::U32, &[0xff; 12]).contains("holds 4294967295"));
        assert!(error(Scalar::U16, &[0; 5]).contains("take 6 bytes, and there are 5"));
        let scaled = Storage { scaling: Some([0.5, 0.0]), ..storage(Scalar::U8, false) };
        assert_eq!(scaled.labels(&[2, 4, 0]), Ok(vec![1, 2, 0]));
        assert!(scaled.labels(&[2, 3, 0]).unwrap_err().contains("holds 1.5"));
        // A third in single precision, three times, is one; and no more than rounding is allowed.
        let third = f64::from(1.0f32 / 3.0);
        let scaled = |slope| Storage { scaling: Some([slope, 0.0]), ..storage(Scalar::U8, false) };
        assert_eq!(scaled(third).labels(&[3, 6, 0]), Ok(vec![1, 2, 0]));
        assert!(scaled(third + 1e-6).labels(&[3, 6, 0]).unwrap_err().contains("holds 1.000003"));
    }

    #[test]
    fn sizes_that_no_file_could_fill_are_refused_before_any_memory_is_taken() {
        let huge = Storage { dims: [usize::MAX, 2, 1], ..storage(Scalar::U8, false) };
        assert!(huge.labels(&[1]).unwrap_err().contains("no volume"));
        let large = Storage { dims: [1 << 20, 1 << 20, 1 << 10], ..huge };
        assert!(large.labels(&[1]).unwrap_err().contains("truncated"));
        assert!(inflated(&[0x1f, 0x8b], large.bytes().unwrap()).unwrap_err().contains("cannot"));
        let none = Storage { dims: [3, 0, 1], ..huge };
        assert!(none.labels(&[]).unwrap_err().contains("no volume"));
    }

    #[test]
    fn names_become_unique() {
        let material = |id, name: &str| Material { id, name: name.to_owned(), color: [0; 3] };
        let materials = ["a", "a", "outside", ""].iter().zip(1..);
        let materials = distinct(materials.map(|(name, id)| material(id, name)).collect());
        let names: Vec<&str> = materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["a", "a 2", "outside 3", "4"]);
    }
}
