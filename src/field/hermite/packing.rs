//! Cells laid out for the f32 backends, in their own coordinates as those of the mean-value
//! field are (`field/packing`).

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec3;

use super::nodes::{FacetNodes, Node, Nodes};
use crate::complex::Complex;
use crate::field::Boundaries;
use crate::field::boundaries::SMALLEST_CLEARANCE;
use crate::field::packing::{Frame, PackedCorner, unit_cube};
use crate::field::places::{key, step};
use crate::label::Label;
use crate::plane::Bounds;

/// A triangle is far from so many times its longest side on.
const FAR: f32 = 8.0;
/// Values of one label that differ by less than this part of the box's diagonal are the same.
const ALIKE: f64 = 1e-6;

/// A facet of a cell: parts of the cell's corners, edges and triangles.
#[derive(Debug, Clone)]
pub struct HermiteFace {
    pub frame: Frame,
    pub corners: Range<usize>,
    pub edges: Range<usize>,
    pub triangles: Range<usize>,
}

/// An edge of triangles.
#[derive(Debug, Clone, Copy)]
pub struct HermiteEdge {
    /// Among the face's corners.
    pub ends: [u32; 2],
    /// From one end to the other, rounded once.
    pub span: [f32; 2],
    pub span_squared: f32,
}

/// A triangle, counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub struct HermiteTriangle {
    /// Among the face's corners.
    pub corners: [u32; 3],
    /// Among the face's edges: those opposite to its corners.
    pub edges: [u32; 3],
    /// 1 for an edge that runs counter-clockwise, else −1.
    pub signs: [f32; 3],
    /// The corners, among the cell's nodes.
    pub nodes: [u32; 3],
    /// 1 / 4 A.
    pub quarter: f32,
    /// A / 6.
    pub sixth: f32,
    /// The square of the distance from which on it counts as far.
    pub far: f32,
}

/// A cell.
#[derive(Debug, Clone)]
pub struct HermiteCell {
    pub labels: Vec<Label>,
    /// World units.
    pub origin: DVec3,
    /// Cell units per world unit.
    pub scale: f64,
    /// The smallest |γ|, in cell units.
    pub clearance: f32,
    pub faces: Vec<HermiteFace>,
    pub corners: Vec<PackedCorner>,
    pub edges: Vec<HermiteEdge>,
    pub triangles: Vec<HermiteTriangle>,
    /// How much every node counts.
    pub densities: Vec<f32>,
    /// For every node and every label (c, g) with f_i + ∇f_i · (x − v_i) = c + g · x.
    pub tangents: Vec<[f32; 4]>,
}

/// A cell in the making.
struct Packing<'a> {
    cell: HermiteCell,
    /// World units per unit of values.
    unit: f64,
    step: f64,
    /// What is alike.
    alike: f64,
    /// The nodes at every place.
    places: BTreeMap<[u64; 3], Vec<u32>>,
    /// For every node what is said there, and the area around it.
    said: Vec<(&'a FacetNodes, usize)>,
    areas: Vec<f64>,
}

impl HermiteCell {
    /// A cell's boundary. Values are in the given units of the world's.
    pub fn new(
        boundaries: &Boundaries,
        nodes: &Nodes,
        cell: u32,
        unit: f64,
        density: bool,
    ) -> Self {
        let complex = boundaries.complex();
        let facets = complex.cells().get(cell).map_or(&[][..], |cell| &cell.facets);
        let points = facets.iter().flat_map(|&facet| &nodes.on(facet).mesh.points).copied();
        let (origin, scale) = Bounds::around(points).map_or((DVec3::ZERO, 1.0), unit_cube);
        let clearance = (boundaries.clearance() * scale).max(SMALLEST_CLEARANCE) as f32;
        let cell = Self {
            labels: boundaries.labels(cell).to_vec(),
            origin,
            scale,
            clearance,
            faces: Vec::new(),
            corners: Vec::new(),
            edges: Vec::new(),
            triangles: Vec::new(),
            densities: Vec::new(),
            tangents: Vec::new(),
        };
        let mut packing = Packing {
            cell,
            unit,
            step: step(complex.bounds()),
            alike: ALIKE * complex.bounds().diagonal(),
            places: BTreeMap::new(),
            said: Vec::new(),
            areas: Vec::new(),
        };
        for &facet in facets {
            packing.add(complex, facet, nodes.on(facet));
        }
        packing.finish(density)
    }

    /// A point in the cell's coordinates.
    pub fn localize(&self, point: DVec3) -> DVec3 {
        (point - self.origin) * self.scale
    }

    /// Edges that are evaluated for a point.
    pub fn edge_count(&self) -> u64 {
        self.edges.len() as u64
    }
}

impl<'a> Packing<'a> {
    fn add(&mut self, complex: &Complex, facet: u32, own: &'a FacetNodes) {
        let plane = complex.planes()[complex.facets()[facet].plane];
        let frame = Frame {
            tangents: plane.tangents(),
            normal: plane.unit_normal(),
            offset: plane.distance(self.cell.origin) * self.cell.scale,
        };
        let flat: Vec<_> =
            own.mesh.points.iter().map(|&point| frame.flatten(self.cell.localize(point))).collect();
        let nodes: Vec<u32> = (0..flat.len()).map(|point| self.node(own, point)).collect();
        let first_corner = self.cell.corners.len();
        self.cell.corners.extend(flat.iter().map(|&point| PackedCorner::new(point)));
        let (first_edge, first_triangle) = (self.cell.edges.len(), self.cell.triangles.len());
        let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for corners in &own.mesh.triangles {
            let [a, b, c] = corners.map(|corner| flat[corner as usize]);
            let doubled = (b - a).perp_dot(c - a);
            if doubled <= 0.0 {
                continue;
            }
            let mut signs = [1.0; 3];
            let opposite = std::array::from_fn(|corner| {
                let [start, end] = [corners[(corner + 1) % 3], corners[(corner + 2) % 3]];
                if start > end {
                    signs[corner] = -1.0;
                }
                let ends = [start.min(end), start.max(end)];
                let next = edges.len() as u32;
                *edges.entry(ends).or_insert_with(|| {
                    let span = flat[ends[1] as usize] - flat[ends[0] as usize];
                    self.cell.edges.push(HermiteEdge {
                        ends,
                        span: span.as_vec2().to_array(),
                        span_squared: span.length_squared() as f32,
                    });
                    next
                })
            });
            let nodes = corners.map(|corner| nodes[corner as usize]);
            for node in nodes {
                self.areas[node as usize] += doubled / 6.0;
            }
            let sides = opposite.map(|own| self.cell.edges[first_edge + own as usize].span_squared);
            self.cell.triangles.push(HermiteTriangle {
                corners: *corners,
                edges: opposite,
                signs,
                nodes,
                quarter: (0.5 / doubled) as f32,
                sixth: (doubled / 12.0) as f32,
                far: FAR * FAR * sides.into_iter().fold(0.0, f32::max),
            });
        }
        self.cell.faces.push(HermiteFace {
            frame,
            corners: first_corner..self.cell.corners.len(),
            edges: first_edge..self.cell.edges.len(),
            triangles: first_triangle..self.cell.triangles.len(),
        });
    }

    /// The node at a facet's point: one for all facets that say the same there.
    fn node(&mut self, own: &'a FacetNodes, point: usize) -> u32 {
        let (labels, alike) = (&self.cell.labels, self.alike);
        let here = self.places.entry(key(own.mesh.points[point], self.step)).or_default();
        let is_same = |&&node: &&u32| {
            let (other, at) = self.said[node as usize];
            labels.iter().all(|&label| {
                let [one, two] = [own.at(point, label), other.at(at, label)];
                (one.value - two.value).abs() <= alike
            })
        };
        if let Some(&known) = here.iter().find(is_same) {
            return known;
        }
        let next = self.said.len() as u32;
        here.push(next);
        self.said.push((own, point));
        self.areas.push(0.0);
        next
    }

    fn finish(mut self, density: bool) -> HermiteCell {
        let mean = self.areas.iter().sum::<f64>() / self.areas.len().max(1) as f64;
        let weight = |area: f64| match density {
            true if area > 0.0 => (mean / area) as f32,
            true => 0.0,
            false => 1.0,
        };
        self.cell.densities = self.areas.iter().map(|&area| weight(area)).collect();
        for &(own, point) in &self.said {
            let local = self.cell.localize(own.mesh.points[point]);
            for &label in &self.cell.labels {
                let Node { value, gradient } = own.at(point, label);
                let gradient = gradient / (self.cell.scale * self.unit);
                let constant = value / self.unit - gradient.dot(local);
                let [x, y, z] = gradient.as_vec3().to_array();
                self.cell.tangents.push([constant as f32, x, y, z]);
            }
        }
        self.cell
    }
}

impl FacetNodes {
    /// What is said about a label at a point.
    pub fn at(&self, point: usize, label: Label) -> Node {
        match self.labels.binary_search(&label) {
            Ok(slot) => self.nodes[point * self.labels.len() + slot],
            Err(_) => Node::default(),
        }
    }
}
