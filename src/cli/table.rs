//! Results as short tables.

use std::fmt::Write;

use crate::figures::{grouped, mebibytes, number};
use crate::label::Material;
use crate::report::Report;
use crate::section::Disagreement;
use crate::skeleton::Details;
use crate::stack::Links;
use crate::stage::Stage;
use crate::terminal::Lines;

mod comparison;
mod crosscheck;
mod labels;
mod methods;

pub use comparison::comparison;
pub use crosscheck::print_crosscheck;
use labels::write_labels;
pub use methods::methods;

/// How many labels are shown.
const LABELS: usize = 24;
/// How many contradictions are shown.
const CONTRADICTIONS: usize = 5;
/// How many links are shown.
const LINKS: usize = 5;

/// Prints a report to stderr.
pub fn print(report: &Report) {
    let mut lines = Lines::default();
    // Writing to lines cannot fail.
    let _ = write_report(&mut lines, report);
    lines.tell();
}

fn write_report(out: &mut Lines, report: &Report) -> std::fmt::Result {
    let by = if report.exact.is_some() { "" } else { "field on " };
    let by = format!("{by}{}", report.device);
    match report.layers[..] {
        [] => write_grid(out, report.sections, report.nodes, report.voxel, &report.units, &by)?,
        _ => write_grids(out, report, &by)?,
    }
    writeln!(out)?;
    write_labels(out, report)?;
    write_agreement(out, report)?;
    write_stages(out, &report.stages, report.seconds, report.peak_memory)
}

/// Each of several structures has a grid of its own.
fn write_grids(out: &mut Lines, report: &Report, by: &str) -> std::fmt::Result {
    let voxels = report.layers.iter().map(|layer| layer.voxel);
    let [least, most] =
        voxels.fold([f64::INFINITY, 0.0f64], |[low, high], own| [low.min(own), high.max(own)]);
    writeln!(
        out,
        "{} sections of {} structures, each on a grid of its own, voxels {} to {} {}, {by}",
        report.sections,
        report.layers.len(),
        number(least),
        number(most),
        report.units
    )
}

fn write_grid(
    out: &mut Lines,
    sections: usize,
    [x, y, z]: [i32; 3],
    voxel: f64,
    units: &str,
    by: &str,
) -> std::fmt::Result {
    writeln!(
        out,
        "{sections} sections, grid {x} × {y} × {z}, voxel {voxel:.6}{}{units}, {by}",
        if units.is_empty() { "" } else { " " },
    )
}

fn write_agreement(out: &mut Lines, report: &Report) -> std::fmt::Result {
    let check = &report.check;
    writeln!(out)?;
    let unknown: f64 = check.dice.sections.iter().map(|section| section.unknown).sum();
    if unknown > 0.0 {
        let share = 100.0 * unknown / check.dice.sections.len() as f64;
        writeln!(out, "unknown          {share:.1} % of the sections")?;
    }
    match check.dice.mean.zip(check.dice.min) {
        Some((mean, least)) => writeln!(out, "section Dice     mean {mean:.4}, least {least:.4}")?,
        None => writeln!(out, "section Dice     none: nothing is on any section")?,
    }
    match check.contours.vertices {
        0 => writeln!(out, "contour distance none: the surface reaches no contour")?,
        _ => writeln!(
            out,
            "contour distance mean {:.2}, largest {:.2} voxels",
            check.contours.mean, check.contours.largest
        )?,
    }
    if let Some(part) = check.support.parts.first() {
        let [x, y, z] = part.at.map(number);
        writeln!(
            out,
            "where to scan next: around ({x}, {y}, {z}), where the surface is up to {} from any \
             section",
            number(part.distance)
        )?;
    }
    let thin: usize = check.contours.thin.iter().map(|place| place.vertices).sum();
    if thin > 0 {
        writeln!(out, "too thin for the grid: {thin} contour vertices (--report lists them)")?;
    }
    if let Some(links) = report.links.as_ref().filter(|links| links.connected) {
        write_links(out, links, &report.materials)?;
    }
    if let Some(exact) = &report.exact {
        return write_contradictions(out, exact);
    }
    // What is shorter than a voxel comes from rounded contours, as a rule.
    let visible = |pair: &&Disagreement| pair.worst_length > report.voxel;
    let disagreements = report.disagreements.iter().filter(visible).count();
    if disagreements > 0 {
        writeln!(
            out,
            "{disagreements} pairs of sections contradict each other along their common line \
             (`transect inspect` lists them)"
        )?;
    }
    Ok(())
}

/// The first of the links.
fn write_links(
    out: &mut Lines,
    Links { found, .. }: &Links,
    materials: &[Material],
) -> std::fmt::Result {
    writeln!(out, "links            {} between parts that do not overlap", found.len())?;
    for link in found.iter().take(LINKS) {
        let ([from, to], name) = (&link.sections, link.name(materials));
        let [x, y, z] = link.at.map(number);
        writeln!(
            out,
            "  {name} at ({x}, {y}, {z}) from {from} to {to}, moved by {}, overlapping by {:.2} then",
            number(link.length),
            link.overlap
        )?;
    }
    let rest = found.len().saturating_sub(LINKS);
    if rest > 0 {
        writeln!(out, "  … and {rest} more (--report lists them)")?;
    }
    Ok(())
}

/// What is exact is listed, however short.
fn write_contradictions(out: &mut Lines, exact: &Details) -> std::fmt::Result {
    if !exact.left_out.is_empty() {
        writeln!(
            out,
            "{} of {} cells hold too many partial sections to be exact: the surface comes from \
             nearest points on the grid, and is not made fair",
            exact.left_out.len(),
            exact.cells
        )?;
    }
    if let Some(first) = exact.inexact.iter().max_by(|a, b| a.volume.total_cmp(&b.volume)) {
        let parts: u32 = exact.inexact.iter().map(|inexact| inexact.parts).sum();
        writeln!(
            out,
            "exact            {:.2} % of the box; in {parts} places too many sections are equally \
             near: most in cell {} around ({})",
            // Not 100 % where something is not.
            (1e4 * exact.exact_share).floor() / 100.0,
            first.cell,
            first.at.map(number).join(", ")
        )?;
    }
    writeln!(
        out,
        "common lines     {} places made one, {} contradictions",
        exact.snapped,
        exact.contradictions.len()
    )?;
    for found in exact.contradictions.iter().take(CONTRADICTIONS) {
        let [first, second] = &found.sections;
        let [from, to] = found.ends.map(|end| end.map(number).join(", "));
        let [one, other] = [0, 1].map(|which: usize| found.labels[which].join(" "));
        writeln!(out, "  {first}: {one}, {second}: {other}, from ({from}) to ({to})")?;
    }
    let rest = exact.contradictions.len().saturating_sub(CONTRADICTIONS);
    if rest > 0 {
        writeln!(out, "  … and {rest} more (--report lists them)")?;
    }
    Ok(())
}

fn write_stages(
    out: &mut Lines,
    stages: &[Stage],
    seconds: f64,
    peak_memory: u64,
) -> std::fmt::Result {
    writeln!(out)?;
    for stage in stages {
        let counts: Vec<String> = stage
            .counts
            .iter()
            .map(|(name, count)| format!("{} {name}", grouped(*count)))
            .collect();
        writeln!(
            out,
            "{:<12}{:>8.2} s {:>9}  {}",
            stage.name,
            stage.seconds,
            mebibytes(stage.peak_memory),
            counts.join(", ")
        )?;
    }
    let memory = mebibytes(peak_memory);
    writeln!(out, "{:<12}{seconds:>8.2} s {memory:>9}", "all")
}
