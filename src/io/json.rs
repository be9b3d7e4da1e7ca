//! Our own format of sections (docs/formats.md): everything a [`Section`] can
//! say, with names, colours, units and the frame.

use std::io::{self, Write};
use std::path::Path;

use glam::DVec3;
use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use super::{Raw, check, diagonal, unwritten};
use crate::direction;
use crate::error::{Error, Result};
use crate::label::{Label, Material};
use crate::plane::Plane;
use crate::section::{Edge, Findings, Loop, Rules, Section, Sections};

/// What the member `transect` says in such a file.
const KIND: &str = "sections";
/// The version that is written and read.
const VERSION: u64 = 1;

/// The members that say whether the rest can be understood.
#[derive(Deserialize)]
struct Header {
    transect: Option<String>,
    version: Option<u64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    transect: String,
    version: u64,
    #[serde(default)]
    units: String,
    #[serde(default)]
    frame: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    up: Option<Up>,
    #[serde(default)]
    labels: Vec<Named>,
    sections: Vec<Planar>,
}

/// Which way is up: an axis as `z` or `-y`, or a vector.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged, expecting = "\"up\" is an axis (\"z\", \"-y\") or a vector ([0, 0, 1])")]
enum Up {
    Axis(String),
    Vector([f64; 3]),
}

/// A material.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Named {
    id: u32,
    name: Option<String>,
    /// `#rrggbb`.
    color: Option<String>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Planar {
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<String>,
    normal: [f64; 3],
    offset: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    background: Option<Word>,
    #[serde(skip_serializing_if = "Option::is_none")]
    extent: Option<Vec<[f64; 3]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    loops: Option<Vec<Polygon>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertices: Option<Vec<[f64; 3]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    edges: Option<Vec<(u32, u32, Word, Word)>>,
    /// Of the surface, at the vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    normals: Option<Vec<Option<[f64; 3]>>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Polygon {
    #[serde(skip_serializing_if = "Option::is_none")]
    label: Option<Word>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hole_of: Option<usize>,
    points: Vec<[f64; 3]>,
    /// Of the surface, at the points.
    #[serde(skip_serializing_if = "Option::is_none")]
    normals: Option<Vec<Option<[f64; 3]>>>,
}

/// A label as written: its number, its name, `outside` or `unknown`.
#[derive(Clone)]
enum Word {
    Number(u32),
    Name(String),
}

impl<'de> Deserialize<'de> for Word {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        struct Words;
        impl Visitor<'_> for Words {
            type Value = Word;
            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a label (its number, its name, \"outside\" or \"unknown\")")
            }
            fn visit_u64<E: de::Error>(self, number: u64) -> std::result::Result<Word, E> {
                u32::try_from(number)
                    .ok()
                    .filter(|&number| number != u32::MAX)
                    .map(Word::Number)
                    .ok_or_else(|| E::invalid_value(de::Unexpected::Unsigned(number), &self))
            }
            fn visit_str<E: de::Error>(self, name: &str) -> std::result::Result<Word, E> {
                Ok(Word::Name(name.to_owned()))
            }
        }
        deserializer.deserialize_any(Words)
    }
}

impl Serialize for Word {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => serializer.serialize_u32(*number),
            Self::Name(name) => serializer.serialize_str(name),
        }
    }
}

impl From<Label> for Word {
    fn from(label: Label) -> Self {
        if label == Label::UNKNOWN {
            Self::Name("unknown".to_owned())
        } else {
            Self::Number(label.0)
        }
    }
}

/// A section's contours with their labels.
enum Contours {
    Loops(Vec<Loop>),
    Graph(Vec<DVec3>, Vec<Edge>),
}

struct Content {
    plane: Plane,
    background: Option<Label>,
    extent: Option<Vec<DVec3>>,
    contours: Contours,
    /// Points, and the surface's normals there.
    normals: Vec<(DVec3, DVec3)>,
}

/// Reads the text of such a file; `file` is for errors.
///
/// # Errors
/// Where the text is no JSON or of another kind or version, and where a
/// section breaks a rule.
pub fn read(text: &str, file: &Path, rules: &Rules) -> Result<Sections> {
    check_version(text, file)?;
    let content: File = parse(text, file)?;
    let materials = materials(file, &content.labels)?;
    let raw = content
        .sections
        .iter()
        .enumerate()
        .map(|(i, planar)| raw(file, i, planar, &materials))
        .collect::<Result<Vec<_>>>()?;
    let diagonal = diagonal(raw.iter().flat_map(|raw| raw.content.points()));
    let mut sections = check(file, &raw, rules, |raw| make(raw, diagonal, rules))?;
    sections.units = content.units;
    sections.frame = content.frame;
    sections.up = content.up.map(|up| upward(file, &up)).transpose()?;
    sections.name_materials(materials);
    Ok(sections)
}

pub(super) fn parse<'a, T: Deserialize<'a>>(text: &'a str, file: &Path) -> Result<T> {
    serde_json::from_str(text).map_err(|error| {
        let place = format!("line {}, column {}", error.line(), error.column());
        let text = error.to_string();
        let what = text.rsplit_once(" at line").map_or(text.as_str(), |(what, _)| what);
        Error::input(file, place, format!("{what}: docs/formats.md says what belongs there"))
    })
}

fn check_version(text: &str, file: &Path) -> Result<()> {
    let header: Header = parse(text, file)?;
    if header.transect.as_deref() != Some(KIND) {
        return Err(Error::file(
            file,
            format!("this JSON holds no sections: they begin with \"transect\": \"{KIND}\""),
        ));
    }
    match header.version {
        Some(VERSION) => Ok(()),
        Some(version) => Err(Error::file(
            file,
            format!("its version is {version}, and only {VERSION} can be read: update transect"),
        )),
        None => Err(Error::file(file, format!("it has no version: add \"version\": {VERSION}"))),
    }
}

fn materials(file: &Path, labels: &[Named]) -> Result<Vec<Material>> {
    let mut found: Vec<Material> = Vec::with_capacity(labels.len());
    for (i, named) in labels.iter().enumerate() {
        let error = |what: String| Err(Error::input(file, format!("labels[{i}]"), what));
        if !Label(named.id).is_material() {
            return error(format!("the id {} is no material's: they count from 1", named.id));
        }
        let mut material = Material::numbered(Label(named.id));
        material.name = named.name.clone().unwrap_or(material.name);
        if let Some(color) = &named.color {
            let Some(color) = hex(color) else {
                return error(format!("the color {color:?} is not of the form #rrggbb"));
            };
            material.color = color;
        }
        if ["outside", "unknown"].contains(&material.name.as_str()) {
            return error(format!("the name {:?} has a meaning of its own", material.name));
        }
        if found.iter().any(|known| known.id == material.id || known.name == material.name) {
            return error(format!(
                "the id {} or the name {:?} occurs twice: make them unique",
                material.id, material.name
            ));
        }
        found.push(material);
    }
    Ok(found)
}

fn upward(file: &Path, up: &Up) -> Result<DVec3> {
    let (direction, written) = match up {
        Up::Axis(name) => (direction::axis(name), format!("{name:?}")),
        Up::Vector(vector) => (Some(DVec3::from_array(*vector)), format!("{vector:?}")),
    };
    direction.filter(|&up| direction::unit(up).is_some()).ok_or_else(|| {
        let what = format!("{written} is no direction: write \"x\", \"-z\" or [0, 1, 0]");
        Error::input(file, "\"up\"", what)
    })
}

/// The channels of `#rrggbb`.
fn hex(color: &str) -> Option<[u8; 3]> {
    let digits = color.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    let [_, red, green, blue] = number.to_be_bytes();
    Some([red, green, blue])
}

fn raw(file: &Path, i: usize, planar: &Planar, materials: &[Material]) -> Result<Raw<Content>> {
    let name = planar.name.clone().unwrap_or_else(|| (i + 1).to_string());
    let place = format!("sections[{i}]");
    let error = |what: String| Error::input(file, format!("section {name} ({place})"), what);
    let label = |word: &Word| resolve(word, materials).map_err(error);
    let contours = match (&planar.loops, &planar.vertices, &planar.edges) {
        (Some(loops), None, None) => Contours::Loops(
            loops
                .iter()
                .enumerate()
                .map(|(i, polygon)| {
                    to_loop(polygon, &label)?.ok_or_else(|| {
                        error(format!("loops[{i}] needs a \"label\", or \"hole_of\" for a hole"))
                    })
                })
                .collect::<Result<_>>()?,
        ),
        (None, Some(vertices), Some(edges)) => Contours::Graph(
            points(vertices),
            edges.iter().map(|edge| to_edge(edge, &label)).collect::<Result<_>>()?,
        ),
        (None, None, None) => Contours::Graph(Vec::new(), Vec::new()),
        _ => return Err(error("it needs \"loops\", or \"vertices\" with \"edges\"".to_owned())),
    };
    let normals = normals(planar).map_err(error)?;
    let content = Content {
        plane: Plane { normal: DVec3::from_array(planar.normal), offset: planar.offset },
        background: planar.background.as_ref().map(label).transpose()?,
        extent: planar.extent.as_deref().map(points),
        contours,
        normals,
    };
    Ok(Raw { name, place, content })
}

/// Points of a section at which the surface's normal is given.
fn normals(planar: &Planar) -> std::result::Result<Vec<(DVec3, DVec3)>, String> {
    let of_loops =
        planar.loops.iter().flatten().enumerate().map(|(i, polygon)| {
            (format!("loops[{i}]"), "points", &polygon.points, &polygon.normals)
        });
    let none = Vec::new();
    let vertices = planar.vertices.as_ref().unwrap_or(&none);
    let of_graph = ("the section".to_owned(), "vertices", vertices, &planar.normals);
    let mut known = Vec::new();
    for (whose, what, points, normals) in of_loops.chain([of_graph]) {
        let Some(normals) = normals else { continue };
        if normals.len() != points.len() {
            return Err(format!(
                "{whose} has {} {what} and {} normals: give one for each, null where it is not \
                 known",
                points.len(),
                normals.len()
            ));
        }
        let pairs = points.iter().zip(normals).filter_map(|(&at, &normal)| Some((at, normal?)));
        known.extend(pairs.map(|(at, normal)| (at.into(), normal.into())));
    }
    Ok(known)
}

fn points(points: &[[f64; 3]]) -> Vec<DVec3> {
    points.iter().copied().map(DVec3::from_array).collect()
}

fn to_loop(polygon: &Polygon, label: &impl Fn(&Word) -> Result<Label>) -> Result<Option<Loop>> {
    let known = polygon.label.as_ref().map(label).transpose()?;
    let default = polygon.hole_of.map(|_| Label::OUTSIDE);
    let points = points(&polygon.points);
    Ok(known.or(default).map(|label| Loop { points, label, hole_of: polygon.hole_of }))
}

fn to_edge(edge: &(u32, u32, Word, Word), label: &impl Fn(&Word) -> Result<Label>) -> Result<Edge> {
    let (start, end, left, right) = edge;
    Ok(Edge { start: *start, end: *end, left: label(left)?, right: label(right)? })
}

fn resolve(word: &Word, materials: &[Material]) -> std::result::Result<Label, String> {
    match word {
        Word::Number(number) => Ok(Label(*number)),
        Word::Name(name) if name == "outside" => Ok(Label::OUTSIDE),
        Word::Name(name) if name == "unknown" => Ok(Label::UNKNOWN),
        Word::Name(name) => materials
            .iter()
            .find(|material| material.name == *name)
            .map(|material| Label(material.id))
            .ok_or_else(|| format!("no label is called {name:?}: add it to \"labels\"")),
    }
}

impl Content {
    fn points(&self) -> Vec<&DVec3> {
        let contours: Vec<&DVec3> = match &self.contours {
            Contours::Loops(loops) => loops.iter().flat_map(|polygon| &polygon.points).collect(),
            Contours::Graph(points, _) => points.iter().collect(),
        };
        contours.into_iter().chain(self.extent.iter().flatten()).collect()
    }
}

fn make(raw: &Raw<Content>, diagonal: f64, rules: &Rules) -> Result<(Section, Findings)> {
    let Raw { name, content, .. } = raw;
    let plane = content.plane;
    let (mut section, mut findings) = match &content.contours {
        Contours::Loops(loops) => Section::from_loops(name, plane, loops, diagonal, rules)?,
        Contours::Graph(points, edges) => {
            Section::from_graph(name, plane, points, edges, diagonal, rules)?
        }
    };
    if let Some(background) = content.background {
        section = section.with_background(background)?;
    }
    if let Some(extent) = &content.extent {
        let loops: &[Loop] = match &content.contours {
            Contours::Loops(loops) => loops,
            Contours::Graph(..) => &[],
        };
        let (within, found) = section.within(extent, loops, diagonal, rules)?;
        section = within;
        findings.append(found);
    }
    Ok((section.with_normals(content.normals.iter().copied())?, findings))
}

/// Writes sections as JSON: every section a planar graph, on a line of its
/// own. Reading it gives the same sections.
///
/// # Errors
/// Where writing fails.
pub fn write(sections: &Sections, out: &mut dyn Write) -> Result<()> {
    write_all(sections, out).map_err(|error| unwritten(".json", &error))
}

fn write_all(sections: &Sections, out: &mut dyn Write) -> io::Result<()> {
    let File { units, frame, up, labels, sections, .. } = document(sections);
    writeln!(out, "{{\n\"transect\": \"{KIND}\",\n\"version\": {VERSION},")?;
    writeln!(out, "\"units\": {},", serde_json::to_string(&units)?)?;
    writeln!(out, "\"frame\": {},", serde_json::to_string(&frame)?)?;
    if let Some(up) = up {
        writeln!(out, "\"up\": {},", serde_json::to_string(&up)?)?;
    }
    rows(out, "labels", &labels)?;
    writeln!(out, ",")?;
    rows(out, "sections", &sections)?;
    writeln!(out, "\n}}")
}

/// Sections as JSON on a single line. Reading it gives the same sections.
///
/// # Errors
/// Where a number has no JSON.
pub fn line(sections: &Sections) -> Result<String> {
    serde_json::to_string(&document(sections)).map_err(|error| unwritten(".json", &error.into()))
}

/// All that is written.
fn document(sections: &Sections) -> File {
    let up = |up| match direction::axis_name(up) {
        Some(name) => Up::Axis(name.to_owned()),
        None => Up::Vector(up.to_array()),
    };
    File {
        transect: KIND.to_owned(),
        version: VERSION,
        units: sections.units.clone(),
        frame: sections.frame.clone(),
        up: sections.up.map(up),
        labels: sections.materials.iter().map(named).collect(),
        sections: sections.sections.iter().map(planar).collect(),
    }
}

/// A member that is a list, an entry a line.
fn rows<T: Serialize>(out: &mut dyn Write, name: &str, entries: &[T]) -> io::Result<()> {
    write!(out, "\"{name}\": [")?;
    for (i, entry) in entries.iter().enumerate() {
        write!(out, "{}", if i == 0 { "\n" } else { ",\n" })?;
        serde_json::to_writer(&mut *out, entry)?;
    }
    write!(out, "\n]")
}

fn named(material: &Material) -> Named {
    let [red, green, blue] = material.color;
    Named {
        id: material.id,
        name: Some(material.name.clone()),
        color: Some(format!("#{red:02x}{green:02x}{blue:02x}")),
    }
}

fn planar(section: &Section) -> Planar {
    let vertices = 0..section.vertices().len() as u32;
    let edge = |edge: &Edge| (edge.start, edge.end, edge.left.into(), edge.right.into());
    let known = |normal: DVec3| (normal != DVec3::ZERO).then(|| normal.to_array());
    Planar {
        name: Some(section.name().to_owned()),
        normal: section.plane().normal.to_array(),
        offset: section.plane().offset,
        background: Some(section.background().into()),
        vertices: Some(vertices.map(|vertex| section.point(vertex).to_array()).collect()),
        edges: Some(section.edges().iter().map(edge).collect()),
        normals: (!section.normals().is_empty())
            .then(|| section.normals().iter().map(|&normal| known(normal)).collect()),
        ..Planar::default()
    }
}
