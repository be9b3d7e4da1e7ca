//! What each stage took.

use maud::{Markup, html};

use super::text::text;
use crate::figures::{grouped, mebibytes};
use crate::report::Report;

/// A row for each stage, with a bar for its share of the time.
pub fn stages(report: &Report) -> Markup {
    let share = |seconds: f64| match report.seconds > 0.0 {
        true => (100.0 * seconds / report.seconds).clamp(0.0, 100.0),
        false => 0.0,
    };
    let counts = |counts: &std::collections::BTreeMap<String, u64>| {
        let all = counts.iter().map(|(name, count)| format!("{} {name}", grouped(*count)));
        all.collect::<Vec<_>>().join(", ")
    };
    html! {
        div.wide {
            table {
                thead {
                    tr {
                        th scope="col" { "Stage" }
                        th.number scope="col" { "Seconds" }
                        th.bars scope="col" { span.hidden { "Share" } }
                        th.number scope="col" { "Memory" }
                        th scope="col" { "Counts" }
                    }
                }
                tbody {
                    @for stage in &report.stages {
                        tr {
                            th scope="row" { (text(&stage.name)) }
                            td.number { (format!("{:.2}", stage.seconds)) }
                            td.bars { span style=(format!("width:{:.1}%", share(stage.seconds))) {} }
                            td.number { @if stage.peak_memory > 0 { (mebibytes(stage.peak_memory)) } }
                            td { (text(&counts(&stage.counts))) }
                        }
                    }
                }
                tfoot {
                    tr {
                        th scope="row" { "All" }
                        td.number { (format!("{:.2}", report.seconds)) }
                        td {}
                        td.number { @if report.peak_memory > 0 { (mebibytes(report.peak_memory)) } }
                        td {}
                    }
                }
            }
        }
    }
}
