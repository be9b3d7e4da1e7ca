//! What must hold for every arrangement. All of it is decided exactly on
//! names, but for areas.

use std::collections::{BTreeMap, HashMap, HashSet};

use glam::DVec3;

use super::{Arrangement, Face};
use crate::label::Label;

/// How much areas may differ, relative to the face's.
const AREA_TOLERANCE: f64 = 1e-9;

type Check = Result<(), String>;

impl Arrangement {
    pub(super) fn check(&self) -> Check {
        self.check_euler()?;
        self.check_sides()?;
        for cell in 0..self.cells.len() {
            self.check_convex(cell)?;
            self.check_closed(cell)?;
        }
        (0..self.faces.len()).try_for_each(|face| self.check_regions(face))
    }

    /// V − E + F − C = 1 for a ball cut into cells.
    fn check_euler(&self) -> Check {
        let edges: HashSet<[u32; 2]> =
            (0..self.faces.len()).flat_map(|face| self.face_sides(face)).collect();
        let counts = [self.topology.corners.len(), edges.len(), self.faces.len(), self.cells.len()];
        let [v, e, f, c] = counts.map(|count| count as i64);
        ensure(v - e + f - c == 1, || format!("V − E + F − C is {v} − {e} + {f} − {c}, not 1"))
    }

    /// Two different cells at every inner face, one at every outer one.
    fn check_sides(&self) -> Check {
        for (index, face) in self.faces.iter().enumerate() {
            let inner = self.topology.cutting.contains(&face.plane);
            let sound = match face.cells {
                [Some(front), Some(behind)] => inner && front != behind,
                [None, None] => false,
                _ => !inner,
            };
            ensure(sound, || format!("face {index} has the cells {:?}", face.cells))?;
        }
        Ok(())
    }

    /// Every corner of a cell is on the cell's side of every plane.
    fn check_convex(&self, cell: usize) -> Check {
        for &face in &self.cells[cell].faces {
            for &corner in &self.topology.face_corners[face as usize] {
                let name = &self.topology.corners[corner as usize];
                ensure(name.bounds(&self.topology.cells[cell]), || {
                    format!("corner {corner} of face {face} is not a corner of its cell {cell}")
                })?;
            }
        }
        Ok(())
    }

    /// Every edge of a cell is on two of its faces.
    fn check_closed(&self, cell: usize) -> Check {
        let mut counts = HashMap::new();
        for &face in &self.cells[cell].faces {
            for edge in self.face_sides(face as usize) {
                *counts.entry(edge).or_insert(0) += 1;
            }
        }
        let closed = counts.len() >= 6 && counts.values().all(|&count| count == 2);
        ensure(closed, || format!("the faces of cell {cell} do not close around it"))
    }

    /// The regions' borders close, and their areas add up to the face's.
    fn check_regions(&self, face: usize) -> Check {
        let Face { plane, edges, labels, .. } = &self.faces[face];
        let outline = &self.topology.outlines[face];
        let normal = self.planes[*plane as usize].unit_normal();
        let area = |start: DVec3, end: DVec3| {
            (start - outline[0]).cross(end - outline[0]).dot(normal) / 2.0
        };
        let mut areas: BTreeMap<Label, f64> = labels.iter().map(|&label| (label, 0.0)).collect();
        for (label, start, end) in edges.iter().flat_map(directed) {
            let known = areas.get_mut(&label).map(|sum| *sum += area(start, end));
            ensure(known.is_some(), || format!("face {face} does not list its label {label}"))?;
        }
        let next = outline.iter().cycle().skip(1);
        let whole: f64 = outline.iter().zip(next).map(|(&start, &end)| area(start, end)).sum();
        let tolerance = AREA_TOLERANCE * whole.abs() + rounding(outline);
        let sum: f64 = areas.values().sum();
        ensure(
            (sum - whole).abs() <= tolerance && areas.values().all(|&a| a >= -tolerance),
            || format!("the regions of face {face} have the areas {areas:?}, together not {whole}"),
        )?;
        ensure(labels.iter().all(|&label| closes(edges, label)), || {
            format!("the border of a region of face {face} does not close")
        })
    }

    /// The arrangement's edges around a face, by their corners.
    fn face_sides(&self, face: usize) -> impl Iterator<Item = [u32; 2]> {
        let corners = &self.topology.face_corners[face];
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).map(|(&a, &b)| [a.min(b), a.max(b)])
    }
}

fn ensure(holds: bool, message: impl FnOnce() -> String) -> Check {
    if holds { Ok(()) } else { Err(message()) }
}

/// An edge once for each label beside it, the label on its left.
fn directed(edge: &super::FaceEdge) -> impl Iterator<Item = (Label, DVec3, DVec3)> + use<> {
    let left = (edge.left, edge.start, edge.end);
    let right = edge.right.map(|label| (label, edge.end, edge.start));
    std::iter::once(left).chain(right)
}

/// Whether as many edges of a region end in every point as start there.
fn closes(edges: &[super::FaceEdge], label: Label) -> bool {
    let mut degrees = HashMap::new();
    let own = edges.iter().flat_map(directed).filter(|&(beside, ..)| beside == label);
    for (_, start, end) in own {
        *degrees.entry(start.to_array().map(f64::to_bits)).or_insert(0) += 1;
        *degrees.entry(end.to_array().map(f64::to_bits)).or_insert(0) -= 1;
    }
    degrees.values().all(|&degree| degree == 0)
}

/// How far off an area can be because corners were rounded.
fn rounding(outline: &[DVec3]) -> f64 {
    let reach = outline.iter().map(|point| point.abs().max_element()).fold(0.0, f64::max);
    let length = outline.iter().map(|point| point.distance(outline[0])).fold(0.0, f64::max);
    16.0 * f64::EPSILON * reach * length
}
