//! The sections on a page: plates to look through.

use maud::{Markup, PreEscaped, html};

use super::plates::{Plate, Plates};
use super::text::{name_of, text};
use crate::report::Report;

/// How many labels of a plate are named.
const NAMED: usize = 3;
/// Below this Dice's coefficient a section is marked.
const POOR: f64 = 0.9;

/// Plates, the worst first, and what was left out.
pub fn sections(plates: &Plates, report: &Report) -> Markup {
    html! {
        p {
            "Areas are what is drawn, the line is the result on the section's plane. The worst "
            "come first; one to look at closer opens when it is clicked."
            @if plates.shown.iter().any(|plate| plate.unknown > 0.0) { " Hatched is unknown." }
        }
        (hatching())
        div.plates {
            @for (number, plate) in plates.shown.iter().enumerate() { (figure(number, plate, report)) }
        }
        @if let Some(words) = left_out(plates) { p { (words) } }
        dialog #large aria-label="A section, larger" {
            div.turn {
                button type="button" data-step="-1" aria-label="The one before" { "‹" }
                p {}
                button type="button" data-step="1" aria-label="The next one" { "›" }
                button type="button" data-close="" aria-label="Close" { "×" }
            }
            div.sheet {}
        }
    }
}

/// What is not shown.
fn left_out(plates: &Plates) -> Option<String> {
    let Plates { shown, count, empty, next } = plates;
    let shown = shown.len();
    let mut words = match next {
        None if *empty == 0 => return None,
        None => format!("{shown} of {count} sections are shown."),
        Some(None) => format!(
            "{shown} of {count} sections are shown; of the others there is nothing to compare."
        ),
        Some(Some(dice)) => format!(
            "{shown} of {count} sections are shown; those left out have a Dice of {dice:.4} or more."
        ),
    };
    if *empty > 0 {
        words.push_str(&format!(" On {empty} there is no line to show."));
    }
    Some(words)
}

fn figure(number: usize, plate: &Plate, report: &Report) -> Markup {
    let Plate { name, labels, dice, unknown, size: [width, height], .. } = plate;
    let view = format!("0 0 {width} {height}");
    let named = labels.iter().take(NAMED).map(|&label| name_of(label, &report.materials));
    let mut named: Vec<String> = named.collect();
    if labels.len() > NAMED {
        named.push(format!("and {} more", labels.len() - NAMED));
    }
    if *unknown > 0.0 {
        named.push(format!("{:.0} % unknown", 100.0 * unknown));
    }
    let [above, left] = &plate.directions;
    html! {
        figure.plate {
            button type="button" data-plate=(number) {
                svg viewBox=(view) role="img" aria-label="What is drawn, and the result" {
                    (PreEscaped(&plate.drawing))
                }
                span.above { (above) }
                span.left { (left) }
            }
            figcaption {
                span.name { (text(name)) }
                @match dice {
                    Some(dice) => span class=(if *dice < POOR { "dice doubtful" } else { "dice" }) { (format!("{dice:.4}")) },
                    None => span.dice { "–" },
                }
                small {
                    @if !named.is_empty() { (text(&named.join(", "))) "; " }
                    "bar " (plate.bar) " " (text(&report.units))
                }
            }
        }
    }
}

/// The pattern of what is unknown, for all drawings of the page.
fn hatching() -> Markup {
    html! {
        svg.pattern width="0" height="0" aria-hidden="true" {
            defs {
                pattern #hatching width="40" height="40" patternUnits="userSpaceOnUse" patternTransform="rotate(45)" {
                    rect width="40" height="40" {}
                    path d="M20 0v40" {}
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_out_is_told() {
        let plates = |next, empty| Plates { shown: Vec::new(), count: 70, empty, next };
        assert_eq!(left_out(&plates(None, 0)), None);
        let told = left_out(&plates(Some(Some(0.98)), 3)).expect("words");
        assert!(
            told.contains("0 of 70") && told.contains("Dice of 0.9800") && told.contains("On 3")
        );
        assert!(left_out(&plates(Some(None), 0)).expect("words").contains("nothing to compare"));
    }
}
