//! What a grid would take, and what there is, before the work begins.

use crate::error::{Remedy, Result};
use crate::memory;
use crate::plane::{Bounds, polygon_area};
use crate::section::Section;

use super::contour::segments;
use super::samples::{LEAF_NODES, LEAF_SIDE, Lattice};

/// A tile's label and whether its leaf is evaluated.
const BYTES_PER_TILE: u64 = 5;
/// For each material where a leaf's values are.
const BYTES_PER_SLOT: u64 = 4;
/// Besides its values, what a leaf brings along in the stages that follow:
/// the mesh with its connectivity and the level set.
const BYTES_PER_LEAF: u64 = 24 << 10;
/// Copies of a leaf's values: sampled, being smoothed, and smoothed.
const COPIES: u64 = 3;
/// Leaves that a surface takes for each leaf face of its area. A plane of any
/// direction cuts 1.5 cubes per unit of area on average; following it takes
/// in neighbours.
const LEAVES_PER_FACE: f64 = 3.0;

/// Bytes that sampling and what follows would take at their peak, by a rough
/// estimate: the tiles exactly, the leaves from the length of the contours.
pub fn estimate_memory(lattice: &Lattice, sections: &[Section], materials: usize) -> u64 {
    let tiles = lattice.leaf_count();
    let side = lattice.voxel * LEAF_SIDE as f64;
    let faces = surface_area(lattice, sections) / (side * side);
    let leaves = ((LEAVES_PER_FACE * faces) as u64).min(tiles); // the cast saturates
    // Rarely more than two materials meet in a leaf.
    let values = COPIES * materials.clamp(1, 2) as u64 * (LEAF_NODES * size_of::<f32>()) as u64;
    let leaves = leaves.saturating_mul(values + BYTES_PER_LEAF);
    let tile = BYTES_PER_TILE + BYTES_PER_SLOT * materials as u64;
    tiles.saturating_mul(tile).saturating_add(leaves)
}

/// Refuses a grid that would not fit.
///
/// # Errors
/// [`Error::Memory`](crate::error::Error::Memory) says how much it would take.
pub fn require_memory(lattice: &Lattice, sections: &[Section], materials: usize) -> Result<()> {
    let [x, y, z] = lattice.dims;
    let needed = estimate_memory(lattice, sections, materials);
    require_bytes(needed, Remedy::CoarserLattice, || format!("a grid of {x} × {y} × {z} nodes"))
}

/// Refuses what would not fit, with what to ask for instead.
///
/// # Errors
/// As [`require_memory`].
pub(crate) fn require_bytes(
    needed: u64,
    remedy: Remedy,
    what: impl FnOnce() -> String,
) -> Result<()> {
    memory::require(needed, what).map_err(|error| error.avoidable(remedy))
}

/// The area of all surfaces, from the length of the contours: for planes in
/// general position the area in a volume V is 4/π · V · length / area of the
/// planes (stereology's S_V = 4/π · L_A).
fn surface_area(lattice: &Lattice, sections: &[Section]) -> f64 {
    let last = lattice.dims.map(|nodes| nodes - 1);
    let bounds = Bounds { min: lattice.origin, max: lattice.position(last) };
    let length: f64 =
        sections.iter().flat_map(segments).map(|[start, end]| start.distance(end)).sum();
    let area: f64 =
        sections.iter().map(|section| polygon_area(&section.plane().polygon_in(bounds))).sum();
    // Sections without any area in the box: a layer of one voxel each.
    let per_area = if area > 0.0 { length / area } else { 0.0 };
    4.0 / std::f64::consts::PI * bounds.volume() * per_area
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::error::Error;
    use crate::grid::lattice::Resolution;

    const UNIT: Bounds = Bounds { min: DVec3::ZERO, max: DVec3::ONE };

    #[test]
    fn huge_grids_are_refused_at_once() {
        for voxels in [100_000, 1_000_000] {
            let lattice = Lattice::new(UNIT, Resolution::Voxels(voxels)).unwrap();
            let error = require_memory(&lattice, &[], 1).unwrap_err();
            let tiles = f64::from(voxels / 8).powi(3) * BYTES_PER_TILE as f64;
            let Error::Avoidable { error, remedy: Remedy::CoarserLattice } = error else {
                panic!("{error}")
            };
            let Error::Memory { needed, .. } = *error else { panic!("{error}") };
            assert!(needed as f64 >= tiles);
        }
        let lattice = Lattice { origin: DVec3::ZERO, voxel: 1.0, dims: [i32::MAX - 16; 3] };
        assert_eq!(estimate_memory(&lattice, &[], 1), u64::MAX);
    }

    #[test]
    fn modest_grids_fit() {
        let lattice = Lattice::new(UNIT, Resolution::Voxels(64)).unwrap();
        require_memory(&lattice, &[], 9).unwrap();
        assert!(memory::available() > 1 << 20);
    }
}
