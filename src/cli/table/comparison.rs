//! How solids agree with a reference.

use std::fmt::{Result, Write};

use super::{LABELS, number};
use crate::compare::{Agreement, Comparison, LabelComparison, LabelledComparison};
use crate::terminal::Lines;

/// How many characters of a name.
const NAME: usize = 23;

/// A comparison as text.
pub fn comparison(comparison: &LabelledComparison) -> String {
    let mut lines = Lines::default();
    // Writing to lines cannot fail.
    let _ = write_comparison(&mut lines, comparison);
    lines.as_str().to_owned()
}

fn write_comparison(out: &mut Lines, comparison: &LabelledComparison) -> Result {
    let surface = if comparison.tolerance.is_some() { "surface" } else { "" };
    writeln!(
        out,
        "{:<24}{:>14}{:>14}{:>9}{surface:>9}{:>12}{:>12}{:>12}",
        "label", "volume", "reference", "Dice", "Hausdorff", "95 %", "mean"
    )?;
    for label in comparison.labels.iter().take(LABELS) {
        write_label(out, label)?;
    }
    let rest = comparison.labels.len().saturating_sub(LABELS);
    if rest > 0 {
        writeln!(out, "… and {rest} more labels (--json has them all)")?;
    }
    write_row(out, "all", comparison.union.volumes.map(Some), Some(&comparison.union))?;
    write_meaning(out, comparison)?;
    writeln!(out)?;
    write_union(out, &comparison.all)
}

fn write_label(out: &mut Lines, label: &LabelComparison) -> Result {
    let name = match &label.name {
        Some(name) => format!("{} {name}", label.label),
        None => label.label.to_string(),
    };
    write_row(out, &name, label.volumes, label.agreement.as_ref())
}

fn write_row(
    out: &mut Lines,
    name: &str,
    volumes: [Option<f64>; 2],
    agreement: Option<&Agreement>,
) -> Result {
    let name: String = name.chars().take(NAME).collect();
    let [own, reference] = volumes.map(|volume| volume.map_or("none".to_owned(), number));
    write!(out, "{name:<24}{own:>14}{reference:>14}")?;
    let Some(agreement) = agreement else { return writeln!(out, "{:>9}", "–") };
    let surface = agreement.surface_dice.map_or(String::new(), |share| format!("{share:.4}"));
    writeln!(
        out,
        "{:>9.4}{surface:>9}{:>12}{:>12}{:>12}",
        agreement.dice,
        number(agreement.hausdorff),
        number(agreement.hausdorff_95),
        number(agreement.assd)
    )
}

/// What the figures are, and how they were counted.
fn write_meaning(out: &mut Lines, comparison: &LabelledComparison) -> Result {
    let unit = match comparison.unit.as_str() {
        "" => "a unit that is not known",
        unit => unit,
    };
    let overlap = match comparison.exact_overlap {
        true => "voxel by voxel",
        false => "on a grid around both",
    };
    writeln!(out, "lengths are in {unit}; Dice is counted {overlap}")?;
    match comparison.tolerance {
        Some(length) => writeln!(
            out,
            "surface: the part of both surfaces no farther than {} from the other",
            number(length)
        ),
        None => Ok(()),
    }
}

/// All materials as one, over the diagonal.
fn write_union(out: &mut Lines, comparison: &Comparison) -> Result {
    let Comparison { to_reference: to, from_reference: from, .. } = comparison;
    writeln!(out, "IoU            {:.5}", comparison.iou)?;
    writeln!(
        out,
        "Hausdorff      {:.6}  (to the reference {:.6}, from it {:.6})",
        comparison.hausdorff, to.max, from.max
    )?;
    writeln!(
        out,
        "mean distance  {:.6}  (to the reference {:.6}, from it {:.6})",
        comparison.chamfer, to.mean, from.mean
    )?;
    writeln!(out, "volume ratio   {:.5}", comparison.volume_ratio)?;
    writeln!(out, "area ratio     {:.5}", comparison.area_ratio)?;
    writeln!(
        out,
        "these are of all materials as one, distances relative to the reference's diagonal of {}",
        number(comparison.diagonal)
    )?;
    comparison.warnings.iter().try_for_each(|warning| writeln!(out, "warning: {warning}"))
}
