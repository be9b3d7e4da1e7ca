//! Delaunay refinement of labelled samples, for any number of labels.
mod curves;
mod oracle;
mod seeds;

use glam::DVec3;

use super::{Mesh, back_and_front};
use crate::error::{Error, Result};
use crate::ffi::delaunay::{self as ffi, Criteria, Facets, Features};
use crate::grid::samples::Samples;
use crate::label::Label;
use crate::progress::Progress;
use oracle::Oracle;

/// What the triangles must be like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// The smallest angle, in degrees, save at junction curves; above 30,
    /// refinement need not come to an end by itself.
    pub angle: f64,
    /// The largest radius of a ball around a triangle that is centred on the
    /// surface, in voxels.
    pub size: f64,
    /// How far a triangle may be from the surface, in voxels.
    pub distance: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self { angle: 30.0, size: 2.0, distance: 0.2 }
    }
}

/// x
pub fn delaunay(samples: &Samples, options: &Options, progress: &dyn Progress) -> Result<Mesh> {
    let e = |n: &str, d: f64| std::env::var(n).ok().and_then(|v| v.parse().ok()).unwrap_or(d);
    let t = std::time::Instant::now();
    let mut dual = super::dual(samples, progress)?;
    if dual.triangles.is_empty() {
        return Ok(dual);
    }
    eprintln!("dual {:?}", t.elapsed());
    progress.begin("refinement", 0);
    let oracle = Oracle::new(samples, &dual)?;
    eprintln!("oracle {:?}", t.elapsed());
    let lattice = samples.lattice;
    dual.vertices.iter_mut().for_each(|point| *point = (*point - lattice.origin) / lattice.voxel);
    let seeds = seeds::seeds(&dual, &oracle, e("SEED", 1.0) * options.size);
    let curves = curves::curves(&dual);
    eprintln!("{} seeds {} curves {} curve points {:?}", seeds.len(), curves.len(), curves.iter().map(Vec::len).sum::<usize>(), t.elapsed());
    let seed_points = super::nearest::flat(&seeds.iter().map(|s| s.point).collect::<Vec<_>>());
    let seed_sides: Vec<u32> = seeds.iter().flat_map(|s| s.sides.map(|l| l.0)).collect();
    let curve_points = super::nearest::flat(&curves.concat());
    let mut end = 0;
    let curve_ends: Vec<u32> = curves.iter().map(|c| { end += c.len() as u32; end }).collect();
    let label_at = |p: [f64; 3]| oracle.label_at(p).0;
    let d = lattice.dims.map(|n| f64::from(n - 1));
    let criteria = Criteria { angle: options.angle, size: options.size, distance: options.distance, edge: e("EDGE", 1.0) * options.size, smallest: e("SMALL", 0.1), error: 1e-3, most_vertices: 10_000_000 };
    let facets = ffi::refine(&ffi::Oracle(&label_at), &[0.0, 0.0, 0.0, d[0], d[1], d[2]],
        &Features { seeds: &seed_points, seed_sides: &seed_sides, curve_points: &curve_points, curve_ends: &curve_ends }, &criteria)
        .map_err(|x| Error::library("mesh", &x))?;
    eprintln!("refined {:?} rings {}", t.elapsed(), facets.rings.len());
    let mut mesh = Mesh::default();
    mesh.vertices = facets.points.chunks_exact(3).map(|p| lattice.origin + lattice.voxel * DVec3::from_slice(p)).collect();
    for (t, s) in facets.triangles.chunks_exact(3).zip(facets.sides.chunks_exact(2)) {
        let own = [Label(s[0]), Label(s[1])];
        let sides = back_and_front(own[0], own[1]);
        mesh.sides.push(sides);
        mesh.triangles.push(if sides == own { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] });
    }
    Ok(mesh)
}
