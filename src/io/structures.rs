//! Structures that may overlap, as a file holds them: which of them are read, and whether they
//! exclude each other.

use std::path::{Path, PathBuf};

use crate::error::{Error, Remedy, Result};

/// Which structures of a file are read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Chosen {
    /// By their names or numbers; all where none is named.
    pub names: Vec<String>,
    /// Whether structures exclude each other, and which go first: where two overlap, what is in
    /// both belongs to the one that is named earlier here. Those that are not named follow, the
    /// smallest first: what lies within others is theirs then.
    pub partition: Option<Vec<String>>,
}

/// A structure as a file names it.
#[derive(Debug, Clone, Copy)]
pub struct Named<'a> {
    /// Its number in the file.
    pub number: u32,
    /// What people call it.
    pub name: &'a str,
    /// The area of its contours, or anything else that is larger for larger ones.
    pub size: f64,
}

impl Chosen {
    /// Which structures are read, by their places: in the order of the file, or of the partition.
    ///
    /// # Errors
    /// Where a name is none of theirs.
    pub fn of(&self, known: &[Named]) -> Result<Vec<usize>> {
        let wanted = match self.names.is_empty() {
            true => (0..known.len()).collect(),
            false => places("--structures", &self.names, known)?,
        };
        let mut rest: Vec<usize> = (0..known.len()).collect();
        let first = match &self.partition {
            Some(first) => {
                rest.sort_by(|&one, &other| known[one].size.total_cmp(&known[other].size));
                places("--partition", first, known)?
            }
            None => Vec::new(),
        };
        let mut order: Vec<usize> = Vec::new();
        for place in first.into_iter().chain(rest) {
            if wanted.contains(&place) && !order.contains(&place) {
                order.push(place);
            }
        }
        Ok(order)
    }
}

/// The structures that words stand for: the name, else the number, else the name in other letters
/// (`heart` for `Heart`).
fn places(option: &str, words: &[String], known: &[Named]) -> Result<Vec<usize>> {
    let mut places = Vec::new();
    for word in words.iter().map(|word| word.trim()) {
        let number = word.parse::<u32>().ok();
        let ways: [&dyn Fn(&Named) -> bool; 3] =
            [&|one| one.name == word, &|one| Some(one.number) == number, &|one| {
                one.name.to_lowercase() == word.to_lowercase()
            }];
        let of = |way: &&dyn Fn(&Named) -> bool| -> Vec<usize> {
            (0..known.len()).filter(|&place| way(&known[place])).collect()
        };
        match ways.iter().map(of).find(|own| !own.is_empty()) {
            Some(own) => places.extend(own),
            None => return Err(unknown(option, word, known)),
        }
    }
    Ok(places)
}

/// That there are several structures where there is room for one.
pub fn several(files: &[PathBuf], count: usize) -> Error {
    let what = format!(
        "it holds {count} structures that may overlap, each a solid of its own, and here is room for \
         one"
    );
    let file = files.first().map_or(Path::new(""), |file| file.as_path());
    Error::file(file, what).avoidable(Remedy::Structures)
}

fn unknown(option: &str, word: &str, known: &[Named]) -> Error {
    let names: Vec<String> =
        known.iter().map(|Named { number, name, .. }| format!("{name:?} ({number})")).collect();
    Error::Option(format!(
        "{option}: there is no structure {word:?}, but {}",
        super::text::listed(&names)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [Named<'static>; 3] = [
        Named { number: 1, name: "BODY", size: 9.0 },
        Named { number: 4, name: "Heart", size: 3.0 },
        Named { number: 7, name: "4", size: 5.0 },
    ];

    fn words(words: &[&str]) -> Vec<String> {
        words.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn structures_are_named_or_numbered() {
        let of = |names: &[&str]| Chosen { names: words(names), partition: None }.of(&KNOWN);
        assert_eq!(of(&[]), Ok(vec![0, 1, 2]));
        assert_eq!(of(&["heart ", "1"]), Ok(vec![0, 1]));
        assert_eq!(of(&["4"]), Ok(vec![2]), "a name goes before a number");
        let error = of(&["Liver"]).unwrap_err().to_string();
        assert!(error.contains("\"Liver\"") && error.contains("\"Heart\" (4)"), "{error}");
    }

    #[test]
    fn a_partition_has_an_order() {
        let of = |names: &[&str], first: &[&str]| {
            Chosen { names: words(names), partition: Some(words(first)) }.of(&KNOWN)
        };
        assert_eq!(of(&[], &[]), Ok(vec![1, 2, 0]), "the smallest first");
        assert_eq!(of(&[], &["BODY"]), Ok(vec![0, 1, 2]));
        assert_eq!(of(&["BODY", "Heart"], &["BODY"]), Ok(vec![0, 1]));
    }
}
