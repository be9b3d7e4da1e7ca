//! The oracle on a lattice, so that meshers can show what it says.

use glam::DVec3;
use rayon::prelude::*;

use super::Oracle;
use crate::error::Result;
use crate::field::{Field, Queries};
use crate::grid::Cells;
use crate::grid::samples::{Lattice, Samples};
use crate::grid::sampling::{Margin, Starts, sample};
use crate::label::Label;
use crate::plane::Bounds;
use crate::progress::Progress;

/// How near to a plane a label is told from others, in voxels: on the plane its
/// distance is 0 and its share a step, in which an interpolated crossing would
/// be lost.
const CLEARANCE: f64 = 0.02;
/// So many times as far away as the nearest label, another has no share: leaves
/// hold only labels that are near.
const REACH: f64 = 4.0;

impl Oracle<'_> {
    /// Every label's share on a lattice, near where the nearest label changes.
    ///
    /// The share of a label at the distance D is max(0, 1/D − 1/(4 D₁)) over the
    /// sum of all, D₁ being the distance of the nearest. So two labels that are
    /// equally near have equal shares, and f = 2·share − 1 of the only two
    /// labels near changes its sign just where the nearest label does.
    ///
    /// # Errors
    /// Where sampling fails.
    pub fn sample(&self, lattice: &Lattice, progress: &dyn Progress) -> Result<Samples> {
        let field = Shares { oracle: self, clearance: CLEARANCE * lattice.voxel };
        self.sample_field(&field, lattice, progress)
    }

    /// The nearest label on a lattice, near where it changes: f is 1 for it and −1
    /// for all others. Much cheaper than shares, and nothing to mesh.
    ///
    /// # Errors
    /// Where sampling fails.
    pub fn sample_labels(&self, lattice: &Lattice, progress: &dyn Progress) -> Result<Samples> {
        self.sample_field(&NearestLabel(self), lattice, progress)
    }

    fn sample_field(
        &self,
        field: &dyn Field,
        lattice: &Lattice,
        progress: &dyn Progress,
    ) -> Result<Samples> {
        // Along all edges, so that the surface is also found around a part of one
        // label in the middle of what is unknown.
        let edges: Vec<[DVec3; 2]> =
            self.sites.iter().flat_map(|site| site.section.segments()).collect();
        let starts = Starts::along(&edges, lattice);
        Ok(sample(self, field, &starts, lattice, Margin(1), progress)?.kept.samples)
    }
}

/// The box is one cell: where other planes are plays no role.
impl Cells for Oracle<'_> {
    fn bounds(&self) -> Bounds {
        self.bounds
    }

    fn is_open(&self) -> bool {
        self.border.is_none_or(|border| border.label != Label::OUTSIDE)
    }

    fn locate(&self, _point: DVec3) -> u32 {
        0
    }

    fn locator<'a>(&'a self, _region: Bounds) -> Box<dyn Fn(DVec3) -> u32 + 'a> {
        Box::new(|_| 0)
    }
}

/// All or nothing.
struct NearestLabel<'a>(&'a Oracle<'a>);

impl Field for NearestLabel<'_> {
    fn labels(&self, _cell: u32) -> &[Label] {
        &self.0.labels
    }

    fn edges(&self, _cell: u32) -> u64 {
        self.0.sites.iter().map(|site| site.section.edges().len() as u64).sum()
    }

    fn name(&self) -> String {
        "nearest point".to_owned()
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        let values = |&point: &DVec3| {
            let nearest = self.0.nearest(point).label;
            self.0.labels.iter().map(move |&label| if label == nearest { 1.0 } else { -1.0 })
        };
        Ok(queries.points.par_iter().flat_map_iter(values).collect())
    }
}

/// Shares by distance.
struct Shares<'a> {
    oracle: &'a Oracle<'a>,
    /// In world units.
    clearance: f64,
}

impl Field for Shares<'_> {
    fn labels(&self, _cell: u32) -> &[Label] {
        &self.oracle.labels
    }

    fn edges(&self, _cell: u32) -> u64 {
        self.oracle.sites.iter().map(|site| site.section.edges().len() as u64).sum()
    }

    fn name(&self) -> String {
        "nearest point".to_owned()
    }

    fn evaluate(&self, queries: &Queries) -> Result<Vec<f32>> {
        let values = |&point: &DVec3| self.values(point);
        Ok(queries.points.par_iter().flat_map_iter(values).collect())
    }
}

impl Shares<'_> {
    /// For every label its f.
    fn values(&self, point: DVec3) -> Vec<f32> {
        let mut weights = self.oracle.distances_off_planes(point, self.clearance, REACH);
        let nearest = weights.iter().copied().fold(f64::INFINITY, f64::min).max(self.clearance);
        for weight in &mut weights {
            *weight = (nearest / weight.max(nearest) - 1.0 / REACH).max(0.0);
        }
        let sum: f64 = weights.iter().sum();
        weights.into_iter().map(|weight| (2.0 * weight / sum - 1.0) as f32).collect()
    }
}
