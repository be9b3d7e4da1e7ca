//! The box that is filled, and how lattices lie over it.

use glam::DVec3;

use crate::error::Result;
use crate::plane::Bounds;

use super::lattice::Resolution;
use super::samples::Lattice;

/// Sizes of fixed boxes to a doubling.
const SIZES_OF_DOUBLING: f64 = 4.0;
/// Voxels on the longest side of a box with fixed lattices at least: these reach up to a leaf
/// beyond the box, and farther away, relative to its size, fields are anything.
const FIXED_VOXELS: f64 = 64.0;

/// A box with lattices of all voxel sizes over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The box that is filled.
    pub bounds: Bounds,
    /// The finest lattice, which has the result.
    pub lattice: Lattice,
    /// Whether nodes are where they are for any box; else they follow its corner.
    pub is_fixed: bool,
}

impl Frame {
    /// With lattices that begin at the box's lower corner.
    ///
    /// # Errors
    /// As [`Lattice::new`].
    pub fn new(bounds: Bounds, resolution: Resolution) -> Result<Self> {
        Ok(Self { bounds, lattice: Lattice::new(bounds, resolution)?, is_fixed: false })
    }

    /// With lattices that other boxes have, too, if the box has some 64 voxels: the nodes that
    /// two boxes have in common are nodes of both.
    ///
    /// # Errors
    /// As [`Lattice::new`].
    pub fn fixed(bounds: Bounds, voxel: f64) -> Result<Self> {
        if bounds.size().max_element() < FIXED_VOXELS * voxel {
            return Self::new(bounds, Resolution::VoxelSize(voxel));
        }
        Ok(Self { bounds, lattice: Lattice::fixed(bounds, voxel)?, is_fixed: true })
    }

    /// Another lattice of this frame, over some box.
    ///
    /// # Errors
    /// As [`Lattice::new`].
    pub fn over(&self, bounds: Bounds, voxel: f64) -> Result<Lattice> {
        match self.is_fixed {
            true => Lattice::fixed(bounds, voxel),
            false => Lattice::new(bounds, Resolution::VoxelSize(voxel)),
        }
    }

    /// The longest side of the box, for what is measured by it. Where lattices are fixed it is
    /// rounded, so that it stays the same while the box grows a little.
    pub fn size(&self) -> f64 {
        let (size, voxel) = (self.bounds.size().max_element(), self.lattice.voxel);
        match self.is_fixed {
            true => {
                voxel
                    * ((SIZES_OF_DOUBLING * (size / voxel).log2()).round() / SIZES_OF_DOUBLING)
                        .exp2()
            }
            false => size,
        }
    }

    /// Where lattices in the planes of sections begin: a point that stays when a fixed frame
    /// grows.
    pub fn center(&self) -> DVec3 {
        if self.is_fixed { DVec3::ZERO } else { self.bounds.middle() }
    }

    /// Whether what was computed in another one can hold in this one: lengths are measured
    /// alike, and nodes are where they were.
    pub fn continues(&self, other: &Self) -> bool {
        match self.is_fixed && other.is_fixed {
            true => self.lattice.voxel == other.lattice.voxel && self.size() == other.size(),
            false => self == other,
        }
    }
}
