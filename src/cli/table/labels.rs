//! What became of each label.

use std::fmt::{Result, Write};

use super::{LABELS, number};
use crate::check::LabelCheck;
use crate::check::passage::Passage;
use crate::report::Report;
use crate::terminal::Lines;

/// How many places are shown where pieces begin and end.
const PASSAGES: usize = 8;
/// How many characters of a name.
const NAME: usize = 23;

/// A row for each label, and then what is to be said of some.
pub fn write_labels(out: &mut Lines, report: &Report) -> Result {
    let labels = &report.check.labels;
    let stacked = if report.check.stack.is_some() { "of stack" } else { "" };
    writeln!(
        out,
        "{:<24}{:>14}{stacked:>10}{:>14}{:>12}{:>8}{:>8}  closed",
        "label", "volume", "area", "components", "genus", "ripple"
    )?;
    for label in labels.iter().take(LABELS) {
        write_label(out, report, label)?;
    }
    let rest = labels.len().saturating_sub(LABELS);
    if rest > 0 {
        writeln!(out, "… and {rest} more labels")?;
    }
    write_passages(out, report)?;
    labels.iter().try_for_each(|label| write_unreached(out, report, label))
}

fn name(report: &Report, label: &LabelCheck) -> String {
    let material = report.materials.iter().find(|material| material.id == label.label);
    let name = material.map_or_else(|| label.label.to_string(), |found| found.name.clone());
    name.chars().take(NAME).collect()
}

fn write_label(out: &mut Lines, report: &Report, label: &LabelCheck) -> Result {
    let facts = &label.facts;
    let stacked = label.cavalieri.map_or(String::new(), |own| format!("× {:.3}", own.ratio));
    let ripple = label.ripple.map_or(String::new(), |own| format!("{:.1}°", own.angle()));
    writeln!(
        out,
        "{:<24}{:>14}{stacked:>10}{:>14}{:>12}{:>8}{ripple:>8}  {}",
        name(report, label),
        number(facts.volume),
        number(facts.area),
        facts.components,
        facts.genus,
        label.closed_in_words()
    )
}

/// Where pieces begin and end within the stack.
fn write_passages(out: &mut Lines, report: &Report) -> Result {
    let labels = report.check.labels.iter();
    let all: Vec<(&LabelCheck, &Passage)> = labels
        .flat_map(|label| label.passages.iter().map(move |passage| (label, passage)))
        .collect();
    for (label, passage) in all.iter().take(PASSAGES) {
        let [one, other] = &passage.sections;
        let what = passage.in_words();
        if !what.is_empty() {
            writeln!(out, "{}: {what} between sections {one} and {other}", name(report, label))?;
        }
    }
    let rest = all.len().saturating_sub(PASSAGES);
    if rest > 0 {
        writeln!(out, "… and {rest} more places where pieces begin or end (--report lists them)")?;
    }
    Ok(())
}

/// Contours that the surface does not come near to.
fn write_unreached(out: &mut Lines, report: &Report, label: &LabelCheck) -> Result {
    let unreached = label.unreached;
    if unreached.contours == 0 {
        return Ok(());
    }
    let thin = match unreached.thin_length {
        0.0 => String::new(),
        thin => format!(", {} of it too thin for the grid", number(thin)),
    };
    let (contours, are) = match unreached.contours {
        1 => ("contour", "is"),
        _ => ("contours", "are"),
    };
    writeln!(
        out,
        "{}: {} {contours} {are} nowhere near the surface; a length of {}{thin} is not reached in all",
        name(report, label),
        unreached.contours,
        number(unreached.length),
    )
}
