//! What people read on a terminal. Files of others hold names with any characters in them: none
//! of these moves the cursor, ends a line or turns the direction of writing.

use std::fmt;
use std::io::{self, Write};

/// A longer word is cut short, and so is a longer message in its middle.
const WORD: usize = 100;
const MESSAGE: usize = 1200;
/// What is left of a word, and of a number's digits.
const LEFT: usize = 60;
const DIGITS: usize = 24;
/// No more characters of what a library says are quoted.
const QUOTED: usize = 200;

/// Whether a character does something else than being shown.
fn is_control(character: char) -> bool {
    let turns = matches!(
        character,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
    );
    character.is_control() || turns
}

/// A text with escapes in place of what a terminal would obey: `\n`, `\u{1b}`.
pub fn escaped(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        match is_control(character) {
            true => shown.extend(character.escape_default()),
            false => shown.push(character),
        }
    }
    shown
}

/// A message as one line, whatever is quoted in it: long words, numbers of hundreds of digits
/// and long texts are cut short.
pub fn shortened(text: &str) -> String {
    let words: Vec<String> = text.split_whitespace().map(short_word).collect();
    let line = words.join(" ");
    let count = line.chars().count();
    if count <= MESSAGE {
        return line;
    }
    // What to do about it comes last.
    let (first, last) = (2 * MESSAGE / 3, MESSAGE / 3);
    let begin: String = line.chars().take(first).collect();
    let end: String = line.chars().skip(count - last).collect();
    format!("{begin} … {end}")
}

/// What a library says about a file, for a message of ours: it may quote whole tables.
pub fn quoted(words: impl fmt::Display) -> String {
    let words = shortened(&words.to_string());
    match words.char_indices().nth(QUOTED) {
        Some((end, _)) => format!("{}…", &words[..end]),
        None => words,
    }
}

fn short_word(word: &str) -> String {
    let mut short = String::with_capacity(word.len().min(4 * WORD));
    let (mut digits, mut cut) = (0, false);
    for character in word.chars() {
        digits = if character.is_ascii_digit() { digits + 1 } else { 0 };
        match digits {
            ..=DIGITS => short.push(character),
            _ if digits == DIGITS + 1 => short.push('…'),
            _ => (),
        }
        cut |= short.chars().count() > WORD;
        if cut {
            break;
        }
    }
    if !cut {
        return short;
    }
    short.chars().take(LEFT).chain(['…']).collect()
}

/// Tells a line on standard error. That nobody can read it is no reason to stop.
pub fn tell(line: &str) {
    let _ = io::stderr().write_all(format!("{}\n", escaped(line)).as_bytes());
}

/// Lines for a terminal. Each `write!` or `writeln!` is a part of one line: only a line end that
/// is the last of it ends the line, and what else has a meaning for terminals is escaped.
#[derive(Debug, Default)]
pub struct Lines(String);

impl Lines {
    /// As they are shown.
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Shows them on standard error, if anybody reads it.
    pub fn tell(&self) {
        let _ = io::stderr().write_all(self.0.as_bytes());
    }
}

impl fmt::Write for Lines {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let (line, end) = text.strip_suffix('\n').map_or((text, ""), |line| (line, "\n"));
        self.0.push_str(&escaped(line));
        self.0.push_str(end);
        Ok(())
    }

    /// As a whole: a name in it must not end the line.
    fn write_fmt(&mut self, arguments: fmt::Arguments<'_>) -> fmt::Result {
        self.write_str(&arguments.to_string())
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;

    #[test]
    fn names_neither_end_lines_nor_move_the_cursor() {
        let mut lines = Lines::default();
        let (name, units) = ("a\nb", "\u{1b}[2J\u{7}\u{9b}\u{202e}é");
        writeln!(lines, "{name:<8}|{units}").unwrap();
        lines.write_str("\r").unwrap();
        writeln!(lines).unwrap();
        let expected = "a\\nb     |\\u{1b}[2J\\u{7}\\u{9b}\\u{202e}é\n\\r\n";
        assert_eq!(lines.as_str(), expected);
    }

    #[test]
    fn what_is_long_is_cut_short() {
        let number = format!("[{}, -1]", 1e300);
        assert_eq!(shortened(&number), format!("[1{}…, -1]", "0".repeat(23)));
        let garbage = format!("{:?}\n is no number", "x".repeat(5000));
        assert_eq!(shortened(&garbage), format!("\"{}… is no number", "x".repeat(59)));
        assert_eq!(quoted(format_args!("{}", "ab ".repeat(100))).chars().count(), QUOTED + 1);
        assert_eq!(quoted("bad checksum"), "bad checksum");
        let long = format!("a name {}: rename it", "of words ".repeat(1000));
        let short = shortened(&long);
        assert!(short.chars().count() < 1300 && short.ends_with(": rename it"), "{short}");
        assert_eq!(
            shortened("it is as it is: 0.1234567890123456"),
            "it is as it is: 0.1234567890123456"
        );
    }
}
