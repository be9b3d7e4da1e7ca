//! The header of an NRRD file: lines of text up to an empty one.

use std::collections::BTreeMap;
use std::str::FromStr;

use glam::DVec3;

use super::super::text::shortened;
use super::Checked;

/// No header is longer; what is, is none.
const LONGEST: usize = 1 << 24;

/// What a header says.
#[derive(Debug, Default)]
pub struct Header {
    /// `name: value`, names in lower case.
    fields: BTreeMap<String, String>,
    /// `key:=value`.
    keys: BTreeMap<String, String>,
}

impl Header {
    /// The header, and what follows it.
    pub fn read(bytes: &[u8]) -> Checked<(Self, &[u8])> {
        let mut header = Self::default();
        let mut rest = bytes;
        let magic = line(&mut rest).unwrap_or_default();
        if !(magic.starts_with("NRRD000") && magic.trim_end().len() == 8) {
            return Err("an NRRD file begins with NRRD0004 or a like word: it is none".to_owned());
        }
        while let Some(line) = line(&mut rest) {
            if line.is_empty() {
                return Ok((header, rest));
            }
            header.add(&line)?;
        }
        // A detached header may end with the file.
        if header.fields.contains_key("data file") { Ok((header, rest)) } else { Err(ended()) }
    }

    fn add(&mut self, line: &str) -> Checked<()> {
        if line.starts_with('#') {
            return Ok(());
        }
        let field = line.split_once(": ").or_else(|| line.split_once(':'));
        match (line.split_once(":="), field) {
            // Whichever sign comes first: a key may hold the other in its value.
            (Some((key, value)), field)
                if field.is_none_or(|(name, _)| key.len() <= name.len()) =>
            {
                self.keys.insert(key.to_owned(), value.to_owned());
            }
            (_, Some((name, value))) => {
                let name = match name.trim().to_lowercase().as_str() {
                    "datafile" => "data file".to_owned(),
                    "byteskip" => "byte skip".to_owned(),
                    "lineskip" => "line skip".to_owned(),
                    "axismins" => "axis mins".to_owned(),
                    "axismaxs" => "axis maxs".to_owned(),
                    other => other.to_owned(),
                };
                self.fields.insert(name, value.trim().to_owned());
            }
            (_, None) => {
                let line = shortened(line);
                return Err(format!("the line {line:?} is neither a field nor a key: correct it"));
            }
        }
        Ok(())
    }

    /// A field's value.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.fields.get(name).map(String::as_str)
    }

    /// A key's value.
    pub fn key(&self, key: &str) -> Option<&str> {
        self.keys.get(key).map(String::as_str)
    }

    /// How the voxels are stored.
    pub fn encoding(&self) -> &str {
        self.get("encoding").unwrap_or("raw")
    }

    /// A field of numbers.
    pub fn numbers<T: FromStr>(&self, name: &str) -> Checked<Option<Vec<T>>> {
        let Some(text) = self.get(name) else { return Ok(None) };
        let numbers = text.split_whitespace().map(str::parse).collect::<Result<_, _>>();
        let error = |_| format!("{name} is {:?}: numbers belong there", shortened(text));
        numbers.map(Some).map_err(error)
    }

    /// A field of vectors: `(1,0,0) (0,1,0)`.
    pub fn vectors(&self, name: &str) -> Checked<Option<Vec<DVec3>>> {
        let Some(text) = self.get(name) else { return Ok(None) };
        let error =
            || format!("{name} is {:?}: vectors of three numbers belong there", shortened(text));
        // An axis without a direction.
        let text = text.replace("none", "");
        let parts = text.split(')').map(str::trim).filter(|part| !part.is_empty());
        let vectors = parts.map(|part| {
            let numbers = part.strip_prefix('(')?.split(',').map(|number| number.trim().parse());
            let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().ok()?;
            <[f64; 3]>::try_from(numbers).ok().map(DVec3::from)
        });
        vectors.collect::<Option<Vec<_>>>().map(Some).ok_or_else(error)
    }
}

/// Takes the next line, without its end; `None` when no line ends any more.
fn line(rest: &mut &[u8]) -> Option<String> {
    let end = rest.iter().take(LONGEST).position(|&byte| byte == b'\n')?;
    let (line, after) = rest.split_at(end);
    *rest = &after[1..];
    let text = String::from_utf8_lossy(line);
    Some(text.trim_end_matches('\r').to_owned())
}

fn ended() -> String {
    "it ends before the empty line that should follow the header: it is truncated".to_owned()
}
