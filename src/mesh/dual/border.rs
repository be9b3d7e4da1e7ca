//! The faces of an open box, in which caps lie.

use glam::DVec3;
use rayon::prelude::*;

use crate::grid::samples::Lattice;
use crate::plane::Bounds;

/// The faces of a box, and the layers of cells that they pass through: the
/// first and the last along every axis.
pub struct BoxFaces {
    bounds: Bounds,
    /// The first nodes of the cells of the last layers.
    last: DVec3,
}

impl BoxFaces {
    /// The box that a lattice was made for.
    pub fn new(bounds: Bounds, lattice: &Lattice) -> Self {
        let last = DVec3::from(lattice.dims.map(|nodes| f64::from(nodes - 2)));
        Self { bounds, last }
    }

    /// Whether a face passes through the cell with this first node, in lattice
    /// units.
    pub fn touch(&self, low: DVec3) -> bool {
        low.cmple(DVec3::ZERO).any() || low.cmpge(self.last).any()
    }

    /// Puts points onto the faces that pass through their cells, in the
    /// coordinates to which `from_world` leads.
    pub fn project(
        &self,
        points: &mut [DVec3],
        lows: &[DVec3],
        from_world: impl Fn(DVec3) -> DVec3,
    ) {
        let (min, max) = (from_world(self.bounds.min), from_world(self.bounds.max));
        points.par_iter_mut().zip(lows).for_each(|(point, low)| {
            *point = DVec3::select(low.cmpge(self.last), max, *point);
            *point = DVec3::select(low.cmple(DVec3::ZERO), min, *point);
        });
    }
}
