//! What became of each label, as a table.

use maud::{Markup, html};

use super::text::{name_of, quantity, swatch, text};
use crate::check::LabelCheck;
use crate::figures::{grouped, number};
use crate::io::units;
use crate::report::Report;

/// How many labels and how many remarks about them are listed.
const LABELS: usize = 400;
const REMARKS: usize = 100;

/// A row for each label, and what is to be said of some.
pub fn labels(report: &Report) -> Markup {
    let all = &report.check.labels;
    let rest = all.len().saturating_sub(LABELS);
    let is_stack = report.check.stack.is_some();
    let powers = ["²", "³"].map(|power| match report.units.as_str() {
        "" => String::new(),
        units => format!("{units}{power}"),
    });
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        th scope="col" { "Label" }
                        th.number scope="col" { "Volume" (unit(&powers[1])) }
                        @if is_stack {
                            th.number scope="col" title="The volume over area times spacing (Cavalieri)" { "of stack" }
                        }
                        th.number scope="col" { "Area" (unit(&powers[0])) }
                        th.number scope="col" title="Connected pieces, cavities included" { "Pieces" }
                        th.number scope="col" title="Genus: handles of all pieces together" { "Handles" }
                        th.number scope="col" title="Agreement with the sections on which it is: mean" { "Dice" }
                        th.number scope="col" title="Agreement with the sections on which it is: least" { "least" }
                        th.number scope="col" title="How much more the surface leans between sections than at them" { "Ripple" }
                        th.number scope="col" { "Triangles" }
                        th scope="col" { "Closed" }
                    }
                }
                tbody { @for label in all.iter().take(LABELS) { (row(report, label, is_stack)) } }
            }
        }
        @if rest > 0 { p { "… and " (rest) " more labels: " code { "--report FILE.json" } " lists them." } }
        (remarks(report))
    }
}

fn unit(unit: &str) -> Markup {
    html! { @if !unit.is_empty() { " " small { (text(unit)) } } }
}

fn row(report: &Report, label: &LabelCheck, is_stack: bool) -> Markup {
    let facts = &label.facts;
    let material = report.materials.iter().find(|material| material.id == label.label);
    let shares = report.check.dice.sections.iter();
    let shares: Vec<f64> =
        shares.filter_map(|section| *section.labels.get(&label.label)?).collect();
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    let dice =
        |share: f64| if shares.is_empty() { "–".to_owned() } else { format!("{share:.4}") };
    let closed = label.closed_in_words();
    html! {
        tr {
            th scope="row" {
                (swatch(material.map_or([128; 3], |material| material.color)))
                (text(&name_of(label.label, &report.materials)))
                " " small { (label.label) }
            }
            td.number {
                (quantity(facts.volume))
                @if let Some(volume) = millilitres(facts.volume, &report.units) {
                    br; small { (volume) }
                }
            }
            @if is_stack {
                td.number { (label.cavalieri.map_or("–".to_owned(), |own| format!("× {:.3}", own.ratio))) }
            }
            td.number { (quantity(facts.area)) }
            td.number {
                (facts.components)
                @if facts.cavities > 0 { br; small { (facts.cavities) " hollow" } }
            }
            td.number { (facts.genus) }
            td.number { (dice(mean)) }
            td.number { (dice(least)) }
            td.number { (label.ripple.map_or("–".to_owned(), |own| format!("{:.1}°", own.angle()))) }
            td.number { (grouped(facts.triangles as u64)) }
            td class=[(closed != "yes").then_some("doubtful")] { (closed) }
        }
    }
}

/// A volume as physicians say it, where it is of a size that they speak of.
fn millilitres(volume: f64, units: &str) -> Option<String> {
    let millilitres = volume * units::metres(units).powi(3) * 1e6;
    match millilitres {
        _ if units.is_empty() => None,
        100.0..1e6 => Some(format!("{millilitres:.0} ml")),
        1.0..100.0 => Some(format!("{millilitres:.1} ml")),
        0.01..1.0 => Some(format!("{millilitres:.3} ml")),
        _ => None,
    }
}

/// What is to be said of some labels besides.
fn remarks(report: &Report) -> Markup {
    let mut all: Vec<String> = Vec::new();
    for label in &report.check.labels {
        let name = name_of(label.label, &report.materials);
        for passage in &label.passages {
            let [one, other] = &passage.sections;
            let what = passage.in_words();
            if !what.is_empty() {
                all.push(format!("{name}: {what} between sections {one} and {other}"));
            }
        }
        let unreached = label.unreached;
        if unreached.contours > 0 {
            let thin = match unreached.thin_length {
                0.0 => String::new(),
                thin => format!(", {} of it too thin for the grid", number(thin)),
            };
            let (contours, are) =
                if unreached.contours == 1 { ("contour", "is") } else { ("contours", "are") };
            all.push(format!(
                "{name}: {} {contours} {are} nowhere near the surface; a length of {}{thin} is not \
                 reached in all",
                unreached.contours,
                number(unreached.length)
            ));
        }
        if let Some(count) = label.facts.self_intersections.filter(|&count| count > 0) {
            all.push(format!("{name}: {} pairs of its triangles cross", grouped(count)));
        }
    }
    let rest = all.len().saturating_sub(REMARKS);
    html! {
        @if !all.is_empty() {
            ul { @for remark in all.iter().take(REMARKS) { li { (text(remark)) } } }
        }
        @if rest > 0 { p { "… and " (rest) " more (" code { "--report FILE.json" } " lists them)" } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_of_bodies_are_in_millilitres() {
        let said = |volume, units| millilitres(volume, units);
        assert_eq!(said(661_470.0, "mm").as_deref(), Some("661 ml"));
        assert_eq!(said(17.1941, "cm").as_deref(), Some("17.2 ml"));
        assert_eq!(said(250.0, "mm").as_deref(), Some("0.250 ml"));
        assert_eq!([said(661_470.0, ""), said(3e9, "m"), said(1e-3, "mm")], [None, None, None]);
    }
}
