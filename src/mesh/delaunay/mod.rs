//! Delaunay refinement of labelled samples, for any number of labels
//! (Boissonnat & Oudot; Rineau & Yvinec), by CGAL's Mesh_3.
//!
//! The samples say which label is where (`oracle`). Every tetrahedron of a
//! Delaunay triangulation has the label of its circumcentre, and the interface
//! is made of the facets between tetrahedra of different labels. A facet that
//! is too large, too far from the surface or has too small an angle is refined
//! by a point where its dual edge crosses the surface. Refinement starts from
//! points on every piece of the dual mesh (`seeds`), so that none is missed;
//! the curves where three labels meet are there from the start (`curves`),
//! as chains of edges inside balls that nothing else may enter.
//!
//! # Why every label's surface is closed, oriented and edge-manifold
//!
//! The tetrahedra, with everything around them outside, fill space without
//! overlap. Fix a label l: its boundary consists of the facets with l on one
//! side only. Around an edge l and not-l alternate, so it has an even number
//! of them, and as many that lead into l as lead out of it. More than two are
//! there only where l comes up more than once around the edge; what refinement
//! leaves of such edges is split (`pinches`). Nothing crosses anything,
//! since no two tetrahedra do.
//!
//! # Why it comes to an end
//!
//! A facet smaller than a hundredth of a voxel is never refined, so that no
//! point is ever nearer than that to another one; and there is a limit to the
//! number of points.
//!
//! In an open box, the rims of the caps and the edges of the box between two
//! caps are curves like those where labels meet, and vertices of caps are put
//! onto the box's faces.
//!
//! Refinement runs on one thread: CGAL's parallel variant gives another mesh
//! on every run.

mod curves;
mod oracle;
mod pinches;
mod saddles;
mod seeds;

use std::collections::HashSet;

use glam::DVec3;
use rayon::prelude::*;

use super::caps::CAP_TOLERANCE;
use super::nearest::{Nearest, flat};
use super::{Mesh, back_and_front};
use crate::error::{Error, Remedy, Result};
use crate::ffi::delaunay::{self as ffi, Criteria, Curves, Facets, Refinement};
use crate::grid::samples::{Lattice, Samples};
use crate::label::Label;
use crate::progress::Progress;
use oracle::Oracle;
use seeds::Seed;

/// The longest edge along a curve, in facet sizes.
const CURVE_EDGE: f64 = 1.0;
/// Facets smaller than this are not refined, in voxels.
const SMALLEST: f64 = 0.01;
/// How exactly points are on the surface, in voxels.
const PRECISION: f64 = 1e-4;
/// How far the dual mesh's vertices may be from the result, in voxels, before
/// more seeds are set.
const FAR: f64 = 0.75;
/// How often refinement is begun at most.
const ROUNDS: usize = 4;
/// How many times the vertices that are expected there may be.
const PATIENCE: f64 = 20.0;

/// What the triangles must be like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The smallest angle, in degrees, save at junction curves. Up to 30;
    /// beyond, refinement would not come to an end by itself.
    pub angle: f64,
    /// The largest radius of a ball through a triangle's corners that is
    /// centred on the surface, in voxels.
    pub size: f64,
    /// The largest distance of that centre from the triangle's, in voxels.
    pub distance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { angle: 30.0, size: 2.0, distance: 0.1 }
    }
}

/// The network of interfaces between the labels of the samples, in world
/// units. The same for any number of threads.
///
/// # Errors
/// [`Error::Option`] when the options ask for more triangles than there can
/// be.
pub fn delaunay(samples: &Samples, options: &Options, progress: &dyn Progress) -> Result<Mesh> {
    let mut dual = super::dual(samples, progress)?;
    if dual.triangles.is_empty() {
        return Ok(dual);
    }
    progress.begin("refinement", 0);
    let oracle = match samples.open {
        None => Oracle::new(samples, &dual),
        Some(open) => Oracle::new(samples, &dual.without_caps(open, 0.0)),
    };
    let mut curves = curves::curves(&dual, samples.open);
    let Lattice { origin, voxel, dims } = samples.lattice;
    let points = dual.vertices.iter_mut().chain(curves.iter_mut().flatten());
    points.for_each(|point| *point = (*point - origin) / voxel);
    let mut mesh = complete(&dual, &oracle, &curves, dims, options, progress)?;
    mesh.vertices.par_iter_mut().for_each(|point| {
        *point = origin + voxel * *point;
        if let Some(open) = samples.open {
            *point = open.snapped(*point, CAP_TOLERANCE * voxel);
        }
    });
    Ok(mesh)
}

/// Refines until no vertex of the dual mesh is far and no edge is pinched:
/// there, something thin needs more seeds. Everything in lattice units.
fn complete(
    dual: &Mesh,
    oracle: &Oracle,
    curves: &[Vec<DVec3>],
    dims: [i32; 3],
    options: &Options,
    progress: &dyn Progress,
) -> Result<Mesh> {
    let label_at = |point: [f64; 3]| oracle.label_at(point).0;
    let asked = ffi::Oracle(&label_at);
    let mut refinement = begun(&asked, curves, dims, &criteria(dual, options)?)?;
    let mut seeds = seeds::seeds(dual, oracle, options.size, options.distance);
    // More vertices bring a surface nearer and nothing away from it, so only
    // those that were far are looked at again.
    let mut far: Vec<usize> = (0..dual.vertices.len()).collect();
    let mut given = HashSet::new();
    let mut round = 1;
    loop {
        progress.go_on()?;
        let facets = refined(&mut refinement, &seeds)?;
        let mut mesh = network(&facets);
        given.extend(seeds.iter().map(Seed::key));
        far = far_vertices(dual, &mesh, far)?;
        seeds = seeds::near(dual, oracle, &far);
        seeds.extend(pinches::seeds(&mesh, &facets.rings, oracle));
        // A seed that was given before is there, or in the ball of a vertex on
        // a curve, where it may not be.
        seeds.retain(|seed| !given.contains(&seed.key()));
        if round == ROUNDS || seeds.is_empty() {
            pinches::split(&mut mesh, &facets.rings);
            return Ok(mesh);
        }
        round += 1;
    }
}

/// Those of some vertices of the dual mesh that are further than [`FAR`] from
/// a mesh.
fn far_vertices(dual: &Mesh, mesh: &Mesh, vertices: Vec<usize>) -> Result<Vec<usize>> {
    if mesh.triangles.is_empty() {
        return Ok(vertices);
    }
    let points: Vec<DVec3> = vertices.iter().map(|&vertex| dual.vertices[vertex]).collect();
    let distances = Nearest::on_mesh(mesh)?.distances(&points)?;
    let far = vertices.into_iter().zip(distances).filter(|&(_, distance)| distance > FAR);
    Ok(far.map(|(vertex, _)| vertex).collect())
}

/// With the curves, before any seed.
fn begun<'a>(
    oracle: &'a ffi::Oracle<'a>,
    curves: &[Vec<DVec3>],
    dims: [i32; 3],
    criteria: &Criteria,
) -> Result<Refinement<'a>> {
    let ends = curves.iter().scan(0, |end, curve| {
        *end += curve.len() as u32;
        Some(*end)
    });
    let (points, ends): (_, Vec<u32>) = (flat(&curves.concat()), ends.collect());
    let [x, y, z] = dims.map(|nodes| f64::from(nodes - 1));
    let curves = Curves { points: &points, ends: &ends };
    Refinement::new(oracle, &[0.0, 0.0, 0.0, x, y, z], &curves, criteria).map_err(refused)
}

/// After more seeds.
fn refined(refinement: &mut Refinement, seeds: &[Seed]) -> Result<Facets> {
    let points: Vec<DVec3> = seeds.iter().map(|seed| seed.point).collect();
    let sides: Vec<u32> = seeds.iter().flat_map(|seed| seed.sides.map(|side| side.0)).collect();
    refinement.refine(&flat(&points), &sides).map_err(refused)
}

fn refused(exception: cxx::Exception) -> Error {
    Error::library("delaunay mesher", &exception)
}

/// # Errors
/// When more vertices are to be expected than can be numbered.
fn criteria(dual: &Mesh, options: &Options) -> Result<Criteria> {
    let area: f64 = (0..dual.triangles.len())
        .map(|triangle| dual.corners(triangle))
        .map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0)
        .sum();
    // Each vertex has two triangles of at most this radius; half of that is
    // usual. The voxels' own detail asks for some at any size.
    let spacing = options.size.min(2.0 * options.distance.sqrt()).min(1.0);
    let most = PATIENCE * (1000.0 + area / (spacing * spacing));
    if most > f64::from(u32::MAX) {
        let what = format!(
            "triangles of {} voxels that are nowhere further than {} from the surface would be \
             too many",
            options.size, options.distance
        );
        return Err(Error::Option(what).avoidable(Remedy::LargerTriangles));
    }
    Ok(Criteria {
        angle: options.angle,
        size: options.size,
        distance: options.distance,
        edge: CURVE_EDGE * options.size,
        smallest: SMALLEST,
        error: PRECISION,
        most_vertices: most as usize,
    })
}

/// The facets, each with its front at the right side.
fn network(facets: &Facets) -> Mesh {
    let vertices = facets.points.chunks_exact(3).map(DVec3::from_slice).collect();
    let (triangles, sides) = (facets.triangles.as_chunks::<3>().0.iter())
        .zip(facets.sides.as_chunks::<2>().0)
        .map(|(&[a, b, c], &[back, front])| {
            let own = [Label(back), Label(front)];
            let sides = back_and_front(own[0], own[1]);
            (if sides == own { [a, b, c] } else { [a, c, b] }, sides)
        })
        .unzip();
    Mesh { vertices, triangles, sides }
}

#[cfg(test)]
mod tests;
