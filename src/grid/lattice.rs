//! Where the grid's nodes are.

use crate::error::{Error, Remedy, Result};
use crate::label::Label;
use crate::plane::Bounds;

use super::samples::{LEAF_SIDE, Lattice};

/// How fine the grid is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Resolution {
    /// So many voxels on the box's longest side.
    Voxels(u32),
    /// Voxels of this size, in world units.
    VoxelSize(f64),
}

/// Nodes stand half a voxel off the box's faces: planes that divide the box
/// evenly then pass between nodes.
const OFFSET: f64 = 0.5;

impl Lattice {
    /// The lattice over a box, with its outermost nodes outside.
    ///
    /// # Errors
    /// A resolution or a voxel size that is no positive number, a box without
    /// a size, or more nodes along an axis than 32 bits can count.
    pub fn new(bounds: Bounds, resolution: Resolution) -> Result<Self> {
        let voxel = voxel_size(bounds, resolution)?;
        let origin = bounds.min - OFFSET * voxel;
        let mut dims = [0; 3];
        for (nodes, size) in dims.iter_mut().zip(bounds.size().to_array()) {
            // The smallest whole number of voxels that leads past the box.
            let last = (size / voxel + OFFSET).floor() + 1.0;
            if last > f64::from(i32::MAX - 2 * LEAF_SIDE as i32) {
                let what = format!(
                    "voxels of {voxel} are too small for a box of {size}: the grid would have \
                     {last:.0} nodes on one side"
                );
                return Err(Error::Option(what).avoidable(Remedy::CoarserLattice));
            }
            *nodes = last as i32 + 1;
        }
        Ok(Self { origin, voxel, dims })
    }

    /// How many leaves there are; saturates.
    pub fn leaf_count(&self) -> u64 {
        self.leaf_dims()
            .iter()
            .fold(1, |product: u64, &side| product.saturating_mul(side.unsigned_abs().into()))
    }

    /// Whether a leaf is in the lattice.
    pub fn has_leaf(&self, at: [i32; 3]) -> bool {
        at.iter().zip(self.leaf_dims()).all(|(&at, leaves)| (0..leaves).contains(&at))
    }

    /// The index of a leaf of the lattice: x slowest, z fastest.
    pub fn leaf_index(&self, at: [i32; 3]) -> usize {
        let [_, y, z] = self.leaf_dims().map(|leaves| leaves as usize);
        (at[0] as usize * y + at[1] as usize) * z + at[2] as usize
    }

    /// The leaf with an index: the inverse of [`Lattice::leaf_index`].
    pub fn leaf_at(&self, index: usize) -> [i32; 3] {
        let [_, y, z] = self.leaf_dims().map(|leaves| leaves as usize);
        [index / (y * z), index / z % y, index % z].map(|at| at as i32)
    }

    /// The label of a leaf, of those of all leaves of the lattice. Beyond it all is outside.
    pub fn tile(&self, tiles: &[Label], at: [i32; 3]) -> Label {
        if self.has_leaf(at) { tiles[self.leaf_index(at)] } else { Label::OUTSIDE }
    }
}

fn voxel_size(bounds: Bounds, resolution: Resolution) -> Result<f64> {
    let longest = bounds.size().max_element();
    if !(longest.is_finite() && longest > 0.0) {
        return Err(Error::Option(format!("the box has no size: its longest side is {longest}")));
    }
    let voxel = match resolution {
        Resolution::Voxels(0) => {
            return Err(Error::Option("a grid needs a resolution of 1 at least".to_owned()));
        }
        Resolution::Voxels(count) => longest / f64::from(count),
        Resolution::VoxelSize(size) => size,
    };
    if !(voxel.is_finite() && voxel > 0.0) {
        return Err(Error::Option(format!("the size of a voxel must be positive, and is {voxel}")));
    }
    Ok(voxel)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn bounds(size: DVec3) -> Bounds {
        let min = DVec3::new(-3.0, 5.0, 100.0);
        Bounds { min, max: min + size }
    }

    #[test]
    fn outermost_nodes_lie_outside_the_box() {
        for size in [DVec3::new(10.0, 4.0, 3.3), DVec3::splat(1e-3), DVec3::new(1.0, 0.0, 7.0)] {
            for resolution in [Resolution::Voxels(7), Resolution::VoxelSize(0.31)] {
                let bounds = bounds(size);
                let lattice = Lattice::new(bounds, resolution).unwrap();
                let last = lattice.position(lattice.dims.map(|nodes| nodes - 1));
                assert!(lattice.origin.cmplt(bounds.min).all());
                assert!(last.cmpgt(bounds.max).all());
                // No more than needed: the layer before it is inside or on the box.
                let before = last - lattice.voxel;
                assert!(before.cmple(bounds.max).all());
            }
        }
    }

    #[test]
    fn the_longest_side_has_the_resolution() {
        let lattice =
            Lattice::new(bounds(DVec3::new(2.0, 8.0, 1.0)), Resolution::Voxels(256)).unwrap();
        assert_eq!(lattice.voxel, 8.0 / 256.0);
        // 256 voxels of the box, and half a voxel more on either side.
        assert_eq!(lattice.dims, [66, 258, 34]);
    }

    #[test]
    fn absurd_resolutions_are_errors() {
        let small = bounds(DVec3::ONE);
        for resolution in [
            Resolution::Voxels(0),
            Resolution::Voxels(u32::MAX),
            Resolution::VoxelSize(0.0),
            Resolution::VoxelSize(-1.0),
            Resolution::VoxelSize(f64::NAN),
            Resolution::VoxelSize(1e-300),
        ] {
            let error = Lattice::new(small, resolution).unwrap_err();
            let is_plain = matches!(error, Error::Option(_) | Error::Avoidable { .. });
            assert!(is_plain, "{error}");
        }
        assert!(Lattice::new(bounds(DVec3::ZERO), Resolution::Voxels(5)).is_err());
    }

    #[test]
    fn leaf_indices_invert() {
        let lattice = Lattice { origin: DVec3::ZERO, voxel: 1.0, dims: [17, 8, 25] };
        assert_eq!(lattice.leaf_dims(), [3, 1, 4]);
        assert_eq!(lattice.leaf_count(), 12);
        for index in 0..12 {
            let at = lattice.leaf_at(index);
            assert!(lattice.has_leaf(at));
            assert_eq!(lattice.leaf_index(at), index);
        }
        assert!(!lattice.has_leaf([0, 1, 0]) && !lattice.has_leaf([-1, 0, 0]));
    }
}
