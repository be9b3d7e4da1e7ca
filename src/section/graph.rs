//! Sections from planar graphs whose edges carry a label on either side.

use glam::DVec3;

use super::draft::Draft;
use super::subdivision::{Cover, Curves, Side, Subdivision, UNBOUNDED};
use super::{Edge, Findings, Rules, Section};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Plane;

impl Section {
    /// A section from a planar graph with labels on either side of its edges.
    ///
    /// Vertices may lie on edges; edges with one label on both sides are
    /// dropped. Without edges the whole plane is *outside*.
    ///
    /// # Errors
    /// Where the plane is none, a vertex is not finite, too far off the plane
    /// or missing, and where the labels contradict each other.
    pub fn from_graph(
        name: &str,
        plane: Plane,
        points: &[DVec3],
        edges: &[Edge],
        diagonal: f64,
        rules: &Rules,
    ) -> Result<(Self, Findings)> {
        let mut draft = Draft::new(name, plane, diagonal, rules)?;
        let mut curves = Curves::default();
        let numbers = points
            .iter()
            .enumerate()
            .map(|(i, &point)| draft.project(point, || format!("vertex {i}")))
            .map(|kept| kept.map(|kept| curves.point(kept)))
            .collect::<Result<Vec<u32>>>()?;
        for (i, edge) in edges.iter().enumerate() {
            let end = |vertex: u32| {
                numbers.get(vertex as usize).copied().ok_or_else(|| {
                    draft.error(format!(
                        "edge {i} ends at vertex {vertex}, but there are only {}",
                        points.len()
                    ))
                })
            };
            let [start, end] = [end(edge.start)?, end(edge.end)?];
            if edge.left != edge.right {
                curves.segment(i, start, end);
            }
        }
        let subdivision = curves.subdivide(&draft)?;
        let labels = face_labels(&draft, edges, &subdivision)?;
        let section = subdivision.section(&draft, &labels);
        Ok((section, draft.findings))
    }
}

/// The label of every face, on which all edges around it must agree.
fn face_labels(draft: &Draft, edges: &[Edge], subdivision: &Subdivision) -> Result<Vec<Label>> {
    let mut labels: Vec<Option<Label>> = vec![None; subdivision.faces];
    for side in &subdivision.edges {
        for cover in &side.covers {
            let [left, right] = directed(&edges[cover.curve as usize], cover);
            for (face, label) in [(side.left, left), (side.right, right)] {
                let known = *labels[face].get_or_insert(label);
                if known != label {
                    return Err(contradiction(draft, subdivision, side, [known, label]));
                }
            }
        }
    }
    labels[UNBOUNDED].get_or_insert(Label::OUTSIDE);
    Ok(labels.into_iter().map(|label| label.unwrap_or(Label::OUTSIDE)).collect())
}

fn directed(edge: &Edge, cover: &Cover) -> [Label; 2] {
    if cover.forward { [edge.left, edge.right] } else { [edge.right, edge.left] }
}

fn contradiction(
    draft: &Draft,
    subdivision: &Subdivision,
    side: &Side,
    [known, label]: [Label; 2],
) -> crate::error::Error {
    let [start, end] = [side.start, side.end].map(|i| draft.place(subdivision.points[i as usize]));
    draft.error(format!(
        "contradictory labels around vertex {} at {start}: the edge from there to {end} says {label} \
         where another says {known}: correct the labels or the missing or crossing edges",
        side.start
    ))
}
