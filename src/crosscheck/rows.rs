//! The lattice's nodes in a convex cell: in every row along z, one range.

use std::ops::Range;

use glam::DVec3;

use crate::complex::Complex;
use crate::grid::samples::Lattice;
use crate::plane::{Bounds, Plane};

/// The nodes of a cell by rows.
#[derive(Debug, Clone)]
pub struct Rows {
    /// The first row.
    first: [i32; 2],
    /// How many rows along x and y.
    pub dims: [usize; 2],
    /// The nodes of each row; row (x, y) is at `x * dims[1] + y`.
    ranges: Vec<Range<i32>>,
}

impl Rows {
    /// The nodes in a cell that are in the box; `None` where there are none.
    pub fn new(complex: &Complex, cell: u32, lattice: &Lattice) -> Option<Self> {
        let corners = complex.facets_of(cell).flat_map(|(_, facet)| &facet.outline).copied();
        let bounds = Bounds::around(corners)?;
        let nodes = |point: DVec3| (point - lattice.origin) / lattice.voxel;
        let (low, high) = (nodes(bounds.min).ceil(), nodes(bounds.max).floor());
        let range = |axis: usize| {
            let start = (low[axis] as i32).max(1);
            start..(high[axis] as i32 + 1).min(lattice.dims[axis] - 1).max(start)
        };
        let [x, y, z] = [range(0), range(1), range(2)];
        let walls = walls(complex, cell);
        let mut ranges = Vec::with_capacity(x.len() * y.len());
        for i in x.clone() {
            ranges.extend(y.clone().map(|j| row_range(&walls, lattice, [i, j], z.clone())));
        }
        let any = ranges.iter().any(|range| !range.is_empty());
        any.then(|| Self { first: [x.start, y.start], dims: [x.len(), y.len()], ranges })
    }

    /// The nodes of a row, along z.
    pub fn range(&self, [x, y]: [usize; 2]) -> Range<i32> {
        self.ranges[x * self.dims[1] + y].clone()
    }

    /// Those of them whose six neighbours are in the cell; where there are none,
    /// an empty range at the end.
    pub fn inner(&self, [x, y]: [usize; 2]) -> Range<i32> {
        let own = self.range([x, y]);
        let mut inner = own.start + 1..own.end - 1;
        for (x, y) in [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)] {
            let is_row = x < self.dims[0] && y < self.dims[1];
            let other = if is_row { self.range([x, y]) } else { 0..0 };
            inner = inner.start.max(other.start)..inner.end.min(other.end);
        }
        if inner.is_empty() { own.end..own.end } else { inner }
    }

    /// The node of a row at a place along z.
    pub fn node(&self, [x, y]: [usize; 2], z: i32) -> [i32; 3] {
        [self.first[0] + x as i32, self.first[1] + y as i32, z]
    }
}

/// The planes of a cell's facets, each turned to the cell.
fn walls(complex: &Complex, cell: u32) -> Vec<Plane> {
    let inward = complex.facets_of(cell).map(|(_, facet)| {
        let plane = complex.planes()[facet.plane];
        if facet.cells[0] == Some(cell) {
            plane
        } else {
            Plane { normal: -plane.normal, offset: -plane.offset }
        }
    });
    inward.collect()
}

/// The part of a row that is in front of all walls.
fn row_range(walls: &[Plane], lattice: &Lattice, [x, y]: [i32; 2], z: Range<i32>) -> Range<i32> {
    let foot = lattice.position([x, y, 0]);
    let (mut low, mut high) = (f64::from(z.start), f64::from(z.end - 1));
    for wall in walls {
        // In front of the wall where value + slope · z is not negative.
        let (value, slope) = (wall.normal.dot(foot) - wall.offset, wall.normal.z * lattice.voxel);
        if slope > 0.0 {
            low = low.max((-value / slope).ceil());
        } else if slope < 0.0 {
            high = high.min((-value / slope).floor());
        } else if value < 0.0 {
            return z.start..z.start;
        }
    }
    if low > high { z.start..z.start } else { low as i32..high as i32 + 1 }
}
