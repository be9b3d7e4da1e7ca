//! The labels of the faces of a planar subdivision, by flooding from the
//! edges of the sections.

use glam::DVec2;

use super::layout::{Drawing, Layer};
use crate::error::{Error, Result};
use crate::ffi::arrangement::Subdivision;
use crate::label::Label;

/// An edge of a subdivision, directed from its lexicographically smaller end.
pub(super) struct SubEdge {
    pub start: u32,
    pub end: u32,
    /// The face left of it.
    pub left: u32,
    /// The face right of it.
    pub right: u32,
}

impl Subdivision {
    /// The edges with the curves on them.
    pub(super) fn edges(&self) -> impl Iterator<Item = (SubEdge, &[u32])> {
        self.edges.chunks_exact(4).enumerate().map(|(index, edge)| {
            let curves = self.curve_starts[index] as usize..self.curve_starts[index + 1] as usize;
            let edge = SubEdge { start: edge[0], end: edge[1], left: edge[2], right: edge[3] };
            (edge, &self.curves[curves])
        })
    }

    /// A vertex in kept coordinates.
    pub(super) fn point(&self, vertex: u32) -> DVec2 {
        DVec2::from_slice(&self.points[2 * vertex as usize..])
    }
}

/// The label of every face. `planes` is the number of planes.
///
/// # Errors
/// Where the labels of a section contradict each other, or those of another
/// section on the same plane.
pub(super) fn labels(
    subdivision: &Subdivision,
    drawing: &Drawing,
    planes: u32,
) -> Result<Vec<Label>> {
    let mut layers = drawing.layers.iter();
    let Some(first) = layers.next() else { return Ok(Vec::new()) };
    let labels = layer_labels(subdivision, drawing, first, planes)?;
    for layer in layers {
        let others = layer_labels(subdivision, drawing, layer, planes)?;
        if let Some(face) = (0..labels.len()).find(|&face| labels[face] != others[face]) {
            let what = format!(
                "it lies on the plane of section {}, and where that says {}, it says {} (beside \
                 {}): leave one of them out",
                first.name,
                labels[face],
                others[face],
                place(subdivision, drawing, face as u32)
            );
            return Err(Error::Section { section: layer.name.to_owned(), what });
        }
    }
    Ok(labels)
}

/// Floods the labels of one section across all edges but its own.
fn layer_labels(
    subdivision: &Subdivision,
    drawing: &Drawing,
    layer: &Layer,
    planes: u32,
) -> Result<Vec<Label>> {
    let own = |curve: &u32| {
        curve.checked_sub(planes).is_some_and(|edge| layer.edges.contains(&(edge as usize)))
    };
    let open = subdivision.edges().filter(|(_, curves)| !curves.iter().any(own));
    let groups =
        components(subdivision.faces, open.map(|(SubEdge { left, right, .. }, _)| [left, right]));
    let count = groups.iter().max().map_or(0, |&last| last as usize + 1);
    let mut labels = vec![None; count];
    let mut seed = |face: u32, label: Label| {
        let found = *labels[groups[face as usize] as usize].get_or_insert(label);
        if found == label { Ok(()) } else { Err((face, found, label)) }
    };
    let contradiction = |(face, one, other)| Error::Section {
        section: layer.name.to_owned(),
        what: format!(
            "the region beside {} would be both {one} and {other}: close the contours around it \
             and check the labels on their sides",
            place(subdivision, drawing, face)
        ),
    };
    seed(0, layer.background).map_err(contradiction)?;
    for (edge, curves) in subdivision.edges() {
        for curve in curves.iter().filter(|curve| own(curve)) {
            let [left, right] = drawing.sides((curve - planes) as usize);
            seed(edge.left, left).map_err(contradiction)?;
            seed(edge.right, right).map_err(contradiction)?;
        }
    }
    // Every component is bounded by edges of the section, or has no bounds.
    let label = |&group: &u32| labels[group as usize].unwrap_or(layer.background);
    Ok(groups.iter().map(label).collect())
}

/// A point on the border of a face, for messages.
fn place(subdivision: &Subdivision, drawing: &Drawing, face: u32) -> String {
    let beside = |(edge, _): &(SubEdge, &[u32])| edge.left == face || edge.right == face;
    subdivision.edges().find(beside).map_or_else(String::new, |(edge, _)| {
        let middle = subdivision.point(edge.start).midpoint(subdivision.point(edge.end));
        drawing.plane.lift(middle).to_string()
    })
}

/// Numbers the connected components of `count` items; the component of the
/// first item is 0.
pub(crate) fn components(count: u32, pairs: impl Iterator<Item = [u32; 2]>) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..count).collect();
    for pair in pairs {
        let [one, other] = pair.map(|item| root(&mut parents, item));
        parents[one.max(other) as usize] = one.min(other);
    }
    // A root is the smallest of its component, so it is numbered first.
    let mut numbers = vec![0; count as usize];
    let mut next = 0;
    for item in 0..count {
        let root = root(&mut parents, item);
        if root == item {
            numbers[item as usize] = next;
            next += 1;
        } else {
            numbers[item as usize] = numbers[root as usize];
        }
    }
    numbers
}

/// The root of an item's tree; halves the path on the way.
fn root(parents: &mut [u32], mut item: u32) -> u32 {
    while parents[item as usize] != item {
        parents[item as usize] = parents[parents[item as usize] as usize];
        item = parents[item as usize];
    }
    item
}
