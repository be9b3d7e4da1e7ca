//! `.contour`: planes with planar graphs, labels on either side of every edge
//! (docs/formats.md).
//!
//! Two things differ between writers and are read off the data: the sign of
//! the plane's offset, and which label is the left one.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::text::{Rows, shortest};
use super::{Raw, check, diagonal, off_planes, unwritten, writable};
use crate::error::{Error, Result};
use crate::label::Label;
use crate::plane::Plane;
use crate::section::{Edge, Rules, Section, Sections};

/// A plane and its graph, labelA taken as the left one.
#[derive(Clone)]
struct Content {
    plane: Plane,
    points: Vec<DVec3>,
    edges: Vec<Edge>,
}

/// Reads the text of a `.contour` file; `file` is for errors.
///
/// # Errors
/// Where the text is no `.contour`, ends early, a section breaks a rule, or the
/// labels contradict each other whichever is taken as the left one.
pub fn read(text: &str, file: &Path, rules: &Rules) -> Result<Sections> {
    let mut rows = Rows::new(text, file);
    let header = rows.next("", || "the number of planes".to_owned())?;
    header.expect(1, || "the first line (the number of planes)".to_owned())?;
    let count = header.count(0, "the number of planes")?;
    let mut raw = Vec::new(); // no capacity from a count that may be wrong
    for number in 1..=count {
        raw.push(section(&mut rows, &number.to_string())?);
    }
    settle_offset(&mut raw);
    let diagonal = diagonal(raw.iter().flat_map(|raw| &raw.content.points));
    let make = |raw: &[Raw<Content>]| {
        check(file, raw, rules, |raw| {
            let Content { plane, points, edges } = &raw.content;
            Section::from_graph(&raw.name, *plane, points, edges, diagonal, rules)
        })
    };
    let mut sections =
        settle_sides(make(&raw), || make(&mirrored(&raw)), rules.meaning(Label::OUTSIDE))?;
    super::refuse_rest(&mut rows, count, file, rules, &mut sections)?;
    Ok(sections)
}

/// Writes sections as `.contour`, with a x + b y + c z = d and labelA on the left.
///
/// # Errors
/// Where a section has unknown regions, or reaches to infinity with a material, and where writing
/// fails.
pub fn write(sections: &Sections, out: &mut dyn Write) -> Result<()> {
    for section in &sections.sections {
        writable(section, ".contour")?;
    }
    write_all(sections, out).map_err(|error| unwritten(".contour", &error))
}

fn write_all(sections: &Sections, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{}", sections.sections.len())?;
    for section in &sections.sections {
        let Plane { normal, offset } = section.plane();
        let plane = [normal.x, normal.y, normal.z, *offset].map(shortest).join(" ");
        writeln!(out, "\n{plane}\n{} {}", section.vertices().len(), section.edges().len())?;
        for vertex in 0..section.vertices().len() {
            writeln!(out, "{}", section.point(vertex as u32).to_array().map(shortest).join(" "))?;
        }
        for Edge { start, end, left, right } in section.edges() {
            writeln!(out, "{start} {end} {} {}", left.0, right.0)?;
        }
    }
    Ok(())
}

fn section(rows: &mut Rows, name: &str) -> Result<Raw<Content>> {
    let row = rows.next(name, || format!("plane {name}"))?;
    row.expect(4, || "a plane (a, b, c, d)".to_owned())?;
    let place = format!("line {}", row.line);
    let normal = row.vector(0, "the plane's normal")?;
    if normal == DVec3::ZERO {
        return Err(row.error("the plane's normal (a, b, c) is zero: correct the plane"));
    }
    let plane = Plane { normal, offset: row.number(3, "the plane's d")? };
    let row = rows.next(name, || "the numbers of vertices and edges".to_owned())?;
    row.expect(2, || "the line after a plane (vertices, edges)".to_owned())?;
    let [vertices, edges] =
        [row.count(0, "the number of vertices")?, row.count(1, "the number of edges")?];
    let mut content = Content { plane, points: Vec::new(), edges: Vec::new() };
    for vertex in 0..vertices {
        let row = rows.next(name, || format!("vertex {vertex} of {vertices}"))?;
        row.expect(3, || format!("vertex {vertex}"))?;
        content.points.push(row.vector(0, &format!("vertex {vertex}"))?);
    }
    for edge in 0..edges {
        let row = rows.next(name, || format!("edge {edge} of {edges}"))?;
        row.expect(4, || format!("edge {edge}"))?;
        let count = content.points.len();
        content.edges.push(Edge {
            start: row.index(0, count)?,
            end: row.index(1, count)?,
            left: row.label(2)?,
            right: row.label(3)?,
        });
    }
    Ok(Raw { name: name.to_owned(), place, content })
}

/// a x + b y + c z = d, or … + d = 0: whichever the file's vertices are nearer to.
fn settle_offset(raw: &mut [Raw<Content>]) {
    let planes = raw.iter().map(|raw| (&raw.content.plane, raw.content.points.as_slice()));
    let [given, other] = off_planes(planes);
    if other < given {
        for raw in raw {
            raw.content.plane.offset = -raw.content.plane.offset;
        }
    }
}

/// The same with labelA taken as the right one.
fn mirrored(raw: &[Raw<Content>]) -> Vec<Raw<Content>> {
    let swap = |edge: &Edge| Edge { left: edge.right, right: edge.left, ..*edge };
    raw.iter()
        .map(|Raw { name, place, content }| {
            let edges = content.edges.iter().map(swap).collect();
            let content = Content { edges, ..content.clone() };
            Raw { name: name.clone(), place: place.clone(), content }
        })
        .collect()
}

/// labelA as the left one where that is consistent; a single ring is
/// consistent both ways, and then *outside*, or what it means here, must lie
/// outside.
fn settle_sides(
    left: Result<Sections>,
    right: impl FnOnce() -> Result<Sections>,
    far: Label,
) -> Result<Sections> {
    let outside = |sections: &Sections| {
        sections.sections.iter().filter(|section| section.background() == far).count()
    };
    match left {
        Ok(left) if outside(&left) == left.sections.len() => Ok(left),
        Ok(left) => match right() {
            Ok(right) if outside(&right) > outside(&left) => Ok(right),
            _ => Ok(left),
        },
        Err(Error::Input { file, place, what }) => right().map_err(|_| Error::Input {
            file,
            place,
            what: format!("{what} (taking labelA as the left one; the other way is no better)"),
        }),
        Err(other) => Err(other),
    }
}
