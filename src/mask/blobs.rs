//! Blobs: where a smooth random field on a rectangle exceeds a threshold.
//!
//! The field is a sum of cosines of random direction and phase. On a lattice
//! over the rectangle, the border of the blobs is found by marching squares;
//! the threshold is bisected until the area within that border is what it
//! should be.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};

use super::{Blobs, cover};
use crate::error::Result;
use crate::label::Label;
use crate::plane::Plane;
use crate::random::Random;
use crate::section::{COVERED, Edge, Rectangle, Section};

/// How many cosines: sums of many look alike everywhere.
const WAVES: usize = 32;
/// Lattice cells in a wavelength.
const CELLS: f64 = 8.0;
/// Rounds of bisection: to 1e-12 of the field's range.
const ROUNDS: usize = 40;
/// How near to a node the border may cross the lattice's edges, relative to
/// their lengths: so its corners are apart, and it does not touch itself.
const NEAREST: f64 = 0.01;

/// A section that covers the wanted part of a rectangle on a plane.
pub(super) fn blobs(
    plane: &Plane,
    rectangle: &Rectangle,
    blobs: &Blobs,
    seed: u64,
) -> Result<Section> {
    let lattice = Lattice::new(rectangle.size(), blobs.size, &mut Random::new(seed));
    let outline = lattice.covering(blobs.fraction);
    let points: Vec<DVec3> =
        outline.points.iter().map(|&point| rectangle.point(rectangle.min + point)).collect();
    let edge = |&[start, end]: &[u32; 2]| Edge { start, end, left: COVERED, right: Label::OUTSIDE };
    let edges: Vec<Edge> = outline.edges.iter().map(edge).collect();
    cover(plane, &points, &edges)
}

/// cos(wave · point + phase)
struct Wave {
    wave: DVec2,
    phase: f64,
}

/// The field at the nodes of a lattice over a rectangle.
struct Lattice {
    /// Of a cell.
    size: DVec2,
    /// Along both sides.
    cells: [usize; 2],
    /// Row by row.
    values: Vec<f64>,
}

/// The border of blobs, which lie left of its edges.
struct Outline<'a> {
    lattice: &'a Lattice,
    threshold: f64,
    points: Vec<DVec2>,
    edges: Vec<[u32; 2]>,
    /// The points at each node, and on the edges to the right and up from it.
    numbers: Vec<[u32; 3]>,
}

impl Lattice {
    /// `part` is the wavelength over the longer side.
    fn new(size: DVec2, part: f64, random: &mut Random) -> Self {
        let wavelength = part * size.max_element();
        let cells = (size / wavelength * CELLS).ceil().max(DVec2::ONE);
        let waves: Vec<Wave> = (0..WAVES)
            .map(|_| Wave {
                wave: TAU / wavelength * DVec2::from_angle(TAU * random.unit()),
                phase: TAU * random.unit(),
            })
            .collect();
        let field = |point: DVec2| -> f64 {
            waves.iter().map(|Wave { wave, phase }| (wave.dot(point) + phase).cos()).sum()
        };
        let [columns, rows] = cells.to_array().map(|count| count as usize);
        let nodes = (0..=rows).flat_map(|row| (0..=columns).map(move |column| [column, row]));
        let place = |node: [usize; 2]| DVec2::from(node.map(|i| i as f64)) * size / cells;
        let values = nodes.map(|node| field(place(node))).collect();
        Self { size: size / cells, cells: [columns, rows], values }
    }

    /// The blobs that cover a part of the rectangle.
    fn covering(&self, fraction: f64) -> Outline<'_> {
        let [columns, rows] = self.cells.map(|count| count as f64);
        let wanted = fraction * (self.size * DVec2::new(columns, rows)).element_product();
        // All is above the first, nothing above the second.
        let mut low = self.values.iter().copied().fold(f64::INFINITY, f64::min) - 1.0;
        let mut high = self.values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        for _ in 0..ROUNDS {
            let middle = f64::midpoint(low, high);
            if Outline::new(self, middle).area() > wanted {
                low = middle;
            } else {
                high = middle;
            }
        }
        Outline::new(self, low)
    }

    fn number(&self, [column, row]: [usize; 2]) -> usize {
        row * (self.cells[0] + 1) + column
    }

    fn value(&self, node: [usize; 2]) -> f64 {
        self.values[self.number(node)]
    }
}

impl<'a> Outline<'a> {
    fn new(lattice: &'a Lattice, threshold: f64) -> Self {
        let numbers = vec![[u32::MAX; 3]; lattice.values.len()];
        let mut outline =
            Self { lattice, threshold, points: Vec::new(), edges: Vec::new(), numbers };
        let [columns, rows] = lattice.cells;
        for row in 0..rows {
            for column in 0..columns {
                outline.add_cell([column, row]);
            }
        }
        outline
    }

    /// The area within.
    fn area(&self) -> f64 {
        let swept = |&[start, end]: &[u32; 2]| {
            self.points[start as usize].perp_dot(self.points[end as usize])
        };
        0.5 * self.edges.iter().map(swept).sum::<f64>()
    }

    /// The border within a cell, and along the rectangle's sides.
    fn add_cell(&mut self, [column, row]: [usize; 2]) {
        let [columns, rows] = self.lattice.cells;
        let corners = [[column, row], [column + 1, row], [column + 1, row + 1], [column, row + 1]];
        let inside = corners.map(|corner| self.covers(corner));
        let on_side = [row == 0, column + 1 == columns, row + 1 == rows, column == 0];
        for i in 0..4 {
            let next = (i + 1) % 4;
            if inside[i] && !inside[next] {
                // Counter-clockwise, a run of covered corners ends here: its
                // border goes back to where it began. So covered corners
                // opposite to each other are apart.
                let begin = (1..4).map(|back| (i + 4 - back) % 4).find(|&j| !inside[j]);
                let begin = begin.unwrap_or(next);
                let from = self.crossing(corners[i], corners[next]);
                let to = self.crossing(corners[begin], corners[(begin + 1) % 4]);
                self.edges.push([from, to]);
            }
            if on_side[i] && (inside[i] || inside[next]) {
                let from = self.end(corners[i], corners[next]);
                let to = self.end(corners[next], corners[i]);
                self.edges.push([from, to]);
            }
        }
    }

    fn covers(&self, node: [usize; 2]) -> bool {
        self.lattice.value(node) > self.threshold
    }

    /// Where the covered part of a lattice edge ends at the side of `node`.
    fn end(&mut self, node: [usize; 2], other: [usize; 2]) -> u32 {
        if self.covers(node) {
            let point = self.place(node);
            self.point(node, 0, point)
        } else {
            self.crossing(node, other)
        }
    }

    /// Where the field takes the threshold between two neighbours.
    fn crossing(&mut self, a: [usize; 2], b: [usize; 2]) -> u32 {
        let (from, to) = (a.min(b), a.max(b));
        let [start, end] = [from, to].map(|node| self.lattice.value(node));
        let part = ((self.threshold - start) / (end - start)).clamp(NEAREST, 1.0 - NEAREST);
        let point = self.place(from).lerp(self.place(to), part);
        self.point(from, if to[0] > from[0] { 1 } else { 2 }, point)
    }

    fn place(&self, node: [usize; 2]) -> DVec2 {
        DVec2::from(node.map(|i| i as f64)) * self.lattice.size
    }

    /// The number of the point in a slot of a node.
    fn point(&mut self, node: [usize; 2], slot: usize, point: DVec2) -> u32 {
        let number = &mut self.numbers[self.lattice.number(node)][slot];
        if *number == u32::MAX {
            *number = self.points.len() as u32;
            self.points.push(point);
        }
        *number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blobs_cover_what_they_should() {
        for (seed, part, fraction) in [(1, 0.2, 0.1), (2, 0.05, 0.5), (3, 1.0, 0.9), (4, 0.3, 1e-3)]
        {
            let size = DVec2::new(30.0, 7.0);
            let lattice = Lattice::new(size, part, &mut Random::new(seed));
            let covered = lattice.covering(fraction).area() / size.element_product();
            assert!((covered - fraction).abs() < 1e-5, "{covered} instead of {fraction}");
        }
    }

    #[test]
    fn borders_close_and_go_around_every_blob() {
        // Two covered corners opposite to each other, of height 1 against 0:
        // at the threshold 0.5 two triangles with legs of half a cell.
        let lattice =
            Lattice { size: DVec2::splat(2.0), cells: [1, 1], values: vec![1.0, 0.0, 0.0, 1.0] };
        let outline = Outline::new(&lattice, 0.5);
        assert_eq!((outline.points.len(), outline.edges.len()), (6, 6));
        assert_eq!(outline.area(), 1.0);
        let mut degree = vec![0; 6];
        for &[start, end] in &outline.edges {
            degree[start as usize] += 1;
            degree[end as usize] -= 1;
        }
        assert_eq!(degree, [0; 6]);
        assert_eq!(Outline::new(&lattice, -1.0).area(), 4.0);
    }
}
