//! `.csl`: planes with loops (docs/formats.md).

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;

use super::text::{Row, Rows, shortened, shortest};
use super::{Raw, check, diagonal, off_planes, unwritten, writable};
use crate::error::Result;
use crate::plane::Plane;
use crate::section::{Loop, Region, Rules, Section, Sections};

/// The word that the file begins with.
const MAGIC: &str = "CSLC";

/// A plane and its loops.
struct Content {
    plane: Plane,
    points: Vec<DVec3>,
    loops: Vec<Loop>,
}

/// Reads the text of a `.csl` file; `file` is for errors.
///
/// # Errors
/// Where the text is no `.csl`, ends early, or a section breaks a rule.
pub fn read(text: &str, file: &Path, rules: &Rules) -> Result<Sections> {
    let mut rows = Rows::new(text, file);
    let magic = rows.next("", || format!("the word {MAGIC}"))?;
    if magic.words != [MAGIC] {
        let found = shortened(magic.words.first().unwrap_or(&""));
        return Err(magic.error(format!(
            "a .csl file begins with {MAGIC}, this one with {found:?}: it is of another kind"
        )));
    }
    let header = rows.next("", || "the number of planes".to_owned())?;
    let count = header.count(0, "the number of planes")?;
    let mut raw = Vec::new(); // no capacity from a count that may be wrong
    for number in 1..=count {
        raw.push(section(&mut rows, number)?);
    }
    let diagonal = diagonal(raw.iter().flat_map(|raw: &Raw<Content>| &raw.content.points));
    let is_turned = settle_offset(&mut raw, rules.tolerance * diagonal);
    let mut sections = check(file, &raw, rules, |raw| {
        let Content { plane, loops, .. } = &raw.content;
        Section::from_loops(&raw.name, *plane, loops, diagonal, rules)
    })?;
    if is_turned {
        let what = "D has the other sign throughout, as in A x + B y + C z = D: the planes are read \
                    where their vertices are";
        super::doubt(&mut sections, file, "the planes", what.to_owned(), rules)?;
    }
    super::refuse_rest(&mut rows, count, file, rules, &mut sections)?;
    Ok(sections)
}

/// Where vertices are off the planes by more than a tolerance (in world units), and on those with
/// the other sign of D, these are meant.
fn settle_offset(raw: &mut [Raw<Content>], tolerance: f64) -> bool {
    let planes = raw.iter().map(|raw| (&raw.content.plane, raw.content.points.as_slice()));
    let [given, other] = off_planes(planes);
    let is_turned = given > tolerance && other <= tolerance;
    if is_turned {
        for raw in raw {
            raw.content.plane.offset = -raw.content.plane.offset;
        }
    }
    is_turned
}

fn section(rows: &mut Rows, number: usize) -> Result<Raw<Content>> {
    let row = rows.next(&number.to_string(), || format!("plane {number}"))?;
    row.expect(7, || format!("plane {number} (id, vertices, loops, A, B, C, D)"))?;
    let name = shortened(row.words[0]);
    let place = format!("line {}", row.line);
    let [vertices, loops] =
        [row.count(1, "the number of vertices")?, row.count(2, "the number of loops")?];
    let normal = row.vector(3, "the plane's normal")?;
    let offset = 0.0 - row.number(6, "the plane's D")?; // A x + B y + C z + D = 0
    let plane = Plane { normal, offset };
    if normal == DVec3::ZERO {
        return Err(row.error("the plane's normal (A, B, C) is zero: correct the plane"));
    }
    let mut content = Content { plane, points: Vec::new(), loops: Vec::new() };
    for vertex in 0..vertices {
        let row = rows.next(&name, || format!("vertex {vertex} of {vertices}"))?;
        row.expect(3, || format!("vertex {vertex}"))?;
        content.points.push(row.vector(0, &format!("vertex {vertex}"))?);
    }
    for number in 0..loops {
        let row = rows.next(&name, || format!("loop {number} of {loops}"))?;
        content.loops.push(polygon(&row, number, loops, &content.points)?);
    }
    Ok(Raw { name, place, content })
}

/// `COUNT[hPARENT] label i0 i1 …`
fn polygon(row: &Row, number: usize, loops: usize, points: &[DVec3]) -> Result<Loop> {
    let first = row.words[0];
    let (count, parent) = match first.split_once(['h', 'H']) {
        Some((count, parent)) => (count, Some(parent)),
        None => (first, None),
    };
    let bad = |_| {
        row.error(format!(
            "loop {number} should begin with its number of vertices (as 12, or 12h0 for a hole of \
             loop 0), but begins with {:?}",
            shortened(first)
        ))
    };
    let count: usize = count.parse().map_err(bad)?;
    let hole_of: Option<usize> = parent.map(str::parse).transpose().map_err(bad)?;
    if let Some(parent) = hole_of.filter(|&parent| parent >= loops) {
        return Err(row.error(format!(
            "loop {number} is a hole of loop {parent}, but the section has {loops} loops, from 0"
        )));
    }
    if row.words.len().checked_sub(2) != Some(count) {
        return Err(row.error(format!(
            "loop {number} promises {count} vertices, the line has {}",
            row.words.len().saturating_sub(2)
        )));
    }
    // A hole's label is not to be trusted, but must be there.
    let label = row.label(1)?;
    let points = (2..row.words.len())
        .map(|word| row.index(word, points.len()).map(|index| points[index as usize]))
        .collect::<Result<Vec<DVec3>>>()?;
    Ok(Loop { points, label, hole_of })
}

/// Writes sections as `.csl`: every region one loop, counter-clockwise about
/// the normal, and its holes, clockwise. Reading it gives the same sections.
///
/// # Errors
/// Where a section has unknown regions, or reaches to infinity with a
/// material: the format has no word for them. And where writing fails.
pub fn write(sections: &Sections, out: &mut dyn Write) -> Result<()> {
    let regions =
        sections.sections.iter().map(|own| writable(own, ".csl")).collect::<Result<Vec<_>>>()?;
    let labels = sections.materials.last().map_or(0, |material| material.id);
    write_all(sections, &regions, labels, out).map_err(|error| unwritten(".csl", &error))
}

fn write_all(
    sections: &Sections,
    regions: &[Vec<Region>],
    labels: u32,
    out: &mut dyn Write,
) -> io::Result<()> {
    writeln!(out, "{MAGIC}\n{} {}", sections.sections.len(), u64::from(labels) + 1)?;
    for (number, (section, regions)) in sections.sections.iter().zip(regions).enumerate() {
        let Plane { normal, offset } = section.plane();
        let loops: usize = regions.iter().map(|region| 1 + region.holes.len()).sum();
        let counts = format!("{} {} {loops}", number + 1, section.vertices().len());
        let plane = [normal.x, normal.y, normal.z, -offset].map(shortest).join(" ");
        writeln!(out, "\n{counts} {plane}\n")?;
        for vertex in 0..section.vertices().len() {
            writeln!(out, "{}", section.point(vertex as u32).to_array().map(shortest).join(" "))?;
        }
        writeln!(out)?;
        write_loops(regions, out)?;
    }
    Ok(())
}

fn write_loops(regions: &[Region], out: &mut dyn Write) -> io::Result<()> {
    let mut number = 0;
    for region in regions {
        let outer = region.outer.iter().map(|walk| (walk, String::new()));
        let holes = region.holes.iter().map(|walk| (walk, format!("h{number}")));
        for (walk, parent) in outer.chain(holes) {
            write!(out, "{}{parent} {}", walk.len(), region.label.0)?;
            for vertex in walk {
                write!(out, " {vertex}")?;
            }
            writeln!(out)?;
        }
        number += 1 + region.holes.len();
    }
    Ok(())
}
