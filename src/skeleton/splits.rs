//! Points on contours that the triangles on one side have and those on the other
//! do not.

use std::collections::{BTreeMap, HashMap};

use super::{Skeleton, merge};
use crate::mesh::Mesh;
use crate::sets::components;

/// A point between the ends of a contour's piece: `[from, to, point]`.
pub(super) type Split = [u32; 3];

/// Divides triangles so that all at a contour's piece have all points on it.
pub(super) fn fit(skeleton: &mut Skeleton, splits: &[Split]) {
    let mut on: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for &[from, to, point] in splits {
        on.entry([from.min(to), from.max(to)]).or_default().push(point);
    }
    let mut chains: Vec<Vec<u32>> =
        on.into_iter().map(|(ends, points)| chain(&skeleton.mesh, ends, points)).collect();
    unite(skeleton, &mut chains);
    divide(skeleton, &chains);
}

/// Divides triangles so that all at the points of a chain, one after the other on a line,
/// have all those that are between two of their corners.
pub(super) fn divide(skeleton: &mut Skeleton, chains: &[Vec<u32>]) {
    let between = between(chains);
    let contours = std::mem::take(&mut skeleton.details.contours);
    for [mut from, to] in contours {
        while let Some(&point) = between.get(&[from, to]) {
            skeleton.details.contours.push([from, point]);
            from = point;
        }
        skeleton.details.contours.push([from, to]);
    }
    let mut index = 0;
    while index < skeleton.mesh.triangles.len() {
        // What is divided is looked at again: another side may be on a piece.
        if !divide_one(skeleton, &between, index) {
            index += 1;
        }
    }
}

/// For every two points of a chain that are not neighbours the first one between
/// them.
fn between(chains: &[Vec<u32>]) -> HashMap<[u32; 2], u32> {
    let mut between = HashMap::new();
    for chain in chains {
        for first in 0..chain.len() {
            for last in first + 2..chain.len() {
                between.insert([chain[first], chain[last]], chain[first + 1]);
                between.insert([chain[last], chain[first]], chain[last - 1]);
            }
        }
    }
    between
}

/// All points of a piece in order.
fn chain(mesh: &Mesh, [from, to]: [u32; 2], mut points: Vec<u32>) -> Vec<u32> {
    let place = |point: u32| mesh.vertices[point as usize];
    let along = |point: u32| (place(point) - place(from)).dot(place(to) - place(from));
    points.extend([from, to]);
    // Those at one place are neighbours, also where rounding has others as far along.
    let order = |point: u32| [along(point), place(point).x, place(point).y, place(point).z];
    let compare = |one: [f64; 4], other: [f64; 4]| {
        let pairs = one.into_iter().zip(other);
        pairs.map(|(one, other)| one.total_cmp(&other)).find(|order| order.is_ne())
    };
    points.sort_by(|&one, &other| {
        compare(order(one), order(other)).unwrap_or_else(|| one.cmp(&other))
    });
    points.dedup();
    points
}

/// Makes one of neighbours at the same place: cells on both sides may have made the same
/// point, and rounded some are the same though they are not. What was between them goes.
fn unite(skeleton: &mut Skeleton, chains: &mut [Vec<u32>]) {
    let vertices = &skeleton.mesh.vertices;
    let same = |ends: &&[u32]| vertices[ends[0] as usize] == vertices[ends[1] as usize];
    let pairs: Vec<[u32; 2]> = chains
        .iter()
        .flat_map(|chain| chain.windows(2).filter(same))
        .map(|ends| [ends[0], ends[1]])
        .collect();
    if pairs.is_empty() {
        return;
    }
    let groups = components(vertices.len() as u32, pairs.iter().copied());
    let mut first: HashMap<u32, u32> = HashMap::new();
    for &point in pairs.as_flattened() {
        let first = first.entry(groups[point as usize]).or_insert(point);
        *first = point.min(*first);
    }
    let of = |point: u32| first.get(&groups[point as usize]).copied().unwrap_or(point);
    let renumber = |point: &mut u32| *point = of(*point);
    for chain in chains {
        chain.iter_mut().for_each(renumber);
        chain.dedup();
    }
    let Skeleton { mesh, details } = skeleton;
    mesh.triangles.as_flattened_mut().iter_mut().for_each(renumber);
    details.contours.as_flattened_mut().iter_mut().for_each(renumber);
    details.contours.retain(|[from, to]| from != to);
    merge::cancel(skeleton);
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
        fit(&mut skeleton, &[[1, 0, 4]]);
        let expected = [[0, 4, 2], [1, 4, 3], [4, 0, 3], [4, 1, 2]];
        assert_eq!(skeleton.mesh.triangles, expected);
        assert_eq!(skeleton.details.origins.len(), 4);
    }

    /// The middle is there twice, as cells make it; between the two is a triangle of no size.
    #[test]
    fn points_at_one_place_are_one() {
        let middle = 0.5 * DVec3::X;
        let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, -DVec3::Y, middle, middle];
        let triangles = vec![[0, 1, 2], [5, 4, 3], [4, 0, 3], [1, 5, 3]];
        let sides = vec![[Label(1), Label::OUTSIDE]; 4];
        let origin = Origin { kind: Kind::Wall, sections: [None; 2], cell: 0 };
        let mesh = Mesh { vertices, triangles, sides };
        let contours = vec![[0, 1], [4, 5]];
        let details = Details { origins: vec![origin; 4], contours, ..Details::default() };
        let mut skeleton = Skeleton { mesh, details };
        fit(&mut skeleton, &[[0, 1, 4], [1, 0, 5]]);
        assert_eq!(skeleton.mesh.triangles, [[0, 4, 2], [4, 0, 3], [1, 4, 3], [4, 1, 2]]);
        assert_eq!(skeleton.details.contours, [[0, 4], [4, 1]]);
        assert_eq!((skeleton.mesh.sides.len(), skeleton.details.origins.len()), (4, 4));
    }
}
