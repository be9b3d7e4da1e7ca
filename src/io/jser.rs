//! Series of PyReconstruct (`.jser`): traces on parallel sections, in micrometres.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DAffine2, DMat2, DVec2, DVec3};
use serde::Deserialize;
use serde_json::Value;

use super::json::parse;
use super::polygons::{self, holds};
use super::{Raw, check, diagonal};
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::plane::Plane;
use crate::section::{Loop, Rules, Section, Sections, Warning};
use crate::volume::{Shown, shown};

/// What sections are said to be aligned by where no alignment is chosen.
const UNALIGNED: &str = "no-alignment";

/// A file, as far as it is about contours.
#[derive(Deserialize)]
struct File {
    series: Series,
    /// By number, from 0; there may be none.
    sections: Vec<Option<Planar>>,
}

#[derive(Deserialize)]
struct Series {
    #[serde(default = "default_alignment")]
    alignment: String,
}

fn default_alignment() -> String {
    "default".to_owned()
}

#[derive(Deserialize)]
struct Planar {
    thickness: f64,
    /// By alignment: two rows of three numbers.
    #[serde(default)]
    tforms: BTreeMap<String, [f64; 6]>,
    /// By the names of objects.
    contours: BTreeMap<String, Vec<Value>>,
}

/// A closed trace.
struct Trace {
    points: Vec<DVec2>,
    color: [u8; 3],
    is_closed: bool,
    is_negative: bool,
}

/// Reads the text of such a file; `file` is for errors.
///
/// # Errors
/// Where the text is no such series, and where a section breaks a rule.
pub fn read(text: &str, file: &Path, rules: &Rules) -> Result<Sections> {
    let content: File = parse(text, file)?;
    let thickness = thickness(&content.sections)
        .ok_or_else(|| Error::file(file, "there is no section with a thickness in it"))?;
    let mut materials = BTreeMap::new();
    let mut open = 0;
    let mut raw = Vec::new();
    for (number, planar) in content.sections.iter().enumerate() {
        let Some(planar) = planar else { continue };
        let at = |what: String| Error::input(file, format!("section {number}"), what);
        let place = placed(planar, &content.series.alignment).map_err(at)?;
        let z = number as f64 * thickness;
        let mut loops = Vec::new();
        for (name, values) in &planar.contours {
            let traces = values.iter().map(trace).collect::<std::result::Result<Vec<_>, _>>();
            let traces = traces.map_err(|what| at(format!("{name:?}: {what}")))?;
            let count = traces.len();
            let closed: Vec<Trace> = traces.into_iter().filter(|own| own.is_closed).collect();
            open += count - closed.len();
            let Some(first) = closed.first() else { continue };
            let id = materials.len() as u32 + 1;
            let material = Material { id, name: name.clone(), color: first.color };
            let label = Label(materials.entry(name.clone()).or_insert(material).id);
            loops.extend(looped(&closed, label, loops.len(), &place, z));
        }
        let plane = Plane { normal: DVec3::Z, offset: z };
        let place = format!("sections[{number}]");
        raw.push(Raw { name: number.to_string(), place, content: (plane, loops) });
    }
    // As in stacks of pictures: who draws on some alone says nothing on the others.
    let filled: Vec<bool> = raw.iter().map(|raw| !raw.content.1.is_empty()).collect();
    let kept: Vec<usize> = match shown(&filled) {
        Shown::Sparse(kept) => kept,
        Shown::Full(kept) => kept.collect(),
    };
    let mut number = 0..;
    raw.retain(|_| number.next().is_some_and(|number| kept.contains(&number)));
    if raw.is_empty() {
        return Err(Error::file(file, "no closed trace is in it: export it again"));
    }
    let diagonal = diagonal(raw.iter().flat_map(|raw| &raw.content.1).flat_map(|own| &own.points));
    let mut sections = check(file, &raw, rules, |raw| {
        let (plane, loops) = &raw.content;
        Section::from_loops(&raw.name, *plane, loops, diagonal, rules)
    })?;
    let what = format!(
        "a series of {} sections, {thickness} apart (their mean thickness), by the alignment {:?}",
        filled.len(),
        content.series.alignment
    );
    sections.notes.push(Warning { section: String::new(), what });
    if open > 0 {
        let what = format!("{open} open traces, which enclose nothing");
        sections.left_out.push(Warning { section: String::new(), what });
    }
    "um".clone_into(&mut sections.units);
    sections.name_materials(super::volume::distinct(materials.into_values().collect()));
    Ok(sections)
}

/// The mean thickness of sections, as the program itself takes it.
fn thickness(sections: &[Option<Planar>]) -> Option<f64> {
    let all: Vec<f64> = sections.iter().flatten().map(|own| own.thickness).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    (mean.is_normal() && mean > 0.0).then_some(mean)
}

/// From a section's own coordinates to aligned ones.
fn placed(planar: &Planar, alignment: &str) -> std::result::Result<DAffine2, String> {
    if alignment == UNALIGNED {
        return Ok(DAffine2::IDENTITY);
    }
    let &[a, b, c, d, e, f] = planar
        .tforms
        .get(alignment)
        .ok_or_else(|| format!("it has no transform for the alignment {alignment:?}"))?;
    let place = DAffine2 {
        matrix2: DMat2::from_cols(DVec2::new(a, d), DVec2::new(b, e)),
        translation: DVec2::new(c, f),
    };
    match place.is_finite() && place.matrix2.determinant() != 0.0 {
        true => Ok(place),
        false => Err("its transform is none: correct its numbers".to_owned()),
    }
}

/// A list of x, y, color, closed, negative, hidden and more, after a name or not; or an object with
/// these members, in older files.
fn trace(value: &Value) -> std::result::Result<Trace, String> {
    let wrong = || "a trace is not of the form that PyReconstruct writes: save it anew".to_owned();
    let list = value.as_array().map_or(&[][..], Vec::as_slice);
    let list = if list.first().is_some_and(Value::is_string) { &list[1..] } else { list };
    let member =
        |number: usize, name: &str| list.get(number).or_else(|| value.get(name)).ok_or_else(wrong);
    let numbers =
        |value: &Value| serde_json::from_value::<Vec<f64>>(value.clone()).map_err(|_| wrong());
    let [x, y] = [numbers(member(0, "x")?)?, numbers(member(1, "y")?)?];
    if x.len() != y.len() {
        return Err(format!("a trace has {} x and {} y: save it anew", x.len(), y.len()));
    }
    let color = serde_json::from_value(member(2, "color")?.clone()).map_err(|_| wrong())?;
    let is = |number, name| member(number, name)?.as_bool().ok_or_else(wrong);
    Ok(Trace {
        // Two points enclose nothing, whatever is said.
        is_closed: is(3, "closed")? && x.len() > 2,
        is_negative: is(4, "negative")?,
        points: x.into_iter().zip(y).map(DVec2::from).collect(),
        color,
    })
}

/// The traces of an object as loops; a negative one is a hole of the smallest around it, and
/// without one it takes nothing away. `first` is how many loops there are before.
fn looped(traces: &[Trace], label: Label, first: usize, place: &DAffine2, z: f64) -> Vec<Loop> {
    let points = |own: &Trace| -> Vec<DVec3> {
        own.points.iter().map(|&at| place.transform_point2(at).extend(z)).collect()
    };
    let positive: Vec<&Trace> = traces.iter().filter(|own| !own.is_negative).collect();
    let mut loops: Vec<Loop> =
        positive.iter().map(|own| Loop { points: points(own), label, hole_of: None }).collect();
    for own in traces.iter().filter(|own| own.is_negative) {
        let around =
            (0..positive.len()).filter(|&other| holds(&positive[other].points, &own.points));
        let area = |&other: &usize| polygons::area(&positive[other].points);
        if let Some(outer) = around.min_by(|one, other| area(one).total_cmp(&area(other))) {
            loops.push(Loop { points: points(own), label, hole_of: Some(first + outer) });
        }
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sections 0 to 3, of which the first has no data; the square of section 2 is turned and moved.
    const SERIES: &str = r#"{"series": {"alignment": "mine", "window": [0, 0, 1, 1]}, "log": "",
        "sections": [null,
        {"src": "a.tif", "mag": 0.002, "thickness": 0.05, "tforms": {"mine": [1, 0, 0, 0, 1, 0]},
         "contours": {"d1": [[[0, 4, 4, 0], [0, 0, 4, 4], [255, 128, 0], true, false, false,
            ["none", "none"], []],
            [[1, 2, 2, 1], [1, 1, 2, 2], [255, 128, 0], true, true, false, ["none", "none"], []],
            [[1, 2], [1, 1], [255, 128, 0], false, false, false, ["none", "none"], []]]}},
        {"thickness": 0.05, "tforms": {"mine": [0, -1, 10, 1, 0, 20]},
         "contours": {"d1": [["d1", [0, 4, 4, 0], [0, 0, 4, 4], [255, 128, 0], true, false, false,
            ["none", "none"], []]],
          "axon": [{"x": [5, 7, 5], "y": [0, 0, 3], "color": [1, 2, 3], "closed": true,
            "negative": false, "hidden": true, "mode": [], "tags": []}]}},
        {"thickness": 0.05, "tforms": {"mine": [1, 0, 0, 0, 1, 0]}, "contours": {}}]}"#;

    fn read_text(text: &str) -> Result<Sections> {
        read(text, Path::new("a.jser"), &Rules::default())
    }

    #[test]
    fn traces_are_where_their_alignment_puts_them() {
        let sections = read_text(SERIES).expect("sections");
        assert_eq!(sections.units, "um");
        let names: Vec<&str> = sections.sections.iter().map(Section::name).collect();
        assert_eq!(names, ["1", "2"]);
        let materials: Vec<_> =
            sections.materials.iter().map(|own| (own.name.as_str(), own.color)).collect();
        assert_eq!(materials, [("d1", [255, 128, 0]), ("axon", [1, 2, 3])]);
        let areas = |section: &Section| -> Vec<f64> {
            let regions = section.regions().expect("regions");
            [1, 2]
                .map(|label| {
                    regions.iter().filter(|own| own.label == Label(label)).map(|own| own.area).sum()
                })
                .to_vec()
        };
        assert_eq!(areas(&sections.sections[0]), [15.0, 0.0]);
        assert_eq!(areas(&sections.sections[1]), [16.0, 3.0]);
        assert!((sections.sections[1].plane().offset - 0.1).abs() < 1e-12);
        // (0, 0) to (4, 4) becomes (10, 20) to (6, 24).
        let corners: Vec<DVec3> = (0..sections.sections[1].vertices().len() as u32)
            .map(|at| sections.sections[1].point(at))
            .collect();
        assert!(
            corners.iter().any(|at| at.distance(DVec3::new(6.0, 24.0, 0.1)) < 1e-12),
            "{corners:?}"
        );
        assert!(sections.left_out[0].what.contains("1 open"), "{:?}", sections.left_out);
    }

    #[test]
    fn what_is_no_series_is_refused() {
        let error = |from: &str, to: &str| {
            read_text(&SERIES.replacen(from, to, 1)).expect_err("it is wrong").to_string()
        };
        assert!(error("\"series\"", "\"serious\"").contains("missing field"));
        assert!(error("0.05", "-0.1").contains("thickness"));
        assert!(
            error("\"mine\": [1,", "\"other\": [1,").contains("section 1: it has no transform")
        );
        assert!(error("[0, -1, 10, 1, 0, 20]", "[0, 0, 10, 1, 0, 20]").contains("section 2"));
        assert!(error("[0, 4, 4, 0]", "[0, 4, 4]").contains("3 x and 4 y"));
        assert!(error("[0, 4, 4, 0]", "7").contains("not of the form"));
    }
}
