//! What rounding can no longer tell apart becomes one.
//!
//! Coordinates of exact points that are nearer to each other than their rounding
//! errors make slivers whose triangles may intersect. Making such points one
//! keeps every boundary closed: it maps boundaries to boundaries.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use crate::label::Label;
use crate::mesh::back_and_front;
use crate::sets::Sets;

use super::{Origin, Skeleton};

/// Joins vertices that are chained by steps of at most `distance`, each to the
/// first of its group, and leaves out what has no area then. Says how many
/// vertices were joined.
pub(super) fn merge(skeleton: &mut Skeleton, distance: f64) -> u32 {
    let first = groups(&skeleton.mesh.vertices, distance);
    let joined = first.iter().enumerate().filter(|&(own, &first)| own as u32 != first).count();
    if joined == 0 {
        return 0;
    }
    for corner in skeleton.mesh.triangles.as_flattened_mut() {
        *corner = first[*corner as usize];
    }
    for end in skeleton.details.contours.as_flattened_mut() {
        *end = first[*end as usize];
    }
    skeleton.details.contours.retain(|[from, to]| from != to);
    cancel(skeleton);
    joined as u32
}

/// For every point the first of those that it is chained to.
fn groups(points: &[DVec3], distance: f64) -> Vec<u32> {
    let place = |point: DVec3| (point / distance).floor().as_i64vec3();
    let mut places: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
    for (index, &point) in points.iter().enumerate() {
        places.entry(place(point)).or_default().push(index as u32);
    }
    let mut sets = Sets::new(points.len());
    for (index, &point) in points.iter().enumerate() {
        for other in around(place(point)).filter_map(|place| places.get(&place)).flatten() {
            if points[*other as usize].distance(point) <= distance {
                sets.join(index as u32, *other);
            }
        }
    }
    sets.roots()
}

fn around(place: I64Vec3) -> impl Iterator<Item = I64Vec3> {
    (0..27).map(move |i| place + I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

/// Leaves out triangles with a corner twice. Of several with the same corners
/// what is left are steps from label to label that do not cancel.
pub(super) fn cancel(skeleton: &mut Skeleton) {
    let (triangles, sides) = (&skeleton.mesh.triangles, &skeleton.mesh.sides);
    let mut same: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    for (index, &corners) in triangles.iter().enumerate() {
        let sorted = sorted(corners);
        if sorted[0] != sorted[1] && sorted[1] != sorted[2] {
            same.entry(sorted).or_default().push(index);
        }
    }
    let mut kept: Vec<(usize, [u32; 3], [Label; 2])> = Vec::new();
    for (&corners, indices) in &same {
        if let [index] = indices[..] {
            kept.push((index, triangles[index], sides[index]));
            continue;
        }
        // As seen with the corners in ascending order.
        let steps = indices.iter().map(|&index| {
            let [back, front] = sides[index];
            if is_even(triangles[index]) { [back, front] } else { [front, back] }
        });
        for (step, &index) in left(steps).into_iter().zip(indices) {
            let ordered = back_and_front(step[0], step[1]);
            let [a, b, c] = corners;
            let turned = if ordered == step { [a, b, c] } else { [a, c, b] };
            kept.push((index, turned, ordered));
        }
    }
    kept.sort_unstable_by_key(|entry| entry.0);
    let origins: Vec<Origin> = kept.iter().map(|entry| skeleton.details.origins[entry.0]).collect();
    skeleton.mesh.triangles = kept.iter().map(|entry| entry.1).collect();
    skeleton.mesh.sides = kept.iter().map(|entry| entry.2).collect();
    skeleton.details.origins = origins;
}

/// Steps from label to label with the same beginnings and ends, without those
/// that cancel.
fn left(steps: impl Iterator<Item = [Label; 2]>) -> Vec<[Label; 2]> {
    let (mut begins, mut ends) = (Vec::new(), Vec::new());
    for [from, to] in steps {
        begins.push(from);
        ends.push(to);
    }
    begins.retain(|label| match ends.iter().position(|end| end == label) {
        Some(at) => {
            ends.swap_remove(at);
            false
        }
        None => true,
    });
    begins.sort_unstable();
    ends.sort_unstable();
    begins.into_iter().zip(ends).map(|(from, to)| [from, to]).collect()
}

fn sorted(mut corners: [u32; 3]) -> [u32; 3] {
    corners.sort_unstable();
    corners
}

/// Whether the corners are an even permutation of ascending ones.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    (a < b) == ((b < c) == (a < c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use crate::skeleton::{Details, Kind};

    #[test]
    fn permutations() {
        let even = [[0, 1, 2], [1, 2, 0], [2, 0, 1]];
        assert!(even.into_iter().all(is_even));
        assert!(![[0, 2, 1], [2, 1, 0], [1, 0, 2]].into_iter().any(is_even));
    }

    /// Two tetrahedra of labels 1 and 2 that nearly share a face.
    #[test]
    fn facing_triangles_become_one_border() {
        let gap = DVec3::new(1e-15, 0.0, 0.0);
        let mut mesh = Mesh::default();
        for (label, shift, x) in [(1, DVec3::ZERO, DVec3::X), (2, -gap, -DVec3::X)] {
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([DVec3::ZERO, DVec3::Y, DVec3::Z].map(|corner| corner + shift));
            mesh.vertices.push(x);
            let outward = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
            mesh.triangles.extend(outward.map(|[a, b, c]| {
                let [b, c] = if label == 1 { [b, c] } else { [c, b] };
                [a, b, c].map(|corner| corner + first)
            }));
            mesh.sides.extend([[Label(label), Label::OUTSIDE]; 4]);
        }
        let origin = Origin { kind: Kind::Roof, sections: [None; 2], cell: 0 };
        let origins = vec![origin; 8];
        let mut skeleton = Skeleton { mesh, details: Details { origins, ..Details::default() } };
        assert_eq!(merge(&mut skeleton, 1e-12), 3);
        let between: Vec<usize> =
            (0..7).filter(|&i| skeleton.mesh.sides[i] == [Label(1), Label(2)]).collect();
        assert_eq!((skeleton.mesh.triangles.len(), between.len()), (7, 1));
        for label in [1, 2] {
            let surface = skeleton.mesh.surface(Label(label));
            assert!(surface.open_edges().is_empty());
            assert!((surface.volume() - 1.0 / 6.0).abs() < 1e-12);
        }
    }
}
