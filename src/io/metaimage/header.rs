//! The header of a MetaImage: lines `Key = value`, up to the one that says where the voxels are.

use std::collections::BTreeMap;
use std::str::FromStr;

use super::Checked;
use crate::io::text::shortened;

/// No line is longer, and what begins with one is no header.
const LONGEST: usize = 1 << 20;
/// Sequences have dozens of lines for each frame, but no header is longer.
const MOST: usize = 1 << 28;

/// What is said of a file that has no such header.
const NONE: &str = "this is no MetaImage, whose lines are \"Key = value\": export it again";

/// What a header says.
#[derive(Debug, Default)]
pub struct Header {
    entries: BTreeMap<String, String>,
}

impl Header {
    /// The header, and what follows it.
    pub fn read(bytes: &[u8]) -> Checked<(Self, &[u8])> {
        let mut header = Self::default();
        let mut rest = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let mut length = 0;
        while let Some(line) = line(&mut rest) {
            length += line.len();
            if line.trim().is_empty() {
                continue;
            }
            let Some((key, value)) = line.split_once('=').filter(|_| length < MOST) else {
                return Err(match header.entries.is_empty() {
                    true => NONE.to_owned(),
                    false => {
                        let line = shortened(&line);
                        format!("the line {line:?} is not of the form \"Key = value\": correct it")
                    }
                });
            };
            let (key, value) = (key.trim().to_owned(), value.trim().to_owned());
            let is_last = key == "ElementDataFile";
            header.entries.insert(key, value);
            if is_last {
                return Ok((header, rest));
            }
        }
        let what = match header.entries.contains_key("NDims") {
            true => "it ends before ElementDataFile, which says where the voxels are: truncated",
            false => NONE,
        };
        Err(what.to_owned())
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.get(key).map(String::as_str)
    }

    /// The value of the first of several keys that mean the same.
    pub fn any<'a>(&self, keys: &[&'a str]) -> Option<(&'a str, &str)> {
        keys.iter().find_map(|&key| Some((key, self.get(key)?)))
    }

    /// All keys with their values.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &str)> {
        self.entries.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Whether a key is there and true: by its first letter, as ITK takes it.
    pub fn is_true(&self, keys: &[&str]) -> bool {
        self.any(keys).is_some_and(|(_, value)| value.starts_with(['T', 't', '1']))
    }

    /// So many numbers, under the first of several keys that is there.
    pub fn numbers<T: FromStr>(&self, keys: &[&str], count: usize) -> Checked<Option<Vec<T>>> {
        let Some((key, text)) = self.any(keys) else { return Ok(None) };
        let numbers = text.split_whitespace().map(str::parse).collect::<Result<Vec<T>, _>>();
        let numbers = numbers.ok().filter(|numbers| numbers.len() == count);
        let error = || format!("{key} is {:?}: {count} numbers belong there", shortened(text));
        numbers.map(Some).ok_or_else(error)
    }

    /// A whole number.
    pub fn number(&self, key: &str) -> Checked<Option<i64>> {
        let numbers = self.numbers(&[key], 1)?;
        Ok(numbers.and_then(|numbers| numbers.first().copied()))
    }
}

/// Takes the next line, without its end, or what is left of a file without one.
fn line(rest: &mut &[u8]) -> Option<String> {
    if rest.is_empty() {
        return None;
    }
    let within = &rest[..rest.len().min(LONGEST)];
    let end = match within.iter().position(|&byte| byte == b'\n') {
        Some(end) => end,
        // A header of its own may lack the last line's end.
        None if within.len() == rest.len() => rest.len(),
        None => return None,
    };
    let (line, after) = rest.split_at(end);
    *rest = after.get(1..).unwrap_or_default();
    Some(String::from_utf8_lossy(line).trim_end_matches('\r').to_owned())
}
