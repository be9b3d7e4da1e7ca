//! VTK's XML files: arrays of numbers as words, as base64 or as bytes, compressed or not
//! ("VTK XML Formats", the file format's documentation).

use std::io::Read;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use flate2::read::ZlibDecoder;
use roxmltree::{Document, Node};

use crate::memory;

pub type Checked<T> = std::result::Result<T, String>;

/// Some writers leave the padding out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);
/// What begins the data that follow the elements.
const APPENDED: &[u8] = b"<AppendedData";
/// Deflate makes no more bytes than this of one.
const DEFLATE: usize = 1032;

/// The elements of a file and the data that follow them.
pub struct Parts<'a> {
    pub text: String,
    appended: &'a [u8],
    is_base64: bool,
}

impl<'a> Parts<'a> {
    /// Divides the bytes of a file. Appended bytes are no text.
    pub fn of(bytes: &'a [u8]) -> Checked<Self> {
        let place = bytes.windows(APPENDED.len()).position(|window| window == APPENDED);
        let (head, rest) = bytes.split_at(place.unwrap_or(bytes.len()));
        let text = String::from_utf8(head.to_vec())
            .map_err(|error| format!("byte {} is no text", error.utf8_error().valid_up_to()))?;
        let Some(_) = place else { return Ok(Self { text, appended: &[], is_base64: false }) };
        let end =
            rest.iter().position(|&byte| byte == b'>').ok_or("the appended data are cut off")?;
        let tag = String::from_utf8_lossy(&rest[..end]);
        let is_base64 = tag.contains("base64");
        let data = &rest[end + 1..];
        let start =
            data.iter().position(|&byte| byte == b'_').ok_or("there is no appended data")?;
        let appended = &data[start + 1..];
        Ok(Self { text: text + "</VTKFile>", appended, is_base64 })
    }
}

/// A file of one kind of data set.
pub struct VtkFile<'a> {
    root: Node<'a, 'a>,
    data_set: Node<'a, 'a>,
    parts: &'a Parts<'a>,
    big_endian: bool,
    /// Bytes of a length.
    header: usize,
    /// Whether blocks are packed.
    is_packed: bool,
}

impl<'a> VtkFile<'a> {
    /// Looks at a document, which is of this kind.
    pub fn new(document: &'a Document<'a>, parts: &'a Parts<'a>, kind: &str) -> Checked<Self> {
        let root = document.root_element();
        if root.tag_name().name() != "VTKFile" {
            return Err("this is no file of VTK: export it again".to_owned());
        }
        let data_set = root.children().find(|child| child.has_tag_name(kind));
        let data_set = data_set.ok_or_else(|| {
            let found = super::text::shortened(root.attribute("type").unwrap_or("nothing"));
            format!("it holds {found}, and lines are read from {kind}")
        })?;
        let is_packed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let other = super::text::shortened(other);
                return Err(format!("it is compressed by {other}: write it with zlib or without"));
            }
        };
        let header = match root.attribute("header_type") {
            Some("UInt64") => 8,
            _ => 4,
        };
        let big_endian = root.attribute("byte_order") == Some("BigEndian");
        Ok(Self { root, data_set, parts, big_endian, header, is_packed })
    }

    /// The pieces of the data set.
    pub fn pieces(&self) -> impl Iterator<Item = Node<'a, 'a>> + use<'a> {
        self.data_set.children().filter(|child| child.has_tag_name("Piece"))
    }

    /// The numbers of an array; none where there is no array.
    pub fn numbers(&self, array: Option<Node>) -> Checked<Vec<f64>> {
        let Some(array) = array else { return Ok(Vec::new()) };
        let name = super::text::shortened(array.attribute("Name").unwrap_or("without a name"));
        self.read(array).map_err(|what| format!("array {name}: {what}"))
    }

    fn read(&self, array: Node) -> Checked<Vec<f64>> {
        let text = array.text().unwrap_or_default();
        let bytes = match array.attribute("format") {
            Some("binary") => self.unpacked(&decoded(text.as_bytes())?)?,
            Some("appended") => {
                let offset = array.attribute("offset").and_then(|own| own.parse::<usize>().ok());
                let data = offset.and_then(|offset| self.parts.appended.get(offset..));
                let data = data.ok_or("its offset is beyond the appended data")?;
                match self.parts.is_base64 {
                    true => self.unpacked(&decoded(&data[..self.reach(offset, data)])?)?,
                    false => self.unpacked(data)?,
                }
            }
            _ => {
                let number = |word: &str| {
                    let shown = || format!("{:?} is no number", super::text::shortened(word));
                    word.parse::<f64>().map_err(|_| shown())
                };
                return text.split_whitespace().map(number).collect();
            }
        };
        let big = self.big_endian;
        Ok(match array.attribute("type").unwrap_or_default() {
            "Int8" => numbers(&bytes, big, |own| f64::from(i8::from_le_bytes(own))),
            "UInt8" => numbers(&bytes, big, |[own]| f64::from(own)),
            "Int16" => numbers(&bytes, big, |own| f64::from(i16::from_le_bytes(own))),
            "UInt16" => numbers(&bytes, big, |own| f64::from(u16::from_le_bytes(own))),
            "Int32" => numbers(&bytes, big, |own| f64::from(i32::from_le_bytes(own))),
            "UInt32" => numbers(&bytes, big, |own| f64::from(u32::from_le_bytes(own))),
            // What is rounded here is too large anyway.
            "Int64" => numbers(&bytes, big, |own| i64::from_le_bytes(own) as f64),
            "UInt64" => numbers(&bytes, big, |own| u64::from_le_bytes(own) as f64),
            "Float32" => numbers(&bytes, big, |own| f64::from(f32::from_le_bytes(own))),
            "Float64" => numbers(&bytes, big, f64::from_le_bytes),
            other => {
                let other = super::text::shortened(other);
                return Err(format!("numbers of type {other:?} are not known"));
            }
        })
    }

    /// Up to where encoded data go: to the next array or the end.
    fn reach(&self, offset: Option<usize>, data: &[u8]) -> usize {
        let offsets = self.root.descendants().filter_map(|node| node.attribute("offset"));
        let next = offsets
            .filter_map(|own| own.parse::<usize>().ok()?.checked_sub(offset?))
            .filter(|&distance| distance > 0)
            .min();
        let end = data.iter().position(|&byte| byte == b'<').unwrap_or(data.len());
        next.unwrap_or(end).min(end)
    }

    /// What follows the length of data, unpacked if it is packed.
    fn unpacked(&self, bytes: &[u8]) -> Checked<Vec<u8>> {
        let length = |number: usize| -> Checked<usize> {
            let own = number
                .checked_mul(self.header)
                .and_then(|start| bytes.get(start..start.checked_add(self.header)?));
            let own = own.ok_or("the data are cut off")?;
            let wide = own.iter().enumerate().fold(0u64, |all, (place, &byte)| {
                let place = if self.big_endian { self.header - 1 - place } else { place };
                all | u64::from(byte) << (8 * place)
            });
            usize::try_from(wide).map_err(|_| "its length is beyond all memory".to_owned())
        };
        let cut_off = || "the data are cut off".to_owned();
        if !self.is_packed {
            let own = length(0)?.checked_add(self.header);
            return bytes
                .get(self.header..own.ok_or_else(cut_off)?)
                .map(<[u8]>::to_vec)
                .ok_or_else(cut_off);
        }
        let (blocks, size) = (length(0)?, length(1)?);
        let start = blocks.checked_add(3).and_then(|all| all.checked_mul(self.header));
        let mut rest = start.and_then(|start| bytes.get(start..)).ok_or_else(cut_off)?;
        let total = blocks.checked_mul(size).filter(|&all| all / DEFLATE <= bytes.len());
        let total = total.ok_or("its lengths are more than so few bytes can hold")?;
        memory::require(3 * total as u64, || "an array of VTK".to_owned())
            .map_err(|error| error.to_string())?;
        let mut all = Vec::new();
        for block in 0..blocks {
            let packed = length(3 + block)?;
            let (own, after) = rest.split_at_checked(packed).ok_or_else(cut_off)?;
            let read = ZlibDecoder::new(own).take(size as u64).read_to_end(&mut all);
            read.map_err(|error| format!("a block cannot be unpacked ({error})"))?;
            rest = after;
        }
        Ok(all)
    }
}

/// The child of an element.
pub fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|child| child.has_tag_name(name))
}

/// The first array of an element whose name is one of those wanted.
pub fn array<'a>(node: Node<'a, 'a>, wanted: impl Fn(&str) -> bool) -> Option<Node<'a, 'a>> {
    let mut arrays = node.children().filter(|child| child.has_tag_name("DataArray"));
    arrays.find(|array| wanted(array.attribute("Name").unwrap_or_default()))
}

/// Bytes from base64. Lengths and data may each be padded.
fn decoded(text: &[u8]) -> Checked<Vec<u8>> {
    let text: Vec<u8> = text.iter().copied().filter(|byte| !byte.is_ascii_whitespace()).collect();
    let mut bytes = Vec::new();
    for part in text.split(|&byte| byte == b'=').filter(|part| !part.is_empty()) {
        let failed = |error| format!("it is no base64 ({error})");
        BASE64.decode_vec(part, &mut bytes).map_err(failed)?;
    }
    Ok(bytes)
}

fn numbers<const SIZE: usize>(
    bytes: &[u8],
    big_endian: bool,
    number: impl Fn([u8; SIZE]) -> f64,
) -> Vec<f64> {
    let number = |chunk: &[u8; SIZE]| {
        let mut own = *chunk;
        if big_endian {
            own.reverse();
        }
        number(own)
    };
    bytes.as_chunks::<SIZE>().0.iter().map(number).collect()
}
