//! Which slices of a volume, or pictures of a stack, somebody drew on.
//!
//! Between slices that were drawn lie empty ones, of which nothing is known. A voxel that was
//! drawn on a slice has neighbours on it, and none on either side of it:
//!
//! ```text
//!   ··········       a drawn slice, seen from its side; where another one crosses it, voxels
//!   ####|#####       have neighbours everywhere and tell nothing
//!   ····|·····
//! ```

use rayon::prelude::*;

use super::LabelVolume;

/// Of all voxels of materials, this part is on drawn slices when there are such.
const COVERED: f64 = 0.9;
/// Runs of neighbouring slices that are at most this long in the median are drawn by hand, with
/// empty slices between them.
const RUN: usize = 2;

/// The slices that show something.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Drawn {
    /// Those of each axis that were drawn; nothing is known of all others.
    Sparse([Vec<usize>; 3]),
    /// All that are in the reach of materials, along the axis: empty ones are outside.
    Full(usize),
}

/// The slices of a stack that show something, by which of them are not empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Shown {
    /// These; nothing is known of the empty ones between them.
    Sparse(Vec<usize>),
    /// All from the first to the last that is not empty.
    Full(std::ops::Range<usize>),
}

/// What a stack shows. Slices by hand are few, with empty ones between: few in a row.
pub fn shown(is_filled: &[bool]) -> Shown {
    let filled: Vec<usize> = (0..is_filled.len()).filter(|&slice| is_filled[slice]).collect();
    let mut runs: Vec<usize> =
        filled.chunk_by(|one, next| one + 1 == *next).map(<[usize]>::len).collect();
    runs.sort_unstable();
    match (filled.first(), filled.last()) {
        (Some(&first), Some(&last)) if runs.len() < 2 || runs[runs.len() / 2] > RUN => {
            Shown::Full(first..last + 1)
        }
        _ => Shown::Sparse(filled),
    }
}

impl LabelVolume {
    /// The slices that were drawn, on one axis or on those on which there are any.
    pub(super) fn drawn(&self, axis: Option<usize>) -> Drawn {
        let axes: Vec<usize> = axis.map_or_else(|| vec![2, 1, 0], |axis| vec![axis]);
        let counts = self.counts();
        let mut flat = [0, 1, 2].map(|axis| counts.drawn(axis));
        if self.covered(&flat) >= COVERED {
            let used: Vec<usize> = (0..3).filter(|&axis| !flat[axis].is_empty()).collect();
            if let [only] = used[..] {
                // What is a line or a point there tells no axis, but there is no other.
                flat[only] = counts.filled(only);
            }
            (0..3).filter(|other| !axes.contains(other)).for_each(|other| flat[other].clear());
            if flat.iter().any(|slices| !slices.is_empty()) {
                return Drawn::Sparse(flat);
            }
        }
        for &axis in &axes {
            let is_filled: Vec<bool> = counts.slices[axis].iter().map(|one| one.all > 0).collect();
            if let Shown::Sparse(slices) = shown(&is_filled) {
                let mut drawn: [Vec<usize>; 3] = Default::default();
                drawn[axis] = slices;
                return Drawn::Sparse(drawn);
            }
        }
        Drawn::Full(axis.unwrap_or_else(|| self.longest()))
    }

    /// The axis with the longest step; of equals the last, along which most programs draw.
    fn longest(&self) -> usize {
        let lengths = [0, 1, 2].map(|axis| self.placement.steps.col(axis).length());
        let longest = lengths.into_iter().fold(0.0, f64::max);
        // As long but for rounding.
        (0..3).rev().find(|&axis| lengths[axis] > (1.0 - 1e-6) * longest).unwrap_or(2)
    }

    /// The part of all voxels of materials that is on some slices.
    fn covered(&self, slices: &[Vec<usize>; 3]) -> f64 {
        let uncovered = self.uncovered(slices).map_or(0, |(count, _)| count);
        1.0 - uncovered as f64 / self.counts_of_materials().max(1) as f64
    }

    fn counts_of_materials(&self) -> usize {
        self.labels.par_iter().filter(|&&label| label != 0).count()
    }

    /// How many voxels of materials are on none of some slices, and the first of them.
    pub(super) fn uncovered(&self, slices: &[Vec<usize>; 3]) -> Option<(usize, [usize; 3])> {
        let is_drawn = [0, 1, 2].map(|axis| {
            let mut is_drawn = vec![false; self.dims[axis]];
            slices[axis].iter().for_each(|&slice| is_drawn[slice] = true);
            is_drawn
        });
        let [x, y, _] = self.dims;
        let rows = self.labels.par_chunks(x.max(1)).enumerate();
        let found = rows.filter(|(row, _)| !is_drawn[1][row % y] && !is_drawn[2][row / y]);
        found
            .flat_map_iter(|(row, voxels)| {
                let missed = voxels.iter().enumerate();
                let missed = missed.filter(|&(i, &label)| label != 0 && !is_drawn[0][i]);
                missed.map(move |(i, _)| [i, row % y, row / y])
            })
            .map(|voxel| (1, voxel))
            .reduce_with(|one, next| {
                let first = [one.1, next.1].into_iter().min_by_key(|&[i, j, k]| [k, j, i]);
                (one.0 + next.0, first.unwrap_or(one.1))
            })
    }

    /// Counts voxels of materials by slice.
    fn counts(&self) -> Counts {
        let Some([low, high]) = self.occupied else { return Counts::new(self.dims) };
        let layers = (low[2]..=high[2]).into_par_iter();
        let count = |mut counts: Counts, k: usize| {
            for j in low[1]..=high[1] {
                for i in low[0]..=high[0] {
                    let voxel = [i, j, k];
                    if self.label(voxel.map(|index| index as i64)) != 0 {
                        counts.add(voxel, self.flat(voxel));
                    }
                }
            }
            counts
        };
        layers.fold(|| Counts::new(self.dims), count).reduce(|| Counts::new(self.dims), Counts::sum)
    }

    /// Along which axes a voxel has no neighbour of a material.
    fn flat(&self, voxel: [usize; 3]) -> [bool; 3] {
        let at = voxel.map(|index| index as i64);
        std::array::from_fn(|axis| {
            [-1, 1].into_iter().all(|step| {
                let mut neighbor = at;
                neighbor[axis] += step;
                self.label(neighbor) == 0
            })
        })
    }
}

/// Voxels of materials.
#[derive(Debug, Clone, Default)]
struct Slice {
    all: usize,
    /// Those that are flat along the slices' axis alone.
    drawn: usize,
    /// Those that are flat along two axes or three: on lines and points.
    unclear: usize,
}

/// By the axis and the index of slices.
#[derive(Debug)]
struct Counts {
    slices: [Vec<Slice>; 3],
}

impl Counts {
    fn new(dims: [usize; 3]) -> Self {
        Self { slices: dims.map(|dim| vec![Slice::default(); dim]) }
    }

    fn add(&mut self, voxel: [usize; 3], flat: [bool; 3]) {
        let is_unclear = flat.iter().filter(|&&flat| flat).count() > 1;
        for axis in 0..3 {
            let slice = &mut self.slices[axis][voxel[axis]];
            slice.all += 1;
            slice.drawn += usize::from(flat[axis] && !is_unclear);
            slice.unclear += usize::from(is_unclear);
        }
    }

    fn sum(mut self, other: Self) -> Self {
        let pairs = self.slices.iter_mut().flatten().zip(other.slices.iter().flatten());
        for (slice, more) in pairs {
            slice.all += more.all;
            slice.drawn += more.drawn;
            slice.unclear += more.unclear;
        }
        self
    }

    /// The slices most of which is flat.
    fn drawn(&self, axis: usize) -> Vec<usize> {
        let slices = self.slices[axis].iter().enumerate();
        let drawn = slices
            .filter(|(_, slice)| slice.drawn > 0 && 2 * slice.drawn >= slice.all - slice.unclear);
        drawn.map(|(index, _)| index).collect()
    }

    fn filled(&self, axis: usize) -> Vec<usize> {
        let slices = self.slices[axis].iter().enumerate();
        slices.filter(|(_, slice)| slice.all > 0).map(|(index, _)| index).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_slices_in_a_row_are_drawn_by_hand() {
        let shown = |text: &str| {
            let is_filled: Vec<bool> = text.chars().map(|letter| letter == '#').collect();
            shown(&is_filled)
        };
        assert_eq!(shown("··#··#··##·"), Shown::Sparse(vec![2, 5, 8, 9]));
        assert_eq!(shown("·####·"), Shown::Full(1..5));
        assert_eq!(shown("·#·"), Shown::Full(1..2));
        // Two solids, one behind the other.
        assert_eq!(shown("####··####"), Shown::Full(0..10));
        assert_eq!(shown("···"), Shown::Sparse(vec![]));
    }
}
