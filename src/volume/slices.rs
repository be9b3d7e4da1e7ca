//! The slices of a volume that show something, as images.

use glam::DVec3;

use super::LabelVolume;
use super::drawn::Drawn;
use crate::label_image::{ImagePlacement, LabelImage};
use crate::section::{ImageRules, VolumeAxis};

/// What axes of voxels are called.
const AXES: [char; 3] = ['i', 'j', 'k'];

/// The slices that show something.
#[derive(Debug, Clone, PartialEq)]
pub struct Slices {
    /// By axis and index. They are called "k = 12 (z = 36)": by the axis that they lie across, the
    /// index along it, from 0, and where they lie along a coordinate's axis their place there.
    pub images: Vec<(String, LabelImage)>,
    /// Which slices these are, and why.
    pub found: String,
    /// How many voxels of materials are on none of them, and the first one's indices; where
    /// slices of several axes were drawn.
    pub left_out: Option<(usize, [usize; 3])>,
}

impl LabelVolume {
    /// The slices that show something: those that were drawn, where there are empty ones
    /// between them, on however many axes; else all in the reach of materials, across the axis
    /// with the longest step. Where slices of several axes cross, each shows there what it does
    /// on both sides of the line.
    ///
    /// # Errors
    /// When there is no material in the volume.
    pub fn slices(&self, rules: &ImageRules) -> std::result::Result<Slices, String> {
        let Some([low, high]) = self.occupied else {
            return Err("all of its voxels are 0, which is outside: export the labels".to_owned());
        };
        let axis = rules.axis.map(|axis| self.number(axis));
        let drawn = self.drawn(axis);
        let mut found = self.found(&drawn);
        let slices = match drawn {
            Drawn::Sparse(slices) => slices,
            Drawn::Full(axis) => {
                let mut slices: [Vec<usize>; 3] = Default::default();
                slices[axis] = (low[axis]..=high[axis]).collect();
                slices
            }
        };
        let left_out = self.uncovered(&slices).filter(|_| axis.is_none());
        let mut images = Vec::new();
        for (axis, all) in slices.iter().enumerate() {
            for &index in all.iter().step_by(rules.every.max(1)) {
                let image = self.slice(axis, index, &slices)?;
                images.push((self.name(axis, index), image));
            }
        }
        if rules.every > 1 {
            found += &format!("; of them every {} is taken, {}", nth(rules.every), images.len());
        }
        Ok(Slices { images, found, left_out })
    }

    fn number(&self, axis: VolumeAxis) -> usize {
        match axis {
            VolumeAxis::Voxels(axis) => axis.min(2),
            VolumeAxis::World(coordinate) => {
                let along = |axis: &usize| {
                    self.placement.steps.col(*axis).normalize()[coordinate.min(2)].abs()
                };
                (0..3).max_by(|one, next| along(one).total_cmp(&along(next))).unwrap_or(2)
            }
        }
    }

    fn found(&self, drawn: &Drawn) -> String {
        match drawn {
            Drawn::Full(axis) => {
                let axis = AXES[*axis];
                format!(
                    "a full volume: every slice across {axis} that materials reach is a section"
                )
            }
            Drawn::Sparse(slices) => {
                let parts: Vec<String> = (0..3)
                    .filter(|&axis| !slices[axis].is_empty())
                    .map(|axis| numbers(AXES[axis], &slices[axis]))
                    .collect();
                format!(
                    "drawn on slices {}: these are the sections, and what is between them is \
                     unknown",
                    parts.join(" and ")
                )
            }
        }
    }

    fn name(&self, axis: usize, index: usize) -> String {
        let voxel = DVec3::from(std::array::from_fn(|other| match other == axis {
            true => index as f64,
            false => 0.0,
        }));
        let at = self.placement.point(voxel);
        let [u, v] = in_plane(axis).map(|other| self.placement.steps.col(other));
        let normal = u.cross(v).normalize();
        let name = format!("{} = {index}", AXES[axis]);
        match (0..3).find(|&coordinate| normal[coordinate].abs() > 1.0 - 1e-9) {
            // Six digits are more than anybody reads, and hide rounding.
            Some(coordinate) => {
                let place = (at[coordinate] * 1e6).round() / 1e6 + 0.0;
                format!("{name} ({} = {place})", ['x', 'y', 'z'][coordinate])
            }
            None => name,
        }
    }

    /// The image of a slice, without what others draw on it where they cross it.
    fn slice(
        &self,
        axis: usize,
        index: usize,
        drawn: &[Vec<usize>; 3],
    ) -> std::result::Result<LabelImage, String> {
        let [u, v] = in_plane(axis);
        let size = [self.dims[u], self.dims[v]];
        let voxel = |x: usize, y: usize| {
            let mut voxel = [0; 3];
            (voxel[axis], voxel[u], voxel[v]) = (index, x, y);
            voxel
        };
        let label = |x: usize, y: usize| self.label(voxel(x, y).map(|index| index as i64));
        let mut labels = Vec::with_capacity(size[0] * size[1]);
        for y in 0..size[1] {
            labels.extend((0..size[0]).map(|x| label(x, y)));
        }
        for (line, sides) in crossings(&drawn[u], size[0]) {
            for y in 0..size[1] {
                let beside = sides.map(|x| x.map_or(0, |x| label(x, y)));
                if beside[0] == beside[1] {
                    labels[y * size[0] + line] = beside[0];
                }
            }
        }
        let by_row = labels.clone();
        let label = |x: usize, y: usize| by_row[y * size[0] + x];
        for (line, sides) in crossings(&drawn[v], size[1]) {
            for x in 0..size[0] {
                let beside = sides.map(|y| y.map_or(0, |y| label(x, y)));
                if beside[0] == beside[1] {
                    labels[line * size[0] + x] = beside[0];
                }
            }
        }
        let origin = self.placement.point(DVec3::from(voxel(0, 0).map(|index| index as f64)));
        let steps = [u, v].map(|axis| self.placement.steps.col(axis));
        Ok(LabelImage::new(size, labels, ImagePlacement { origin, steps })?.cropped())
    }
}

/// The axes of a slice across another one.
fn in_plane(axis: usize) -> [usize; 2] {
    [[1, 2], [0, 2], [0, 1]][axis]
}

/// The lines of an image on which other slices cross it, each with the next lines before and
/// after it on which none does.
fn crossings(
    lines: &[usize],
    size: usize,
) -> impl Iterator<Item = (usize, [Option<usize>; 2])> + use<'_> {
    lines.chunk_by(|one, next| one + 1 == *next).flat_map(move |run| {
        let before = run[0].checked_sub(1);
        let after = Some(run[run.len() - 1] + 1).filter(|&after| after < size);
        run.iter().map(move |&line| (line, [before, after]))
    })
}

/// "k = 3, 8, 13, … 43 (9)"
fn numbers(axis: char, slices: &[usize]) -> String {
    let text =
        |slices: &[usize]| slices.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    match slices {
        [first @ .., last] if slices.len() > 6 => {
            format!("{axis} = {}, … {last} ({} slices)", text(&first[..3]), slices.len())
        }
        _ => format!("{axis} = {}", text(slices)),
    }
}

/// "3rd"
pub(crate) fn nth(number: usize) -> String {
    let ending = match (number % 10, number % 100) {
        (_, 11..=13) => "th",
        (1, _) => "st",
        (2, _) => "nd",
        (3, _) => "rd",
        _ => "th",
    };
    format!("{number}{ending}")
}

#[cfg(test)]
mod tests;
