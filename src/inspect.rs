//! What is in files of sections, and what is doubtful about it.

use std::fmt::{self, Write};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::label::Label;
use crate::plane::Bounds;
use crate::section::{Disagreement, Region, Section, Sections, Warning};
use crate::terminal::Lines;

/// Normals that differ by less than this, in radians, are one orientation.
const PARALLEL: f64 = 1e-6;
/// How many entries of a list the text shows.
const SHOWN: usize = 20;

/// What is in files of sections.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inspection {
    /// The files.
    pub files: Vec<String>,
    /// How many structures may overlap, each with sections of its own; 1 where labels exclude each
    /// other.
    pub layers: usize,
    /// How many sections there are.
    pub sections: usize,
    /// The unit of length; empty when unknown.
    pub units: String,
    /// The frame of the coordinates; empty when unknown.
    pub frame: String,
    /// The smallest and largest coordinates; absent without contours.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// The diagonal of the bounds.
    pub diagonal: f64,
    /// Vertices of all sections.
    pub vertices: usize,
    /// Edges of all sections.
    pub edges: usize,
    /// Closed boundaries of material and unknown regions.
    pub loops: usize,
    /// How many of them bound holes.
    pub holes: usize,
    /// The largest distance of a vertex off its plane, as the file gives it.
    pub off_plane: f64,
    /// The planes by their orientation, the most frequent first.
    pub orientations: Vec<Orientation>,
    /// The materials, and *unknown* where it occurs.
    pub labels: Vec<Content>,
    /// The sections of which something is unknown, in their order.
    pub unknown: Vec<Unknown>,
    /// How files were understood where they leave a choice.
    pub notes: Vec<Warning>,
    /// What was doubtful.
    pub warnings: Vec<Warning>,
    /// What was left out.
    pub left_out: Vec<Warning>,
    /// Pairs of sections that disagree along their common line, the worst first.
    pub disagreements: Vec<Disagreement>,
}

/// Planes with one normal, or its opposite.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Orientation {
    /// Of unit length; its largest component is positive.
    pub normal: [f64; 3],
    /// The names of the sections, by their offset along the normal.
    pub sections: Vec<String>,
    /// The smallest, mean and largest distance of neighbours; absent for one.
    pub spacing: Option<[f64; 3]>,
}

/// How much there is of a label.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Content {
    /// The label's number; absent for *unknown*.
    pub id: Option<u32>,
    /// Its name.
    pub name: String,
    /// Its colour, `#rrggbb`; absent for *unknown*.
    pub color: Option<String>,
    /// How many sections it occurs on.
    pub sections: usize,
    /// How many regions it has; unbounded ones are not counted.
    pub regions: usize,
    /// The area of these regions, in square units.
    pub area: f64,
}

/// How much of a section is unknown, within the rectangle around its contours
/// and extent.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Unknown {
    /// The section's name.
    pub section: String,
    /// The unknown area in that rectangle, in square units; absent where there
    /// are no contours: then all is unknown.
    pub area: Option<f64>,
    /// Its share of the rectangle, from 0 to 1.
    pub share: f64,
    /// Whether all beyond the rectangle is unknown too.
    pub beyond: bool,
}

/// What is in sections.
///
/// # Errors
/// Where a stage fails; valid sections do not make it.
pub fn inspect(sections: &Sections) -> Result<Inspection> {
    let regions: Vec<Result<Vec<Region>>> =
        sections.sections.par_iter().map(Section::regions).collect();
    let regions = regions.into_iter().collect::<Result<Vec<Vec<Region>>>>()?;
    let spoken = || regions.iter().flatten().filter(|region| region.label != Label::OUTSIDE);
    let bounds = sections.bounds();
    Ok(Inspection {
        files: sections.files.iter().map(|file| file.display().to_string()).collect(),
        layers: 1,
        sections: sections.sections.len(),
        units: sections.units.clone(),
        frame: sections.frame.clone(),
        bounds: bounds.map(|Bounds { min, max }| [min.to_array(), max.to_array()]),
        diagonal: bounds.map_or(0.0, |bounds| bounds.diagonal()),
        vertices: sections.sections.iter().map(|section| section.vertices().len()).sum(),
        edges: sections.sections.iter().map(|section| section.edges().len()).sum(),
        loops: spoken()
            .map(|region| region.holes.len() + usize::from(region.outer.is_some()))
            .sum(),
        holes: spoken().map(|region| region.holes.len()).sum(),
        off_plane: sections.off_plane,
        orientations: orientations(&sections.sections),
        labels: contents(sections, &regions),
        unknown: sections
            .sections
            .iter()
            .zip(&regions)
            .filter_map(|(section, regions)| unknown(section, regions))
            .collect(),
        notes: sections.notes.clone(),
        warnings: sections.warnings.clone(),
        left_out: sections.left_out.clone(),
        disagreements: sections.disagreements(),
    })
}

fn contents(sections: &Sections, regions: &[Vec<Region>]) -> Vec<Content> {
    let mut labels: Vec<Label> = sections.sections.iter().flat_map(Section::labels).collect();
    labels.sort();
    labels.dedup();
    labels.retain(|&label| label != Label::OUTSIDE);
    labels.into_iter().map(|label| content(sections, regions, label)).collect()
}

fn content(sections: &Sections, regions: &[Vec<Region>], label: Label) -> Content {
    let material = sections.material(label);
    let of = |regions: &&Region| regions.label == label;
    let bounded = || regions.iter().flatten().filter(of).filter(|region| region.outer.is_some());
    Content {
        id: label.is_material().then_some(label.0),
        name: material.map_or_else(|| label.to_string(), |material| material.name.clone()),
        color: material.map(|material| {
            let [red, green, blue] = material.color;
            format!("#{red:02x}{green:02x}{blue:02x}")
        }),
        sections: regions.iter().filter(|section| section.iter().any(|region| of(&region))).count(),
        regions: bounded().count(),
        area: bounded().fold(0.0, |sum, region| sum + region.area),
    }
}

/// How much of a section is unknown; `None` where all is known. The rectangle
/// is full of bounded regions and of the unbounded one.
fn unknown(section: &Section, regions: &[Region]) -> Option<Unknown> {
    if !section.is_partial() {
        return None;
    }
    let name = section.name().to_owned();
    let Some(rectangle) = section.rectangle() else {
        return Some(Unknown { section: name, area: None, share: 1.0, beyond: true });
    };
    let bounded = |unknown: bool| -> f64 {
        let of = |region: &&Region| (region.label == Label::UNKNOWN) == unknown;
        let bounded = regions.iter().filter(|region| region.outer.is_some());
        bounded.filter(of).fold(0.0, |sum, region| sum + region.area)
    };
    let beyond = section.background() == Label::UNKNOWN;
    let area = if beyond { (rectangle.area() - bounded(false)).max(0.0) } else { bounded(true) };
    let share = (area / rectangle.area()).min(1.0);
    Some(Unknown { section: name, area: Some(area), share, beyond })
}

/// The planes by orientation: parallel ones together.
fn orientations(sections: &[Section]) -> Vec<Orientation> {
    let mut groups: Vec<(DVec3, Vec<(f64, String)>)> = Vec::new();
    for section in sections {
        let plane = section.plane();
        let unit = plane.unit_normal();
        let sign = unit[plane.dropped_axis()].signum();
        let entry = (sign * plane.offset / plane.normal.length(), section.name().to_owned());
        let parallel =
            groups.iter_mut().find(|(normal, _)| normal.cross(sign * unit).length() < PARALLEL);
        match parallel {
            Some((_, members)) => members.push(entry),
            None => groups.push((sign * unit, vec![entry])),
        }
    }
    groups.sort_by_key(|(_, members)| std::cmp::Reverse(members.len()));
    groups.into_iter().map(|(normal, members)| orientation(normal, members)).collect()
}

fn orientation(normal: DVec3, mut members: Vec<(f64, String)>) -> Orientation {
    members.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Layers have sections on the same planes.
    let gaps = members.windows(2).map(|pair| pair[1].0 - pair[0].0);
    let gaps: Vec<f64> = gaps.filter(|&gap| gap > 0.0).collect();
    let spacing = (!gaps.is_empty()).then(|| {
        let smallest = gaps.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = gaps.iter().copied().fold(0.0, f64::max);
        [smallest, gaps.iter().sum::<f64>() / gaps.len() as f64, largest]
    });
    let sections = members.into_iter().map(|(_, name)| name).collect();
    Orientation { normal: (normal + 0.0).to_array(), sections, spacing }
}

impl fmt::Display for Inspection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut lines = Lines::default();
        self.write(&mut lines)?;
        f.write_str(lines.as_str())
    }
}

impl Inspection {
    fn write(&self, f: &mut Lines) -> fmt::Result {
        self.write_summary(f)?;
        self.write_orientations(f)?;
        self.write_labels(f)?;
        self.write_unknown(f)?;
        if !self.notes.is_empty() {
            write_told(f, "notes", &self.notes)?;
        }
        write_told(f, "left out", &self.left_out)?;
        write_told(f, "warnings", &self.warnings)?;
        self.write_disagreements(f)
    }

    fn write_summary(&self, f: &mut Lines) -> fmt::Result {
        let or_unknown = |text: &str| if text.is_empty() { "unknown" } else { text }.to_owned();
        writeln!(f, "files         {}", self.files.join(", "))?;
        match self.layers {
            1 => writeln!(f, "sections      {}", self.sections)?,
            layers => writeln!(
                f,
                "sections      {}, of {layers} structures that may overlap: each is a solid of its own",
                self.sections
            )?,
        }
        writeln!(f, "vertices      {}, edges {}", self.vertices, self.edges)?;
        writeln!(f, "loops         {}, {} of them holes", self.loops, self.holes)?;
        if let Some([min, max]) = self.bounds {
            writeln!(f, "bounds        {} to {}", triple(min), triple(max))?;
        }
        writeln!(f, "diagonal      {:.6}", self.diagonal)?;
        let (units, frame) = (or_unknown(&self.units), or_unknown(&self.frame));
        writeln!(f, "units         {units}, frame {frame}")?;
        let relative = self.off_plane / self.diagonal.max(f64::MIN_POSITIVE);
        writeln!(f, "off plane     {:.3e} at most ({relative:.1e} of the diagonal)", self.off_plane)
    }

    fn write_orientations(&self, f: &mut Lines) -> fmt::Result {
        writeln!(f, "orientations  {}", self.orientations.len())?;
        for group in self.orientations.iter().take(SHOWN) {
            write!(f, "  {:4} with normal {}", group.sections.len(), triple(group.normal))?;
            if let Some([smallest, mean, largest]) = group.spacing {
                write!(f, ", {mean:.6} apart ({smallest:.6} to {largest:.6})")?;
            }
            writeln!(f)?;
        }
        write_more(f, self.orientations.len())
    }

    fn write_labels(&self, f: &mut Lines) -> fmt::Result {
        writeln!(f, "labels        {}", self.labels.len())?;
        for label in &self.labels {
            let id = label.id.map_or("-".to_owned(), |id| id.to_string());
            let color = label.color.as_deref().unwrap_or("-");
            writeln!(
                f,
                "  {id:>4} {:<20} {color:<7}  area {:.6} in {} regions on {} sections",
                label.name, label.area, label.regions, label.sections
            )?;
        }
        Ok(())
    }

    fn write_unknown(&self, f: &mut Lines) -> fmt::Result {
        writeln!(f, "unknown       on {} sections", self.unknown.len())?;
        for part in self.unknown.iter().take(SHOWN) {
            write!(f, "  {}: ", part.section)?;
            let beyond = if part.beyond { ", and all beyond" } else { "" };
            match part.area {
                Some(area) => writeln!(
                    f,
                    "area {area:.6}, {:.1} % of the rectangle around its contours{beyond}",
                    100.0 * part.share
                )?,
                None => writeln!(f, "everything")?,
            }
        }
        write_more(f, self.unknown.len())
    }

    fn write_disagreements(&self, f: &mut Lines) -> fmt::Result {
        let total = self.disagreements.iter().fold(0.0, |sum, pair| sum + pair.length);
        writeln!(
            f,
            "disagreement  {} pairs of sections, over a length of {total:.3e} of their common lines",
            self.disagreements.len()
        )?;
        for pair in self.disagreements.iter().take(SHOWN) {
            writeln!(
                f,
                "  {} and {}: {:.3e} of {:.3e}, worst near {}: {} against {}",
                pair.sections[0],
                pair.sections[1],
                pair.length,
                pair.occupied,
                triple(pair.worst),
                pair.labels[0],
                pair.labels[1]
            )?;
        }
        write_more(f, self.disagreements.len())
    }
}

fn triple([x, y, z]: [f64; 3]) -> String {
    format!("({x:.6}, {y:.6}, {z:.6})")
}

fn write_told(f: &mut Lines, title: &str, told: &[Warning]) -> fmt::Result {
    writeln!(f, "{title:<13} {}", told.len())?;
    for Warning { section, what } in told {
        let section = if section.is_empty() { "the file" } else { section };
        writeln!(f, "  {section}: {what}")?;
    }
    Ok(())
}

fn write_more(f: &mut Lines, count: usize) -> fmt::Result {
    if count > SHOWN { writeln!(f, "  and {} more", count - SHOWN) } else { Ok(()) }
}
