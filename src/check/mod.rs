//! What a result is worth: how well it agrees with the sections, and whether
//! its surfaces are what they should be.

pub mod afloat;
pub mod cavalieri;
mod components;
pub mod contour;
pub mod overlap;
pub mod passage;
pub mod pieces;
mod raster;
pub mod ripple;
#[cfg(test)]
pub(crate) mod shapes;
pub mod support;
pub mod unknown;
pub mod warnings;

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Result;
use crate::grid::labels::LabelGrid;
use crate::grid::samples::{Lattice, Samples};
use crate::label::Label;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::mesh::facts::Facts;
use crate::mesh::{Mesh, Surface};
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::{Section, Stack};
use afloat::Afloat;
use cavalieri::Cavalieri;
use components::Components;
use contour::{Contours, Unreached};
use overlap::Counts;
use passage::{Passage, passages};
use pieces::{Pieces, Scene};
use raster::Raster;
use ripple::{Ripple, ripples};
use support::{Support, support};

/// So many pixels of a section's raster are on the longest side of the box around what is drawn,
/// at least, unless the whole box would have more than those.
const PIXELS: f64 = 48.0;
const MOST_PIXELS: f64 = 4096.0;

/// What is measured besides the rest.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Options {
    /// Whether self-intersections are counted, which is slow.
    pub self_intersections: bool,
    /// The box, when the mesh is to be used without its caps: surfaces may then
    /// be open there.
    pub open: Option<Bounds>,
}

/// What a mesh is worth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// The side of a voxel, in world units: what distances are given in.
    pub voxel: f64,
    /// The sections' agreement with the mesh.
    pub dice: Agreement,
    /// The contours' distances to it.
    pub contours: Contours,
    /// The stack, where the sections are one.
    pub stack: Option<StackCheck>,
    /// Every material of the sections and of the mesh, by number.
    pub labels: Vec<LabelCheck>,
    /// Where the surface is farthest from what is known.
    pub support: Support,
    /// The volume of the lattice's box less that of all materials, in cubic
    /// world units.
    pub outside_volume: f64,
    /// The volume of the lattice's box, in cubic world units.
    pub box_volume: f64,
}

/// Sections that are parallel.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StackCheck {
    /// Their common normal, of length one.
    pub direction: [f64; 3],
    /// The smallest distance between neighbours, in world units.
    pub least_spacing: f64,
    /// The largest.
    pub largest_spacing: f64,
}

/// Dice's coefficient between sections and the mesh's cuts by their planes,
/// rasterised with pixels of half a voxel, or less where what is drawn would have few of them; all
/// materials pooled. Sections on which both are empty have none.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Agreement {
    /// The mean over the sections; `None` when all are empty.
    pub mean: Option<f64>,
    /// The smallest; `None` when all are empty.
    pub min: Option<f64>,
    /// In the order of the sections.
    pub sections: Vec<SectionCheck>,
}

/// One section's agreement with the mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SectionCheck {
    /// The section's name.
    pub section: String,
    /// Of all materials together.
    pub dice: Option<f64>,
    /// How much of its plane in the lattice's box is unknown, from 0 to 1.
    pub unknown: f64,
    /// For each material by number.
    pub labels: BTreeMap<u32, Option<f64>>,
}

/// One label's surface.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LabelCheck {
    /// The label.
    pub label: u32,
    /// What its surface is like. Where caps are left out, volume, pieces and
    /// genus are those with caps, and `outward` says that it was closed with
    /// them.
    #[serde(flatten)]
    pub facts: Facts,
    /// Edges with one triangle alone, where caps are left out.
    pub open_edges: usize,
    /// Whether all of them lie on the box.
    pub open_at_box: bool,
    /// Area times spacing, where the sections are a stack.
    pub cavalieri: Option<Cavalieri>,
    /// Where regions begin and end between neighbouring sections of a stack, or
    /// are torn.
    pub passages: Vec<Passage>,
    /// Whether it hangs together as the sections show it; `None` where it is in one piece.
    pub pieces: Option<Pieces>,
    /// Pieces that no section passes through.
    pub afloat: Afloat,
    /// Whether the surface ripples in step with the sections.
    pub ripple: Option<Ripple>,
    /// What of the contours the surface does not reach.
    pub unreached: Unreached,
}

impl Check {
    /// Whether every surface faces outward and is closed, or closed but for the
    /// box where caps are left out.
    pub fn is_sound(&self) -> bool {
        self.labels.iter().all(LabelCheck::is_sound)
    }

    /// What is wrong with which of a mesh's surfaces, and where, if something is.
    pub fn fault(&self, mesh: &Mesh) -> Option<String> {
        let label = self.labels.iter().find(|label| !label.is_sound())?;
        let name = format!("the surface of label {}", label.label);
        let gap = mesh.surface(Label(label.label)).first_gap();
        Some(match gap {
            Some(at) => format!("{name} is not closed at {at}"),
            None if label.facts.outward => format!("{name} is open away from the box"),
            None => format!("a piece of {name} faces inward"),
        })
    }
}

/// Checks a mesh made from samples, with its caps, against the sections these
/// were made from.
pub fn check(
    sections: &[Section],
    mesh: &Mesh,
    samples: &Samples,
    options: Options,
    progress: &dyn Progress,
) -> Result<Check> {
    let lattice = &samples.lattice;
    let labels = labels(sections, mesh);
    progress.begin("check", (sections.len() + labels.len()) as u64 + 3);
    let dice = agreement(sections, mesh, lattice, progress);
    progress.go_on()?;
    let contours = contour::contours(sections, mesh, lattice.voxel)?;
    progress.go_on()?;
    progress.advance(1);
    let tolerance = CAP_TOLERANCE * lattice.voxel;
    let opened = options.open.map(|bounds| mesh.without_caps(bounds, tolerance));
    let used = opened.as_ref().unwrap_or(mesh);
    let support = support(used, sections, lattice.voxel);
    progress.advance(1);
    progress.go_on()?;
    let stack = Stack::new(sections);
    let passages = passages_of(sections, stack.as_ref(), samples, &labels);
    let ripples = ripples(used, sections, &labels, lattice.voxel);
    progress.advance(1);
    let mut labels: Vec<LabelCheck> = labels
        .par_iter()
        .zip(passages)
        .zip(ripples)
        .map(|((&label, passages), ripple)| {
            progress.go_on()?;
            let surface = mesh.surface(label);
            let facts = surface.facts(options.self_intersections)?;
            progress.advance(1);
            let stack = stack.as_ref();
            let cavalieri = |stack| Cavalieri::new(stack, sections, label, facts.volume);
            let closed = LabelCheck {
                label: label.0,
                cavalieri: stack.and_then(cavalieri),
                facts,
                open_edges: 0,
                open_at_box: true,
                passages,
                pieces: None,
                afloat: Afloat::new(&surface, sections),
                ripple,
                unreached: contours.unreached.get(&label).copied().unwrap_or_default(),
            };
            let Some(bounds) = options.open else { return Ok(closed) };
            Ok(closed.without_caps(&used.surface(label), bounds, tolerance))
        })
        .collect::<Result<_>>()?;
    let in_pieces = labels.iter().filter(|own| own.facts.components > own.facts.cavities + 1);
    let in_pieces: Vec<Label> = in_pieces.map(|own| Label(own.label)).collect();
    let scene = Scene {
        sections,
        mesh,
        origin: lattice.origin,
        voxel: lattice.voxel,
        stack: stack.as_ref(),
    };
    let mut pieces = scene.pieces(&in_pieces, |section| pixel(section, lattice));
    labels.iter_mut().for_each(|own| own.pieces = pieces.remove(&Label(own.label)));
    let box_volume = lattice.dims.iter().map(|&nodes| f64::from(nodes - 1) * lattice.voxel);
    let box_volume = box_volume.product();
    let materials: f64 = labels.iter().map(|label| label.facts.volume).sum();
    Ok(Check {
        voxel: lattice.voxel,
        dice,
        contours,
        stack: stack.as_ref().map(StackCheck::new),
        labels,
        support,
        outside_volume: box_volume - materials,
        box_volume,
    })
}

impl StackCheck {
    fn new(stack: &Stack) -> Self {
        let spacings = stack.spacings();
        Self {
            direction: stack.direction.to_array(),
            least_spacing: spacings.iter().copied().fold(f64::INFINITY, f64::min),
            largest_spacing: spacings.iter().copied().fold(0.0, f64::max),
        }
    }
}

/// What becomes of each label's regions between the sections of a stack, in
/// the solid that samples show.
fn passages_of(
    sections: &[Section],
    stack: Option<&Stack>,
    samples: &Samples,
    labels: &[Label],
) -> Vec<Vec<Passage>> {
    let Some(stack) = stack else { return vec![Vec::new(); labels.len()] };
    let Lattice { origin, voxel, .. } = samples.lattice;
    let rasters: Vec<Raster> = sections
        .par_iter()
        .map(|section| Raster::new(section, stack.direction, origin, voxel))
        .collect();
    let parts = Components::between(&LabelGrid::new(samples), stack);
    passages(stack, sections, &parts, &rasters, labels)
}

impl LabelCheck {
    /// Whether its surface is closed, as tables say it.
    pub fn closed_in_words(&self) -> &'static str {
        let facts = &self.facts;
        match self.open_edges {
            _ if facts.triangles == 0 => "nothing",
            0 if facts.closed && facts.outward => "yes",
            1.. if self.open_at_box && facts.outward => "but for the box",
            _ => "NO",
        }
    }

    fn is_sound(&self) -> bool {
        self.facts.outward && (self.facts.closed || self.open_edges > 0) && self.open_at_box
    }

    /// The same for the surface without its caps.
    fn without_caps(mut self, surface: &Surface, bounds: Bounds, tolerance: f64) -> Self {
        let edges = surface.open_edges();
        let on_box = |edge: &[u32; 2]| {
            let ends = edge.map(|vertex| surface.vertices[vertex as usize]);
            bounds.on_one_face(&ends, tolerance)
        };
        self.open_edges = edges.len();
        self.open_at_box = edges.iter().all(on_box);
        self.facts.closed &= edges.is_empty();
        self.facts.area = surface.area();
        self.facts.triangles = surface.triangles.len();
        self
    }
}

/// The box from the lattice's first node to its last.
fn space_of(lattice: &Lattice) -> Bounds {
    let last = lattice.dims.map(|nodes| nodes - 1);
    Bounds { min: lattice.origin, max: lattice.position(last) }
}

fn labels(sections: &[Section], mesh: &Mesh) -> Vec<Label> {
    let mut labels = mesh.labels();
    labels.extend(sections.iter().flat_map(Section::labels).filter(|label| label.is_material()));
    labels.sort();
    labels.dedup();
    labels
}

/// Half a voxel, or less where what is drawn on a section would have too few pixels to tell how well
/// it is met; but the box does not get too many.
fn pixel(section: &Section, lattice: &Lattice) -> f64 {
    let longest = |bounds: Bounds| bounds.size().max_element();
    let fine = section.bounds().map_or(f64::INFINITY, longest) / PIXELS;
    (0.5 * lattice.voxel).min(fine.max(longest(space_of(lattice)) / MOST_PIXELS))
}

fn agreement(
    sections: &[Section],
    mesh: &Mesh,
    lattice: &Lattice,
    progress: &dyn Progress,
) -> Agreement {
    let space = space_of(lattice);
    let sections: Vec<SectionCheck> = sections
        .par_iter()
        .map(|section| {
            let counts = overlap::overlap(section, mesh, pixel(section, lattice));
            progress.advance(1);
            SectionCheck {
                section: section.name().to_owned(),
                dice: Counts::pooled(counts.values()).dice(),
                unknown: unknown::unknown_share(section, space),
                labels: counts.iter().map(|(label, counts)| (label.0, counts.dice())).collect(),
            }
        })
        .collect();
    Agreement::new(sections)
}

impl Agreement {
    /// Of sections that were compared.
    pub(crate) fn new(sections: Vec<SectionCheck>) -> Self {
        let all: Vec<f64> = sections.iter().filter_map(|section| section.dice).collect();
        let mean = (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64);
        Self { mean, min: all.iter().copied().reduce(f64::min), sections }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::*;
    use crate::mesh::dual;
    use crate::mesh::shapes::{cylinder, open_samples, samples};
    use crate::plane::Plane;
    use crate::progress::Silent;

    /// A ball of radius 0.5 (label 1) inside a shell up to 0.8 (label 2).
    fn nested() -> (Mesh, Samples) {
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.04, dims: [51; 3] };
        let samples = samples(lattice, |node| {
            let radius = lattice.position(node).length();
            let share = |to: f64| ((to - radius) / 0.12).clamp(-1.0, 1.0) as f32;
            // The shares of the ball and of the union, as indicators.
            let (ball, both) = (share(0.5), share(0.8));
            vec![ball, both - ball - 1.0]
        });
        (dual(&samples, &Silent).unwrap(), samples)
    }

    #[test]
    fn a_ball_in_a_shell() {
        let (mesh, samples) = nested();
        let plane = Plane { normal: DVec3::Y, offset: 0.3 };
        let section = shapes::disc(plane, 0.4, 200, Label(1));
        let check = check(&[section], &mesh, &samples, Options::default(), &Silent).unwrap();
        assert!(check.is_sound());
        let [ball, shell] = &check.labels[..] else { panic!("{:?}", check.labels) };
        let sphere = |radius: f64| 4.0 / 3.0 * PI * radius.powi(3);
        assert!((ball.facts.volume / sphere(0.5) - 1.0).abs() < 1e-2);
        assert!((shell.facts.volume / (sphere(0.8) - sphere(0.5)) - 1.0).abs() < 1e-2);
        assert_eq!((shell.facts.components, shell.facts.cavities), (2, 1));
        assert!((check.box_volume - 8.0).abs() < 1e-12);
        let sum = check.outside_volume + ball.facts.volume + shell.facts.volume;
        assert!((sum - 8.0).abs() < 1e-12);
        // The section knows only the ball: its disc of area π 0.4² agrees;
        // the shell on that plane, π (0.55 − 0.16), is not on the section.
        let labels = &check.dice.sections[0].labels;
        assert!(labels[&1].unwrap() > 0.99);
        assert_eq!(labels[&2], Some(0.0));
        let pooled = 2.0 * 0.16 / (0.16 + 0.16 + 0.39);
        assert!((check.dice.mean.unwrap() - pooled).abs() < 0.01, "{:?}", check.dice.mean);
        assert!(check.contours.largest < 0.1);
    }

    #[test]
    fn a_cylinder_without_caps_is_sound_where_it_leaves_the_box_only() {
        let bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
        let (radius, voxel) = (0.6, 0.04);
        let samples = open_samples(bounds, 50, cylinder(radius, voxel));
        let mesh = dual(&samples, &Silent).unwrap();
        let plane = Plane { normal: DVec3::Z, offset: 0.3 };
        let sections = [shapes::disc(plane, radius, 200, Label(1))];
        let check = |mesh: &Mesh, open| {
            let options = Options { open, ..Options::default() };
            super::check(&sections, mesh, &samples, options, &Silent).unwrap()
        };
        let lateral = 2.0 * PI * radius * 2.0;
        let disc = PI * radius * radius;
        for (open, area) in [(None, lateral + 2.0 * disc), (Some(bounds), lateral)] {
            let check = check(&mesh, open);
            let LabelCheck { facts, open_edges, open_at_box, .. } = &check.labels[0];
            assert!(check.is_sound() && facts.outward && *open_at_box);
            assert_eq!((facts.closed, *open_edges > 0), (open.is_none(), open.is_some()));
            assert!((facts.volume / (2.0 * disc) - 1.0).abs() < 2e-3);
            assert!((facts.area / area - 1.0).abs() < 2e-3);
            assert!(check.dice.min > Some(0.99));
        }
        // In a box that is said to be larger, the same ends are holes.
        let larger = bounds.grown(0.1);
        assert!(check(&mesh, Some(larger)).is_sound(), "there are no caps in that box");
        let holed = mesh.without_caps(bounds, 0.0);
        assert!(!check(&holed, Some(larger)).is_sound());
        assert!(!check(&holed, None).is_sound());
    }
}
