//! A cross-check as a table.

use std::fmt::Write;

use super::{LABELS, grouped, number, write_grid, write_stages};
use crate::crosscheck::{
    Against, Agreement, Crosscheck, Gap, LabelSolids, Pairing, Part, Points, Reconstruction,
    Region, Solid,
};
use crate::label::Label;
use crate::terminal::Lines;

/// How many places are shown of each kind.
const PLACES: usize = 4;

/// Prints a report to stderr.
pub fn print_crosscheck(report: &Crosscheck) {
    let mut lines = Lines::default();
    // Writing to lines cannot fail.
    let _ = write_crosscheck(&mut lines, report);
    lines.tell();
}

fn write_crosscheck(out: &mut Lines, report: &Crosscheck) -> std::fmt::Result {
    let found = &report.found;
    let by = format!("field on {}", report.device);
    write_grid(out, report.sections, report.nodes, report.voxel, &report.units, &by)?;
    writeln!(out)?;
    write_labels(out, report)?;
    writeln!(out)?;
    write_agreement(out, &found.agreement)?;
    match &found.points {
        Some(points) => write_points(out, points)?,
        None => writeln!(out, "must agree       is known of --method mvc alone")?,
    }
    write_parts(out, found.part_count, &found.parts)?;
    write_pairing(out, &found.pairing)?;
    if let [longest, ..] = &found.skeleton.details.contradictions[..] {
        writeln!(
            out,
            "contradictions   {} between sections along their common lines, the longest over {}",
            found.skeleton.details.contradictions.len(),
            number(longest.length)
        )?;
    }
    if !found.skeleton.exact {
        writeln!(out, "the skeleton's surface is sampled on the grid: within a voxel")?;
    }
    write_gap(out, "dual to skeleton", found.distances.dual_skeleton.as_ref())?;
    write_gap(out, "dual to delaunay", found.distances.dual_delaunay.as_ref())?;
    if let Some(against) = &found.against {
        write_against(out, against)?;
    }
    write_stages(out, &report.stages, report.seconds, report.peak_memory)
}

/// A line for each label: volumes, and pieces and handles in each mesh.
fn write_labels(out: &mut Lines, report: &Crosscheck) -> std::fmt::Result {
    let labels = &report.found.labels;
    let meshes = if labels.iter().any(|label| label.delaunay.is_some()) { "f/d/s" } else { "f/s" };
    writeln!(
        out,
        "{:<24}{:>14}{:>14}{:>9}{:>9}{:>13}{:>13}",
        "label",
        "field",
        "skeleton",
        "differ",
        "IoU",
        format!("pieces {meshes}"),
        format!("genus {meshes}")
    )?;
    for label in labels.iter().take(LABELS) {
        write_label(out, report, label)?;
    }
    let rest = labels.len().saturating_sub(LABELS);
    if rest > 0 {
        writeln!(out, "… and {rest} more labels")?;
    }
    Ok(())
}

fn write_label(out: &mut Lines, report: &Crosscheck, label: &LabelSolids) -> std::fmt::Result {
    let material = report.materials.iter().find(|material| material.id == label.label);
    let name = material.map_or_else(|| label.label.to_string(), |found| found.name.clone());
    let name: String = name.chars().take(23).collect();
    let solids = [Some(&label.dual), label.delaunay.as_ref(), Some(&label.skeleton)];
    let all = |text: &dyn Fn(&Solid) -> String| {
        solids.iter().flatten().map(|solid| text(solid)).collect::<Vec<_>>().join("/")
    };
    let nodes = report.found.agreement.labels.iter().find(|nodes| nodes.label == label.label);
    writeln!(
        out,
        "{name:<24}{:>14}{:>14}{:>9}{:>9}{:>13}{:>13}",
        number(label.dual.volume),
        number(label.skeleton.volume),
        label.volume_difference.map_or_else(String::new, |part| format!("{:+.2} %", 100.0 * part)),
        nodes.map_or_else(String::new, |nodes| format!("{:.4}", nodes.iou)),
        all(&|solid| solid.components.to_string()),
        all(&|solid| solid.genus.map_or_else(|| "-".to_owned(), |genus| genus.to_string())),
    )
}

fn write_agreement(out: &mut Lines, agreement: &Agreement) -> std::fmt::Result {
    writeln!(
        out,
        "labels agree     at {:.3} % of {} nodes; by their distance from the sections in voxels:",
        100.0 * agreement.share,
        grouped(agreement.nodes)
    )?;
    for bin in agreement.bins.iter().filter(|bin| bin.nodes > 0) {
        writeln!(
            out,
            "{:>13} – {:<6}{:>9.3} % of {}",
            bin.from,
            bin.to,
            100.0 * bin.share,
            grouped(bin.nodes)
        )?;
    }
    Ok(())
}

fn write_points(out: &mut Lines, points: &Points) -> std::fmt::Result {
    writeln!(
        out,
        "random points    {:.3} % of {} agree; {} of them must",
        100.0 * points.share(),
        grouped(points.drawn),
        grouped(points.must_agree)
    )?;
    writeln!(
        out,
        "must agree       {}",
        match points.violations {
            0 if points.must_agree == 0 => "none has to".to_owned(),
            0 => "and do".to_owned(),
            count => format!("and DO NOT: {} points and nodes", grouped(count)),
        }
    )?;
    for point in points.first.iter().take(PLACES) {
        writeln!(
            out,
            "  at {} the field says {} (its value for the other is {:.6}, in double precision \
             {:.6}), the skeleton {}; ρ = {:.6}, α = {:.6}",
            place(point.at),
            Label(point.field),
            point.value,
            point.reference,
            Label(point.skeleton),
            point.rho,
            point.alpha
        )?;
    }
    Ok(())
}

fn write_parts(out: &mut Lines, count: usize, parts: &[Part]) -> std::fmt::Result {
    writeln!(out, "differing parts  {}", grouped(count as u64))?;
    for part in parts.iter().take(PLACES) {
        writeln!(
            out,
            "  at {} {} in the field, {} in the skeleton, {:.1} voxels deep, volume {}",
            place(part.at),
            Label(part.field),
            Label(part.skeleton),
            part.depth,
            number(part.volume)
        )?;
    }
    Ok(())
}

fn write_pairing(out: &mut Lines, pairing: &Pairing) -> std::fmt::Result {
    let Pairing { cells, differ, thin, .. } = pairing;
    writeln!(
        out,
        "joined regions   differ in {differ} of {cells} cells ({thin} too thin to tell)"
    )?;
    for found in pairing.differences.iter().take(PLACES) {
        let who = match found.joined_by {
            Reconstruction::Field => "field",
            Reconstruction::Skeleton => "skeleton",
        };
        let [one, other] =
            found.regions.map(|Region { at, nodes }| format!("{} ({nodes} nodes)", place(at)));
        writeln!(
            out,
            "  cell {}: label {} at {one} and at {other} are joined by the {who} alone",
            found.cell,
            Label(found.label)
        )?;
    }
    Ok(())
}

fn write_gap(out: &mut Lines, name: &str, gap: Option<&Gap>) -> std::fmt::Result {
    let Some(gap) = gap else { return Ok(()) };
    let farthest = if gap.there.max >= gap.back.max { gap.there } else { gap.back };
    writeln!(
        out,
        "{name} mean {:.3}, Hausdorff {:.2} voxels, at {} (there {:.2}, back {:.2})",
        gap.mean,
        gap.hausdorff,
        place(farthest.at),
        gap.there.max,
        gap.back.max
    )
}

fn write_against(out: &mut Lines, against: &Against) -> std::fmt::Result {
    let Against { file, solid, gap, comparison, refused } = against;
    writeln!(
        out,
        "against {file}: {}{}, {} pieces, volume {}",
        if solid.closed { "closed" } else { "NOT closed" },
        if solid.manifold { "" } else { ", not manifold" },
        solid.components,
        number(solid.volume)
    )?;
    if let Some(comparison) = comparison {
        writeln!(
            out,
            "  IoU {:.5}, volume ratio {:.5}, area ratio {:.5}",
            comparison.iou, comparison.volume_ratio, comparison.area_ratio
        )?;
    }
    if let Some(why) = refused {
        writeln!(out, "  volumes are not compared: {why}")?;
    }
    write_gap(out, "  ours to theirs", gap.as_ref())
}

fn place([x, y, z]: [f64; 3]) -> String {
    format!("({}, {}, {})", number(x), number(y), number(z))
}
