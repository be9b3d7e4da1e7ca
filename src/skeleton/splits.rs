//! Points on contours that the triangles on one side have and those on the other
//! do not.

use std::collections::{BTreeMap, HashMap};

use super::Skeleton;

/// A point between the ends of a contour's piece: `[from, to, point]`.
pub(super) type Split = [u32; 3];

/// Divides triangles so that all at a contour's piece have all points on it.
pub(super) fn divide(skeleton: &mut Skeleton, splits: &[Split]) {
    let mut on: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for &[from, to, point] in splits {
        on.entry([from.min(to), from.max(to)]).or_default().push(point);
    }
    let chains = chains(skeleton, on);
    let contours = std::mem::take(&mut skeleton.details.contours);
    for [mut from, to] in contours {
        while let Some(&point) = chains.get(&[from, to]) {
            skeleton.details.contours.push([from, point]);
            from = point;
        }
        skeleton.details.contours.push([from, to]);
    }
    let mut index = 0;
    while index < skeleton.mesh.triangles.len() {
        // What is divided is looked at again: another side may be on a piece.
        if !divide_one(skeleton, &chains, index) {
            index += 1;
        }
    }
}

/// For every two points of a piece that are not neighbours the first one between
/// them.
fn chains(skeleton: &mut Skeleton, on: BTreeMap<[u32; 2], Vec<u32>>) -> HashMap<[u32; 2], u32> {
    let mut between = HashMap::new();
    for ([from, to], points) in on {
        let chain = chain(skeleton, from, to, points);
        for first in 0..chain.len() {
            for last in first + 2..chain.len() {
                between.insert([chain[first], chain[last]], chain[first + 1]);
                between.insert([chain[last], chain[first]], chain[last - 1]);
            }
        }
    }
    between
}

/// All points of a piece in order. Cells on both sides may have made the same
/// one: then triangles get the first.
fn chain(skeleton: &mut Skeleton, from: u32, to: u32, mut points: Vec<u32>) -> Vec<u32> {
    let vertices = &skeleton.mesh.vertices;
    let place = |point: u32| vertices[point as usize];
    let along = |point: u32| (place(point) - place(from)).dot(place(to) - place(from));
    points.extend([from, to]);
    points.sort_by(|&one, &other| along(one).total_cmp(&along(other)).then(one.cmp(&other)));
    points.dedup();
    let same = |one: u32, other: u32| place(one) == place(other);
    let mut instead: HashMap<u32, u32> = HashMap::new();
    let mut kept: Vec<u32> = Vec::new();
    for point in points {
        match kept.last() {
            Some(&last) if same(last, point) => {
                instead.insert(point, last);
            }
            _ => kept.push(point),
        }
    }
    if !instead.is_empty() {
        for corner in skeleton.mesh.triangles.as_flattened_mut() {
            *corner = instead.get(corner).copied().unwrap_or(*corner);
        }
    }
    kept
}

/// Whether a side of the triangle had a point on it: then the triangle becomes
/// two.
fn divide_one(skeleton: &mut Skeleton, between: &HashMap<[u32; 2], u32>, index: usize) -> bool {
    let [a, b, c] = skeleton.mesh.triangles[index];
    for [from, to, apex] in [[a, b, c], [b, c, a], [c, a, b]] {
        let Some(&point) = between.get(&[from, to]) else { continue };
        skeleton.mesh.triangles[index] = [from, point, apex];
        skeleton.mesh.triangles.push([point, to, apex]);
        skeleton.mesh.sides.push(skeleton.mesh.sides[index]);
        skeleton.details.origins.push(skeleton.details.origins[index]);
        return true;
    }
    false
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::label::Label;
    use crate::mesh::Mesh;
    use crate::skeleton::{Details, Kind, Origin};

    /// Two triangles over the piece from 0 to 1, one of which has its middle 4.
    #[test]
    fn both_sides_get_the_point() {
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::Y, 0.5 * DVec3::X];
        let triangles = vec![[0, 1, 2], [1, 4, 3], [4, 0, 3]];
        let sides = vec![[Label(1), Label::OUTSIDE]; 3];
        let origin = Origin { kind: Kind::Wall, sections: [None; 2], cell: 0 };
        let mesh = Mesh { vertices, triangles, sides };
        let details = Details { origins: vec![origin; 3], ..Details::default() };
        let mut skeleton = Skeleton { mesh, details };
        divide(&mut skeleton, &[[1, 0, 4]]);
        let expected = [[0, 4, 2], [1, 4, 3], [4, 0, 3], [4, 1, 2]];
        assert_eq!(skeleton.mesh.triangles, expected);
        assert_eq!(skeleton.details.origins.len(), 4);
    }
}
