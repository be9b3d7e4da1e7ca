//! The regions of a section: the faces of its graph.

use super::draft::{Draft, stretch};
use super::subdivision::{Curves, UNBOUNDED};
use super::{Rules, Section};
use crate::error::Result;
use crate::label::Label;

/// A connected part of the plane with one label.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// What it is made of.
    pub label: Label,
    /// Its outer boundary by the section's vertices, counter-clockwise about
    /// the plane's normal; `None` for the part that reaches to infinity. It
    /// may touch itself in vertices.
    pub outer: Option<Vec<u32>>,
    /// The boundaries of its holes, clockwise.
    pub holes: Vec<Vec<u32>>,
    /// The area in world units; minus that of all others when unbounded.
    pub area: f64,
}

impl Section {
    /// The regions, the unbounded one first, then by their smallest vertices.
    pub fn regions(&self) -> Result<Vec<Region>> {
        let rules = Rules::default();
        let mut draft = Draft::new(&self.name, self.plane, 0.0, &rules)?;
        let mut curves = Curves::default();
        for &vertex in &self.vertices {
            curves.point(vertex);
        }
        for (i, edge) in self.edges.iter().enumerate() {
            curves.segment(i, edge.start, edge.end);
        }
        let subdivision = curves.subdivide(&mut draft)?;
        let mut regions: Vec<Region> = subdivision
            .areas()
            .into_iter()
            .map(|area| Region {
                label: self.background,
                outer: None,
                holes: Vec::new(),
                area: area * stretch(&self.plane),
            })
            .collect();
        for side in &subdivision.edges {
            for cover in &side.covers {
                let edge = &self.edges[cover.curve as usize];
                let labels =
                    if cover.forward { [edge.left, edge.right] } else { [edge.right, edge.left] };
                regions[side.left].label = labels[0];
                regions[side.right].label = labels[1];
            }
        }
        for walk in subdivision.walks {
            let vertices = from_smallest(walk.vertices);
            let region = &mut regions[walk.face];
            if walk.outer {
                region.outer = Some(vertices);
            } else {
                region.holes.push(vertices);
            }
        }
        regions[UNBOUNDED + 1..].sort_by(|a, b| a.outer.cmp(&b.outer));
        for region in &mut regions {
            region.holes.sort();
        }
        Ok(regions)
    }
}

/// The closed walk, begun where its vertices, read from there, sort first.
fn from_smallest(mut walk: Vec<u32>) -> Vec<u32> {
    let turned = |start: usize| walk[start..].iter().chain(&walk[..start]);
    let smallest = walk.iter().min().copied();
    let start = (0..walk.len())
        .filter(|&i| Some(walk[i]) == smallest)
        .min_by(|&a, &b| turned(a).cmp(turned(b)))
        .unwrap_or(0);
    walk.rotate_left(start);
    walk
}
