//! A walk over the bytes of a data set, before a library reads it: lengths that lie would make it
//! reserve what they promise, delimiters where none belong stop it, and it goes into sequences
//! within sequences as deep as they are (DICOM PS3.5, 7.1 and 7.5).

use std::ops::Range;

use dicom_core::dictionary::{DataDictionary, DataDictionaryEntry};
use dicom_core::{Tag, VR};
use dicom_dictionary_std::StandardDataDictionary;

/// Sequences within sequences; what people write has a handful.
const DEEPEST: usize = 24;
/// A length that is not given: delimiters end it.
const UNDEFINED: u32 = u32::MAX;

const ITEM: (u16, u16) = (0xfffe, 0xe000);
const ITEM_END: (u16, u16) = (0xfffe, 0xe00d);
const SEQUENCE_END: (u16, u16) = (0xfffe, 0xe0dd);
const PIXEL_DATA: (u16, u16) = (0x7fe0, 0x0010);

/// How elements are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Encoding {
    /// Whether elements say what kind of value they have.
    pub explicit: bool,
    pub big_endian: bool,
}

/// What is wrong and at which byte of the data set.
pub type Walked<T> = std::result::Result<T, (usize, &'static str)>;

/// Walks over a whole data set; the value of its element `wanted`, where it has that.
pub fn walk(bytes: &[u8], encoding: Encoding, wanted: Tag) -> Walked<Option<&[u8]>> {
    let wanted = (wanted.group(), wanted.element());
    let mut walk = Walk { bytes, at: 0, encoding, wanted, found: None };
    walk.elements(bytes.len(), false, 0)?;
    Ok(walk.found.map(|value| &bytes[value]))
}

struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
    wanted: (u16, u16),
    found: Option<Range<usize>>,
}

struct Header {
    tag: (u16, u16),
    length: u32,
    is_sequence: bool,
}

impl Walk<'_> {
    /// Elements up to `end`, or up to the end of an item.
    fn elements(&mut self, end: usize, delimited: bool, depth: usize) -> Walked<()> {
        while self.at < end {
            let start = self.at;
            let header = self.header(end)?;
            match header.tag {
                ITEM_END if delimited => return Ok(()),
                ITEM | ITEM_END | SEQUENCE_END => {
                    return Err((
                        start,
                        "there is an item, or an end of one, where an element belongs",
                    ));
                }
                tag if header.length == UNDEFINED && tag == PIXEL_DATA => self.fragments(end)?,
                _ if header.is_sequence || header.length == UNDEFINED => {
                    self.items(header.length, end, depth + 1)?;
                }
                tag => {
                    let start = self.at;
                    self.skip(header.length, end)?;
                    if depth == 0 && tag == self.wanted {
                        self.found = Some(start..self.at);
                    }
                }
            }
        }
        if delimited { Err((self.at, "an item has no end")) } else { Ok(()) }
    }

    /// The items of a sequence, of this length or up to its end.
    fn items(&mut self, length: u32, end: usize, depth: usize) -> Walked<()> {
        if depth > DEEPEST {
            return Err((self.at, "sequences are within one another too deep"));
        }
        let delimited = length == UNDEFINED;
        let end = if delimited { end } else { self.end(length, end)? };
        while self.at < end {
            let start = self.at;
            let (tag, length) = self.item(end)?;
            match tag {
                SEQUENCE_END if delimited => return Ok(()),
                ITEM if length == UNDEFINED => self.elements(end, true, depth)?,
                ITEM => {
                    let end = self.end(length, end)?;
                    self.elements(end, false, depth)?;
                }
                _ => return Err((start, "there is something else where an item belongs")),
            }
        }
        if delimited { Err((self.at, "a sequence has no end")) } else { Ok(()) }
    }

    /// The pieces of compressed pixels.
    fn fragments(&mut self, end: usize) -> Walked<()> {
        while self.at < end {
            let start = self.at;
            match self.item(end)? {
                (SEQUENCE_END, _) => return Ok(()),
                (ITEM, length) if length != UNDEFINED => self.skip(length, end)?,
                _ => {
                    return Err((
                        start,
                        "there is something else where a piece of the pixels belongs",
                    ));
                }
            }
        }
        Err((self.at, "the pixels have no end"))
    }

    fn header(&mut self, end: usize) -> Walked<Header> {
        let tag = (self.short(end)?, self.short(end)?);
        if tag.0 == ITEM.0 {
            return Ok(Header { tag, length: self.long(end)?, is_sequence: false });
        }
        if !self.encoding.explicit {
            let known = StandardDataDictionary.by_tag(Tag(tag.0, tag.1));
            let is_sequence = known.is_some_and(|entry| entry.vr().exact() == Some(VR::SQ));
            return Ok(Header { tag, length: self.long(end)?, is_sequence });
        }
        let start = self.at;
        self.skip(2, end)?;
        let kind = VR::from_binary([self.bytes[start], self.bytes[start + 1]]).unwrap_or(VR::UN);
        use VR::{OB, OD, OF, OL, OV, OW, SQ, SV, UC, UN, UR, UT, UV};
        let length = match kind {
            OB | OD | OF | OL | OV | OW | SQ | SV | UC | UN | UR | UT | UV => {
                self.skip(2, end)?;
                self.long(end)?
            }
            _ => u32::from(self.short(end)?),
        };
        Ok(Header { tag, length, is_sequence: kind == SQ })
    }

    fn item(&mut self, end: usize) -> Walked<((u16, u16), u32)> {
        Ok(((self.short(end)?, self.short(end)?), self.long(end)?))
    }

    /// Where a value of this length ends.
    fn end(&self, length: u32, end: usize) -> Walked<usize> {
        let own = usize::try_from(length).ok().and_then(|length| self.at.checked_add(length));
        own.filter(|&own| own <= end).ok_or((
            self.at,
            "a value is longer than what is left: the file is truncated or damaged",
        ))
    }

    fn skip(&mut self, length: u32, end: usize) -> Walked<()> {
        self.at = self.end(length, end)?;
        Ok(())
    }

    fn short(&mut self, end: usize) -> Walked<u16> {
        let start = self.at;
        self.skip(2, end)?;
        let pair = [self.bytes[start], self.bytes[start + 1]];
        Ok(if self.encoding.big_endian {
            u16::from_be_bytes(pair)
        } else {
            u16::from_le_bytes(pair)
        })
    }

    fn long(&mut self, end: usize) -> Walked<u32> {
        let pair = [self.short(end)?, self.short(end)?].map(u32::from);
        let [first, second] = pair;
        Ok(if self.encoding.big_endian { first << 16 | second } else { second << 16 | first })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IMPLICIT: Encoding = Encoding { explicit: false, big_endian: false };

    fn walked(bytes: &[u8]) -> Walked<Option<&[u8]>> {
        walk(bytes, IMPLICIT, Tag(0x3006, 0x0026))
    }

    fn element(tag: (u16, u16), length: u32, value: &[u8]) -> Vec<u8> {
        let mut bytes = [tag.0.to_le_bytes(), tag.1.to_le_bytes()].concat();
        bytes.extend(length.to_le_bytes());
        bytes.extend(value);
        bytes
    }

    #[test]
    fn sequences_of_either_kind_are_walked_over() {
        let value = element((0x3006, 0x0026), 4, b"BODY");
        let ended = [value.clone(), element(ITEM_END, 0, &[])].concat();
        let item = element(ITEM, value.len() as u32, &value);
        let undefined = [element(ITEM, UNDEFINED, &ended), element(SEQUENCE_END, 0, &[])].concat();
        let [defined, undefined] = [(item.len() as u32, &item), (UNDEFINED, &undefined)]
            .map(|(length, items)| element((0x3006, 0x0020), length, items));
        for sequence in [defined, undefined] {
            assert_eq!(walked(&sequence), Ok(None), "it is not wanted within sequences");
            for length in 1..sequence.len() {
                assert!(walked(&sequence[..length]).is_err(), "{length} bytes");
            }
        }
        assert_eq!(walked(&value), Ok(Some(b"BODY".as_slice())));
    }

    #[test]
    fn lies_are_found() {
        let long = element((0x3006, 0x0026), 5, b"BODY");
        assert_eq!(walked(&long).unwrap_err().0, 8);
        let stray = element(SEQUENCE_END, 0, &[]);
        assert!(walked(&stray).is_err());
        let mut deep = Vec::new();
        for _ in 0..1000 {
            deep.extend(element((0x3006, 0x0020), UNDEFINED, &element(ITEM, UNDEFINED, &[])));
        }
        assert!(walked(&deep).unwrap_err().1.contains("too deep"));
    }
}
