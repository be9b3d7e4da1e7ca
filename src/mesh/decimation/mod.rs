//! Decimation: fewer triangles for the same surface, by collapsing edges, those first that
//! change it least (Garland and Heckbert 1997).
//!
//! Curves where surfaces meet are made simpler in the whole network, so that all surfaces at a
//! curve keep its vertices (`curves`). What lies between them is a manifold, in which CGAL
//! collapses edges (`sheets`). This alternates, from fine to coarse.
//!
//! What holds: for every label the boundary stays closed and outward, with as many pieces and
//! handles. No more triangles cross each other than did before. With a limit of distance no point
//! of the surface as it was is farther than that from the result, for certain, and the result is
//! looked at as densely as there were triangles. Where any of this fails less is collapsed in
//! another try; after the last one everything stays as it was.

mod curves;
mod deviation;
mod reduced;
mod sheets;

use serde::Serialize;

use super::Mesh;
use super::facts::crossings;
use super::nearest::Nearest;
use super::network::Network;
use crate::error::{Error, Result};
use crate::progress::Progress;

use deviation::beyond;
use reduced::Reduced;
use sheets::STEP;

/// How far a surface is made simpler.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Decimation {
    /// Until this share of its triangles is left, above 0 and up to 1.
    Share(f64),
    /// As far as no point of it is farther from the result than this, in world units, nor the
    /// result from it.
    Distance(f64),
}

/// A simpler surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Decimated {
    /// The network.
    pub mesh: Mesh,
    /// What became of it.
    pub outcome: Outcome,
}

/// What decimation did.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Outcome {
    /// Triangles that there were.
    pub before: usize,
    /// Triangles that were asked for, if a share was.
    pub wanted: Option<usize>,
    /// Triangles that there are.
    pub triangles: usize,
    /// The largest distance from a vertex that there was to the surface that there is, in world
    /// units.
    pub moved: f64,
}

/// Of what was wanted, this much more is worth no word.
const SHORT: f64 = 1.01;
/// The share of triangles that remains when curves and what is between them were made simpler
/// once.
const LEVEL: f64 = 0.25;
/// When more than this remains nothing more is to be had.
const STUCK: f64 = 0.98;
/// The sum of a vertex's steps may be so long, against the limit of distance: what is between
/// vertices is farther.
const WITHIN: f64 = 0.8;
/// Where something is wrong the sum may be so long, against what it was.
const STRICTER: f64 = 0.25;
/// Tries.
const TRIES: usize = 10;
/// In so many of the last ones limits are lower everywhere, too.
const LAST: usize = 5;
/// By this factor.
const LOWER: f64 = 0.5;

/// A network with fewer triangles. The edges that are given by their vertices become no surface
/// between others: they are simplified as curves are where surfaces meet.
///
/// The same for any number of threads.
///
/// # Errors
/// When the share or the distance is none, when an edge has a vertex that the mesh has not, when
/// cancelled, or when CGAL fails.
pub fn decimate(
    mesh: &Mesh,
    kept: &[[u32; 2]],
    decimation: Decimation,
    progress: &dyn Progress,
) -> Result<Decimated> {
    decimation.require()?;
    let task = Task::new(mesh, kept, decimation)?;
    let mut limits = vec![task.limit; mesh.vertices.len()];
    for left in (0..TRIES).rev() {
        progress.begin("decimation", (task.count().saturating_sub(task.wanted) / 2 / STEP) as u64);
        let made = task.reduced(&limits, progress)?;
        let wrong = task.wrong(&made)?;
        if wrong.is_empty() {
            return task.outcome(Network::from(made.mesh).into_mesh());
        }
        if left <= LAST {
            limits.iter_mut().for_each(|limit| *limit *= LOWER);
        }
        made.limit(&mut limits, &wrong, STRICTER);
    }
    task.outcome(mesh.clone())
}

impl Outcome {
    /// What is to be said where more triangles are left than were wanted.
    pub fn shortfall(&self) -> Option<String> {
        let Self { before, wanted, triangles, .. } = *self;
        let wanted = wanted.filter(|&wanted| triangles as f64 > SHORT * wanted as f64)?;
        Some(format!(
            "of {before} triangles {triangles} are left, not {wanted}: with fewer, parts would \
             hang together in another way, surfaces would cross or triangles turn over"
        ))
    }
}

impl Decimation {
    fn require(self) -> Result<()> {
        let what = match self {
            Self::Share(share) if !(share > 0.0 && share <= 1.0) => {
                format!("{share} of all triangles cannot remain: give a share above 0 and up to 1")
            }
            Self::Distance(distance) if !(distance.is_finite() && distance > 0.0) => {
                format!("a surface cannot move by {distance}: give a positive distance")
            }
            _ => return Ok(()),
        };
        Err(Error::Option(what))
    }
}

/// What is to be made simpler.
struct Task<'a> {
    mesh: &'a Mesh,
    kept: &'a [[u32; 2]],
    decimation: Decimation,
    /// Triangles.
    wanted: usize,
    /// How far vertices may be from what they were made of.
    limit: f64,
    /// Pairs of triangles that cross each other.
    crossings: usize,
    /// Whether all surfaces are closed and have their inside behind them.
    is_sound: bool,
    /// The surface as it was, where distances from it count.
    nearest: Option<Nearest>,
}

impl<'a> Task<'a> {
    fn new(mesh: &'a Mesh, kept: &'a [[u32; 2]], decimation: Decimation) -> Result<Self> {
        let crossings = crossings(&mesh.vertices, &mesh.triangles, &[])?.len();
        let is_sound = mesh.faces_outward()?;
        let has_area = !mesh.triangles.is_empty();
        let (wanted, limit, nearest) = match decimation {
            Decimation::Share(share) => {
                ((share * mesh.triangles.len() as f64).ceil() as usize, f64::INFINITY, None)
            }
            Decimation::Distance(distance) => {
                (0, WITHIN * distance, has_area.then(|| Nearest::on_mesh(mesh)).transpose()?)
            }
        };
        Ok(Self { mesh, kept, decimation, wanted, limit, crossings, is_sound, nearest })
    }

    fn count(&self) -> usize {
        self.mesh.triangles.len()
    }

    /// As few triangles as are wanted, or can be had within the limits of vertices.
    fn reduced(&self, limits: &[f64], progress: &dyn Progress) -> Result<Reduced> {
        let mut made = Reduced::new(self.mesh, self.kept, limits);
        loop {
            progress.go_on()?;
            let was = made.mesh.triangles.len();
            if was <= self.wanted {
                break;
            }
            let wanted = self.wanted.max((LEVEL * was as f64).ceil() as usize);
            // A curve has as many edges as the root of what surfaces have triangles.
            made.reduce_curves((wanted as f64 / was as f64).sqrt())?;
            made.reduce_sheets(wanted, progress)?;
            let is = made.mesh.triangles.len();
            if !made.torn.is_empty() || is as f64 > STUCK * was as f64 {
                break;
            }
        }
        made.untie();
        Ok(made)
    }

    /// The vertices around which something is not as it must be.
    fn wrong(&self, made: &Reduced) -> Result<Vec<u32>> {
        if !made.torn.is_empty() {
            return Ok(made.torn.clone());
        }
        let mesh = &made.mesh;
        let corners = |mesh: &Mesh, triangles: Vec<u32>| {
            triangles.into_iter().flat_map(|own| mesh.triangles[own as usize]).collect::<Vec<_>>()
        };
        let mut wrong: Vec<u32> = Vec::new();
        let found = crossings(&mesh.vertices, &mesh.triangles, &[])?;
        if found.len() > self.crossings {
            wrong.extend(corners(mesh, found.into_flattened()));
        }
        if self.is_sound {
            wrong.extend(corners(mesh, turned_inside_out(mesh)?));
        }
        if let (Decimation::Distance(distance), Some(nearest)) = (self.decimation, &self.nearest) {
            let dense = self.mean_edge();
            wrong.extend(corners(mesh, beyond(mesh, (self.mesh, nearest), distance, dense)?));
            let own = Nearest::on_mesh(mesh)?;
            let left_behind = beyond(self.mesh, (mesh, &own), distance, 0.0)?;
            let left_behind = corners(self.mesh, left_behind);
            wrong.extend(left_behind.into_iter().map(|vertex| made.places[vertex as usize]));
        }
        Ok(wrong)
    }

    /// How long edges would be if all triangles were equilateral, of the same size.
    fn mean_edge(&self) -> f64 {
        let area = |triangle| {
            let [a, b, c] = self.mesh.corners(triangle);
            (b - a).cross(c - a).length() / 2.0
        };
        let area: f64 = (0..self.count()).map(area).sum();
        (area / self.count() as f64 * 4.0 / 3f64.sqrt()).sqrt()
    }

    fn outcome(&self, mesh: Mesh) -> Result<Decimated> {
        let mut outcome = Outcome {
            before: self.count(),
            wanted: matches!(self.decimation, Decimation::Share(_)).then_some(self.wanted),
            triangles: mesh.triangles.len(),
            moved: 0.0,
        };
        if !mesh.triangles.is_empty() && mesh != *self.mesh {
            let distances = Nearest::on_mesh(&mesh)?.distances(&self.mesh.vertices)?;
            outcome.moved = distances.into_iter().fold(0.0, f64::max);
        }
        Ok(Decimated { mesh, outcome })
    }
}

/// The triangles of labels whose surface is open or has its inside in front of it.
fn turned_inside_out(mesh: &Mesh) -> Result<Vec<u32>> {
    let mut found = Vec::new();
    for label in mesh.labels() {
        if !mesh.surface(label).facts(false)?.outward {
            let sides = mesh.sides.iter().enumerate();
            let own = sides.filter(|(_, sides)| sides.contains(&label));
            found.extend(own.map(|(triangle, _)| triangle as u32));
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests;
