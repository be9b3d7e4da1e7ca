//! A mesh whose labels are pieces.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3Swizzles};

use crate::label::Label;
use crate::mesh::{Mesh, Surface};
use crate::sets::Sets;

/// A mesh of the pieces of some labels, each a label of its own from 1.
pub struct Numbered {
    pub mesh: Mesh,
    /// The label of every piece, from 1.
    labels: Vec<Label>,
}

impl Numbered {
    /// All that is none of the labels counts as outside.
    pub fn new(mesh: &Mesh, labels: &[Label]) -> Self {
        let mut sides = vec![[Label::OUTSIDE; 2]; mesh.triangles.len()];
        let mut names = Vec::new();
        for &label in labels {
            let mut pieces = pieces(&mesh.surface(label)).into_iter();
            let mut numbers: BTreeMap<u32, Label> = BTreeMap::new();
            // A label's surface has its triangles in the mesh's order.
            for (own, both) in sides.iter_mut().zip(&mesh.sides) {
                let Some(side) = (0..2).find(|&side| both[side] == label) else { continue };
                if both[1 - side] == label {
                    continue;
                }
                let Some(piece) = pieces.next() else { break };
                own[side] = *numbers.entry(piece).or_insert_with(|| {
                    names.push(label);
                    Label(names.len() as u32)
                });
            }
        }
        let kept = (0..sides.len()).filter(|&triangle| sides[triangle][0] != sides[triangle][1]);
        let (triangles, sides) =
            kept.map(|triangle| (mesh.triangles[triangle], sides[triangle])).unzip();
        let mesh = Mesh { vertices: mesh.vertices.clone(), triangles, sides };
        Self { mesh, labels: names }
    }

    /// The label that a piece is of.
    pub fn label(&self, piece: Label) -> Label {
        self.labels[piece.0 as usize - 1]
    }
}

/// For every triangle its piece; what faces a cavity belongs to the piece around it.
fn pieces(surface: &Surface) -> Vec<u32> {
    let mut sets = Sets::new(surface.vertices.len());
    for &[a, b, c] in &surface.triangles {
        sets.join(a, b);
        sets.join(b, c);
    }
    let roots = |sets: &mut Sets| -> Vec<u32> {
        surface.triangles.iter().map(|corners| sets.root(corners[0])).collect()
    };
    let shells = roots(&mut sets);
    let middle = surface.vertices.first().copied().unwrap_or_default();
    let mut volumes: BTreeMap<u32, f64> = BTreeMap::new();
    for (triangle, &shell) in shells.iter().enumerate() {
        let [a, b, c] = surface.corners(triangle).map(|corner| corner - middle);
        *volumes.entry(shell).or_default() += a.dot(b.cross(c));
    }
    for (cavity, _) in volumes.into_iter().filter(|(_, volume)| *volume < 0.0) {
        if let Some(around) = around(surface, &shells, cavity) {
            sets.join(cavity, around);
        }
    }
    roots(&mut sets)
}

/// The shell that is met first from where a cavity reaches farthest along x: between the two is
/// what is inside.
fn around(surface: &Surface, shells: &[u32], cavity: u32) -> Option<u32> {
    let own = (0..shells.len()).filter(|&triangle| shells[triangle] == cavity);
    let farthest = own
        .flat_map(|triangle| surface.corners(triangle))
        .max_by(|one, other| one.x.total_cmp(&other.x))?;
    let others = (0..shells.len()).filter(|&triangle| shells[triangle] != cavity);
    let hits = others.filter_map(|triangle| {
        let x = met(farthest, surface.corners(triangle)).filter(|&x| x >= farthest.x)?;
        Some((x, shells[triangle]))
    });
    hits.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, shell)| shell)
}

/// Where the line along x through a point meets a triangle.
fn met(point: DVec3, corners: [DVec3; 3]) -> Option<f64> {
    let [a, b, c] = corners.map(|corner| (corner - point).yz());
    let weights = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
    let total: f64 = weights.iter().sum();
    let is_within = weights.iter().all(|weight| weight * total >= 0.0) && total != 0.0;
    let x = || weights.iter().zip(corners).map(|(weight, corner)| weight * corner.x).sum::<f64>();
    is_within.then(|| x() / total)
}
