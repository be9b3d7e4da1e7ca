//! Remeshing patch by patch: borders of patches stay as they are, so that remeshed patches
//! fit.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;
use rayon::prelude::*;

use super::guard::Sides;
use crate::error::{Error, Result};
use crate::ffi::fairing::{self, Patch};
use crate::mesh::Mesh;
use crate::mesh::network::{Ends, Kind, Network};
use crate::mesh::pieces::{Piece, border};

/// Rounds of splitting, collapsing, flipping and projecting back.
const ROUNDS: u32 = 3;
/// This part of the way to vertices beside it goes what divides a chord.
const OFF_CHORD: f64 = 0.25;

impl Network {
    /// Makes the edges within patches about as long as `length`, but for those that are to
    /// stay and those that would come to cross another.
    ///
    /// # Errors
    /// When CGAL fails.
    pub fn remesh(&mut self, length: f64, stay: &BTreeSet<u32>, planes: &[Sides]) -> Result<()> {
        self.divide_borders(length, stay);
        let pieces = self.pieces_of_patches();
        let mut remeshed: Vec<Option<Patch>> = pieces
            .par_iter()
            .map(|piece| match stay.contains(&piece.patch) {
                true => Ok(None),
                false => self.remeshed(piece, length),
            })
            .collect::<Result<_>>()?;
        let (vertices, pinned) = (self.mesh.vertices.clone(), self.pinned.clone());
        loop {
            self.mesh.vertices.clone_from(&vertices);
            self.pinned.clone_from(&pinned);
            self.assemble(&pieces, &remeshed, planes);
            let crossing = self.patches_of(&self.crossings()?);
            let mut is_same = true;
            for (piece, patch) in pieces.iter().zip(&mut remeshed) {
                if crossing.contains(&piece.patch) && patch.take().is_some() {
                    is_same = false;
                }
            }
            if is_same {
                return Ok(());
            }
        }
    }

    /// The network of patches, each remeshed or as it was.
    fn assemble(&mut self, pieces: &[Piece], remeshed: &[Option<Patch>], planes: &[Sides]) {
        self.mesh.triangles.clear();
        self.mesh.sides.clear();
        self.patches.clear();
        for (piece, patch) in pieces.iter().zip(remeshed) {
            match patch {
                Some(patch) => self.put(piece, patch, planes),
                None => self.put_back(piece),
            }
            self.patches.resize(self.mesh.triangles.len(), piece.patch);
        }
    }

    /// Divides edges that are borders of patches and longer than a remesher
    /// leaves them, but for those between patches that stay.
    fn divide_borders(&mut self, length: f64, stay: &BTreeSet<u32>) {
        // A little less than CGAL lets pass, whatever rounding makes of the parts.
        let longest = 4.0 / 3.0 * length * (1.0 - 1e-9);
        let mut parts = BTreeMap::new();
        for sides in self.edges().iter().filter(|sides| self.kind(sides) != Kind::Surface) {
            let edge = self.length(sides[0].0);
            let stays = sides.iter().all(|side| stay.contains(&self.patches[side.1 as usize]));
            if edge > longest && !stays {
                parts.insert(sides[0].0, (edge / longest).ceil() as u32);
            }
        }
        self.divide(&parts);
    }

    /// How often to divide edges that are no borders but lead from one vertex
    /// with a name to another: two patches could have one between the same two.
    /// One that leads from a vertex to itself, where a surface touches itself,
    /// has to become three.
    fn chords(&self, names: &[Option<u32>]) -> BTreeMap<Ends, u32> {
        let mut parts = BTreeMap::new();
        for sides in self.edges().iter().filter(|sides| self.kind(sides) == Kind::Surface) {
            let ends = sides[0].0;
            if let [Some(one), Some(other)] = ends.map(|end| names[end as usize]) {
                parts.insert(ends, if one == other { 3 } else { 2 });
            }
        }
        parts
    }

    /// Moves what divides chords a little to vertices beside it that lie on no border. A
    /// triangle with all corners on one contour, which lies in its plane, is bent out of it:
    /// the section says something else there.
    fn leave_chords(&mut self, names: &[Option<u32>]) {
        let is_new = |vertex: u32| vertex as usize >= names.len();
        let is_inner = |vertex: u32| matches!(names.get(vertex as usize), Some(None));
        let mut beside: BTreeMap<u32, Vec<DVec3>> = BTreeMap::new();
        for triangle in &self.mesh.triangles {
            for &vertex in triangle.iter().filter(|&&vertex| is_new(vertex)) {
                let inner = triangle.iter().filter(|&&other| is_inner(other));
                let places = inner.map(|&other| self.mesh.vertices[other as usize]);
                beside.entry(vertex).or_default().extend(places);
            }
        }
        for (vertex, places) in beside.into_iter().filter(|(_, places)| !places.is_empty()) {
            let middle = places.iter().sum::<DVec3>() / places.len() as f64;
            let place = &mut self.mesh.vertices[vertex as usize];
            *place = place.lerp(middle, OFF_CHORD);
        }
    }

    /// A patch remeshed; nothing when it is to stay as it is, because it is one
    /// triangle or none that CGAL can take, or its border came back otherwise.
    fn remeshed(&self, piece: &Piece, length: f64) -> Result<Option<Patch>> {
        if piece.triangles.len() < 2 {
            return Ok(None);
        }
        let places = piece.vertices.iter().map(|&vertex| self.mesh.vertices[vertex as usize]);
        let points: Vec<f64> = places.flat_map(|place| place.to_array()).collect();
        let pinned: Vec<u8> =
            piece.vertices.iter().map(|&vertex| self.pinned[vertex as usize].into()).collect();
        let patch =
            fairing::remesh(&points, piece.triangles.as_flattened(), &pinned, length, ROUNDS);
        let patch = patch.map_err(|exception| Error::library("fairing", &exception))?;
        let came_back = border(&patch.triangles, |vertex| patch.origins[vertex as usize]);
        let stays = came_back == border(piece.triangles.as_flattened(), |vertex| vertex);
        Ok(stays.then_some(patch))
    }

    fn put_back(&mut self, piece: &Piece) {
        for triangle in &piece.triangles {
            self.mesh.triangles.push(triangle.map(|vertex| piece.vertices[vertex as usize]));
            self.mesh.sides.push(piece.sides);
        }
    }

    /// What stays keeps its vertex of the network, all else is new.
    fn put(&mut self, piece: &Piece, patch: &Patch, planes: &[Sides]) {
        let mut names: Vec<Option<u32>> = vec![None; piece.vertices.len()];
        for vertex in border(piece.triangles.as_flattened(), |vertex| vertex).into_flattened() {
            names[vertex as usize] = Some(piece.vertices[vertex as usize]);
        }
        for (name, &vertex) in names.iter_mut().zip(&piece.vertices) {
            *name = name.or(self.pinned[vertex as usize].then_some(vertex));
        }
        let name = |&origin: &u32| names.get(origin as usize).copied().flatten();
        let names: Vec<Option<u32>> = patch.origins.iter().map(name).collect();
        let mut part = Self::from(Mesh {
            vertices: patch.points.chunks_exact(3).map(DVec3::from_slice).collect(),
            triangles: patch.triangles.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
            sides: vec![piece.sides; patch.triangles.len() / 3],
        });
        let on = |at: usize| match names[at] {
            Some(_) => planes_at(part.mesh.vertices[at], planes),
            None => Vec::new(),
        };
        let on: Vec<Vec<usize>> = (0..names.len()).map(on).collect();
        part.turn_flat(&on);
        part.divide(&part.chords(&names));
        part.leave_chords(&names);
        let numbers: Vec<u32> = (0..part.mesh.vertices.len())
            .map(|at| match names.get(at).copied().flatten() {
                Some(vertex) => vertex,
                None => self.add(part.mesh.vertices[at], false),
            })
            .collect();
        let renamed = |triangle: [u32; 3]| triangle.map(|vertex| numbers[vertex as usize]);
        self.mesh.triangles.extend(part.mesh.triangles.into_iter().map(renamed));
        self.mesh.sides.extend(part.mesh.sides);
    }
}

/// The planes that a point is on.
fn planes_at(point: DVec3, planes: &[Sides]) -> Vec<usize> {
    (0..planes.len()).filter(|&plane| planes[plane].of(point) == 0.0).collect()
}
