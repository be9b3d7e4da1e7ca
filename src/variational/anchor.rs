//! A surface that a field is drawn to: its nodes near it to the signed distance
//! from it, as far as differences longer than a given length are concerned.
//!
//! With g the signed distance, the energy gets the term λ Σ (f − g)² over the nodes
//! less than [`HALF_WIDTH`] voxels from the surface. Beside Σ‖Hess f‖² it lets waves
//! of g through that are long against ℓ = λ^(−¼) and stops shorter ones: of one with
//! the wave number k, 1 / (1 + (k ℓ)⁴) is left. So λ = (voxel / ℓ)⁴ is the same
//! filter on every lattice.

use std::borrow::Cow;
use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::grid::distance::{HALF_WIDTH, band_around, inside};
use crate::grid::invariant::node_of;
use crate::grid::leaf_grid::LeafGrid;
use crate::grid::samples::LEAF_NODES;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::mesh::caps::CAP_TOLERANCE;
use crate::mesh::nearest::Nearest;
use crate::plane::Bounds;

use super::level::Level;
use super::system::Anchors;

/// Voxels that fit into ℓ at least, for a level to change anything.
const VOXELS_OF_LENGTH: f64 = 2.0;
/// A triangle with less than this for its area has none, in square voxels.
const NOTHING: f64 = 1e-9;

/// What is smoothed, for all labels.
#[derive(Debug, Clone, Copy)]
pub struct Original<'a> {
    /// The network of surfaces.
    pub mesh: &'a Mesh,
    /// The box, when it is open: the caps on its faces draw nothing.
    pub open: Option<Bounds>,
    /// ℓ, in world units.
    pub length: f64,
    /// The smallest voxels, on which there is always a solution.
    pub finest: f64,
}

impl Original<'_> {
    /// Whether a level is fine enough to be solved for: on others the surface is
    /// as it was.
    pub fn is_solved(&self, voxel: f64) -> bool {
        voxel == self.finest || VOXELS_OF_LENGTH * voxel <= self.length
    }
}

/// The surface that one label's field is drawn to.
#[derive(Debug)]
pub struct Anchor<'a> {
    vertices: &'a [DVec3],
    /// Around the label; for *outside* around all materials.
    solid: Vec<[u32; 3]>,
    /// Those that distances are measured from.
    sheets: Vec<[u32; 3]>,
    /// What a distance inside of the solid is multiplied with.
    sign: f32,
    length: f64,
    /// The voxels that it was made on.
    finest: f64,
}

/// A surface with as many vertices as a level needs.
struct Coarse<'a> {
    vertices: Cow<'a, [DVec3]>,
    solid: Cow<'a, [[u32; 3]]>,
    sheets: Cow<'a, [[u32; 3]]>,
}

impl Coarse<'_> {
    /// Whether there is more than edges and points, for rounding.
    fn has_area(&self, voxel: f64) -> bool {
        self.sheets.iter().any(|corners| {
            let [a, b, c] = corners.map(|corner| self.vertices[corner as usize]);
            (b - a).cross(c - a).length() > NOTHING * voxel * voxel
        })
    }
}

impl<'a> Anchor<'a> {
    /// Of a label; `None` where it has no surface.
    pub fn new(original: &Original<'a>, label: Label, voxel: f64) -> Option<Self> {
        let Original { mesh, open, length, .. } = *original;
        let is_outside = label == Label::OUTSIDE;
        let solid = mesh
            .triangles_around(|side| if is_outside { side.is_material() } else { side == label });
        let is_cap = |triangle: &[u32; 3]| {
            let corners = triangle.map(|vertex| mesh.vertices[vertex as usize]);
            let face = |bounds: Bounds| bounds.common_face(&corners, CAP_TOLERANCE * voxel);
            open.and_then(face).is_some()
        };
        let sheets: Vec<[u32; 3]> =
            solid.par_iter().copied().filter(|triangle| !is_cap(triangle)).collect();
        let sign = if is_outside { -1.0 } else { 1.0 };
        (!sheets.is_empty()).then_some(Self {
            vertices: &mesh.vertices,
            solid,
            sheets,
            sign,
            length,
            finest: voxel,
        })
    }

    /// As a level sees it: vertices in one cell as large as a voxel are one, in their
    /// middle. Triangles that lose their area so are left out, which keeps the surface
    /// closed: what an edge loses on one side it loses on the other. Where all of them would,
    /// in bodies smaller than a voxel, the surface is as it is.
    fn at(&self, voxel: f64) -> Coarse<'_> {
        let coarse = (voxel > self.finest).then(|| self.merged(voxel));
        coarse.filter(|coarse| coarse.has_area(voxel)).unwrap_or_else(|| {
            let [solid, sheets] = [&self.solid, &self.sheets].map(Cow::from);
            Coarse { vertices: Cow::from(self.vertices), solid, sheets }
        })
    }

    fn merged(&self, voxel: f64) -> Coarse<'_> {
        let mut merged: HashMap<[i64; 3], u32> = HashMap::new();
        let mut middles: Vec<(DVec3, f64)> = Vec::new();
        const NONE: u32 = u32::MAX;
        let mut own = vec![NONE; self.vertices.len()];
        for &at in self.solid.as_flattened() {
            if own[at as usize] != NONE {
                continue;
            }
            let vertex = self.vertices[at as usize];
            let cell = (vertex / voxel).floor().to_array().map(|along| along as i64);
            let merged = *merged.entry(cell).or_insert(middles.len() as u32);
            match middles.get_mut(merged as usize) {
                Some((sum, count)) => (*sum, *count) = (*sum + vertex, *count + 1.0),
                None => middles.push((vertex, 1.0)),
            }
            own[at as usize] = merged;
        }
        let coarse = |triangles: &[[u32; 3]]| {
            let moved = triangles.iter().map(|triangle| triangle.map(|at| own[at as usize]));
            moved.filter(|[a, b, c]| a != b && b != c && c != a).collect()
        };
        let vertices = middles.into_iter().map(|(sum, count)| sum / count).collect();
        let [solid, sheets] = [&self.solid, &self.sheets].map(|own| coarse(own));
        Coarse { vertices, solid, sheets }
    }

    /// The signed distances on the nodes of a level near the surface, in voxels,
    /// positive where the label is, cut off at [`HALF_WIDTH`].
    pub fn band(&self, level: &Level) -> LeafGrid {
        let Coarse { vertices, solid, sheets } = self.at(level.lattice.voxel);
        let mut band = band_around(&level.lattice, &vertices, &solid, &sheets);
        band.values_mut().iter_mut().for_each(|value| *value *= -self.sign);
        band
    }

    /// The same on all nodes, and not cut off. What is beyond an open box has the
    /// values of the nearest nodes that are not.
    ///
    /// # Errors
    /// When the surface has no area.
    pub fn everywhere(&self, level: &Level, is_open: bool) -> Result<LeafGrid> {
        let lattice = &level.lattice;
        let Coarse { vertices, solid, sheets } = self.at(lattice.voxel);
        let mut grid = LeafGrid::new(level.domain.low, level.domain.high);
        grid.add(grid.all_places());
        let solid = inside(lattice, &vertices, &solid, grid.leaves());
        for (value, is_inside) in grid.values_mut().iter_mut().zip(solid) {
            *value = if is_inside { self.sign } else { -self.sign };
        }
        let places: Vec<[i32; 3]> = (grid.leaves().iter())
            .flat_map(|&leaf| (0..LEAF_NODES).map(move |node| node_of(leaf, node)))
            .map(|node| if is_open { lattice.nearest_inner(node) } else { node })
            .collect();
        let points: Vec<DVec3> = places.par_iter().map(|&node| lattice.position(node)).collect();
        let nearest = Nearest::new(&vertices, sheets.as_flattened())?;
        let distances = nearest.distances(&points)?;
        let signed: Vec<f32> = (places.into_par_iter().zip(distances))
            .map(|(node, distance)| {
                grid.value(node).unwrap_or(0.0) * (distance / lattice.voxel) as f32
            })
            .collect();
        grid.values_mut().copy_from_slice(&signed);
        Ok(grid)
    }

    /// What draws the nodes of leaves of a level, by the signed distances there.
    pub fn anchors(
        &self,
        level: &Level,
        distances: &LeafGrid,
        leaves: &[[i32; 3]],
        is_open: bool,
    ) -> Anchors {
        let weight = (level.lattice.voxel / self.length).powi(4) as f32;
        let of_node = |index: usize| {
            let node = node_of(leaves[index / LEAF_NODES], index % LEAF_NODES);
            let is_known = !is_open || level.lattice.is_inner(node);
            let near = |distance: &f32| is_known && f64::from(distance.abs()) < HALF_WIDTH;
            distances.value(node).filter(near).map_or((0.0, 0.0), |distance| (weight, distance))
        };
        let (weights, targets) =
            (0..leaves.len() * LEAF_NODES).into_par_iter().map(of_node).unzip();
        Anchors { weights, targets }
    }
}
