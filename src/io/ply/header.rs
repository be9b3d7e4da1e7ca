//! What a PLY file says that it holds.

use super::super::text::shortened;
use super::values::{Encoding, Scalar};

/// The header of a PLY file.
#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

/// Things of one kind: vertices, faces.
#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// A number, or a list of numbers, that every element of a kind has.
#[derive(Debug)]
pub struct Property {
    pub name: String,
    pub kind: Scalar,
    /// How the length of a list is written; `None` for a single number.
    pub length: Option<Scalar>,
}

impl Element {
    /// The bytes that one takes at least.
    fn least_bytes(&self, encoding: Encoding) -> usize {
        let bytes = |property: &Property| match encoding {
            // A digit, and a blank.
            Encoding::Text => 2,
            _ => property.length.unwrap_or(property.kind).size(),
        };
        self.properties.iter().map(bytes).sum()
    }
}

impl Header {
    /// Refuses counts of elements for which so many bytes have no room.
    pub fn require_room(&self, bytes: usize) -> Result<(), String> {
        for element in self.elements.iter().filter(|element| element.count > 0) {
            let (name, count) = (shortened(&element.name), element.count);
            // The last blank may be missing.
            let most = bytes.saturating_add(1).checked_div(element.least_bytes(self.encoding));
            let most = most.ok_or_else(|| format!("the element {name:?} has no properties"))?;
            if count > most as u64 {
                return Err(format!(
                    "it promises {count} of {name:?}, and {bytes} bytes follow: the file is cut \
                     off, or its header is damaged"
                ));
            }
        }
        Ok(())
    }

    /// The header, and what follows it.
    pub fn read(bytes: &[u8]) -> Result<(Self, &[u8]), String> {
        let mut rest = bytes;
        if next_line(&mut rest)? != "ply" {
            return Err("it does not begin with \"ply\": this is no PLY file".to_owned());
        }
        let mut encoding = None;
        let mut elements = Vec::new();
        loop {
            let line = next_line(&mut rest)?;
            let words: Vec<&str> = line.split_whitespace().collect();
            match words[..] {
                ["format", name, _] => encoding = Some(Encoding::named(name)?),
                ["element", name, count] => {
                    let count =
                        count.parse().map_err(|_| format!("{:?} has no count", shortened(line)))?;
                    elements.push(Element { name: name.to_owned(), count, properties: vec![] });
                }
                ["property", ..] => {
                    let element = elements.last_mut().ok_or("a property comes before elements")?;
                    element.properties.push(property(&words)?);
                }
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                _ => return Err(format!("{:?} is not understood", shortened(line))),
            }
        }
        let encoding = encoding.ok_or("there is no line \"format\"")?;
        Ok((Self { encoding, elements }, rest))
    }
}

fn property(words: &[&str]) -> Result<Property, String> {
    match words {
        ["property", "list", length, kind, name] => Ok(Property {
            name: (*name).to_owned(),
            kind: Scalar::named(kind)?,
            length: Some(Scalar::named(length)?),
        }),
        ["property", kind, name] => {
            Ok(Property { name: (*name).to_owned(), kind: Scalar::named(kind)?, length: None })
        }
        _ => Err(format!("{:?} is not understood", shortened(&words.join(" ")))),
    }
}

fn next_line<'a>(rest: &mut &'a [u8]) -> Result<&'a str, String> {
    let end = rest.iter().position(|&byte| byte == b'\n').ok_or("it has no end")?;
    let (line, after) = rest.split_at(end);
    *rest = &after[1..];
    let line = std::str::from_utf8(line).map_err(|_| "it is no text")?;
    Ok(line.trim_end_matches('\r'))
}
