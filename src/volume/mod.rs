//! Volumes of labels: a lattice of voxels, each with one label, anywhere in
//! the world.

mod boundary;
mod cut;
mod distances;
mod drawn;
mod fill;
mod layered;
mod slices;

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::label::{Label, Material};
use crate::plane::Bounds;

pub use boundary::Boundary;
pub use distances::distances;
pub(crate) use drawn::{Shown, shown};
pub use fill::fill;
pub use layered::{LayeredVolume, Tally};
pub use slices::Slices;
pub(crate) use slices::nth;

/// Below this part of what a box of the same steps would have, the voxels'
/// volume counts as none.
const FLAT: f64 = 1e-9;

/// Where voxels are: voxel (i, j, k) has its centre at
/// `origin + steps · (i, j, k)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The centre of the first voxel, in world units.
    pub origin: DVec3,
    /// The columns are the steps from a voxel to the next along each axis.
    pub steps: DMat3,
}

impl Placement {
    fn point(&self, index: DVec3) -> DVec3 {
        self.origin + self.steps * index
    }
}

/// Voxels with labels.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelVolume {
    dims: [usize; 3],
    /// The first axis runs fastest.
    labels: Vec<u32>,
    placement: Placement,
    /// From steps in the world to those between voxels.
    inverse: DMat3,
    /// The smallest and largest index along each axis with a material.
    occupied: Option<[[usize; 3]; 2]>,
    /// Names and colours, as far as the file gives them.
    pub materials: Vec<Material>,
    /// The unit of length; empty when unknown.
    pub units: String,
    /// The frame of the coordinates; empty when unknown.
    pub frame: String,
}

impl LabelVolume {
    /// From a label for each voxel, the first axis running fastest.
    ///
    /// # Errors
    /// What is wrong: the number of labels, or steps that span no volume.
    pub fn new(
        dims: [usize; 3],
        labels: Vec<u32>,
        placement: Placement,
    ) -> std::result::Result<Self, String> {
        let count = dims.iter().try_fold(1usize, |product, &dim| product.checked_mul(dim));
        if count != Some(labels.len()) {
            return Err(format!("{} labels are given for {dims:?} voxels", labels.len()));
        }
        let Placement { origin, steps } = placement;
        let lengths = [0, 1, 2].map(|axis| steps.col(axis).length());
        let volume = steps.determinant().abs();
        let spans = volume > FLAT * lengths.iter().product::<f64>() && volume.is_normal();
        if !origin.is_finite() || !steps.is_finite() || !spans {
            return Err(format!(
                "its axes ({}, {}, {}, from {origin}) span no volume: correct its directions",
                steps.x_axis, steps.y_axis, steps.z_axis
            ));
        }
        let occupied = occupied(dims, &labels);
        Ok(Self {
            dims,
            labels,
            placement,
            inverse: steps.inverse(),
            occupied,
            materials: Vec::new(),
            units: String::new(),
            frame: String::new(),
        })
    }

    /// The box around all voxels of materials; `None` without any.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around(self.corners(0.5)?)
    }

    /// The shortest step between voxels.
    pub fn spacing(&self) -> f64 {
        let lengths = [0, 1, 2].map(|axis| self.placement.steps.col(axis).length());
        lengths.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// All materials that occur, sorted.
    pub fn labels(&self) -> Vec<Label> {
        let mut labels = Vec::new();
        for run in self.labels.chunk_by(|one, other| one == other) {
            let label = Label(run[0]);
            if let Some(place) = labels.binary_search(&label).err().filter(|_| label.is_material())
            {
                labels.insert(place, label);
            }
        }
        labels
    }

    /// How many voxels each label has.
    pub fn sizes(&self) -> BTreeMap<Label, u64> {
        let mut sizes = BTreeMap::new();
        for run in self.labels.chunk_by(|one, other| one == other) {
            *sizes.entry(Label(run[0])).or_default() += run.len() as u64;
        }
        sizes
    }

    /// The same with these labels alone; all others are outside.
    pub fn of_labels(mut self, labels: &[u32]) -> Self {
        let others = self.labels.iter_mut().filter(|label| !labels.contains(label));
        others.for_each(|label| *label = 0);
        self.materials.retain(|material| labels.contains(&material.id));
        self.occupied = occupied(self.dims, &self.labels);
        self
    }

    /// The corners of the box of the voxels' centres of all materials, grown
    /// by so many voxels; corner i has the larger index along axis a if bit a
    /// of i is set.
    fn corners(&self, margin: f64) -> Option<[DVec3; 8]> {
        let [low, high] = self.occupied?;
        Some(std::array::from_fn(|corner| {
            let index = |axis: usize| match corner >> axis & 1 {
                0 => low[axis] as f64 - margin,
                _ => high[axis] as f64 + margin,
            };
            self.placement.point(DVec3::new(index(0), index(1), index(2)))
        }))
    }

    /// A voxel's label; beyond the volume it is outside.
    fn label(&self, index: [i64; 3]) -> u32 {
        let [i, j, k] = index.map(|index| usize::try_from(index).unwrap_or(usize::MAX));
        let [x, y, z] = self.dims;
        if i < x && j < y && k < z { self.labels[i + x * (j + y * k)] } else { 0 }
    }

    /// The labels of the eight voxels around a point, given in voxels, and
    /// their shares of it: trilinear weights, that add up to 1.
    fn around(&self, point: DVec3) -> [(u32, f64); 8] {
        let base = point.floor();
        let part = point - base;
        let base = base.to_array().map(|index| index as i64);
        std::array::from_fn(|corner| {
            let mut weight = 1.0;
            let index = [0, 1, 2].map(|axis| {
                let beyond = corner >> axis & 1;
                weight *= if beyond == 1 { part[axis] } else { 1.0 - part[axis] };
                base[axis] + beyond as i64
            });
            (self.label(index), weight)
        })
    }

    /// The share of a label at a point.
    fn share(&self, point: DVec3, label: u32) -> f64 {
        let around = self.around(point);
        around.iter().filter(|voxel| voxel.0 == label).map(|voxel| voxel.1).sum()
    }

    /// The label with the largest share; of equals the smallest.
    fn winner(&self, point: DVec3) -> u32 {
        let around = self.around(point);
        let first = around[0].0;
        if around.iter().all(|voxel| voxel.0 == first) {
            return first;
        }
        let share = |label: u32| -> f64 {
            around.iter().filter(|voxel| voxel.0 == label).map(|voxel| voxel.1).sum()
        };
        let shares = around.map(|voxel| (voxel.0, share(voxel.0)));
        let better = |best: (u32, f64), next: (u32, f64)| {
            if next.1 > best.1 || (next.1 == best.1 && next.0 < best.0) { next } else { best }
        };
        shares.into_iter().reduce(better).map_or(first, |best| best.0)
    }
}

/// The box of all voxels that are not outside.
fn occupied([x, y, _]: [usize; 3], labels: &[u32]) -> Option<[[usize; 3]; 2]> {
    let mut found: Option<[[usize; 3]; 2]> = None;
    for (row, voxels) in labels.chunks(x.max(1)).enumerate() {
        let Some(first) = voxels.iter().position(|&label| label != 0) else { continue };
        let last = voxels.iter().rposition(|&label| label != 0).unwrap_or(first);
        let [low, high] = [first, last].map(|i| [i, row % y, row / y]);
        found = Some(found.map_or([low, high], |[lowest, highest]| {
            [
                std::array::from_fn(|axis| lowest[axis].min(low[axis])),
                std::array::from_fn(|axis| highest[axis].max(high[axis])),
            ]
        }));
    }
    found
}

#[cfg(test)]
mod tests;
