//! Places that a reader should go to: where to scan next, and where something is wrong.

use serde::Serialize;

use super::text::{name_of, place, with_unit};
use crate::report::Report;
use crate::section::Disagreement;

/// How many places of a kind are listed.
const LISTED: usize = 40;
/// A place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Mark {
    /// What it is called in the lists and in space.
    pub sign: String,
    pub kind: Kind,
    /// What is there, in words.
    pub what: String,
    pub at: [f64; 3],
}

/// Why a place is marked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The surface rests on little there.
    Scan,
    /// Something is not as it should be.
    Look,
}

/// The places of a report, those to scan first; and how many more there are of the others.
pub fn marks(report: &Report) -> (Vec<Mark>, usize) {
    let scan = report.check.support.parts.iter().enumerate().map(|(number, part)| {
        let names = part.labels.iter().map(|&label| name_of(label, &report.materials));
        let names: Vec<String> = names.collect();
        let distance = with_unit(part.distance, &report.units, "");
        let what = format!("{}: up to {distance} from any section", names.join(", "));
        Mark { sign: letter(number), kind: Kind::Scan, what, at: part.at }
    });
    let mut look = look(report);
    let rest = look.len().saturating_sub(LISTED);
    look.truncate(LISTED);
    let look = look.into_iter().enumerate().map(|(number, (what, at))| Mark {
        sign: (number + 1).to_string(),
        kind: Kind::Look,
        what,
        at,
    });
    (scan.take(LISTED).chain(look).collect(), rest)
}

/// A, B, …, Z, AA, AB, …
fn letter(number: usize) -> String {
    let own = char::from(b'A' + (number % 26) as u8);
    match number / 26 {
        0 => own.to_string(),
        rest => format!("{}{own}", letter(rest - 1)),
    }
}

fn look(report: &Report) -> Vec<(String, [f64; 3])> {
    let mut found = Vec::new();
    for label in &report.check.labels {
        let name = name_of(label.label, &report.materials);
        for passage in &label.passages {
            let between = passage.sections.join(" and ");
            found.extend(
                passage.torn.iter().map(|&at| (format!("{name}: torn between {between}"), at)),
            );
        }
        if let Some(pieces) = &label.pieces {
            let on = |sections: &[String]| sections.join(", ");
            found.extend(pieces.torn.iter().map(|tear| {
                (
                    format!(
                        "{name}: apart where sections show one piece, at {}",
                        on(&tear.sections)
                    ),
                    tear.at,
                )
            }));
            found.extend(pieces.out_of_place.iter().map(|tear| {
                (
                    format!(
                        "{name}: hangs together with neither neighbour, at {}",
                        on(&tear.sections)
                    ),
                    tear.at,
                )
            }));
        }
        found.extend(
            label
                .afloat
                .largest
                .iter()
                .map(|piece| (format!("{name}: a piece that no section passes through"), piece.at)),
        );
    }
    let mut far: Vec<_> = report.check.contours.far.iter().collect();
    far.sort_by(|one, other| {
        let [one, other] = [one, other].map(|own| own.distance.unwrap_or(f64::INFINITY));
        other.total_cmp(&one)
    });
    found.extend(far.into_iter().map(|far| {
        let name = name_of(far.label, &report.materials);
        let how_far = match far.distance {
            Some(voxels) => format!("{voxels:.1} voxels from the surface"),
            None => "nowhere near a surface".to_owned(),
        };
        (format!("{name}: the contour of section {} is {how_far}", far.section), far.at)
    }));
    if let Some(exact) = &report.exact {
        found.extend(exact.contradictions.iter().map(|own| {
            let middle = [0, 1, 2].map(|axis: usize| own.ends[0][axis].midpoint(own.ends[1][axis]));
            (contradict(&own.sections, &own.labels.each_ref().map(|own| own.join(" "))), middle)
        }));
    } else {
        found
            .extend(visible(report).map(|own| (contradict(&own.sections, &own.labels), own.worst)));
    }
    found
}

/// Where sections contradict each other on more than a voxel: what is shorter comes from rounded
/// contours, as a rule.
pub fn visible(report: &Report) -> impl Iterator<Item = &Disagreement> {
    report.disagreements.iter().filter(|own| own.worst_length > report.voxel)
}

fn contradict([one, other]: &[String; 2], [said, against]: &[String; 2]) -> String {
    format!("sections {one} and {other} contradict each other: {said} against {against}")
}

impl Mark {
    /// Where it is, in world units.
    pub fn place(&self) -> String {
        place(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_letters_and_go_on() {
        assert_eq!([0, 7, 25, 26, 27, 52].map(letter), ["A", "H", "Z", "AA", "AB", "BA"]);
    }
}
