//! Volumes of labels in layers: a voxel has one label in each, or none.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::{DMat3, DVec3, I64Vec3};
use rayon::prelude::*;

use super::{LabelVolume, Placement};

/// How far the voxels of two volumes may be apart, in voxels, to be the same ones: files keep
/// places in single precision.
const SAME: f64 = 1e-3;

/// Layers of the same voxels.
#[derive(Debug, Clone)]
pub struct LayeredVolume {
    layers: Vec<LabelVolume>,
}

/// How many voxels there are.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Tally {
    /// Of each material.
    pub labels: BTreeMap<u32, u64>,
    /// Of all materials together, those in several layers once.
    pub all: u64,
}

impl Tally {
    fn add(&mut self, label: u32, voxels: u64) {
        if label != 0 {
            *self.labels.entry(label).or_default() += voxels;
        }
    }

    fn and(mut self, other: Self) -> Self {
        other.labels.into_iter().for_each(|(label, voxels)| self.add(label, voxels));
        self.all += other.all;
        self
    }
}

/// Where the voxels of a volume are among those of another: its first one, and its steps from
/// voxel to voxel, which go along the other's axes.
#[derive(Debug, Clone, Copy)]
struct Shift {
    origin: I64Vec3,
    steps: [I64Vec3; 3],
}

impl LayeredVolume {
    /// From layers of the same voxels. A label that is in two of them at once counts once.
    ///
    /// # Errors
    /// Where there is no layer, or they have not the same voxels.
    pub fn new(mut layers: Vec<LabelVolume>) -> std::result::Result<Self, String> {
        let Some(first) = layers.first() else { return Err("it has no layer".to_owned()) };
        let (dims, placement) = (first.dims, first.placement);
        if layers.iter().any(|layer| layer.dims != dims || layer.placement != placement) {
            return Err("its layers have not the same voxels".to_owned());
        }
        for place in 1..layers.len() {
            let (before, rest) = layers.split_at_mut(place);
            rest[0].labels.par_iter_mut().enumerate().for_each(|(voxel, label)| {
                if before.iter().any(|layer| layer.labels[voxel] == *label) {
                    *label = 0;
                }
            });
        }
        Ok(Self { layers })
    }

    /// The layers, one at least.
    pub fn layers(&self) -> &[LabelVolume] {
        &self.layers
    }

    /// How many voxels there are along each axis.
    pub(super) fn dims(&self) -> [usize; 3] {
        self.layers[0].dims
    }

    /// Where they are.
    pub(super) fn placement(&self) -> &Placement {
        &self.layers[0].placement
    }

    /// The same voxels elsewhere: coordinates are multiplied by factors other than 0.
    #[must_use]
    pub fn scaled(mut self, factors: DVec3) -> Self {
        for layer in &mut self.layers {
            let Placement { origin, steps } = &mut layer.placement;
            *origin *= factors;
            *steps = DMat3::from_diagonal(factors) * *steps;
            layer.inverse = steps.inverse();
        }
        self
    }

    /// The volume of a voxel.
    pub fn voxel_volume(&self) -> f64 {
        self.placement().steps.determinant().abs()
    }

    /// How many voxels each material has.
    pub fn tally(&self) -> Tally {
        let here = Shift { origin: I64Vec3::ZERO, steps: I64Vec3::AXES };
        self.tally_with(self, here)
    }

    /// How many voxels of each material are of the same one in another volume; `None` where the
    /// voxels of the two are not the same, be it fewer or more, or along other axes.
    pub fn common(&self, other: &Self) -> Option<Tally> {
        Some(self.tally_with(other, self.shift(other)?))
    }

    fn shift(&self, other: &Self) -> Option<Shift> {
        let (own, inverse) = (self.placement(), other.layers[0].inverse);
        let whole = |exact: DVec3, most: f64| {
            let rounded = exact.round();
            let is_near = (exact - rounded).abs().max_element() <= most;
            // What is farther is in no volume.
            let is_small = rounded.abs().max_element() < 1e15;
            (is_near && is_small).then(|| rounded.as_i64vec3())
        };
        let mut steps = [I64Vec3::ZERO; 3];
        for (axis, step) in steps.iter_mut().enumerate() {
            // All along a row.
            let most = SAME / self.dims()[axis] as f64;
            *step = whole(inverse * own.steps.col(axis), most)?;
        }
        let origin = whole(inverse * (own.origin - other.placement().origin), SAME)?;
        // Each along an axis of its own.
        let sum = steps.iter().fold(I64Vec3::ZERO, |sum, step| sum + step.abs());
        let are_single = steps.iter().all(|step| step.abs().element_sum() == 1);
        (are_single && sum == I64Vec3::ONE).then_some(Shift { origin, steps })
    }

    fn tally_with(&self, other: &Self, shift: Shift) -> Tally {
        let [_, height, depth] = self.dims();
        let count = |mut tally, row| {
            self.count_row([row % height, row / height], other, shift, &mut tally);
            tally
        };
        let rows = (0..height * depth).into_par_iter().fold(Tally::default, count);
        rows.reduce(Tally::default, Tally::and)
    }

    fn count_row(&self, [j, k]: [usize; 2], other: &Self, shift: Shift, tally: &mut Tally) {
        let [width, height, _] = self.dims();
        let start = width * (j + height * k);
        let Shift { origin, steps: [step, second, third] } = shift;
        let first = origin + j as i64 * second + k as i64 * third;
        let Some((part, place, stride)) = other.part_of_row(first, step, width) else { return };
        let beside = |i: usize| (place + stride * i as i64) as usize;
        for own in self.layers.iter().map(|layer| &layer.labels[start..start + width]) {
            for others in other.layers.iter().map(|layer| &layer.labels) {
                let (mut label, mut run) = (0, 0);
                for i in part.clone() {
                    let common = if own[i] == others[beside(i)] { own[i] } else { 0 };
                    if common != label {
                        tally.add(label, run);
                        (label, run) = (common, 0);
                    }
                    run += 1;
                }
                tally.add(label, run);
            }
        }
        let is_common = |i: &usize| self.is_any(start + i) && other.is_any(beside(*i));
        tally.all += part.filter(is_common).count() as u64;
    }

    /// Which voxels of a row from a place on are ours, and as a function of their place in the row
    /// where these are: the first of the row, if it is there, and how far they are apart.
    fn part_of_row(
        &self,
        first: I64Vec3,
        step: I64Vec3,
        width: usize,
    ) -> Option<(Range<usize>, i64, i64)> {
        let dims = I64Vec3::from_array(self.dims().map(|count| count as i64));
        let (mut low, mut high) = (0, width as i64);
        for axis in 0..3 {
            let (at, count) = (first[axis], dims[axis]);
            match step[axis] {
                0 if at < 0 || at >= count => return None,
                0 => (),
                1.. => (low, high) = (low.max(-at), high.min(count - at)),
                _ => (low, high) = (low.max(at - count + 1), high.min(at + 1)),
            }
        }
        let strides = I64Vec3::new(1, dims.x, dims.x * dims.y);
        let range = usize::try_from(low).ok()?..usize::try_from(high).ok()?;
        Some((range, first.dot(strides), step.dot(strides)))
    }

    /// Whether any layer has a material at a voxel.
    fn is_any(&self, voxel: usize) -> bool {
        self.layers.iter().any(|layer| layer.labels[voxel] != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn layered(layers: Vec<LabelVolume>) -> LayeredVolume {
        LayeredVolume::new(layers).expect("layers")
    }

    fn counts(tally: &Tally) -> (Vec<(u32, u64)>, u64) {
        (tally.labels.iter().map(|(&label, &count)| (label, count)).collect(), tally.all)
    }

    /// The same random voxels in another order, and a part of them, have all in common.
    #[test]
    fn voxels_are_the_same_in_any_order_and_in_part() {
        let dims = [5usize, 4, 3];
        let mut random = Random::new(7);
        let labels: Vec<u32> = (0..60).map(|_| (4.0 * random.unit()) as u32).collect();
        let steps = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7)
            * DMat3::from_diagonal(DVec3::new(1.0, 0.5, -3.0));
        let whole = Placement { origin: DVec3::new(30.0, -2.0, 7.0), steps };
        let one = LabelVolume::new(dims, labels.clone(), whole).expect("a volume");
        let label = |[i, j, k]: [usize; 3]| labels[i + 5 * (j + 4 * k)];
        // Third axis first, backwards; then the first; then the second, from 1 on.
        let (mut moved, mut expected) = (Vec::new(), BTreeMap::new());
        for j in 1..4 {
            for i in 0..5 {
                for k in (0..3).rev() {
                    let label = label([i, j, k]);
                    moved.push(label);
                    *expected.entry(label).or_insert(0u64) += 1;
                }
            }
        }
        expected.remove(&0);
        let all = expected.values().sum::<u64>();
        let placement = Placement {
            origin: whole.point(DVec3::new(0.0, 1.0, 2.0)),
            steps: DMat3::from_cols(-steps.z_axis, steps.x_axis, steps.y_axis),
        };
        let other = LabelVolume::new([3, 5, 3], moved, placement).expect("a volume");
        let (one, other) = (layered(vec![one]), layered(vec![other]));
        for common in [one.common(&other), other.common(&one), Some(other.tally())] {
            let expected: Vec<(u32, u64)> = expected.clone().into_iter().collect();
            assert_eq!(common.as_ref().map(counts), Some((expected, all)));
        }
        // Half a voxel away, or with other steps, they are others.
        let half = DVec3::splat(0.5);
        for scaled in [DVec3::splat(1.1), DVec3::new(1.0, 1.0, 2.0)] {
            assert_eq!(one.common(&other.clone().scaled(scaled)), None);
        }
        let shifted = Placement { origin: whole.point(half), steps };
        let shifted = LabelVolume::new(dims, labels.clone(), shifted).expect("a volume");
        assert_eq!(one.common(&layered(vec![shifted])), None);
        // Far away there is nothing in common.
        let far = Placement { origin: whole.point(DVec3::splat(1e6)), steps };
        let far = LabelVolume::new(dims, labels, far).expect("a volume");
        assert_eq!(one.common(&layered(vec![far])), Some(Tally::default()));
    }
}
