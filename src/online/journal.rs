//! A journal: every change on disk before anybody is told that it was made.
//!
//! It is text. After a first line that says what the file is, every line is a record:
//!
//! ```text
//! transect journal 1
//! 5cbe01b8 40 {"options":{"method":"mvc","bounds":null}}
//! └─ checksum └─ length of what follows, in bytes
//! ```
//!
//! The checksum is the CRC-32 of the contents of all records up to and with this one, so that
//! a record that is lost or moved does not go unnoticed either. A record that a crash cut
//! short is the last one; it was not acknowledged, and is dropped. Whatever else does not fit
//! is damage, and an error.

use std::fs::{File, OpenOptions};
use std::io::{self, BufRead, BufReader, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use crc32fast::Hasher;
use fs4::{FileExt, TryLockError};

use crate::error::{Error, Result};
use crate::output::{folder_of, write_error};

/// The first line, less the version.
const KIND: &str = "transect journal ";
/// The version that is written and read.
const VERSION: u32 = 1;

/// A journal that is written to; no other program writes to it meanwhile.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// How long it is, in bytes.
    end: u64,
    /// Of all contents so far.
    checksum: Hasher,
}

impl Journal {
    /// Writes a record and waits until it is on disk.
    ///
    /// # Errors
    /// When it cannot be written. What is there of it by then is taken away, or else dropped
    /// when the journal is read again.
    pub fn append(&mut self, content: &str) -> Result<()> {
        let mut checksum = self.checksum.clone();
        checksum.update(content.as_bytes());
        let sum = checksum.clone().finalize();
        self.write(&format!("{sum:08x} {} {content}\n", content.len()))?;
        self.checksum = checksum;
        Ok(())
    }

    fn write(&mut self, line: &str) -> Result<()> {
        let written = self.file.write_all(line.as_bytes()).and_then(|()| self.file.sync_data());
        if let Err(error) = written {
            // The error that counts is the first one.
            let _ = self.file.set_len(self.end);
            let _ = self.file.seek(SeekFrom::Start(self.end));
            return Err(write_error(&self.path, &error));
        }
        self.end += line.len() as u64;
        Ok(())
    }
}

/// The records of a journal, one after the other; [`Records::end`] must follow.
#[derive(Debug)]
pub struct Records {
    path: PathBuf,
    input: BufReader<File>,
    /// Where the last good record ends, in bytes.
    end: u64,
    /// Of all contents so far.
    checksum: Hasher,
    /// What a crash cut short.
    torn: Option<Torn>,
}

/// A last record that is not whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Torn {
    /// Where it begins.
    pub byte: u64,
    /// How many bytes of it there are.
    pub length: u64,
}

impl Records {
    /// Opens a journal, which is made where there is none.
    ///
    /// # Errors
    /// When another program has it open, when the file is none of ours, and when it cannot be
    /// read or made.
    pub fn open(path: &Path) -> Result<Self> {
        let failed = |error: io::Error| write_error(path, &error);
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false);
        let file = options.open(path).map_err(failed)?;
        if !file.metadata().map_err(failed)?.is_file() {
            return Err(Error::file(path, "a journal must be an ordinary file"));
        }
        FileExt::try_lock(&file).map_err(|error| match error {
            TryLockError::WouldBlock => {
                let what = "another transect has this journal open: end it, or name another file";
                Error::file(path, what)
            }
            TryLockError::Error(error) => failed(error),
        })?;
        // A new file is there after a crash only when its folder is on disk.
        #[cfg(unix)]
        File::open(folder_of(path)).and_then(|folder| folder.sync_all()).map_err(failed)?;
        let mut records = Self {
            path: path.to_owned(),
            input: BufReader::new(file),
            end: 0,
            checksum: Hasher::new(),
            torn: None,
        };
        records.read_kind()?;
        Ok(records)
    }

    /// Nothing at all, or only the beginning of the first line, is a journal without records.
    fn read_kind(&mut self) -> Result<()> {
        let expected = format!("{KIND}{VERSION}\n");
        let line = self.read_line()?;
        if line == expected.as_bytes() {
            self.end = line.len() as u64;
        } else if !expected.as_bytes().starts_with(&line) {
            let what = match line.strip_prefix(KIND.as_bytes()) {
                Some(_) => "its first line names another version of transect, or is damaged",
                None => "this is no journal of transect: name another file",
            };
            return Err(Error::file(&self.path, what));
        }
        Ok(())
    }

    fn read_line(&mut self) -> Result<Vec<u8>> {
        let mut line = Vec::new();
        self.input.read_until(b'\n', &mut line).map_err(|error| self.unread(&error))?;
        Ok(line)
    }

    fn unread(&self, error: &io::Error) -> Error {
        Error::file(&self.path, format!("it cannot be read: {error}"))
    }

    /// The next record.
    fn read_record(&mut self) -> Result<Option<String>> {
        let line = self.read_line()?;
        if line.is_empty() || self.torn.is_some() {
            return Ok(None);
        }
        let is_last = self.input.fill_buf().map(<[u8]>::is_empty);
        let is_last = is_last.map_err(|error| self.unread(&error))?;
        match Line::of(&line, &self.checksum) {
            Line::Whole(content, checksum) => {
                self.checksum = checksum;
                self.end += line.len() as u64;
                Ok(Some(content))
            }
            Line::Broken if is_last => {
                self.torn = Some(Torn { byte: self.end, length: line.len() as u64 });
                Ok(None)
            }
            Line::Broken | Line::Overlong => Err(Error::file(
                &self.path,
                format!(
                    "it is damaged in the record that begins at byte {0}, and others follow: what \
                     comes before can be had with `head -c {0}`",
                    self.end
                ),
            )),
        }
    }

    /// The journal, to be gone on with, and what was dropped from its end.
    ///
    /// # Errors
    /// When records were left unread, and when the file cannot be written.
    pub fn end(mut self) -> Result<(Journal, Option<Torn>)> {
        if self.read_record()?.is_some() {
            let what = "a journal was to be written before it was read".to_owned();
            return Err(Error::Bug { stage: "journal", what });
        }
        let Self { path, input, end, checksum, torn } = self;
        let mut file = input.into_inner();
        let cut = file.set_len(end).and_then(|()| file.seek(SeekFrom::Start(end)));
        cut.and_then(|_| file.sync_all()).map_err(|error| write_error(&path, &error))?;
        let mut journal = Journal { path, file, end, checksum };
        if end == 0 {
            journal.write(&format!("{KIND}{VERSION}\n"))?;
        }
        Ok((journal, torn))
    }
}

impl Iterator for Records {
    type Item = Result<String>;

    fn next(&mut self) -> Option<Self::Item> {
        self.read_record().transpose()
    }
}

/// What a line of a journal is.
enum Line {
    /// A record: its content, and the checksum with it.
    Whole(String, Hasher),
    /// None, or not all of one.
    Broken,
    /// A record that is whole, and more: the line's end is damaged, not its content.
    Overlong,
}

impl Line {
    /// Reads a line after what has this checksum.
    fn of(line: &[u8], before: &Hasher) -> Self {
        Self::try_of(line, before).unwrap_or(Self::Broken)
    }

    fn try_of(line: &[u8], before: &Hasher) -> Option<Self> {
        let mut parts = line.splitn(3, |&byte| byte == b' ');
        let [sum, length, rest] = [parts.next()?, parts.next()?, parts.next()?];
        let [sum, length] = [std::str::from_utf8(sum).ok()?, std::str::from_utf8(length).ok()?];
        let content = rest.get(..length.parse().ok()?)?;
        let mut checksum = before.clone();
        checksum.update(content);
        if sum.len() != 8 || u32::from_str_radix(sum, 16) != Ok(checksum.clone().finalize()) {
            return None;
        }
        match &rest[content.len()..] {
            b"\n" => Some(Self::Whole(String::from_utf8(content.to_vec()).ok()?, checksum)),
            [] | [_] => None,
            _ => Some(Self::Overlong),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use tempfile::TempDir;

    use super::*;

    const CONTENTS: [&str; 4] = [r#"{"a":1}"#, "", "ä b 3 \" x", "0123456789"];

    /// A journal in a folder of its own.
    fn journal(contents: &[&str]) -> (TempDir, PathBuf) {
        let folder = TempDir::new().expect("a folder");
        let path = folder.path().join("a.journal");
        let (mut journal, torn) = Records::open(&path).and_then(Records::end).expect("a journal");
        assert_eq!(torn, None);
        contents.iter().for_each(|content| journal.append(content).expect("it is appended"));
        (folder, path)
    }

    /// What is in it, and what was dropped.
    fn read(path: &Path) -> Result<(Vec<String>, Option<Torn>)> {
        let mut records = Records::open(path)?;
        let contents = records.by_ref().collect::<Result<Vec<_>>>()?;
        let (_, torn) = records.end()?;
        Ok((contents, torn))
    }

    #[test]
    fn what_is_appended_is_read_also_after_going_on() {
        let (_folder, path) = journal(&CONTENTS[..2]);
        let mut records = Records::open(&path).expect("a journal");
        assert_eq!(records.by_ref().filter_map(Result::ok).collect::<Vec<_>>(), CONTENTS[..2]);
        let (mut journal, _) = records.end().expect("a journal");
        CONTENTS[2..].iter().for_each(|content| journal.append(content).expect("appended"));
        drop(journal);
        assert_eq!(read(&path), Ok((CONTENTS.map(String::from).to_vec(), None)));
    }

    #[test]
    fn cut_anywhere_it_holds_what_was_whole_and_tells_the_rest() {
        let (_folder, path) = journal(&CONTENTS);
        let whole = fs::read(&path).expect("a file");
        let ends: Vec<usize> = (1..=whole.len()).filter(|&end| whole[end - 1] == b'\n').collect();
        assert_eq!(ends.len(), 5);
        for length in 0..=whole.len() {
            fs::write(&path, &whole[..length]).expect("written");
            let count = ends[1..].iter().filter(|&&end| end <= length).count();
            let (contents, torn) = read(&path).unwrap_or_else(|error| panic!("{length}: {error}"));
            assert_eq!(contents, CONTENTS[..count], "{length}");
            let end = ends.iter().copied().filter(|&end| end <= length).max().unwrap_or(0);
            let rest = (length - end) as u64;
            let expected = Torn { byte: end as u64, length: rest };
            let is_told = rest > 0 && length > ends[0];
            assert_eq!(torn, is_told.then_some(expected), "{length}");
            // And it can be gone on with.
            let mut records = Records::open(&path).expect("a journal");
            assert_eq!(records.by_ref().count(), count);
            records.end().expect("a journal").0.append("more").expect("appended");
            assert_eq!(read(&path).expect("a journal").0.last().map(String::as_str), Some("more"));
        }
    }

    #[test]
    fn damage_before_the_last_record_is_an_error_with_its_place() {
        let (_folder, path) = journal(&CONTENTS);
        let whole = fs::read(&path).expect("a file");
        let starts: Vec<usize> =
            (0..whole.len()).filter(|&start| start == 0 || whole[start - 1] == b'\n').collect();
        let last = starts[starts.len() - 1];
        for byte in 0..whole.len() {
            for flip in [1, 0x80] {
                let mut damaged = whole.clone();
                damaged[byte] ^= flip;
                fs::write(&path, &damaged).expect("written");
                let start = starts.iter().copied().filter(|&start| start <= byte).max();
                let start = start.expect("the first is 0");
                let found = read(&path);
                if byte >= last {
                    let (contents, torn) = found.unwrap_or_else(|error| panic!("{byte}: {error}"));
                    assert_eq!((contents.len(), torn.is_some()), (3, true), "{byte}");
                    continue;
                }
                let error = found.expect_err("damage").to_string();
                assert!(error.contains("a.journal"), "{error}");
                let place = match start {
                    0 if byte < KIND.len() => "no journal".into(),
                    0 => "first line".into(),
                    _ => format!("byte {start},"),
                };
                assert!(error.contains(&place), "{byte}: {place} is not in {error}");
                assert_eq!(fs::read(&path).expect("a file"), damaged, "it is left as it is");
            }
        }
    }

    #[test]
    fn one_program_at_a_time_has_it() {
        let (_folder, path) = journal(&CONTENTS);
        let first = Records::open(&path).expect("a journal");
        let error = Records::open(&path).expect_err("it is open").to_string();
        assert!(error.contains("another transect has this journal open"), "{error}");
        drop(first);
        assert!(Records::open(&path).is_ok());
    }

    #[test]
    fn other_files_are_no_journals() {
        let (folder, path) = journal(&[]);
        assert_eq!(fs::read_to_string(&path).expect("text"), "transect journal 1\n");
        fs::write(&path, "transect journal 2\n").expect("written");
        assert!(read(&path).expect_err("a version").to_string().contains("another version"));
        for text in ["CSLC\n", "tran\n", "\n", "x"] {
            fs::write(&path, text).expect("written");
            assert!(read(&path).expect_err(text).to_string().contains("no journal"), "{text}");
            assert_eq!(fs::read_to_string(&path).expect("text"), text);
        }
        assert!(read(folder.path()).is_err());
    }
}
