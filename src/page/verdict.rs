//! What a result is worth, in a few plain sentences.

use super::marks::visible;
use super::text::counted;
use crate::report::Report;

/// Below this Dice's coefficient a section is not what the surface shows there; there is a warning
/// then.
const POOR: f64 = 0.9;

/// Whether a reader may go on, should look at something first, or has nothing to rely on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    Good,
    Look,
    Bad,
}

/// The words on top of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    pub level: Level,
    pub sentences: Vec<String>,
}

impl Level {
    pub fn words(self) -> &'static str {
        match self {
            Self::Good => "Closed, and as drawn",
            Self::Look => "Something to look at",
            Self::Bad => "Not to be relied on",
        }
    }

    /// As a class of the page.
    pub fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Look => "look",
            Self::Bad => "bad",
        }
    }
}

impl Verdict {
    pub fn new(report: &Report) -> Self {
        let all = [closed(report), agreement(report), warnings(report)];
        let level = all.iter().map(|own| own.0).max().unwrap_or(Level::Bad);
        Self { level, sentences: all.into_iter().map(|own| own.1).collect() }
    }
}

fn closed(report: &Report) -> (Level, String) {
    let words = report.check.labels.iter().map(|label| label.closed_in_words());
    let words: Vec<&str> = words.collect();
    let count = |word: &str| words.iter().filter(|&&own| own == word).count();
    let (all, yes) = (words.len(), count("yes"));
    let [nothing, open, at_box] = [count("nothing"), count("NO"), count("but for the box")];
    if nothing == all {
        return (Level::Bad, "Nothing came out: there is no surface.".to_owned());
    }
    let mut sentence = match (all, yes) {
        (1, 1) => "The surface is closed and faces outward.".to_owned(),
        _ if yes == all => format!("All {all} surfaces are closed and face outward."),
        _ => format!("{yes} of {all} surfaces are closed and face outward."),
    };
    if at_box > 0 {
        sentence.push_str(&format!(
            " {at_box} {} open only where {} the box.",
            if at_box == 1 { "is" } else { "are" },
            if at_box == 1 { "it leaves" } else { "they leave" }
        ));
    }
    if open > 0 {
        sentence.push_str(&format!(" {open} {} NOT closed.", if open == 1 { "is" } else { "are" }));
        return (Level::Bad, sentence);
    }
    if nothing > 0 {
        sentence
            .push_str(&format!(" Of {} nothing came out.", counted(nothing, "label", "labels")));
        return (Level::Look, sentence);
    }
    (Level::Good, sentence)
}

fn agreement(report: &Report) -> (Level, String) {
    let dice = &report.check.dice;
    let Some((mean, least)) = dice.mean.zip(dice.min) else {
        return (
            Level::Look,
            "Nothing is on any section, so nothing could be compared.".to_owned(),
        );
    };
    let compared = dice.sections.iter().filter(|section| section.dice.is_some()).count();
    let figures = match compared {
        1 => format!("a Dice of {mean:.4}"),
        _ => {
            format!("a Dice of {mean:.4} in the mean over {compared} sections, {least:.4} at least")
        }
    };
    let poor = dice.sections.iter().filter(|own| own.dice.is_some_and(|dice| dice < POOR)).count();
    match poor {
        0 => (Level::Good, format!("The result shows what is drawn: {figures}.")),
        1 => (Level::Look, format!("One section is not what the result shows there: {figures}.")),
        _ => (
            Level::Look,
            format!("{poor} sections are not what the result shows there: {figures}."),
        ),
    }
}

fn warnings(report: &Report) -> (Level, String) {
    let mut also = Vec::new();
    let told = [
        (report.left_out.len(), "thing was left out", "things were left out"),
        (
            visible(report).count(),
            "pair of sections contradict each other",
            "pairs of sections contradict each other",
        ),
    ];
    for (count, one, many) in told {
        if count > 0 {
            also.push(counted(count, one, many));
        }
    }
    let count = report.warnings.len();
    let level = if count > 0 { Level::Look } else { Level::Good };
    let first = match count {
        0 => "There are no warnings".to_owned(),
        1 => "There is 1 warning".to_owned(),
        _ => format!("There are {count} warnings"),
    };
    also.insert(0, first);
    (level, format!("{}.", also.join("; ")))
}
