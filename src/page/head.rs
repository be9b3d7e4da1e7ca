//! The top of a page: what it is about, the verdict, and how the result was made.

use maud::{Markup, html};

use super::text::{counted, text, with_unit};
use super::verdict::Verdict;
use crate::figures::{grouped, mebibytes, number};
use crate::report::Report;

/// How many files are named in the title.
const TITLED: usize = 2;
/// How many files are listed.
const FILES: usize = 50;

/// The names of the first files, without their folders.
pub fn title(report: &Report) -> String {
    let name = |file: &String| {
        let name = std::path::Path::new(file).file_name();
        name.map_or_else(|| file.clone(), |name| name.to_string_lossy().into_owned())
    };
    let mut names: Vec<String> = report.files.iter().take(TITLED).map(name).collect();
    match report.files.len().saturating_sub(TITLED) {
        0 if names.is_empty() => "sections".to_owned(),
        0 => names.join(", "),
        rest => {
            names.push(format!("and {rest} more"));
            names.join(", ")
        }
    }
}

/// The verdict, and the figures that people ask for first.
pub fn head(report: &Report) -> Markup {
    let Verdict { level, sentences } = Verdict::new(report);
    let check = &report.check;
    let dice = |share: Option<f64>| share.map_or("–".to_owned(), |share| format!("{share:.4}"));
    let distance = match check.contours.vertices {
        0 => "–".to_owned(),
        _ => format!("{:.2}", check.contours.mean),
    };
    html! {
        header class=(level.class()) {
            p.kind { "Reconstruction report" }
            h1 { (text(&title(report))) }
            p.verdict { strong { (level.words()) } }
            p.words { @for sentence in &sentences { (sentence) " " } }
            dl.figures {
                div { dt { "Sections" } dd { (report.sections) } }
                div { dt { "Labels" } dd { (check.labels.len()) } }
                div { dt { "Dice, mean" } dd { (dice(check.dice.mean)) } }
                div { dt { "Dice, least" } dd { (dice(check.dice.min)) } }
                div { dt { "Contours off by" } dd { (distance) small { " voxels" } } }
                div { dt { "Warnings" } dd { (report.warnings.len()) } }
            }
        }
    }
}

/// How the result was made.
pub fn made(report: &Report, methods: &[String], command: &str) -> Markup {
    let unit = |length: f64| with_unit(length, &report.units, "");
    let rest = report.files.len().saturating_sub(FILES);
    let reasons = |reasons: &[String]| reasons.join(" and ");
    html! {
        dl.made {
            dt { "Program" } dd { (text(&report.program)) }
            @if !command.is_empty() { dt { "Command" } dd { code { (text(command)) } } }
            dt { (if report.files.len() == 1 { "File" } else { "Files" }) }
            dd {
                @for file in report.files.iter().take(FILES) { code { (text(file)) } " " }
                @if rest > 0 { "and " (rest) " more" }
                @if report.files.is_empty() { "none: sections came from a program" }
            }
            dt { "Method" }
            dd {
                @for method in methods { (method) ". " }
                @if let Some(choice) = &report.choice {
                    "It was chosen because " (text(&reasons(&choice.reasons))) "."
                }
                @for layer in &report.layers {
                    @if let Some(choice) = &layer.choice {
                        @for &label in &layer.labels {
                            (super::text::name_of(label, &report.materials)) ": "
                        }
                        (choice.method.name()) ", because " (text(&reasons(&choice.reasons))) ". "
                    }
                }
            }
            dt { "Coordinates" }
            dd {
                @match report.units.as_str() {
                    "" => "of no known unit",
                    units => { "in " (text(units)) },
                }
                @match report.frame.as_str() {
                    "" => ", of no known frame",
                    frame => { ", frame " (text(frame)) },
                }
            }
            dt { "Grid" }
            dd {
                @if report.layers.is_empty() {
                    (report.nodes.map(|count| count.to_string()).join(" × ")) " nodes, voxels of "
                    (unit(report.voxel))
                } @else {
                    (counted(report.layers.len(), "structure", "structures"))
                    " that may overlap, each on a grid of its own, voxels of "
                    (voxels(report)) " " (text(&report.units))
                }
                ", by " (text(&report.device))
            }
            @if let Some(decimation) = &report.decimation {
                dt { "Made simpler" }
                dd {
                    "from " (grouped(decimation.before as u64)) " to "
                    (grouped(decimation.triangles as u64)) " triangles; the surface moved by "
                    (unit(decimation.moved)) " at most"
                }
            }
            dt { "Took" }
            dd {
                (format!("{:.2} s", report.seconds))
                @if report.peak_memory > 0 { ", " (mebibytes(report.peak_memory)) }
            }
        }
    }
}

/// The least and the largest voxel of layers.
fn voxels(report: &Report) -> String {
    let all = || report.layers.iter().map(|layer| layer.voxel);
    let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(0.0, f64::max));
    match least == most {
        true => number(least),
        false => format!("{} to {}", number(least), number(most)),
    }
}
