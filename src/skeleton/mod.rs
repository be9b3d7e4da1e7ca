//! The exact reconstruction: projections onto straight skeletons in rational
//! arithmetic (Barequet and Vaxman 2009).
//!
//! In a convex cell between full sections the label of a point is that of its
//! foot on the nearest wall. So surfaces are *roofs*, where two walls are equally
//! far and show different labels, and *walls* that stand on contours and reach to
//! the roofs over them. Every decision is exact; only the coordinates of the
//! result are rounded.
//!
//! What holds: the boundary of every label is closed, whatever the sections say.
//! Where they contradict each other, or where contours touch in projection, an
//! edge of it can have four triangles or a vertex two fans.

mod closed;
mod input;
mod kept;
mod merge;
mod splits;
mod tied;

use cxx::UniquePtr;
use glam::DVec3;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::ffi::skeleton::{self as ffi, CellOutput, ContradictionOutput};
use crate::label::Label;
use crate::memory;
use crate::mesh::Mesh;
use crate::plane::Bounds;
use crate::progress::Progress;
use crate::section::Section;

use kept::Cell;
use splits::Split;

pub use kept::Kept;

/// How far apart two sections' changes of label on their common line may be to
/// be taken for one, relative to the box's diagonal: what rounding in files
/// makes of one place.
const TOLERANCE: f64 = 1e-3;

/// Nearer vertices are one, relative to the box's diagonal, unless exact
/// coordinates are kept: rounding errors of neighbours are about that large.
const MERGED: f64 = 1e-12;

/// With more pieces between known and unknown a cell takes more than ten minutes.
const MOST_PIECES: u32 = 20_000;

/// Memory for each, at most (320,000 bytes were measured).
const PIECE_BYTES: u64 = 400_000;

/// How the exact reconstruction is done.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Whether exact coordinates are kept. Then vertices that rounding can hardly
    /// tell apart are not joined.
    pub exact: bool,
    /// Accuracy of distances to planes, relative, in bits: doubled until it
    /// suffices.
    pub bits: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self { exact: false, bits: 60 }
    }
}

/// What a triangle is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Where two sections are equally far.
    Roof,
    /// Between a contour and a roof.
    Wall,
}

/// Where a triangle comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Origin {
    /// What it is.
    pub kind: Kind,
    /// The two sections that a roof lies between, or twice that of a wall;
    /// `None` for the box.
    pub sections: [Option<u32>; 2],
    /// The cell it lies in.
    pub cell: u32,
}

/// A stretch of the common line of two sections on which both know and never
/// say the same: what is left, exactly, after places of both were made one. What was drawn
/// is measured by [`Disagreement`](crate::section::Disagreement).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contradiction {
    /// The sections' names.
    pub sections: [String; 2],
    /// Its ends, in world units.
    pub ends: [[f64; 3]; 2],
    /// Its length, in world units.
    pub length: f64,
    /// The labels of either section along it, from the first end on.
    pub labels: [Vec<String>; 2],
}

/// A cell in which more parts of partial sections are equally near, or nearly so, than can
/// be told apart exactly in reasonable time. There only the nearest few decide; the surface
/// is closed all the same, and fits what is around it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Inexact {
    /// The cell.
    pub cell: u32,
    /// How many parts of it this concerns.
    pub parts: u32,
    /// Their volume, in cubic world units.
    pub volume: f64,
    /// The middle of the largest part, in world units.
    pub at: [f64; 3],
}

/// An exact reconstruction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Skeleton {
    /// The surfaces, coordinates rounded.
    pub mesh: Mesh,
    /// What else there is to say.
    pub details: Details,
}

/// What an exact reconstruction says besides its surfaces.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Details {
    /// For every triangle where it comes from.
    #[serde(skip)]
    pub origins: Vec<Origin>,
    /// The contours on the mesh, by two vertices each.
    #[serde(skip)]
    pub contours: Vec<[u32; 2]>,
    /// For every vertex its exact coordinates, each "numerator/denominator", when
    /// asked for.
    #[serde(skip)]
    pub exact: Option<Vec<[String; 3]>>,
    /// Where sections contradict each other, the longest first.
    pub contradictions: Vec<Contradiction>,
    /// How many places on common lines, told apart by rounding alone, were made
    /// one.
    pub snapped: u32,
    /// How many vertices were joined to others that rounding can hardly tell from
    /// them.
    pub joined: u32,
    /// The cells between the full sections.
    pub cells: u32,
    /// Those of which parts are not exact.
    pub inexact: Vec<Inexact>,
    /// The part of the box's volume that is exact.
    pub exact_share: f64,
    /// Those with too many edges of what partial sections know, which have no surface: the
    /// mesh is not closed around them.
    pub left_out: Vec<u32>,
    /// The accuracy of distances that sufficed.
    pub bits: u32,
}

/// Reconstructs exactly what is in a box; its faces are outside.
///
/// # Errors
/// When two planes are too nearly parallel to be told apart in 4096 bits, or when surfaces do
/// not fit together, which is a bug.
pub fn skeleton(
    sections: &[Section],
    bounds: Bounds,
    options: &Options,
    progress: &dyn Progress,
) -> Result<Skeleton> {
    Kept::default().follow(sections, bounds, options, progress)
}

/// Cuts and reconciles sections, and makes the cells between them.
fn prepare(
    sections: &[Section],
    bounds: Bounds,
    options: &Options,
    progress: &dyn Progress,
) -> Result<UniquePtr<ffi::Skeleton>> {
    progress.begin("cells", 0);
    let tolerance = TOLERANCE * bounds.diagonal();
    let input = input::input(sections, bounds, tolerance, options.bits);
    ffi::prepare(&input).map_err(failed)
}

fn failed(exception: cxx::Exception) -> Error {
    Error::library("skeleton", &exception)
}

/// Joins the surfaces of all cells.
fn join(
    prepared: &ffi::Skeleton,
    cells: &[Option<Cell>],
    sections: &[Section],
    bounds: Bounds,
    options: &Options,
) -> Result<Skeleton> {
    let mut joined = Joined::new(prepared.points().map_err(failed)?, sections.len() as u32);
    if options.exact {
        joined.exact = Some(prepared.exact_points().map_err(failed)?);
    }
    for (number, cell) in cells.iter().enumerate() {
        if let Some(cell) = cell {
            joined.add(number as u32, cell);
        }
    }
    let contradictions = prepared.contradictions().map_err(failed)?;
    let mut made = joined.into_skeleton(prepared.contours());
    if made.details.left_out.is_empty() {
        closed::require_closed(&made)?;
    }
    if options.exact {
        untie(&mut made);
    } else {
        made = without_slivers(made, MERGED * bounds.diagonal())?;
    }
    let details = &mut made.details;
    details.contradictions = contradictions_of(sections, contradictions);
    details.snapped = prepared.snapped();
    details.cells = prepared.cells();
    details.bits = prepared.bits();
    let inexact: f64 = details.inexact.iter().map(|inexact| inexact.volume).sum();
    details.exact_share = 1.0 - inexact / bounds.size().element_product();
    Ok(made)
}

/// How many pieces between known and unknown a cell may have: so many as are done in
/// minutes, and as fit into memory when all threads have such a cell.
fn most_pieces(cells: u32) -> u32 {
    let at_once = u64::from(cells).min(rayon::current_num_threads() as u64).max(1);
    let fitting = memory::available() / (PIECE_BYTES * at_once);
    u32::try_from(fitting).unwrap_or(u32::MAX).min(MOST_PIECES)
}

/// Joins vertices that rounding can hardly tell apart, unless that turns a solid that is as
/// thin inside out, or leaves sheets of it that lie on each other.
fn without_slivers(made: Skeleton, distance: f64) -> Result<Skeleton> {
    let mut merged = made.clone();
    merged.details.joined = merge::merge(&mut merged, distance);
    if untie(&mut merged) && merged.mesh.faces_outward()? || merged.details.joined == 0 {
        return Ok(merged);
    }
    let mut made = made;
    untie(&mut made);
    Ok(made)
}

/// Parts what touches itself, in the final order of the vertices: how triangles on each
/// other are paired depends on it. Whether that came to an end.
fn untie(skeleton: &mut Skeleton) -> bool {
    compact(skeleton);
    tied::divide(skeleton)
}

/// The surfaces of all cells with the points they share.
struct Joined {
    points: Vec<f64>,
    exact: Option<Vec<String>>,
    corners: Vec<u32>,
    sides: Vec<[Label; 2]>,
    origins: Vec<Origin>,
    splits: Vec<Split>,
    inexact: Vec<Inexact>,
    left_out: Vec<u32>,
    sections: u32,
}

impl Joined {
    fn new(points: Vec<f64>, sections: u32) -> Self {
        let (corners, sides, origins, splits, inexact) = Default::default();
        let (exact, left_out) = Default::default();
        Self { points, exact, corners, sides, origins, splits, inexact, left_out, sections }
    }

    fn add(&mut self, number: u32, cell: &Cell) {
        let Cell { points, planes, surface, .. } = cell;
        let base = self.points.len() as u32 / 3;
        let own = points.len() as u32;
        let point = |point: u32| points.get(point as usize).copied().unwrap_or(base + point - own);
        self.corners.extend(surface.corners.iter().map(|&corner| point(corner)));
        let splits = surface.splits.as_chunks::<3>().0;
        self.splits.extend(splits.iter().map(|split| split.map(point)));
        if surface.is_left_out {
            self.left_out.push(number);
        }
        if let [x, y, z] = surface.inexact_at[..] {
            let CellOutput { inexact_parts: parts, inexact_volume: volume, .. } = **surface;
            self.inexact.push(Inexact { cell: number, parts, volume, at: [x, y, z] });
        }
        self.points.extend(&surface.points);
        if let Some(exact) = &mut self.exact {
            exact.extend_from_slice(&surface.exact);
        }
        let labels = surface.labels.as_chunks::<2>().0;
        self.sides.extend(labels.iter().map(|pair| pair.map(Label)));
        let section = |plane: u32| Some(planes[plane as usize]).filter(|&own| own < self.sections);
        let between = surface.planes.as_chunks::<2>().0;
        self.origins.extend(surface.walls.iter().zip(between).map(|(&wall, planes)| Origin {
            kind: if wall == 1 { Kind::Wall } else { Kind::Roof },
            sections: planes.map(section),
            cell: number,
        }));
    }

    fn into_skeleton(self, contours: Vec<u32>) -> Skeleton {
        let vertices = self.points.chunks_exact(3).map(DVec3::from_slice).collect();
        let corners = self.corners.chunks_exact(3);
        let triangles = corners.map(|corners| [corners[0], corners[1], corners[2]]).collect();
        let mesh = Mesh { vertices, triangles, sides: self.sides };
        let exact = self.exact.map(|all| {
            let (points, _) = all.as_chunks::<3>();
            points.to_vec()
        });
        let details = Details {
            origins: self.origins,
            contours: contours.as_chunks::<2>().0.to_vec(),
            exact,
            inexact: self.inexact,
            left_out: self.left_out,
            ..Details::default()
        };
        let mut skeleton = Skeleton { mesh, details };
        splits::fit(&mut skeleton, &self.splits);
        skeleton
    }
}

/// Leaves out the points and contours that no triangle uses; the others come in the order in
/// which triangles do.
fn compact(skeleton: &mut Skeleton) {
    let mut number = vec![u32::MAX; skeleton.mesh.vertices.len()];
    let mut order = Vec::new();
    for corner in skeleton.mesh.triangles.as_flattened_mut() {
        let number = &mut number[*corner as usize];
        if *number == u32::MAX {
            *number = order.len() as u32;
            order.push(*corner as usize);
        }
        *corner = *number;
    }
    let contours = &mut skeleton.details.contours;
    for end in contours.as_flattened_mut() {
        *end = number[*end as usize];
    }
    contours.retain(|ends| !ends.contains(&u32::MAX));
    skeleton.mesh.vertices = order.iter().map(|&at| skeleton.mesh.vertices[at]).collect();
    if let Some(exact) = &mut skeleton.details.exact {
        *exact = order.iter().map(|&at| std::mem::take(&mut exact[at])).collect();
    }
}

fn contradictions_of(sections: &[Section], found: Vec<ContradictionOutput>) -> Vec<Contradiction> {
    let labels = |labels: &[u32]| labels.iter().map(|&label| Label(label).to_string()).collect();
    let mut result: Vec<Contradiction> = found
        .into_iter()
        .map(|one| {
            let [from, to] = [0, 3].map(|at| DVec3::from_slice(&one.ends[at..]));
            Contradiction {
                sections: one.sections.map(|section| sections[section as usize].name().to_owned()),
                ends: [from.to_array(), to.to_array()],
                length: from.distance(to),
                labels: [labels(&one.first), labels(&one.second)],
            }
        })
        .collect();
    result.sort_by(|a, b| b.length.total_cmp(&a.length).then_with(|| a.sections.cmp(&b.sections)));
    result
}
