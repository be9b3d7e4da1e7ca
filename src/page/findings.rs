//! What a reader should know before using a result: where to scan next, warnings, what was left
//! out, and where sections contradict each other.

use maud::{Markup, html};

use super::marks::{Kind, Mark, visible};
use super::text::{counted, place, text, with_unit};
use crate::figures::number;
use crate::report::Report;
use crate::section::{Disagreement, Warning};

/// How many of a kind are listed.
const LISTED: usize = 200;

/// Where the surface rests on little.
pub fn scan(report: &Report, marks: &[Mark]) -> Markup {
    let support = &report.check.support;
    html! {
        @if support.parts.is_empty() {
            p { "No part of the surface is farther than a voxel from what the sections show." }
        } @else {
            p {
                "A twentieth of the surface is " (with_unit(support.threshold, &report.units, ""))
                " or more from anything that a section shows. Its largest parts:"
            }
            (list(marks, Kind::Scan))
        }
    }
}

/// Warnings, and places to go to.
pub fn warnings(report: &Report, marks: &[Mark], rest: usize) -> Markup {
    html! {
        @if report.warnings.is_empty() { p { "There are none." } }
        (told(&report.warnings))
        @if marks.iter().any(|mark| mark.kind == Kind::Look) {
            h3 { "Places to look at" }
            (list(marks, Kind::Look))
            (more(rest))
        }
    }
}

fn list(marks: &[Mark], kind: Kind) -> Markup {
    html! {
        ul.marks {
            @for mark in marks.iter().filter(|mark| mark.kind == kind) {
                li {
                    span class=(format!("sign {}", if kind == Kind::Scan { "scan" } else { "look" })) data-sign=(mark.sign) { (mark.sign) }
                    span { (text(&mark.what)) " " small { (mark.place()) } }
                }
            }
        }
    }
}

/// What was found, by section.
pub fn told(all: &[Warning]) -> Markup {
    html! {
        @if !all.is_empty() {
            ul.told {
                @for warning in all.iter().take(LISTED) {
                    li {
                        @if !warning.section.is_empty() { strong { "Section " (text(&warning.section)) ": " } }
                        (text(&warning.what))
                    }
                }
            }
            (more(all.len().saturating_sub(LISTED)))
        }
    }
}

fn more(rest: usize) -> Markup {
    html! { @if rest > 0 { p { "… and " (rest) " more: " code { "--report FILE.json" } " lists them." } } }
}

/// Where sections contradict each other along their common lines.
pub fn disagreements(report: &Report) -> Markup {
    let all: Vec<&Disagreement> = visible(report).collect();
    let rest = report.disagreements.len() - all.len();
    let unit = |length: f64| with_unit(length, &report.units, "");
    html! {
        p {
            "Along the line that two sections have in common both should say the same."
            @if rest > 0 {
                " " (rest) " more pairs differ on less than a voxel (" (unit(report.voxel)) "): that "
                "comes from rounded contours, as a rule."
            }
        }
        @if !all.is_empty() { (pairs(&all)) }
    }
}

fn pairs(all: &[&Disagreement]) -> Markup {
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        th scope="col" { "Sections" }
                        th.number scope="col" { "Length" }
                        th scope="col" { "Most, at" }
                        th scope="col" { "They say" }
                    }
                }
                tbody {
                    @for own in all.iter().take(LISTED) {
                        tr {
                            th scope="row" { (text(&own.sections[0])) ", " (text(&own.sections[1])) }
                            td.number { (number(own.length)) }
                            td { (number(own.worst_length)) " " small { (place(own.worst)) } }
                            td { (text(&own.labels[0])) " / " (text(&own.labels[1])) }
                        }
                    }
                }
            }
        }
        (more(all.len().saturating_sub(LISTED)))
    }
}

/// What is unknown, too thin, linked or not exact.
pub fn besides(report: &Report) -> Markup {
    let check = &report.check;
    let unknown: f64 = check.dice.sections.iter().map(|section| section.unknown).sum();
    let share = 100.0 * unknown / check.dice.sections.len().max(1) as f64;
    let thin: usize = check.contours.thin.iter().map(|place| place.vertices).sum();
    let links = report.links.as_ref().filter(|links| links.connected);
    html! {
        ul {
            li {
                @match check.contours.vertices {
                    0 => "The surface reaches no contour.",
                    _ => {
                        "Contours are " (format!("{:.2}", check.contours.mean))
                        " voxels from the surface in the mean, "
                        (format!("{:.2}", check.contours.largest)) " at most."
                    }
                }
            }
            @if unknown > 0.0 { li { (format!("{share:.1} %")) " of the sections is unknown." } }
            @if thin > 0 {
                li { (counted(thin, "contour vertex is", "contour vertices are")) " where a contour is too thin for the grid." }
            }
            @if let Some(links) = links {
                li {
                    (counted(links.found.len(), "link", "links")) " between parts that do not overlap:"
                    ul {
                        @for link in links.found.iter().take(LISTED) {
                            li {
                                (text(&link.name(&report.materials))) " at " (place(link.at)) " from "
                                (text(&link.sections[0])) " to " (text(&link.sections[1]))
                                ", moved by " (number(link.length)) ", overlapping by "
                                (format!("{:.2}", link.overlap)) " then"
                            }
                        }
                    }
                    (more(links.found.len().saturating_sub(LISTED)))
                }
            }
            @if let Some(exact) = &report.exact {
                @if !exact.left_out.is_empty() {
                    li {
                        (exact.left_out.len()) " of " (exact.cells) " cells hold too many partial "
                        "sections to be exact: the surface comes from nearest points on the grid."
                    }
                }
                @if !exact.inexact.is_empty() {
                    li {
                        // Not 100 % where something is not.
                        (format!("{:.2} %", (1e4 * exact.exact_share).floor() / 100.0))
                        " of the box is exact; elsewhere too many sections are equally near."
                    }
                }
                li {
                    (exact.snapped) " places on common lines were made one; "
                    (counted(exact.contradictions.len(), "contradiction is", "contradictions are"))
                    " left."
                }
            }
        }
    }
}

/// How files were understood.
pub fn notes(report: &Report) -> Markup {
    told(&report.notes)
}
