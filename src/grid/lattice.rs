//! Where the grid's nodes are.

use glam::DVec3;

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
/// By so much of a leaf two may differ and be the same.
const ROUNDING: f64 = 1e-3;

impl Lattice {
    /// The lattice over a box, with its outermost nodes outside.
    ///
    /// # Errors
    /// A resolution or a voxel size that is no positive number, a box without
    /// a size, or more nodes along an axis than 32 bits can count.
    pub fn new(bounds: Bounds, resolution: Resolution) -> Result<Self> {
        let voxel = voxel_size(bounds, resolution)?;
        Self::from(bounds.min - OFFSET * voxel, bounds, voxel)
    }

    /// A lattice over a box, with its outermost nodes outside, that has leaves in common with
    /// those over other boxes: the leaves of voxels of one size are the same everywhere.
    ///
    /// # Errors
    /// As [`Lattice::new`].
    pub fn fixed(bounds: Bounds, voxel: f64) -> Result<Self> {
        let voxel = voxel_size(bounds, Resolution::VoxelSize(voxel))?;
        let side = LEAF_SIDE as f64;
        let first = ((bounds.min / voxel - OFFSET) / side).ceil() - 1.0;
        let mut lattice = Self::from((first * side + OFFSET) * voxel, bounds, voxel)?;
        lattice.dims = lattice.leaf_dims().map(|leaves| leaves * LEAF_SIDE as i32);
        Ok(lattice)
    }

    /// From a first node on to the first ones beyond a box.
    fn from(origin: DVec3, bounds: Bounds, voxel: f64) -> Result<Self> {
        let mut dims = [0; 3];
        for (nodes, size) in dims.iter_mut().zip((bounds.max - origin).to_array()) {
            // The smallest whole number of voxels that leads past the box.
            let last = (size / voxel).floor() + 1.0;
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

    /// What leads from a leaf of this lattice to the same one of another; `None` when they
    /// have none in common.
    pub fn leaves_to(&self, other: &Self) -> Option<[i32; 3]> {
        let apart = (self.origin - other.origin) / (LEAF_SIDE as f64 * self.voxel);
        let is_whole = apart.abs_diff_eq(apart.round(), ROUNDING);
        let is_near = apart.abs().max_element() < f64::from(i32::MAX / 2);
        let is_same = self.voxel == other.voxel && is_whole && is_near;
        is_same.then(|| apart.round().to_array().map(|along| along as i32))
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
    fn fixed_lattices_have_leaves_in_common() {
        for voxel in [0.31, 1.0, 1e-3 / 3.0] {
            let lattices = [0.0, 1.3, -2.5, 700.0].map(|shift| {
                let bounds = bounds(DVec3::new(10.0, 4.0, 3.3 + shift / 100.0));
                let shift = DVec3::new(shift, -shift, 8.0 * voxel);
                let bounds = Bounds { min: bounds.min + shift, max: bounds.max + shift };
                let lattice = Lattice::fixed(bounds, voxel).unwrap();
                let last = lattice.position(lattice.dims.map(|nodes| nodes - 1));
                assert!(lattice.origin.cmplt(bounds.min).all() && last.cmpgt(bounds.max).all());
                // A leaf more than needed is one too many.
                let side = 8.0 * voxel;
                assert!((bounds.min - lattice.origin).max_element() <= side * 1.001);
                assert!((last - bounds.max).max_element() <= side * 1.001);
                lattice
            });
            for other in &lattices[1..] {
                let by = lattices[0].leaves_to(other).unwrap();
                let there = other.position(by.map(|along| 8 * along));
                assert!(there.abs_diff_eq(lattices[0].origin, 1e-9), "{by:?}");
            }
        }
        let [one, other] = [1.0, 1.5].map(|z| {
            Lattice::new(bounds(DVec3::new(1.0, 1.0, z)), Resolution::Voxels(16)).unwrap()
        });
        assert_eq!((one.leaves_to(&one), one.leaves_to(&other)), (Some([0; 3]), None));
        let aside = Lattice { origin: one.origin + one.voxel, ..one };
        assert_eq!(one.leaves_to(&aside), None);
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
