//! A mesh made voxels: every voxel has the label in which its centre lies.

use rayon::prelude::*;

use super::Placement;
use crate::label::Label;
use crate::mesh::Mesh;
use crate::section::Here;

/// Where along a row the label changes.
#[derive(Debug, Clone, Copy)]
struct Change {
    row: u32,
    /// The first voxel whose centre is not before it.
    voxel: u32,
    from: Label,
    to: Label,
}

/// The label of every voxel, the first axis running fastest. What is on a border belongs to the
/// side with the larger index along the last axis, then the second, then the first.
///
/// Surfaces must be closed. Labels are at most [`Label::LARGEST`].
pub fn fill(mesh: &Mesh, dims: [usize; 3], placement: &Placement) -> Vec<u32> {
    let inverse = placement.steps.inverse();
    // Indices are coordinates; a lattice whose axes are left-handed turns triangles over.
    let is_turned = inverse.determinant() < 0.0;
    let vertices: Vec<[f64; 3]> = mesh
        .vertices
        .par_iter()
        .map(|&vertex| (inverse * (vertex - placement.origin)).to_array())
        .collect();
    let [width, height, depth] = dims;
    // The triangles that pass the centres of each slice.
    let mut passing: Vec<Vec<u32>> = vec![Vec::new(); depth];
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let heights = triangle.map(|vertex| vertices[vertex as usize][2]);
        let [low, high] = ends(heights);
        let slices = first_centre(low, depth)..first_centre(high, depth);
        passing[slices].iter_mut().for_each(|slice| slice.push(number as u32));
    }
    let mut labels = vec![0; width * height * depth];
    labels.par_chunks_mut((width * height).max(1)).zip(&passing).enumerate().for_each(
        |(slice, (voxels, triangles))| {
            let mut changes = Vec::new();
            for &number in triangles {
                let triangle = mesh.triangles[number as usize];
                let [back, front] = mesh.sides[number as usize];
                let sides = if is_turned { [front, back] } else { [back, front] };
                let segment = segment(triangle, &vertices, slice as f64);
                add(segment, sides, [width, height], &mut changes);
            }
            changes.sort_unstable_by_key(|change: &Change| (change.row, change.voxel));
            for row in changes.chunk_by(|one, other| one.row == other.row) {
                let start = row[0].row as usize * width;
                paint(row, &mut voxels[start..start + width]);
            }
        },
    );
    labels
}

fn ends(values: [f64; 3]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &value| {
        [low.min(value), high.max(value)]
    })
}

/// The first of so many centres, 0 and on, that is not before `at`.
fn first_centre(at: f64, count: usize) -> usize {
    at.ceil().clamp(0.0, count as f64) as usize
}

/// Where a triangle that passes the plane k = `height` cuts it, in i and j: from start to end with
/// its back on the left. Vertices on the plane count as below it, as for what passes a slice.
fn segment(triangle: [u32; 3], vertices: &[[f64; 3]], height: f64) -> [[f64; 2]; 2] {
    let corners = triangle.map(|vertex| vertices[vertex as usize]);
    let is_above = corners.map(|corner| corner[2] > height);
    let is_lone = |corner: usize| {
        is_above[corner] != is_above[(corner + 1) % 3]
            && is_above[corner] != is_above[(corner + 2) % 3]
    };
    let lone = (0..3).find(|&corner| is_lone(corner)).unwrap_or(0);
    let crossing = |other: usize| {
        // From the same end for both triangles at an edge, so that they meet to the last digit.
        let [one, other] = [lone, other % 3];
        let (from, to) = match triangle[one] < triangle[other] {
            true => (corners[one], corners[other]),
            false => (corners[other], corners[one]),
        };
        let part = (height - from[2]) / (to[2] - from[2]);
        [from[0] + part * (to[0] - from[0]), from[1] + part * (to[1] - from[1])]
    };
    let [first, second] = [crossing(lone + 1), crossing(lone + 2)];
    if is_above[lone] { [first, second] } else { [second, first] }
}

/// The changes on the rows that a segment crosses: those whose centres are in the half-open
/// interval from its lower to its higher end.
fn add(
    [start, end]: [[f64; 2]; 2],
    [left, right]: [Label; 2],
    [width, height]: [usize; 2],
    changes: &mut Vec<Change>,
) {
    // Left of a segment that goes up is before it along the row.
    let (low, high, from, to) = match start[1] < end[1] {
        true => (start, end, left, right),
        false => (end, start, right, left),
    };
    for row in first_centre(low[1], height)..first_centre(high[1], height) {
        let part = (row as f64 - low[1]) / (high[1] - low[1]);
        let at = low[0] + part * (high[0] - low[0]);
        let voxel = first_centre(at, width) as u32;
        changes.push(Change { row: row as u32, voxel, from, to });
    }
}

/// Gives the voxels of a row their labels.
fn paint(changes: &[Change], voxels: &mut [u32]) {
    let mut here = Here::new(Label::OUTSIDE);
    for (place, change) in changes.iter().enumerate() {
        here.change(change.from, change.to);
        let next = changes.get(place + 1).map_or(voxels.len(), |next| next.voxel as usize);
        let label = here.label();
        if label.is_material() {
            voxels[change.voxel as usize..next].fill(label.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DMat3, DVec3};

    use super::*;
    use crate::grid::samples::Lattice;
    use crate::mesh::dual;
    use crate::mesh::shapes::{samples, solid};
    use crate::progress::Silent;

    /// Asks of every voxel what it should be; those nearer to a border than `near` do not count.
    fn assert_filled(
        mesh: &Mesh,
        dims: [usize; 3],
        placement: Placement,
        wanted: impl Fn(DVec3) -> (u32, f64),
        near: f64,
    ) -> usize {
        let labels = fill(mesh, dims, &placement);
        let [width, height, _] = dims;
        let mut filled = 0;
        for (place, &label) in labels.iter().enumerate() {
            let index = [place % width, place / width % height, place / width / height];
            let at = placement.point(DVec3::from(index.map(|index| index as f64)));
            let (wanted, distance) = wanted(at);
            assert!(label == wanted || distance.abs() < near, "{at}: {label}, not {wanted}");
            filled += usize::from(label != 0);
        }
        filled
    }

    #[test]
    fn a_ball_in_lattices_of_any_orientation() {
        let ball = solid(61, 1.0, |point| 0.8 - point.length());
        let inside = |at: DVec3| (u32::from(at.length() < 0.8), at.length() - 0.8);
        let turned = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
        let steps = turned * DMat3::from_diagonal(DVec3::new(0.05, 0.08, 0.11));
        // Left-handed, too, and cut off in the middle of the ball.
        let mirrored = steps * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        for (steps, dims) in [(steps, [40, 25, 20]), (mirrored, [40, 25, 10])] {
            let middle = DVec3::new(19.5, 12.0, 9.5);
            let placement = Placement { origin: -(steps * middle), steps };
            let filled = assert_filled(&ball, dims, placement, inside, 0.01);
            let volume = 0.05 * 0.08 * 0.11 * filled as f64;
            let whole = 4.0 / 3.0 * std::f64::consts::PI * 0.512;
            let wanted = if dims[2] == 20 { whole } else { 0.5 * whole };
            assert!((volume / wanted - 1.0).abs() < 0.02, "{volume} of {wanted}");
        }
    }

    #[test]
    fn labels_that_touch_on_the_very_nodes() {
        let lattice = Lattice { origin: DVec3::splat(-1.0), voxel: 0.125, dims: [17; 3] };
        let samples = samples(lattice, |node| {
            let at = lattice.position(node);
            // The shares of the ball and of its lower half, as indicators.
            let share = |inside: f64| (2.0 * inside + 0.5).clamp(0.0, 1.0);
            let (ball, lower) = (share(0.7 - at.length()), share(-at.x));
            [ball * lower, ball * (1.0 - lower)].map(|share| (2.0 * share - 1.0) as f32).to_vec()
        });
        let mesh = dual(&samples, &Silent).unwrap();
        let steps = DMat3::from_diagonal(DVec3::splat(0.125));
        let placement = Placement { origin: DVec3::splat(-1.0), steps };
        let halves = |at: DVec3| {
            let label = if at.length() > 0.7 {
                0
            } else if at.x < 0.0 {
                1
            } else {
                2
            };
            (label, (at.length() - 0.7).abs().min(at.x.abs()))
        };
        assert_filled(&mesh, [17; 3], placement, halves, 0.03);
    }

    /// Sections' planes pass through vertices of results, and where slices are drawn those are the
    /// slices of the lattice, too.
    #[test]
    fn vertices_on_the_very_nodes() {
        let corner = |x, y, z| 4.0 + 3.0 * DVec3::new(x, y, z);
        let vertices = [-1.0, 1.0]
            .into_iter()
            .flat_map(|side| {
                [corner(side, 0.0, 0.0), corner(0.0, side, 0.0), corner(0.0, 0.0, side)]
            })
            .collect();
        let mut triangles = Vec::new();
        for [x, y, z] in [[0, 1, 2], [3, 4, 2], [3, 1, 5], [0, 4, 5]] {
            // The opposite of each, which faces the other way, is turned.
            let opposite = [x, y, z].map(|vertex| (vertex + 3) % 6);
            triangles.extend([[x, z, y], opposite]);
        }
        let sides = vec![[Label(1), Label::OUTSIDE]; triangles.len()];
        let octahedron = Mesh { vertices, triangles, sides };
        let inside = |at: DVec3| {
            let distance = (at - 4.0).abs().element_sum() - 3.0;
            (u32::from(distance < 0.0), distance)
        };
        for turned in [DVec3::ONE, DVec3::new(1.0, 1.0, -1.0)] {
            let steps = DMat3::from_diagonal(turned);
            let origin = 4.0 - 4.0 * turned;
            let filled =
                assert_filled(&octahedron, [9; 3], Placement { origin, steps }, inside, 1e-9);
            assert!(filled >= 25, "{filled}");
        }
    }
}
