//! The voxels that contours pass through.

use glam::DVec3;
use rayon::prelude::*;

use crate::label::Label;
use crate::section::Section;

use super::samples::Lattice;

/// Pieces of an edge are at most this long along every axis, in voxels: their
/// boxes then hold few voxels that the edge does not pass.
const PIECE: f64 = 0.5;
/// Boxes are grown by this much, in voxels, so that rounding loses no voxel.
const MARGIN: f64 = 1e-6;

/// The edges between two known labels, in space.
pub fn segments(section: &Section) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    let known = |label: Label| label != Label::UNKNOWN;
    section
        .edges()
        .iter()
        .filter(move |edge| known(edge.left) && known(edge.right))
        .map(|edge| [section.point(edge.start), section.point(edge.end)])
}

/// Every voxel of the lattice that a segment passes through, named by its
/// first node, sorted; now and then also a neighbour that it barely misses.
pub fn pierced_voxels(segments: &[[DVec3; 2]], lattice: &Lattice) -> Vec<[i32; 3]> {
    const CHUNK: usize = 256;
    let mut voxels: Vec<[i32; 3]> = segments
        .par_chunks(CHUNK)
        .flat_map_iter(|segments| {
            let mut voxels = Vec::new();
            for &segment in segments {
                rasterize(segment, lattice, &mut voxels);
            }
            voxels
        })
        .collect();
    voxels.par_sort_unstable();
    voxels.dedup();
    voxels
}

/// The eight nodes of a voxel.
pub fn corners(voxel: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (0..8).map(move |corner| {
        [voxel[0] + (corner >> 2), voxel[1] + (corner >> 1 & 1), voxel[2] + (corner & 1)]
    })
}

fn rasterize(segment: [DVec3; 2], lattice: &Lattice, voxels: &mut Vec<[i32; 3]>) {
    let [start, end] = segment.map(|point| (point - lattice.origin) / lattice.voxel);
    let last = DVec3::from(lattice.dims.map(|nodes| f64::from(nodes - 1)));
    let Some([start, end]) = clip(start, end, last) else { return };
    let pieces = ((end - start).abs().max_element() / PIECE).ceil().max(1.0) as u64;
    let mut from = start;
    for piece in 1..=pieces {
        let to = start.lerp(end, piece as f64 / pieces as f64);
        push_box(from.min(to), from.max(to), lattice, voxels);
        from = to;
    }
}

/// The part of a segment in the box from 0 to `last`.
fn clip(start: DVec3, end: DVec3, last: DVec3) -> Option<[DVec3; 2]> {
    let step = end - start;
    let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        if step[axis] == 0.0 {
            if !(0.0..=last[axis]).contains(&start[axis]) {
                return None;
            }
            continue;
        }
        let at = [-start[axis] / step[axis], (last[axis] - start[axis]) / step[axis]];
        enter = enter.max(at[0].min(at[1]));
        leave = leave.min(at[0].max(at[1]));
    }
    (enter <= leave).then(|| [start + enter * step, start + leave * step])
}

fn push_box(min: DVec3, max: DVec3, lattice: &Lattice, voxels: &mut Vec<[i32; 3]>) {
    let index = |value: f64, axis: usize| {
        (value.floor() as i64).clamp(0, i64::from(lattice.dims[axis]) - 2) as i32
    };
    let range = |axis| index(min[axis] - MARGIN, axis)..=index(max[axis] + MARGIN, axis);
    for x in range(0) {
        for y in range(1) {
            voxels.extend(range(2).map(|z| [x, y, z]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pierced(segment: [DVec3; 2]) -> Vec<[i32; 3]> {
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.5, dims: [11, 11, 11] };
        let mut voxels = Vec::new();
        rasterize(segment, &lattice, &mut voxels);
        voxels.sort_unstable();
        voxels.dedup();
        voxels
    }

    #[test]
    fn a_straight_edge_passes_a_row_of_voxels() {
        let found = pierced([DVec3::new(-0.9, -0.9, -0.9), DVec3::new(1.1, -0.9, -0.9)]);
        let expected: Vec<[i32; 3]> = (0..5).map(|x| [x, 0, 0]).collect();
        assert_eq!(found, expected);
    }

    #[test]
    fn no_voxel_along_a_slanted_edge_is_missed() {
        let [start, end] = [DVec3::new(-0.87, -0.3, 3.1), DVec3::new(3.7, 2.9, -0.6)];
        let found = pierced([start, end]);
        for step in 0..=10_000 {
            let point = (start.lerp(end, f64::from(step) / 10_000.0) + 1.0) / 0.5;
            let voxel = [point.x, point.y, point.z].map(|value| value.floor() as i32);
            assert!(found.binary_search(&voxel).is_ok());
        }
        // Along its longest axis the edge is 9.14 voxels long; boxes of half
        // voxels add some neighbours, but not many.
        assert!(found.len() < 60, "{}", found.len());
    }

    #[test]
    fn only_the_part_in_the_lattice_counts() {
        let far = DVec3::new(1e12, 0.1, 0.1);
        assert_eq!(pierced([DVec3::new(0.1, 0.1, 0.1), far]).len(), 8);
        assert!(pierced([DVec3::new(9.0, 0.0, 0.0), far]).is_empty());
    }
}
