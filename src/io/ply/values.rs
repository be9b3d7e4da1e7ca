//! The numbers of a PLY file, in text or binary.

use super::super::text::shortened;
use super::header::Property;

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

impl Encoding {
    /// As a header names it.
    pub fn named(name: &str) -> Result<Self, String> {
        match name {
            "ascii" => Ok(Self::Text),
            "binary_little_endian" => Ok(Self::LittleEndian),
            "binary_big_endian" => Ok(Self::BigEndian),
            _ => Err(format!("the format {:?} is not known", shortened(name))),
        }
    }
}

/// A type of number; all fit into a double.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// As a header names it.
    pub fn named(name: &str) -> Result<Self, String> {
        match name {
            "char" | "int8" => Ok(Self::I8),
            "uchar" | "uint8" => Ok(Self::U8),
            "short" | "int16" => Ok(Self::I16),
            "ushort" | "uint16" => Ok(Self::U16),
            "int" | "int32" => Ok(Self::I32),
            "uint" | "uint32" => Ok(Self::U32),
            "float" | "float32" => Ok(Self::F32),
            "double" | "float64" => Ok(Self::F64),
            _ => Err(format!("the type {:?} is not known", shortened(name))),
        }
    }

    /// Bytes of a number.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// From `size` bytes, the least significant first, padded to eight.
    fn decode(self, bytes: [u8; 8]) -> f64 {
        let [a, b, c, d, ..] = bytes;
        match self {
            Self::I8 => f64::from(a.cast_signed()),
            Self::U8 => f64::from(a),
            Self::I16 => f64::from(i16::from_le_bytes([a, b])),
            Self::U16 => f64::from(u16::from_le_bytes([a, b])),
            Self::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Self::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Self::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Self::F64 => f64::from_le_bytes(bytes),
        }
    }
}

/// Reads numbers one after the other.
pub struct Values<'a> {
    encoding: Encoding,
    rest: &'a [u8],
}

impl<'a> Values<'a> {
    pub fn new(encoding: Encoding, rest: &'a [u8]) -> Self {
        Self { encoding, rest }
    }

    /// The number or numbers of a property.
    pub fn read(&mut self, property: &Property) -> Result<Vec<f64>, String> {
        let count = match property.length {
            None => 1.0,
            Some(length) => self.next(length)?,
        };
        if count.fract() != 0.0 || count < 0.0 {
            return Err(format!("a list cannot have {count} numbers"));
        }
        (0..count as u64).map(|_| self.next(property.kind)).collect()
    }

    fn next(&mut self, kind: Scalar) -> Result<f64, String> {
        if self.encoding == Encoding::Text {
            return self.next_word();
        }
        let (bytes, rest) = self.rest.split_at_checked(kind.size()).ok_or(ENDS_EARLY)?;
        self.rest = rest;
        let mut padded = [0; 8];
        padded[..bytes.len()].copy_from_slice(bytes);
        if self.encoding == Encoding::BigEndian {
            padded[..bytes.len()].reverse();
        }
        Ok(kind.decode(padded))
    }

    fn next_word(&mut self) -> Result<f64, String> {
        let trimmed = self.rest.trim_ascii_start();
        let end = trimmed.iter().position(u8::is_ascii_whitespace).unwrap_or(trimmed.len());
        let (word, rest) = trimmed.split_at(end);
        if word.is_empty() {
            return Err(ENDS_EARLY.to_owned());
        }
        self.rest = rest;
        let word = String::from_utf8_lossy(word);
        word.parse().map_err(|_| format!("{:?} is no number", shortened(&word)))
    }
}

const ENDS_EARLY: &str = "the file ends here: it is cut off, copy or export it again";
