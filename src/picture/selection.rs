//! Which materials are drawn; the others are as if outside.

use std::borrow::Cow;

use crate::label::Label;
use crate::mesh::Mesh;
use crate::section::{Edge, Section};

/// The labels that are drawn; `None` for all.
#[derive(Debug, Clone, Copy, Default)]
pub struct Selection<'a>(pub Option<&'a [Label]>);

impl Selection<'_> {
    /// Whether a material is drawn.
    pub fn shows(self, label: Label) -> bool {
        label.is_material() && self.0.is_none_or(|labels| labels.contains(&label))
    }

    fn seen(self, label: Label) -> Label {
        if label.is_material() && !self.shows(label) { Label::OUTSIDE } else { label }
    }

    /// The part of a network that is drawn, with its vertices alone.
    pub fn mesh(self, mesh: &Mesh) -> Cow<'_, Mesh> {
        if self.0.is_none() {
            return Cow::Borrowed(mesh);
        }
        let mut part = Mesh::default();
        let mut places = vec![None; mesh.vertices.len()];
        for (corners, sides) in mesh.triangles.iter().zip(&mesh.sides) {
            let [back, front] = sides.map(|label| self.seen(label));
            if back == front {
                continue;
            }
            part.sides.push([back, front]);
            part.triangles.push(corners.map(|vertex| {
                *places[vertex as usize].get_or_insert_with(|| {
                    part.vertices.push(mesh.vertices[vertex as usize]);
                    part.vertices.len() as u32 - 1
                })
            }));
        }
        Cow::Owned(part)
    }

    /// The contours that are drawn: the borders of these materials.
    pub fn contours(self, section: &Section) -> impl Iterator<Item = Edge> {
        let edges = section.edges().iter().map(move |edge| Edge {
            left: self.seen(edge.left),
            right: self.seen(edge.right),
            ..*edge
        });
        edges.filter(move |edge| {
            self.0.is_none() || [edge.left, edge.right].into_iter().any(|label| self.shows(label))
        })
    }
}
