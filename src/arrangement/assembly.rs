//! Cells, by matching faces that name the same one (Bermano §4.2).

use std::collections::HashMap;

use glam::DVec3;

use super::layout::Layout;
use super::plane_faces::PlaneFace;
use super::signs::Signs;
use super::{Arrangement, Cell, Face};

/// The exact names behind the numbers.
#[derive(Debug, Clone, Default)]
pub(crate) struct Topology {
    /// The name of each cell, ascending.
    pub cells: Vec<Signs>,
    /// The cell with a name.
    pub index: HashMap<Signs, u32>,
    /// The name of each corner, ascending.
    pub corners: Vec<Signs>,
    /// The corners of each face, counter-clockwise about the plane's normal.
    pub face_corners: Vec<Vec<u32>>,
    /// The same, in space.
    pub outlines: Vec<Vec<DVec3>>,
    /// The planes that have cells on both sides.
    pub cutting: Vec<u32>,
}

/// Puts the faces of all distinct planes together.
pub(super) fn assemble(layout: Layout, planes: Vec<Vec<PlaneFace>>) -> Arrangement {
    let mut topology = Topology::default();
    let sides: Vec<Vec<[Option<Signs>; 2]>> = layout
        .distinct
        .iter()
        .zip(&planes)
        .map(|(&plane, faces)| faces.iter().map(|face| sides(&layout, plane, face)).collect())
        .collect();
    topology.cells = unique(sides.iter().flatten().flatten().flatten().cloned());
    topology.index = topology.cells.iter().cloned().zip(0..).collect();
    topology.corners =
        unique(planes.iter().flatten().flat_map(|face| face.corners.iter().cloned()));

    let mut faces = Vec::new();
    for ((&plane, plane_faces), sides) in layout.distinct.iter().zip(planes).zip(sides) {
        if !plane_faces.is_empty() && layout.sides_inside(plane) == [true, true] {
            topology.cutting.push(plane);
        }
        for (face, sides) in plane_faces.into_iter().zip(sides) {
            let cells = sides.map(|side| side.map(|name| topology.index[&name]));
            topology.add_outline(face.corners, face.outline);
            faces.push(Face { plane, cells, labels: face.labels, edges: face.edges });
        }
    }
    let cells = cells(topology.cells.len(), &faces);
    let Layout { bounds, border, planes, .. } = layout;
    Arrangement { bounds, border, planes, faces, cells, topology }
}

impl Topology {
    fn add_outline(&mut self, corners: Vec<Signs>, outline: Vec<DVec3>) {
        let number = |name: &Signs| self.corners.partition_point(|corner| corner < name) as u32;
        self.face_corners.push(corners.iter().map(number).collect());
        self.outlines.push(outline);
    }
}

/// The names of the cells in front of a face and behind it: its own, but for
/// its plane.
fn sides(layout: &Layout, plane: u32, face: &PlaneFace) -> [Option<Signs>; 2] {
    let [front, behind] = layout.sides_inside(plane);
    let name = |sign| face.signs.with(plane as usize, sign);
    [front.then(|| name(1)), behind.then(|| name(-1))]
}

fn unique(names: impl Iterator<Item = Signs>) -> Vec<Signs> {
    let mut names: Vec<Signs> = names.collect();
    names.sort_unstable();
    names.dedup();
    names
}

fn cells(count: usize, faces: &[Face]) -> Vec<Cell> {
    let mut cells = vec![Cell { faces: Vec::new(), labels: Vec::new() }; count];
    for (index, face) in faces.iter().enumerate() {
        for cell in face.cells.into_iter().flatten() {
            let cell = &mut cells[cell as usize];
            cell.faces.push(index as u32);
            cell.labels.extend(&face.labels);
        }
    }
    for cell in &mut cells {
        cell.labels.sort();
        cell.labels.dedup();
    }
    cells
}
