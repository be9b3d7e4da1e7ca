//! Methods side by side as a table.

use std::fmt::Write;

use super::number;
use crate::compare::methods::{Entry, Figures};
use crate::terminal::Lines;

/// A line for each method, and below why others do not apply.
pub fn methods(entries: &[Entry]) -> String {
    let mut lines = Lines::default();
    // Writing to lines cannot fail.
    let _ = write_methods(&mut lines, entries);
    lines.as_str().to_owned()
}

fn write_methods(out: &mut Lines, entries: &[Entry]) -> std::fmt::Result {
    let found = || entries.iter().filter_map(|entry| Some((entry, entry.figures.as_ref()?)));
    let is_compared = found().any(|(_, figures)| figures.reference.is_some());
    write!(out, "{:<13}", "method")?;
    if is_compared {
        write!(
            out,
            "{:>8}{:>11}{:>10}{:>9}{:>8}{:>9}{:>8}",
            "IoU", "Hausdorff", "mean", "volume", "area", "normals", "at"
        )?;
    } else {
        write!(out, "{:>14}{:>14}", "volume", "area")?;
    }
    writeln!(
        out,
        "{:>8}{:>8}{:>8}{:>7}{:>8}{:>9}{:>9}",
        "Dice", "least", "pieces", "genus", "closed", "seconds", "MiB"
    )?;
    for (entry, figures) in found() {
        write!(out, "{:<13}", entry.method)?;
        if is_compared {
            write_reference(out, figures)?;
        } else {
            write!(out, "{:>14}{:>14}", number(figures.volume), number(figures.area))?;
        }
        writeln!(
            out,
            "{:>8}{:>8}{:>8}{:>7}{:>8}{:>9.2}{:>9}",
            share(figures.dice),
            share(figures.least_dice),
            figures.components,
            figures.genus,
            if figures.closed { "yes" } else { "NO" },
            figures.seconds,
            figures.peak_memory >> 20
        )?;
    }
    if is_compared {
        writeln!(
            out,
            "Hausdorff and mean distance are relative to the reference's diagonal, volume and area \
             to its own; normals are off by so many degrees away from sections, and at them"
        )?;
    }
    entries.iter().try_for_each(|entry| match &entry.refused {
        Some(why) => writeln!(out, "{} does not apply: {why}", entry.method),
        None => Ok(()),
    })
}

fn share(value: Option<f64>) -> String {
    value.map_or_else(|| "none".to_owned(), |own| format!("{own:.4}"))
}

fn write_reference(out: &mut Lines, figures: &Figures) -> std::fmt::Result {
    let Some(against) = &figures.reference else { return write!(out, "{:>63}", "no surface") };
    write!(
        out,
        "{:>8.4}{:>11.5}{:>10.6}{:>9.4}{:>8.4}",
        against.iou, against.hausdorff, against.chamfer, against.volume_ratio, against.area_ratio
    )?;
    let degrees =
        |error: Option<f64>| error.map_or("–".to_owned(), |error| format!("{error:.1}°"));
    let [away, at] = match figures.normals {
        Some(normals) => [normals.away, normals.at].map(degrees),
        None => [None; 2].map(degrees),
    };
    write!(out, "{away:>9}{at:>8}")
}
