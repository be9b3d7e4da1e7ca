//! The surface by patches, one for every leaf of the grid that it passes through: whoever
//! draws a model that changes asks which of them changed, and draws these anew. (The patches
//! of fairing are others: what lies between curves that stay.)

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use super::Mesh;
use crate::grid::samples::{LEAF_SIDE, Lattice};

/// Where a vertex is no farther than this from where it was, in voxels, its patch has not
/// changed. Solving again moves what is far from a change by less.
const STILL: f64 = 0.01;

/// The leaf that a patch is in: it holds the centroids of the patch's triangles. Leaf
/// (i, j, k) of a lattice begins at its node (8 i, 8 j, 8 k).
pub type PatchName = [i32; 3];

/// All of a surface by patches.
#[derive(Debug, Clone, Default)]
pub struct Patches {
    lattice: Option<Lattice>,
    parts: BTreeMap<PatchName, Mesh>,
}

/// What became of patches.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct ChangedPatches {
    /// The corner of patch (0, 0, 0), in world units.
    pub origin: [f64; 3],
    /// The length of a patch's sides, in world units.
    pub side: f64,
    /// Those that are new, or other than they were; sorted.
    pub changed: Vec<PatchName>,
    /// Those that are no more; sorted.
    pub removed: Vec<PatchName>,
}

impl Patches {
    /// Of a surface, by the leaves of a lattice. Of two that have the same triangles in a
    /// leaf the patches are the same, whatever the rest of the surface is like.
    pub fn new(mesh: &Mesh, lattice: Lattice) -> Self {
        let name = |triangle: u32| -> PatchName {
            let centroid = mesh.corners(triangle as usize).iter().sum::<DVec3>() / 3.0;
            ((centroid - lattice.origin) / side(&lattice)).floor().as_ivec3().to_array()
        };
        let all = 0..mesh.triangles.len() as u32;
        let mut members: Vec<(PatchName, u32)> =
            all.into_par_iter().map(|triangle| (name(triangle), triangle)).collect();
        members.par_sort_unstable();
        let parts = members.chunk_by(|one, other| one.0 == other.0);
        let parts = parts.collect::<Vec<_>>().into_par_iter();
        let parts = parts.map(|members| (members[0].0, part(mesh, members)));
        let parts = parts.collect::<Vec<_>>().into_iter();
        Self { lattice: Some(lattice), parts: parts.collect() }
    }

    /// Patches by their names; the vertices of each are its own.
    pub fn iter(&self) -> impl Iterator<Item = (PatchName, &Mesh)> {
        self.parts.iter().map(|(&name, part)| (name, part))
    }

    /// One of them.
    pub fn get(&self, name: PatchName) -> Option<&Mesh> {
        self.parts.get(&name)
    }

    /// Becomes the patches of a surface as it is now, and says which are others than before.
    /// What moved by less than a hundredth of a voxel stays as it was told, so that small
    /// changes do not add up. Where a lattice has leaves in common with the one that it was
    /// first, they keep their names; on another all patches are others.
    pub fn follow(&mut self, mesh: &Mesh, lattice: Lattice) -> ChangedPatches {
        let first = self.lattice.filter(|first| first.leaves_to(&lattice).is_some());
        let lattice = first.unwrap_or(lattice);
        let mut next = Self::new(mesh, lattice);
        let is_on_it = first.is_some();
        let mut was = std::mem::take(&mut self.parts);
        let still = STILL * lattice.voxel;
        let mut changes = ChangedPatches {
            origin: lattice.origin.to_array(),
            side: side(&lattice),
            ..ChangedPatches::default()
        };
        changes.removed.extend(was.keys().filter(|name| !next.parts.contains_key(*name)));
        for (name, part) in &mut next.parts {
            match was.remove(name).filter(|was| is_on_it && is_still(was, part, still)) {
                Some(was) => *part = was,
                None => changes.changed.push(*name),
            }
        }
        *self = next;
        changes
    }

    /// Becomes those of no surface.
    pub fn clear(&mut self) -> ChangedPatches {
        let removed = std::mem::take(&mut self.parts).into_keys().collect();
        let of = |lattice: Lattice| (lattice.origin.to_array(), side(&lattice));
        let (origin, side) = self.lattice.map(of).unwrap_or_default();
        ChangedPatches { origin, side, changed: Vec::new(), removed }
    }
}

fn side(lattice: &Lattice) -> f64 {
    LEAF_SIDE as f64 * lattice.voxel
}

/// Some of a mesh's triangles, with vertices in the order in which these have them.
fn part(mesh: &Mesh, members: &[(PatchName, u32)]) -> Mesh {
    let mut numbers: HashMap<u32, u32> = HashMap::with_capacity(members.len());
    let mut part = Mesh::default();
    for &(_, triangle) in members {
        let triangle = triangle as usize;
        let corners = mesh.triangles[triangle].map(|vertex| {
            *numbers.entry(vertex).or_insert_with(|| {
                part.vertices.push(mesh.vertices[vertex as usize]);
                part.vertices.len() as u32 - 1
            })
        });
        part.triangles.push(corners);
        part.sides.push(mesh.sides[triangle]);
    }
    part
}

fn is_still(was: &Mesh, is: &Mesh, still: f64) -> bool {
    was.triangles == is.triangles
        && was.sides == is.sides
        && was.vertices.iter().zip(&is.vertices).all(|(was, is)| was.distance(*is) <= still)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::label::Label;
    use crate::mesh::shapes::solid;

    fn lattice() -> Lattice {
        Lattice { origin: DVec3::splat(-1.0), voxel: 2.0 / 48.0, dims: [49; 3] }
    }

    fn ball() -> Mesh {
        solid(49, 1.0, |at| 0.6 - at.length())
    }

    /// Every triangle is in one patch, with its corners and labels where they were.
    #[test]
    fn patches_together_are_the_surface() {
        let mesh = ball();
        let patches = Patches::new(&mesh, lattice());
        let triangles = |mesh: &Mesh| -> Vec<[u64; 9]> {
            let bits = |triangle| {
                let corners = mesh.corners(triangle).map(|corner| corner.to_array());
                std::array::from_fn(|at| corners[at / 3][at % 3].to_bits())
            };
            (0..mesh.triangles.len()).map(bits).collect()
        };
        let mut all: Vec<[u64; 9]> = patches.iter().flat_map(|(_, part)| triangles(part)).collect();
        let mut expected = triangles(&mesh);
        all.sort_unstable();
        expected.sort_unstable();
        assert!(patches.iter().count() > 20);
        assert_eq!(all, expected);
        assert!(patches.iter().all(|(_, part)| part.labels() == [Label(1)]));
    }

    /// A bump on one side of a ball concerns the patches there and no others; what moves by
    /// next to nothing concerns none, however often it does.
    #[test]
    fn only_what_moved_is_told() {
        let mesh = ball();
        let mut patches = Patches::default();
        let all = patches.follow(&mesh, lattice());
        assert_eq!(all.changed.len(), patches.iter().count());
        let mut bumped = mesh.clone();
        for vertex in bumped.vertices.iter_mut().filter(|vertex| vertex.x > 0.5) {
            vertex.x += 0.01;
        }
        let told = patches.follow(&bumped, lattice());
        let middle = |name: PatchName| told.origin[0] + told.side * (f64::from(name[0]) + 0.5);
        assert!(!told.changed.is_empty() && told.removed.is_empty());
        assert!(told.changed.iter().all(|&name| middle(name) > 0.3), "{told:?}");
        // A creeping surface is told once it is a hundredth of a voxel away.
        let step = 0.004 * lattice().voxel * DVec3::Y;
        let crept = |steps: f64| {
            let mut mesh = bumped.clone();
            mesh.vertices.iter_mut().for_each(|vertex| *vertex += steps * step);
            mesh
        };
        assert_eq!(patches.follow(&crept(1.0), lattice()).changed.len(), 0);
        assert_eq!(patches.follow(&crept(2.0), lattice()).changed.len(), 0);
        assert!(patches.follow(&crept(3.0), lattice()).changed.len() > 20);
        let count = patches.iter().count();
        assert_eq!(patches.clear().removed.len(), count);
        assert_eq!(patches.iter().count(), 0);
    }
}
