//! Dual contouring of labelled samples, for any number of labels.
//!
//! The interface is made of one polygon around every lattice edge whose nodes
//! have different labels. The polygon's corners are points in the four lattice
//! cells around the edge; a cell has one point for every connected *piece* of
//! the interface in it (`cell::Pieces`), and polygons of one piece share it.
//! What is connected is decided face by face, from the face's own four nodes
//! (`cell::Links`), so that the two cells at a face agree.
//!
//! # Why every label's surface is closed, oriented and edge-manifold
//!
//! Fix a label l. A lattice face has 0, 2 or 4 edges with l at exactly one
//! end, for l and not-l alternate around it. The links put them into pairs:
//!
//! - two: all four cases of `cell::Links` join these two, since a face that
//!   does not join all its edges cuts off two opposite corners, each with its
//!   two edges, and l is then either the label of one such corner (which has
//!   exactly these edges) or has four edges;
//! - four: the face is a checkerboard of l and other labels, and both pairs of
//!   its links consist of neighbouring edges.
//!
//! Each pair stands for one *mesh edge*: that between the points of the two
//! cells at the face, where both polygons of the pair have their corners. Two
//! neighbouring edges of one pair lead around the face once into l and once
//! out of it, so the two polygons, with l behind both, pass the mesh edge in
//! opposite directions. Every side of every polygon lies across exactly one
//! face, and so in exactly one pair. It remains that different pairs have
//! different mesh edges. Those of different faces have: two cells share only
//! one face. Those of one face differ unless the points in both cells are the
//! same for both pairs; such a *pinched* face gets a point of its own for each
//! pair, which makes two different chains of two mesh edges each. Last, the
//! edges inside polygons: the diagonal of a quadrilateral joins two cells
//! that share only this one lattice edge, and the spokes of a larger polygon
//! end at a point that no other polygon has. Each has two triangles of one
//! polygon, which pass it in opposite directions.
//!
//! Nodes on the border of the lattice are outside, so that every edge between
//! different labels has all its four cells.
//!
//! # Caps
//!
//! In an open box ([`Samples::open`]) materials reach up to the nodes on the
//! lattice's border, and polygons around edges to such a node are *caps*.
//! Their corners are points in cells that the box's face passes through; these
//! are put onto it, and so caps lie in the box's faces. Faces between two such
//! cells have two neighbouring corners beyond the box, thus no checkerboard and
//! no pinch: a cap is a quadrilateral. The cells around an edge between inner
//! nodes are of two layers along both other axes, and along its own axis no
//! face passes through them: no triangle of its polygon lies in one face of the
//! box, so [`Mesh::is_cap`] tells caps by their place. [`Mesh::without_caps`]
//! has edges with one triangle where a cap met another polygon: both corners of
//! such an edge are the cap's, so it lies on the box.
//!
//! A vertex may still be shared by
//! two sheets of one label; [`Mesh::surface`] gives each its own.

pub(super) mod block;
mod border;
pub(super) mod cell;
pub(super) mod patch;
mod polygon;
mod relax;
mod triangles;

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::Mesh;
use crate::error::{Error, Result};
use crate::grid::samples::Samples;
use crate::progress::Progress;
use block::Block;
use border::BoxFaces;
use patch::Leaves;
use polygon::{Blocks, Pinched, Polygons};

/// The network of interfaces between the labels of the samples' nodes, in
/// world units. The same for any number of threads.
///
/// # Errors
/// [`Error::Option`] when the mesh would have more points than fit into 32
/// bits.
pub fn dual(samples: &Samples, progress: &dyn Progress) -> Result<Mesh> {
    Ok(dual_again(samples, None, progress)?.0)
}

/// What is in the leaves of samples, for others of which many leaves are the same.
#[derive(Clone, Default)]
pub struct KeptBlocks(Vec<Arc<Block>>);

impl KeptBlocks {
    /// Whether nothing was kept.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The same when the leaves have other names, `by` farther on.
    pub fn moved(&self, by: [i32; 3]) -> Self {
        Self(self.0.par_iter().map(|block| Arc::new(block.moved(by))).collect())
    }
}

impl std::fmt::Debug for KeptBlocks {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("KeptBlocks").field(&self.0.len()).finish()
    }
}

/// The same when there were other samples before, whose blocks were kept: those of leaves that
/// are as they were are taken over. Also returns the blocks of these samples.
///
/// # Errors
/// As [`dual`].
pub fn dual_again(
    samples: &Samples,
    before: Option<(&Samples, &KeptBlocks)>,
    progress: &dyn Progress,
) -> Result<(Mesh, KeptBlocks)> {
    let leaves = Leaves::new(samples);
    let blocks = blocks(&leaves, before, progress);
    let (mut points, polygons) = polygons(&leaves, &blocks)?;
    let lows: Vec<DVec3> = blocks.iter().flat_map(|block| block.lows_of_points()).collect();
    let faces = samples.open.map(|open| BoxFaces::new(open, &samples.lattice));
    let lattice = samples.lattice;
    if let Some(faces) = &faces {
        let inverse = |point| (point - lattice.origin) / lattice.voxel;
        faces.project(&mut points, &lows, inverse);
    }
    relax::relax(&mut points, &lows, &polygons, |low| {
        faces.as_ref().is_some_and(|faces| faces.touch(low))
    });
    let mut mesh = triangles::triangulate(points, &polygons);
    mesh.vertices.par_iter_mut().for_each(|point| *point = lattice.origin + lattice.voxel * *point);
    if let Some(faces) = &faces {
        faces.project(&mut mesh.vertices, &lows, |point| point);
    }
    Ok((mesh, KeptBlocks(blocks)))
}

fn blocks(
    leaves: &Leaves,
    before: Option<(&Samples, &KeptBlocks)>,
    progress: &dyn Progress,
) -> Vec<Arc<Block>> {
    progress.begin("mesh", leaves.count() as u64);
    let same = before.map(|(samples, _)| leaves.same_in(samples)).unwrap_or_default();
    let kept = before.map(|(_, kept)| &kept.0[..]).unwrap_or_default();
    (0..leaves.count())
        .into_par_iter()
        .filter_map(|place| {
            progress.advance(1);
            let at = leaves.at(place);
            if leaves.is_patch_same(at, &same) {
                let number = kept.binary_search_by_key(&at, |block| block.at).ok()?;
                return Some(Arc::clone(&kept[number]));
            }
            Block::new(leaves, at).map(Arc::new)
        })
        .collect()
}

/// All points in lattice units, the pieces' before the pinches', and the
/// polygons in the order of the lattice edges.
fn polygons(leaves: &Leaves, blocks: &[Arc<Block>]) -> Result<(Vec<DVec3>, Vec<Polygons>)> {
    let mut block_at = vec![u32::MAX; leaves.count()];
    for (index, block) in blocks.iter().enumerate() {
        if let Some(place) = leaves.place(block.at) {
            block_at[place] = index as u32;
        }
    }
    let mut points: Vec<DVec3> = blocks.iter().flat_map(|block| block.points.clone()).collect();
    let first_point = starts(0, blocks.iter().map(|block| block.points.len()))?;
    let mut all = Blocks {
        blocks,
        block_at: &block_at,
        dims: leaves.dims(),
        first_point,
        first_pinch: vec![],
    };
    let pinched: Vec<Pinched> =
        (0..blocks.len()).into_par_iter().map(|block| all.pinched(block)).collect();
    all.first_pinch = starts(points.len(), pinched.iter().map(|pinched| pinched.points.len()))?;
    points.extend(pinched.iter().flat_map(|pinched| &pinched.points));
    let polygons: Option<Vec<Polygons>> =
        (0..blocks.len()).into_par_iter().map(|block| all.polygons(block, &pinched)).collect();
    let polygons = polygons.ok_or_else(|| Error::Bug {
        stage: "mesh",
        what: "a lattice edge between two labels lacks a cell".into(),
    })?;
    // Each larger polygon adds a point.
    starts(points.len(), polygons.iter().map(|polygons| polygons.large.len()))?;
    Ok((points, polygons))
}

/// Where each of consecutive ranges starts, as point numbers.
fn starts(first: usize, lengths: impl Iterator<Item = usize>) -> Result<Vec<u32>> {
    let mut next = first;
    let starts: Vec<u32> = lengths
        .map(|length| {
            let start = next as u32;
            next += length;
            start
        })
        .collect();
    if u32::try_from(next).is_err() {
        return Err(Error::Option(format!(
            "the mesh would have {next} points, more than {} can be numbered: \
             choose a lower resolution",
            u32::MAX
        )));
    }
    Ok(starts)
}

#[cfg(test)]
mod tests;
