//! Complexes built by hand, and random directions, for the tests.

use std::collections::BTreeSet;

use glam::{DMat3, DVec2, DVec3};

use super::{Queries, Run};
use crate::complex::{Cell, Complex, Facet, FacetEdge};
use crate::label::Label;
use crate::plane::{Bounds, Plane};
use crate::random::Random;

impl Random {
    /// In [−1, 1) for every component.
    pub fn signed(&mut self) -> DVec3 {
        let mut next = || 2.0 * self.unit() - 1.0;
        DVec3::new(next(), next(), next())
    }

    /// By random directions.
    pub fn rotation(&mut self) -> DMat3 {
        let x = self.signed().normalize();
        let y = x.cross(self.signed()).normalize();
        DMat3::from_cols(x, y, x.cross(y))
    }
}

/// A polygon between two labels, counter-clockwise around `inside`.
#[derive(Debug, Clone)]
pub struct Patch {
    pub corners: Vec<DVec2>,
    pub inside: Label,
    pub around: Label,
}

impl Patch {
    pub fn disc(centre: DVec2, radius: f64, corners: usize, inside: u32, around: u32) -> Self {
        let corners = (0..corners)
            .map(|i| std::f64::consts::TAU * i as f64 / corners as f64)
            .map(|angle| centre + radius * DVec2::from_angle(angle))
            .collect();
        Self { corners, inside: Label(inside), around: Label(around) }
    }
}

/// What is on one of a stack's parallel planes: a label with patches in it.
#[derive(Debug, Clone)]
pub struct Pattern {
    pub ground: Label,
    pub patches: Vec<Patch>,
}

impl Pattern {
    pub fn plain(label: u32) -> Self {
        Self { ground: Label(label), patches: Vec::new() }
    }
}

/// Boxes on top of one another, moved rigidly and scaled: cell i is
/// [−1, 1]² × [i, i + 1] × `thickness` before that, with pattern i below it
/// and pattern i + 1 above; its four walls are `walls`.
#[derive(Debug, Clone)]
pub struct Stack {
    pub patterns: Vec<Pattern>,
    pub walls: Label,
    pub thickness: f64,
    pub rotation: DMat3,
    pub scale: f64,
    pub offset: DVec3,
}

impl Stack {
    pub fn new(patterns: Vec<Pattern>) -> Self {
        Self {
            patterns,
            walls: Label::OUTSIDE,
            thickness: 1.0,
            rotation: DMat3::IDENTITY,
            scale: 1.0,
            offset: DVec3::ZERO,
        }
    }

    /// To the world.
    pub fn place(&self, point: DVec3) -> DVec3 {
        self.offset + self.scale * (self.rotation * point)
    }

    fn plane(&self, normal: DVec3, through: DVec3) -> Plane {
        let normal = self.rotation * normal;
        Plane { normal, offset: normal.dot(self.place(through)) }
    }

    pub fn cell_count(&self) -> usize {
        self.patterns.len() - 1
    }

    pub fn complex(&self) -> Complex {
        let cells = self.cell_count() as u32;
        let mut planes = Vec::new();
        let mut facets = Vec::new();
        for (level, pattern) in self.patterns.iter().enumerate() {
            let z = level as f64 * self.thickness;
            planes.push(self.plane(DVec3::Z, DVec3::new(0.0, 0.0, z)));
            facets.push(self.level_facet(level as u32, z, pattern));
        }
        for wall in 0..4 {
            let turn = DMat3::from_rotation_z(f64::from(wall) * std::f64::consts::FRAC_PI_2);
            planes.push(self.plane(turn * DVec3::X, turn * DVec3::X));
            let plane = planes.len() as u32 - 1;
            facets.extend((0..cells).map(|cell| self.wall_facet(plane, cell, turn)));
        }
        let cells = (0..cells).map(|cell| self.cell(cell, &facets)).collect();
        let corners =
            facets.iter().flat_map(|facet: &Facet| facet.edges.iter().map(|edge| edge.start));
        let bounds = Bounds::around(corners).unwrap();
        let border = Label::OUTSIDE;
        let names = Default::default();
        Complex {
            bounds,
            border,
            planes: planes.into(),
            facets: facets.into(),
            cells: Vec::into(cells),
            names,
        }
    }

    fn level_facet(&self, plane: u32, z: f64, pattern: &Pattern) -> Facet {
        let lift = |point: DVec2| self.place(point.extend(z));
        let square = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(DVec2::from);
        let mut edges = border(&square.map(lift), pattern.ground, None);
        for patch in &pattern.patches {
            let corners: Vec<_> = patch.corners.iter().copied().map(lift).collect();
            edges.extend(border(&corners, patch.inside, Some(patch.around)));
        }
        let above = (plane < self.cell_count() as u32).then_some(plane);
        facet(plane, [above, plane.checked_sub(1)], edges)
    }

    /// A wall, seen from outside.
    fn wall_facet(&self, plane: u32, cell: u32, turn: DMat3) -> Facet {
        let (low, high) = (f64::from(cell) * self.thickness, f64::from(cell + 1) * self.thickness);
        let corners = [(-1.0, low), (1.0, low), (1.0, high), (-1.0, high)]
            .map(|(y, z)| self.place(turn * DVec3::new(1.0, y, z)));
        facet(plane, [None, Some(cell)], border(&corners, self.walls, None))
    }

    fn cell(&self, index: u32, facets: &[Facet]) -> Cell {
        let own: Vec<u32> = (0..facets.len() as u32)
            .filter(|&facet| facets[facet as usize].cells.contains(&Some(index)))
            .collect();
        let labels: BTreeSet<Label> =
            own.iter().flat_map(|&facet| facets[facet as usize].labels.iter().copied()).collect();
        Cell { facets: own, labels: labels.into_iter().collect() }
    }

    /// Points in all cells, a run for each cell.
    pub fn queries(&self, random: &mut Random, per_cell: usize) -> Queries {
        let mut queries = Queries::default();
        for cell in 0..self.cell_count() {
            let first = queries.points.len();
            for _ in 0..per_cell {
                let point = random.signed();
                let z = (cell as f64 + 0.5 + 0.5 * point.z) * self.thickness;
                queries.points.push(self.place(DVec3::new(point.x, point.y, z)));
            }
            let points = first..queries.points.len();
            queries.runs.push(Run { cell: cell as u32, points });
        }
        queries
    }
}

fn border(corners: &[DVec3], left: Label, right: Option<Label>) -> Vec<FacetEdge> {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(&start, &end)| FacetEdge { start, end, left, right }).collect()
}

fn facet(plane: u32, cells: [Option<u32>; 2], edges: Vec<FacetEdge>) -> Facet {
    let labels: BTreeSet<Label> =
        edges.iter().flat_map(|edge| [Some(edge.left), edge.right]).flatten().collect();
    let outline = Vec::new();
    Facet { plane, cells, labels: labels.into_iter().collect(), edges, outline }
}

/// Discs of 2 to `labels` next to one another, in label 1, with a ring in
/// each; on either side of a stack of two.
pub fn busy_stack(random: &mut Random, labels: u32, corners: usize) -> Stack {
    let side = f64::from(labels).sqrt().ceil();
    let mut patterns = Vec::new();
    for level in 0..3 {
        let mut pattern = Pattern::plain(1);
        for label in 2..=labels {
            let index = f64::from(label - 2 + level) % (side * side);
            let at = DVec2::new(index % side, (index / side).floor());
            let centre = (2.0 * at + 1.0) / side - 1.0;
            let radius = (0.5 + 0.45 * random.unit()) / side;
            pattern.patches.push(Patch::disc(centre, radius, corners, label, 1));
            pattern.patches.push(Patch::disc(centre, radius * 0.6, corners, 0, label));
        }
        patterns.push(pattern);
    }
    let mut stack = Stack::new(patterns);
    stack.rotation = random.rotation();
    stack.scale = 37.0;
    stack.offset = 100.0 * random.signed();
    stack
}

/// The same with every other disc of the middle plane unknown, and one on the
/// lowest.
pub fn doubtful_stack(random: &mut Random, labels: u32, corners: usize) -> Stack {
    let mut stack = busy_stack(random, labels, corners);
    for (level, step) in [(0, 100), (1, 4)] {
        // Discs and the rings in them take turns: both of a pair.
        let patches = &mut stack.patterns[level].patches;
        for first in (0..patches.len()).step_by(step) {
            patches[first].inside = Label::UNKNOWN;
            patches[first + 1].around = Label::UNKNOWN;
        }
    }
    stack
}
