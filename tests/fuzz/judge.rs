//! What a reconstruction of a set is held against.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::Path;

use glam::DVec3;
use transect::change::Change;
use transect::check::{self, Agreement, Check, check};
use transect::context::Context;
use transect::error::Error;
use transect::grid::lattice::Resolution;
use transect::io::read_sections;
use transect::label::Label;
use transect::mesh::Mesh;
use transect::mesh::delaunay;
use transect::method::{Fairing, Hermite, MeanValue, Mesher, Method, Skeleton, Variational};
use transect::model::{Derived, Model, Options};
use transect::oracle::Oracle;
use transect::progress::Silent;
use transect::section::ends::stopped;
use transect::section::{Overlap, Rules, Section, Sections};

use super::random::Random;

/// On the longest side.
const VOXELS: u32 = 32;
/// Random points that are asked.
const POINTS: usize = 150;
/// Nearer to the surface than this, relative to the size, rounding decides.
const NEAR: f64 = 1e-9;
/// Nearer than this are places that two sections have on their common line and that were
/// made one: the oracle does not know of it.
const SNAPPED: f64 = 2e-3;
/// A Dice below this is to be explained.
const POOR: f64 = 0.9;
/// Section Dice may fall by so much when a surface is made fair.
const FAIR_DICE: f64 = 0.02;

/// What is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    Exact,
    Fair,
    /// Fair with edges as long as voxels, of which twenty times as many sets are judged.
    Coarse,
    Delaunay,
    Variational,
    MeanValue,
    Hermite,
}

impl Way {
    pub const ALL: [Self; 7] = [
        Self::Exact,
        Self::Fair,
        Self::Coarse,
        Self::Delaunay,
        Self::Variational,
        Self::MeanValue,
        Self::Hermite,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::Exact => "skeleton",
            Self::Fair => "fair",
            Self::Coarse => "coarse",
            Self::Delaunay => "delaunay",
            Self::Variational => "variational",
            Self::MeanValue => "mvc",
            Self::Hermite => "hermite",
        }
    }

    fn method(self, sections: &Sections) -> Method {
        let fair = |edge_length: Option<f64>| {
            let fairing = Some(Fairing { edge_length });
            Method::Skeleton(Skeleton { fairing, ..Skeleton::default() })
        };
        match self {
            Self::Exact => Method::Skeleton(Skeleton::default()),
            Self::Fair => fair(None),
            Self::Coarse => {
                let size = sections.space_of_cells().map(|bounds| bounds.size().max_element());
                fair(size.map(|size| size / f64::from(VOXELS)))
            }
            Self::Delaunay => {
                let mesher = Mesher::Delaunay(delaunay::Options::default());
                Method::Variational(Variational { mesher, ..Variational::default() })
            }
            Self::Variational => Method::Variational(Variational::default()),
            Self::MeanValue => Method::MeanValue(MeanValue::default()),
            Self::Hermite => Method::Hermite(Hermite::default()),
        }
    }
}

/// What is done with a set, or with a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    Reconstruct(Way),
    Read,
}

impl Task {
    pub fn name(self) -> &'static str {
        match self {
            Self::Reconstruct(way) => way.name(),
            Self::Read => "read",
        }
    }

    /// All there are.
    pub fn all() -> impl Iterator<Item = Self> {
        Way::ALL.into_iter().map(Self::Reconstruct).chain([Self::Read])
    }
}

/// How a set went.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// All is well.
    Good,
    /// The input was refused, in these words.
    Refused(String),
    /// It should not have ended so.
    Bad(String),
}

struct Made {
    model: Model,
    checked: Check,
}

impl Made {
    fn derived(&self) -> Result<&Derived, String> {
        self.model.derived().ok_or_else(|| "nothing was derived".to_owned())
    }
}

/// Reconstructs a file one way and judges it.
pub fn judge(file: &Path, way: Way, seed: u64) -> Verdict {
    let rules = Rules { overlap: Some(Overlap::Last), ..Rules::default() };
    let sections = match read_sections(file, &rules) {
        Ok(sections) => sections,
        Err(error) => return refused(&error),
    };
    let made = match reconstruct(sections.clone(), way) {
        Ok(made) => made,
        Err(error) => return refused(&error),
    };
    let found = match way {
        Way::Exact => exact(&made, seed),
        Way::Fair | Way::Coarse => match reconstruct(sections, Way::Exact) {
            Ok(before) => fair(&made, &before),
            Err(error) => return refused(&error),
        },
        Way::Delaunay => sound(&made),
        Way::Variational | Way::MeanValue | Way::Hermite => honest(&made),
    };
    found.map_or_else(Verdict::Bad, |()| Verdict::Good)
}

/// Words about the input are good, words about the program are not.
pub fn refused(error: &Error) -> Verdict {
    match error {
        Error::Bug { .. } | Error::Library { .. } => Verdict::Bad(error.to_string()),
        _ => Verdict::Refused(error.to_string()),
    }
}

fn reconstruct(sections: Sections, way: Way) -> Result<Made, Error> {
    let mut model = Model::new(Options {
        method: way.method(&sections),
        resolution: Resolution::Voxels(VOXELS),
        ..Options::default()
    });
    model.apply(Change::Add(sections), &mut Context::default())?;
    let Some(Derived { mesh, samples, .. }) = model.derived() else {
        return Err(Error::Bug { stage: "model", what: "nothing was derived".to_owned() });
    };
    let options = check::Options { self_intersections: true, open: None };
    let checked = check(&model.sections().sections, mesh, samples, options, &Silent)?;
    Ok(Made { model, checked })
}

/// Closed and outward by the program's own measure and by counting edges.
fn sound(made: &Made) -> Result<(), String> {
    let mesh = &made.derived()?.mesh;
    if let Some(fault) = made.checked.fault(mesh) {
        return Err(fault);
    }
    for label in mesh.labels() {
        let surface = mesh.surface(label);
        let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
        for [a, b, c] in &surface.triangles {
            for edge in [[*a, *b], [*b, *c], [*c, *a]] {
                *edges.entry(edge).or_default() += 1;
            }
        }
        let is_whole = |(&[from, to], &count): (&[u32; 2], &u32)| {
            count == 1 && edges.get(&[to, from]) == Some(&1)
        };
        if !edges.iter().all(is_whole) {
            return Err(format!("an edge of label {} has not one triangle each way", label.0));
        }
    }
    Ok(())
}

/// Sound, and where it does not show a section a warning says so.
fn honest(made: &Made) -> Result<(), String> {
    sound(made)?;
    let Agreement { min, sections, .. } = &made.checked.dice;
    let warnings = made.checked.warnings(&made.model.sections().materials);
    match min {
        Some(least) if !(0.0..=1.0).contains(least) => Err(format!("a Dice of {least}")),
        Some(least) if *least < POOR && warnings.is_empty() => {
            let section = sections.iter().find(|own| own.dice == Some(*least));
            Err(format!("a Dice of {least} without a word: {section:?}"))
        }
        _ => Ok(()),
    }
}

/// The exact surface against the oracle, which knows no surface.
fn exact(made: &Made, seed: u64) -> Result<(), String> {
    sound(made)?;
    let derived = made.derived()?;
    let Some(details) = &derived.exact else { return Err("there are no details".to_owned()) };
    let sections = made.model.sections();
    if !details.left_out.is_empty() {
        return Err(format!("cells {:?} are left out", details.left_out));
    }
    // Where parts are unknown distances are those of a gauge, up to a sixth off.
    if sections.sections.iter().any(Section::is_partial) {
        return Ok(());
    }
    let Some(bounds) = sections.space_of_cells() else {
        return Err("there is no box".to_owned());
    };
    let stopped = stopped(&sections.sections, bounds).map_err(|error| error.to_string())?;
    let oracle =
        Oracle::new(&stopped, bounds, Label::OUTSIDE).map_err(|error| error.to_string())?;
    let near = if details.snapped > 0 { SNAPPED } else { NEAR };
    let mut random = Random::new(seed ^ 0xfeed);
    for number in 0..POINTS {
        let unit = DVec3::from_array(std::array::from_fn(|_| random.unit()));
        let mut point = bounds.min + unit * bounds.size();
        // Half of them near a contour's vertex.
        if number % 2 == 1 {
            let section = &sections.sections[random.below(sections.sections.len())];
            if !section.vertices().is_empty() {
                let vertex = random.below(section.vertices().len()) as u32;
                let share = 10f64.powf(random.between(-7.0..0.0));
                point = section.point(vertex).lerp(point, share);
            }
        }
        let Some(found) = label_at(&derived.mesh, point, near * bounds.diagonal()) else {
            continue;
        };
        let expected = oracle.nearest(point).label;
        if found != expected {
            return Err(format!(
                "at {point} it is {found}, and the nearest section says {expected}"
            ));
        }
    }
    Ok(())
}

/// The label that the mesh shows at a point, by the solid angles of its triangles; `None`
/// for a point that is as near to it as rounding, or where the angles say nothing.
fn label_at(mesh: &Mesh, point: DVec3, near: f64) -> Option<Label> {
    let mut angles: HashMap<Label, f64> = HashMap::new();
    for (triangle, sides) in mesh.sides.iter().enumerate() {
        let corners = mesh.corners(triangle);
        if distance(point, corners) < near {
            return None;
        }
        let angle = solid_angle(corners.map(|corner| corner - point));
        *angles.entry(sides[0]).or_default() += angle;
        *angles.entry(sides[1]).or_default() -= angle;
    }
    let mut label = Label::OUTSIDE;
    for (own, angle) in angles {
        let turns = angle / (2.0 * TAU);
        if own == Label::OUTSIDE {
            continue;
        }
        if (turns - turns.round()).abs() > 0.01 {
            return None;
        }
        if turns.round() == 1.0 {
            label = own;
        }
    }
    Some(label)
}

/// Of a triangle as seen from the origin (van Oosterom and Strackee 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [x, y, z] = [a, b, c].map(DVec3::length);
    let above = a.dot(b.cross(c));
    let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * above.atan2(below)
}

/// From a point to a triangle.
fn distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let within = [[a, b], [b, c], [c, a]]
        .into_iter()
        .all(|[from, to]| normal.cross(to - from).dot(point - from) >= 0.0);
    if within && normal != DVec3::ZERO {
        return normal.normalize().dot(point - a).abs();
    }
    let to_segment = |[from, to]: [DVec3; 2]| {
        let along = to - from;
        let length = along.length_squared();
        let at =
            if length > 0.0 { ((point - from).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        point.distance(from + at * along)
    };
    [[a, b], [b, c], [c, a]].map(to_segment).into_iter().fold(f64::INFINITY, f64::min)
}

/// Whether the vertices of a section are on another's plane but for rounding.
fn is_nearly(section: &Section, other: &Section) -> bool {
    let far = |at: DVec3| other.plane().distance(at).abs() > NEAR * (1.0 + at.length());
    !std::ptr::eq(section, other)
        && !(0..section.vertices().len() as u32).any(|vertex| far(section.point(vertex)))
}

/// A fair surface against the one that it was made from.
fn fair(made: &Made, before: &Made) -> Result<(), String> {
    sound(made)?;
    let crossings = |made: &Made| -> u64 {
        made.checked.labels.iter().filter_map(|label| label.facts.self_intersections).sum()
    };
    if crossings(made) > crossings(before) {
        return Err(format!(
            "fair triangles cross each other {} times, and those before {} times",
            crossings(made),
            crossings(before)
        ));
    }
    let sections = &made.model.sections().sections;
    let pairs = made.checked.dice.sections.iter().zip(&before.checked.dice.sections);
    for ((own, old), section) in pairs.zip(sections) {
        // What lies between planes that rounding can hardly tell apart is cut by both; and
        // a surface that passes a plane where it is unknown may move along it.
        if section.is_partial() || sections.iter().any(|other| is_nearly(section, other)) {
            continue;
        }
        if let (Some(dice), Some(was)) = (own.dice, old.dice)
            && dice < was - FAIR_DICE
        {
            return Err(format!("section {} had a Dice of {was:.3}, fair {dice:.3}", own.section));
        }
    }
    Ok(())
}
