//! Values and gradients at the corners of facets' triangles (Eqs. 1 and 2, §4.3).
//!
//! A label's value is ± the distance in space to the nearest contour of it on any section,
//! positive where its own facet shows the label; so sections that agree agree about it where
//! they cross. On contours it is 0. On unknown regions, which the paper does not have, it is
//! that distance times the mean-value indicator: at the region's border that is what is known
//! beside it, and where the completed labels change it is 0.

use glam::DVec3;
use rayon::prelude::*;

use super::facet_mesh::FacetMesh;
use super::outline::{Contours, Foot, Outline};
use super::{Gradients, Options};
use crate::complex::{Complex, Facet};
use crate::error::{Remedy, Result};
use crate::field::cpu::Cpu;
use crate::field::{Boundaries, Field, Queries, Run};
use crate::grid::memory::require_bytes;
use crate::label::Label;
use crate::plane::polygon_area;
use crate::progress::Progress;
use crate::section::Section;
use crate::segments::Hint;

/// Bytes of a point with its triangles and edges, as they are laid out for both cells beside it,
/// and of each label there.
const BYTES_PER_POINT: f64 = 700.0;
const BYTES_PER_LABEL: f64 = 80.0;

/// Nearer to a contour, relative to the box's diagonal, is on it.
const ON_CONTOUR: f64 = 1e-9;

/// What is said about one label at one point.
#[derive(Debug, Clone, Copy, Default)]
pub struct Node {
    /// World units.
    pub value: f64,
    /// Of the value, as far as it is known.
    pub gradient: DVec3,
}

/// The triangles on a facet, and what is said at their corners.
#[derive(Debug, Default)]
pub struct FacetNodes {
    pub mesh: FacetMesh,
    /// Those of the cells on both sides, sorted.
    pub labels: Vec<Label>,
    /// For every point a node for every label.
    pub nodes: Vec<Node>,
}

/// Those of all facets by their numbers.
#[derive(Debug)]
pub struct Nodes {
    facets: Vec<FacetNodes>,
}

/// All there is to say about points.
struct Sayings<'a> {
    outlines: Vec<(Label, Outline)>,
    gradients: Gradients,
    /// Of the box.
    diagonal: f64,
    boundaries: &'a Boundaries<'a>,
}

impl Nodes {
    /// Of the facets around some cells, that some sections make.
    ///
    /// # Errors
    /// For a bad spacing, where they would not fit into memory, when it is cancelled, and CGAL's
    /// exceptions.
    pub fn new(
        boundaries: &Boundaries,
        sections: &[Section],
        options: &Options,
        progress: &dyn Progress,
    ) -> Result<Self> {
        let complex = boundaries.complex();
        options.check(complex.bounds())?;
        let spacing = options.spacing(complex.bounds());
        require_room(complex, spacing)?;
        let contours = Contours::new(sections, options.gradients != Gradients::InPlane);
        let mut labels: Vec<Label> =
            complex.cells().values().flat_map(|c| &c.labels).copied().collect();
        labels.sort();
        labels.dedup();
        labels.retain(|&label| label != Label::UNKNOWN);
        let outline = |&label: &Label| (label, Outline::new(&contours, label));
        let outlines = labels.par_iter().map(outline).collect();
        let diagonal = complex.bounds().diagonal();
        let sayings = Sayings { outlines, gradients: options.gradients, diagonal, boundaries };
        let facet = |number: usize| match complex.facets().get(number as u32) {
            Some(facet) => {
                progress.go_on()?;
                sayings.facet(facet, FacetMesh::new(complex, facet, spacing)?)
            }
            None => Ok(FacetNodes::default()),
        };
        let facets = (0..complex.facets().end()).into_par_iter().map(facet);
        let mut nodes = Self { facets: facets.collect::<Result<_>>()? };
        if complex.is_partial() {
            nodes.complete(boundaries)?;
        }
        Ok(nodes)
    }

    /// How many triangles there are.
    pub fn triangle_count(&self) -> usize {
        self.facets.iter().map(|facet| facet.mesh.triangles.len()).sum()
    }

    /// What is said on a facet.
    pub fn on(&self, facet: u32) -> &FacetNodes {
        &self.facets[facet as usize]
    }

    /// Gives unknown points, which so far have distances without a sign, their values.
    fn complete(&mut self, boundaries: &Boundaries) -> Result<()> {
        let complex = boundaries.complex();
        let field = Cpu::new(boundaries)?;
        let mut queries = Queries::default();
        let mut wanted: Vec<(usize, usize)> = Vec::new();
        for (number, facet) in complex.facets().iter() {
            let Some(cell) = facet.cells.into_iter().flatten().next() else { continue };
            let mesh = &self.facets[number as usize].mesh;
            let first = queries.points.len();
            for point in (0..mesh.points.len()).filter(|&point| mesh.is_unknown(point)) {
                queries.points.push(mesh.points[point]);
                wanted.push((number as usize, point));
            }
            queries.runs.push(Run { cell, points: first..queries.points.len() });
        }
        let values = field.evaluate(&queries)?;
        let mut next = 0;
        for run in &queries.runs {
            let labels = field.labels(run.cell);
            for &(facet, point) in &wanted[run.points.clone()] {
                let own = &values[next..next + labels.len()];
                next += labels.len();
                self.facets[facet].complete(point, labels, own);
            }
        }
        self.facets.par_iter_mut().for_each(FacetNodes::slope);
        Ok(())
    }
}

/// # Errors
/// Where triangles with edges of some length would not fit into memory.
fn require_room(complex: &Complex, spacing: f64) -> Result<()> {
    // Every point of a triangular lattice has so much of a facet.
    let share = 0.75f64.sqrt() * spacing * spacing;
    let bytes = |facet: &Facet| {
        let inner = polygon_area(&facet.outline) / share;
        let points = inner + facet.edges.len() as f64;
        points * (BYTES_PER_POINT + BYTES_PER_LABEL * facet.labels.len() as f64)
    };
    let needed: f64 = complex.facets().values().map(bytes).sum();
    require_bytes(needed as u64, Remedy::LargerSpacing, || {
        format!("triangles with sides of {spacing} on {} facets", complex.facets().count())
    })
}

impl Sayings<'_> {
    fn facet(&self, facet: &Facet, mesh: FacetMesh) -> Result<FacetNodes> {
        let cells = facet.cells.into_iter().flatten();
        let mut labels: Vec<Label> =
            cells.flat_map(|cell| self.boundaries.labels(cell)).copied().collect();
        labels.sort();
        labels.dedup();
        let mut nodes = vec![Node::default(); mesh.points.len() * labels.len()];
        for (slot, &label) in labels.iter().enumerate() {
            let mut hint = Hint::default();
            let outline = self.outlines.iter().find(|(own, _)| *own == label);
            for (point, &at) in mesh.points.iter().enumerate() {
                let foot = outline.and_then(|(_, outline)| outline.foot(at, &mut hint));
                nodes[point * labels.len() + slot] = self.node(at, foot, mesh.side(point, label));
            }
        }
        Ok(FacetNodes { mesh, labels, nodes })
    }

    /// At a point on one side of a label's nearest contour, or on it.
    fn node(&self, point: DVec3, foot: Option<Foot>, side: Side) -> Node {
        let Some(foot) = foot else {
            return Node { value: side.sign() * self.diagonal, gradient: DVec3::ZERO };
        };
        if side == Side::On || foot.distance < ON_CONTOUR * self.diagonal {
            let gradient = match self.gradients {
                Gradients::None => DVec3::ZERO,
                _ => foot.inward,
            };
            return Node { value: 0.0, gradient };
        }
        let gradient = match self.gradients {
            Gradients::None => DVec3::ZERO,
            Gradients::Distance => side.sign() * (point - foot.at).normalize_or_zero(),
            Gradients::InPlane | Gradients::Normals => foot.inward,
        };
        Node { value: side.sign() * foot.distance, gradient }
    }
}

/// Where a point is as a label sees it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Inside,
    Outside,
    /// On the border to another one.
    On,
    Unknown,
}

impl Side {
    fn sign(self) -> f64 {
        if self == Self::Outside { -1.0 } else { 1.0 }
    }
}

impl FacetMesh {
    fn is_unknown(&self, point: usize) -> bool {
        self.around[point] == [Label::UNKNOWN]
    }

    fn side(&self, point: usize, label: Label) -> Side {
        let known = self.around[point].iter().filter(|&&own| own != Label::UNKNOWN).count();
        match (known, self.around[point].contains(&label)) {
            (0, _) => Side::Unknown,
            (1, true) => Side::Inside,
            (_, true) => Side::On,
            (_, false) => Side::Outside,
        }
    }
}

impl FacetNodes {
    /// Gives a point the values of some labels' indicators; all others are not there.
    fn complete(&mut self, point: usize, labels: &[Label], indicators: &[f32]) {
        let own = &mut self.nodes[point * self.labels.len()..][..self.labels.len()];
        for (node, label) in own.iter_mut().zip(&self.labels) {
            let indicator = match labels.binary_search(label) {
                Ok(slot) => indicators[slot].into(),
                Err(_) => -1.0,
            };
            node.value *= indicator;
            node.gradient = DVec3::ZERO;
        }
    }

    /// Gives unknown points the gradients of the triangles around them.
    fn slope(&mut self) {
        let count = self.labels.len();
        let mut sums = vec![(DVec3::ZERO, 0.0); self.nodes.len()];
        for corners in &self.mesh.triangles {
            let corners = corners.map(|corner| corner as usize);
            if !corners.iter().any(|&corner| self.mesh.is_unknown(corner)) {
                continue;
            }
            let [a, b, c] = corners.map(|corner| self.mesh.points[corner]);
            let normal = (b - a).cross(c - a);
            for slot in 0..count {
                let [fa, fb, fc] = corners.map(|corner| self.nodes[corner * count + slot].value);
                // Twice the area times the gradient.
                let slope =
                    normal.cross(fa * (c - b) + fb * (a - c) + fc * (b - a)) / normal.length();
                for corner in corners {
                    let sum = &mut sums[corner * count + slot];
                    *sum = (sum.0 + slope, sum.1 + normal.length());
                }
            }
        }
        for (index, (node, (slope, weight))) in self.nodes.iter_mut().zip(sums).enumerate() {
            if weight > 0.0 && self.mesh.is_unknown(index / count) {
                node.gradient = slope / weight;
            }
        }
    }
}
