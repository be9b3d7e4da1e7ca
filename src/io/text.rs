//! Text files of rows of words, as `.csl` and `.contour` are: blank lines do
//! not count, and every row can be named by its line.

use std::path::Path;
use std::str::FromStr;

use glam::DVec3;

use crate::error::{Error, Result};
use crate::label::Label;

/// A file's rows, one after the other.
pub(super) struct Rows<'a> {
    file: &'a Path,
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    /// What begins a comment, which goes on to the end of its line.
    comment: Option<char>,
    /// The number of the last line that was read, from 1.
    pub line: usize,
}

impl<'a> Rows<'a> {
    /// The rows of a text; `file` is for errors.
    pub fn new(text: &'a str, file: &'a Path) -> Self {
        Self { file, lines: text.lines().enumerate(), comment: None, line: 0 }
    }

    /// The same without the comments that begin with a character.
    pub fn without_comments(self, comment: char) -> Self {
        Self { comment: Some(comment), ..self }
    }

    /// The next row with words on it, if there is one.
    pub fn try_next(&mut self) -> Option<&'a str> {
        for (number, line) in self.lines.by_ref() {
            self.line = number + 1;
            let end = self.comment.and_then(|comment| line.find(comment)).unwrap_or(line.len());
            let line = &line[..end];
            if !line.trim().is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// The next row, which must hold `what`, of section `section`.
    pub fn next(&mut self, section: &str, what: impl Fn() -> String) -> Result<Row<'a>> {
        let Some(line) = self.try_next() else {
            return Err(Error::input(
                self.file,
                place(section, self.line),
                format!(
                    "the file ends where {} should follow: it is truncated, or a count is wrong",
                    what()
                ),
            ));
        };
        let words: Vec<&str> = line.split_whitespace().collect();
        Ok(Row { file: self.file, section: section.to_owned(), line: self.line, words })
    }
}

/// Where something is: a line, of a section if one is given.
fn place(section: &str, line: usize) -> String {
    if section.is_empty() {
        format!("line {line}")
    } else {
        format!("section {section}, line {line}")
    }
}

/// The words of one line.
pub(super) struct Row<'a> {
    file: &'a Path,
    section: String,
    pub line: usize,
    pub words: Vec<&'a str>,
}

impl Row<'_> {
    /// An error at this line.
    pub fn error(&self, what: impl ToString) -> Error {
        Error::input(self.file, place(&self.section, self.line), what)
    }

    /// Refuses rows that do not have this many words.
    pub fn expect(&self, count: usize, what: impl Fn() -> String) -> Result<()> {
        if self.words.len() == count {
            return Ok(());
        }
        Err(self.error(format!(
            "{} has {count} entries, this line has {}: correct it",
            what(),
            self.words.len()
        )))
    }

    /// Word `i` as a whole number from 0.
    pub fn count(&self, i: usize, what: &str) -> Result<usize> {
        self.parse(i, what, "a whole number from 0")
    }

    /// Word `i` as a number that is not infinite or NaN.
    pub fn number(&self, i: usize, what: &str) -> Result<f64> {
        let value: f64 = self.parse(i, what, "a number")?;
        if !value.is_finite() {
            return Err(self.error(format!("{what} is {value}: it must be finite")));
        }
        Ok(value)
    }

    /// Words `i` to `i + 2` as a point or vector.
    pub fn vector(&self, i: usize, what: &str) -> Result<DVec3> {
        Ok(DVec3::new(self.number(i, what)?, self.number(i + 1, what)?, self.number(i + 2, what)?))
    }

    /// Word `i` as a label; no number stands for *unknown*.
    pub fn label(&self, i: usize) -> Result<Label> {
        let label = Label(self.parse(i, "a label", "a whole number from 0")?);
        if label == Label::UNKNOWN {
            return Err(self.error(format!("the label {} is too large", label.0)));
        }
        Ok(label)
    }

    /// Word `i` as the index of one of `count` things.
    pub fn index(&self, i: usize, count: usize) -> Result<u32> {
        let index: usize = self.count(i, "a vertex index")?;
        if index >= count {
            return Err(self.error(format!(
                "vertex index {index} is out of range: there are {count} vertices, from 0"
            )));
        }
        u32::try_from(index).map_err(|_| self.error(format!("vertex index {index} is too large")))
    }

    fn parse<T: FromStr>(&self, i: usize, what: &str, kind: &str) -> Result<T> {
        let word = self.words.get(i).copied().unwrap_or_default();
        word.parse().map_err(|_| {
            self.error(format!("{what} should be {kind}, but is {:?}", shortened(word)))
        })
    }
}

/// The next three words as a point.
pub(super) fn point<'a>(
    words: &mut impl Iterator<Item = &'a str>,
) -> std::result::Result<DVec3, String> {
    let mut point = DVec3::ZERO;
    for axis in 0..3 {
        let word = words.next().ok_or("a vertex has fewer than three coordinates")?;
        point[axis] = word.parse().map_err(|_| format!("{:?} is no number", shortened(word)))?;
    }
    Ok(point)
}

/// How many entries of a list an error shows.
const LISTED: usize = 20;

/// A list for an error: not too long.
pub(super) fn listed(words: &[String]) -> String {
    let rest = words.len().saturating_sub(LISTED);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    format!("{}{more}", words[..words.len() - rest].join(", "))
}

/// A text as the value of an attribute in XML, which has no place for control characters.
pub(super) fn attribute(text: &str) -> String {
    let mut value = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => value.push_str("&amp;"),
            '<' => value.push_str("&lt;"),
            '>' => value.push_str("&gt;"),
            '"' => value.push_str("&quot;"),
            '\u{fffe}' | '\u{ffff}' => value.push(' '),
            character if character.is_control() => value.push(' '),
            character => value.push(character),
        }
    }
    value
}

/// A word for an error: not too long.
pub(super) fn shortened(word: &str) -> String {
    let mut short: String = word.chars().take(24).collect();
    if short.len() < word.len() {
        short.push('…');
    }
    short
}

/// The shortest decimal that reads as the same double.
pub fn shortest(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".to_owned()
    } else if (1e-5..1e16).contains(&size) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
