//! Where a field is solved for: the lattices, from coarse to fine, and what there is
//! nothing beyond.

use glam::{DVec3, IVec3};

use crate::error::Result;
use crate::grid::frame::Frame;
use crate::grid::samples::Lattice;
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::section::Section;
use crate::section::ends::{End, ends};
use crate::section::reach::{reaches_with, space};

/// Voxels on the longest side of the wide box on the second level, at least.
const WHOLE_VOXELS: f64 = 48.0;
/// How far that box reaches beyond contours within their planes, relative to the
/// diagonal of them all. The given one is near to the surface; half way between two
/// sections the −d on its faces, whose d is larger there, would draw a waist.
const WIDE: f64 = 0.15;
/// How far beyond the last sections of a stack, in spacings: what is −d there is 0
/// a little less than half a spacing beyond.
const BEYOND: f64 = 1.25;
/// Nodes there are to be at least then, in a box that is long.
const WHOLE_NODES: f64 = 45_000.0;
/// Levels between that one and the given lattice have so many voxels on the longest side
/// of the box that is filled, or 2, 4, 8 … times as many: whatever is asked for, the
/// shape comes from the same levels.
const NARROW_VOXELS: f64 = 64.0;
/// The next finer level has voxels smaller by this factor at least, but for the given
/// lattice.
const STEP: f64 = 1.3;
/// The coarse lattices have voxels of one of so many sizes to a doubling, and reach beyond the
/// box that is filled by multiples of so many voxels: so another section leaves them as they
/// are, mostly, and with them what is far from it.
const SIZES_OF_DOUBLING: f64 = 4.0;
const VOXELS_OF_MARGIN: f64 = 4.0;
/// By how much of a voxel a node may be beyond an end, for rounding; other lengths by as large
/// a part of them.
const ROUNDING: f64 = 1e-6;

/// Where is solved.
pub struct Space {
    /// The box that the result fills, and the given lattice.
    pub frame: Frame,
    /// The box of the coarse lattices.
    pub wide: Bounds,
    /// From the coarsest to the given one.
    pub lattices: Vec<Lattice>,
    /// So many of them cover the wide box, at least two: there it is decided how parts hang
    /// together.
    pub whole: usize,
    /// Beyond them the field is given: the faces of the wide box before it was rounded, and the
    /// ends of a stack that leans, which has that box's corners there.
    wide_ends: Vec<Plane>,
    /// Beyond them, as far away as the given box is from an upright stack, all but the
    /// coarse lattices have what is interpolated.
    ends: Vec<Plane>,
}

impl Space {
    /// Around sections, with a wide box unless the given one is open.
    pub fn around(sections: &[Section], border: Label, frame: &Frame) -> Result<Self> {
        let wide = space(sections, WIDE, BEYOND).filter(|_| border != Label::UNKNOWN);
        let Some(wide) = wide else { return Self::new(frame, frame.bounds) };
        let wide = frame.bounds.union(wide);
        let reaches = reaches_with(sections, WIDE);
        let all = ends(sections);
        let wide_end = |end: &End| end.beyond(BEYOND * reaches[end.section]);
        let wide_ends = all.iter().map(wide_end).chain(wide.faces()).collect();
        let ends = all.iter().map(|end| end.beyond(end.reach)).collect();
        Ok(Self { wide_ends, ends, ..Self::new(frame, wide)? })
    }

    /// The given lattice is itself one of those that cover the wide box when it is as coarse as
    /// these would be.
    pub fn new(frame: &Frame, wide: Bounds) -> Result<Self> {
        let Frame { bounds, lattice: finest, is_fixed } = *frame;
        let coarse = coarse_voxel(frame.size(), wide);
        let wide = match is_fixed {
            true => wide,
            false => rounded(wide, bounds, VOXELS_OF_MARGIN * coarse),
        };
        let is_coarse = finest.voxel >= coarse;
        let whole = if is_coarse { finest.voxel } else { coarse };
        let second = if is_coarse { finest } else { frame.over(wide, whole)? };
        let mut lattices = vec![frame.over(wide, 2.0 * whole)?, second];
        let mut voxel = frame.size() / NARROW_VOXELS;
        while voxel >= finest.voxel * STEP {
            if voxel * STEP < whole {
                lattices.push(frame.over(bounds, voxel)?);
            }
            voxel /= 2.0;
        }
        if !is_coarse {
            lattices.push(finest);
        }
        let (wide_ends, ends) = Default::default();
        Ok(Self { frame: *frame, wide, lattices, whole: 2, wide_ends, ends })
    }

    /// Where sections are sampled on a level, and from where on: in the box, or, so that no leaf
    /// gets more of them when a box with fixed lattices grows, on all of the lattice.
    pub fn sampled(&self, lattice: &Lattice) -> (Bounds, DVec3) {
        let bounds = match (self.frame.is_fixed, self.is_wide(lattice)) {
            (true, _) => {
                let last = lattice.dims.map(|nodes| nodes - 1);
                Bounds { min: lattice.origin, max: lattice.position(last) }
            }
            (false, true) => self.wide,
            (false, false) => self.frame.bounds,
        };
        (bounds, self.frame.center())
    }

    /// Beyond these nothing is solved for, on the given box and on the wide one.
    pub fn ends(&self) -> [&[Plane]; 2] {
        [&self.ends, &self.wide_ends]
    }

    /// Whether nodes of a lattice are beyond an end. So many are asked for that it is a
    /// matter of a product.
    pub fn beyond(&self, lattice: &Lattice) -> impl Fn([i32; 3]) -> bool + use<> {
        Self::beyond_ends(self.ends()[usize::from(self.is_wide(lattice))], lattice)
    }

    /// The same for ends of other sections.
    pub fn beyond_ends(ends: &[Plane], lattice: &Lattice) -> impl Fn([i32; 3]) -> bool + use<> {
        let in_nodes = |end: &Plane| {
            let height = -end.distance(lattice.origin) / lattice.voxel;
            (end.unit_normal(), height + ROUNDING)
        };
        let ends: Vec<(DVec3, f64)> = ends.iter().map(in_nodes).collect();
        move |node| {
            let node = IVec3::from_array(node).as_dvec3();
            ends.iter().any(|&(normal, height)| normal.dot(node) > height)
        }
    }

    /// Whether a lattice is one over the wide box.
    pub fn is_wide(&self, lattice: &Lattice) -> bool {
        let finest = self.lattices.last().map_or(0.0, |finest| finest.voxel);
        lattice.voxel >= self.lattices[self.whole - 1].voxel && lattice.voxel > finest
    }
}

/// The voxels of a lattice on the wide box. One that is no wider than the `size` of the box that
/// is filled has [`WHOLE_VOXELS`], but for its volume.
fn coarse_voxel(size: f64, wide: Bounds) -> f64 {
    let wanted =
        (wide.size().max_element() / WHOLE_VOXELS).min((wide.volume() / WHOLE_NODES).cbrt());
    let unit = size / WHOLE_VOXELS;
    let steps = (SIZES_OF_DOUBLING * (wanted / unit).log2() + ROUNDING).floor();
    unit * (steps / SIZES_OF_DOUBLING).exp2()
}

/// The smallest box around another one whose faces are multiples of a length beyond those of
/// a third, inside.
fn rounded(wide: Bounds, inside: Bounds, length: f64) -> Bounds {
    let beyond = |margin: DVec3| (margin / length - ROUNDING).ceil().max(DVec3::ZERO) * length;
    Bounds {
        min: inside.min - beyond(inside.min - wide.min),
        max: inside.max + beyond(wide.max - inside.max),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::lattice::Resolution;

    #[test]
    fn a_wider_box_mostly_has_the_same_lattices() {
        let bounds = Bounds { min: DVec3::ZERO, max: DVec3::new(1.0, 0.9, 0.8) };
        let frame = Frame::new(bounds, Resolution::Voxels(256)).unwrap();
        // One that is not wider has all levels.
        let same = Space::new(&frame, bounds).unwrap();
        assert_eq!(same.wide, bounds);
        let has = |space: &Space, voxels: f64| {
            space.lattices.iter().any(|lattice| (lattice.voxel * voxels - 1.0).abs() < 1e-9)
        };
        assert!(has(&same, 48.0) && has(&same, 64.0) && has(&same, 128.0));
        let spaces: Vec<Space> = (0..100)
            .map(|step| bounds.grown(0.1 + 0.001 * f64::from(step)))
            .map(|wide| {
                let space = Space::new(&frame, wide).unwrap();
                assert_eq!(space.wide.union(wide), space.wide);
                assert!(space.lattices[1].voxel <= wide.size().max_element() / WHOLE_VOXELS);
                space
            })
            .collect();
        let differs = |pair: &&[Space]| pair[0].lattices != pair[1].lattices;
        assert!(spaces.windows(2).filter(differs).count() < 10);
    }

    #[test]
    fn the_last_lattice_is_the_given_one_and_those_before_are_always_the_same() {
        for size in [DVec3::ONE, DVec3::new(1.0, 0.3, 0.2), DVec3::new(0.6, 1.0, 1.0)] {
            let bounds = Bounds { min: -size, max: size };
            let wide = bounds.grown(0.3);
            let spaces = (16..=300).map(|voxels| {
                let frame = Frame::new(bounds, Resolution::Voxels(voxels)).unwrap();
                let space = Space::new(&frame, wide).unwrap();
                assert_eq!(space.lattices.last(), Some(&frame.lattice), "{voxels}");
                let [before @ .., _] = &space.lattices[..] else { panic!() };
                assert!(before.is_sorted_by(|a, b| a.voxel >= b.voxel * STEP));
                assert!(space.lattices.is_sorted_by(|a, b| a.voxel > b.voxel));
                space
            });
            let spaces: Vec<Space> = spaces.collect();
            let [.., largest] = &spaces[..] else { panic!() };
            for space in spaces.iter().filter(|space| space.lattices.len() > 2) {
                let given = space.lattices.len() - 1;
                assert_eq!(space.lattices[..given], largest.lattices[..given]);
            }
        }
    }
}
