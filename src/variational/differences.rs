//! Where sections that went and others that came say something else.

use glam::DVec3;

use crate::grid::leaf_grid::LeafSet;
use crate::grid::samples::Lattice;
use crate::plane::Bounds;
use crate::section::{Edge, Section};

use super::kept::REACH;
use super::level::{Level, near_points};
use super::plane_samples::{PlaneSample, Region, plane_samples};

/// How far samples of planes are apart, in nodes, where all of them are new: less than
/// [`REACH`].
const APART: f64 = 2.0;

/// The leaves of a level near which sections that went and others that came differ; `space` is
/// that of [`plane_samples`].
pub fn mark_differences(
    [went, came]: &[Vec<Section>; 2],
    space: (Bounds, DVec3),
    level: &Level,
    marked: &mut LeafSet,
) {
    let Lattice { origin, voxel, .. } = level.lattice;
    let mut mark = |places: Vec<DVec3>| {
        let in_nodes = |at: DVec3| ((at - origin) / voxel).to_array();
        let places: Vec<[f64; 3]> = places.into_iter().map(in_nodes).collect();
        for leaf in near_points(&places, REACH) {
            marked.insert(leaf);
        }
    };
    let sampled = |section: &Section, spacing: f64| {
        plane_samples(std::slice::from_ref(section), space, spacing, Region::Everywhere)
    };
    let mut went: Vec<&Section> = went.iter().collect();
    for section in came {
        match went.iter().position(|other| other.plane() == section.plane()) {
            Some(other) => {
                let both = [went.swap_remove(other), section];
                mark(differing_samples(both.map(|section| sampled(section, voxel))));
                mark(differing_contours(both, voxel));
            }
            None => went.push(section),
        }
    }
    for section in went {
        mark(sampled(section, APART * voxel).iter().map(|sample| sample.at).collect());
        mark(section.segments().flat_map(|ends| points_between(ends, voxel)).collect());
    }
}

/// Where two lists of samples of one plane differ; everywhere if they are not at the same
/// places, as where another part of the plane is known.
fn differing_samples([was, is]: [Vec<PlaneSample>; 2]) -> Vec<DVec3> {
    let at = |sample: &PlaneSample| sample.at;
    if !was.iter().map(at).eq(is.iter().map(at)) {
        return was.iter().chain(&is).map(at).collect();
    }
    let pairs = was.iter().zip(&is).filter(|(was, is)| was.label != is.label);
    pairs.map(|(_, is)| is.at).collect()
}

/// Points on the contours that one of two sections has and the other has not, or has between
/// other labels.
fn differing_contours(sections: [&Section; 2], spacing: f64) -> Vec<DVec3> {
    let [was, is] = sections.map(|section| {
        let contour = |edge: &Edge| {
            let Edge { start, end, left, right } = *edge;
            let ends =
                [start, end].map(|vertex| section.point(vertex).to_array().map(f64::to_bits));
            match ends[0] <= ends[1] {
                true => (ends, [left, right]),
                false => ([ends[1], ends[0]], [right, left]),
            }
        };
        let mut contours: Vec<_> = section.edges().iter().map(contour).collect();
        contours.sort_unstable();
        contours
    });
    let place = |bits: [u64; 3]| DVec3::from_array(bits.map(f64::from_bits));
    let differing = not_common(&was, &is).into_iter();
    differing.flat_map(|(ends, _)| points_between(ends.map(place), spacing)).collect()
}

/// The ends of a segment and points between them, no farther apart than a spacing.
fn points_between([from, to]: [DVec3; 2], spacing: f64) -> impl Iterator<Item = DVec3> {
    let steps = (from.distance(to) / spacing).ceil().max(1.0) as u32;
    (0..=steps).map(move |step| from.lerp(to, f64::from(step) / f64::from(steps)))
}

/// What only one of two sorted lists has.
fn not_common<T: Ord + Copy>(one: &[T], other: &[T]) -> Vec<T> {
    let without = |all: &[T], others: &[T]| -> Vec<T> {
        all.iter().filter(|own| others.binary_search(own).is_err()).copied().collect()
    };
    [without(one, other), without(other, one)].concat()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::shapes::{disc, partition, rectangle};
    use crate::grid::lattice::Resolution;
    use crate::label::Label;
    use crate::plane::Plane;

    const BOX: Bounds = Bounds { min: DVec3::splat(-1.0), max: DVec3::splat(1.0) };
    const PLANE: Plane = Plane { normal: DVec3::Z, offset: 0.01 };

    /// The leaves, of side ¼, that are marked.
    fn marked(went: Option<&Section>, came: Option<&Section>) -> Vec<[i32; 3]> {
        let level = Level::new(Lattice::new(BOX, Resolution::Voxels(64)).unwrap(), false);
        let mut marked = LeafSet::new(&level.grid);
        let changed = [went, came].map(|section| section.into_iter().cloned().collect());
        mark_differences(&changed, (BOX, DVec3::ZERO), &level, &mut marked);
        marked.sorted()
    }

    #[test]
    fn what_is_the_same_on_a_plane_is_not_marked() {
        let big = |half: f64| (rectangle([-half; 2], [half; 2]), [Label(1), Label::OUTSIDE]);
        // Smaller than a voxel: no sample needs to be in it.
        let small = |label: Label| (rectangle([0.5; 2], [0.505; 2]), [label, Label(1)]);
        let section = |polygons: &[_]| partition(PLANE, polygons, Label::OUTSIDE);
        let was = section(&[big(0.8), small(Label(2))]);
        assert!(marked(Some(&was), Some(&was)).is_empty());
        // A part becomes another label.
        let relabelled = section(&[big(0.8), small(Label(3))]);
        let found = marked(Some(&was), Some(&relabelled));
        assert!(!found.is_empty() && found.len() <= 8, "{found:?}");
        let low = |leaf: &[i32; 3]| leaf.map(|along| -1.0 + 0.25 * f64::from(along));
        assert!(
            found.iter().map(low).all(|[x, y, _]| (x - 0.5).abs() < 0.3 && (y - 0.5).abs() < 0.3)
        );
        // One moves: all along its contour, not in its middle.
        let moved = marked(Some(&was), Some(&section(&[big(0.75), small(Label(2))])));
        assert!(moved.len() > 16 && !moved.contains(&[4, 4, 4]), "{moved:?}");
    }

    #[test]
    fn a_section_without_a_counterpart_is_marked_all_over() {
        let section = disc(PLANE, 0.3, 40, Label(1));
        let [came, went] = [marked(None, Some(&section)), marked(Some(&section), None)];
        assert_eq!(came, went);
        for x in 0..8 {
            assert!((0..8).all(|y| came.contains(&[x, y, 4])));
        }
        assert!(came.iter().all(|leaf| (3..=5).contains(&leaf[2])));
        // Other parts of the plane are known: anything may differ.
        let mut partial = section.clone();
        partial.background = Label::UNKNOWN;
        partial.edges.iter_mut().for_each(|edge| edge.right = Label::UNKNOWN);
        assert!(marked(Some(&partial), Some(&section)).contains(&[4, 4, 4]));
    }
}
