//! Which cell a point lies in, by walking from cell to cell.

use std::cell::Cell;

use glam::DVec3;

use super::Complex;
use crate::plane::{Bounds, Plane};

/// Below this products of doubles are not to be trusted.
const TINY: f64 = 1e-250;

/// Finds the cells of points in a part of the box, each from the one found before.
#[derive(Debug, Clone)]
pub struct Locator<'a> {
    complex: &'a Complex,
    last: Cell<u32>,
    /// Whether all points of the region are in one cell.
    is_in_one: bool,
}

impl<'a> Locator<'a> {
    /// For points of the region; those outside the box count as the nearest
    /// ones in it.
    pub(super) fn new(complex: &'a Complex, region: Bounds) -> Self {
        let clamp = |point: DVec3| point.clamp(complex.bounds.min, complex.bounds.max);
        let (min, max) = (clamp(region.min), clamp(region.max));
        let (center, half) = ((min + max) / 2.0, (max - min) / 2.0);
        let cell = walk(complex, first_cell(complex), center);
        // Over the region n · x − o varies by this much; rounding adds to it.
        let is_beside = |plane: &Plane| {
            let value = plane.normal.dot(center) - plane.offset;
            let reach = plane.normal.abs().dot(half);
            let size = plane.normal.abs().dot(center.abs() + half) + plane.offset.abs();
            value.abs() > reach + 1e-12 * size
        };
        let mut inner = complex.facets_of(cell).filter(|(_, facet)| !facet.cells.contains(&None));
        let is_in_one = inner.all(|(_, facet)| is_beside(&complex.planes[facet.plane]));
        Self { complex, last: Cell::new(cell), is_in_one }
    }

    /// The cell of all points of the region, if there is one alone.
    pub fn only_cell(&self) -> Option<u32> {
        self.is_in_one.then(|| self.last.get())
    }

    /// As [`Complex::locate`], for a point of the region.
    pub fn locate(&self, point: DVec3) -> u32 {
        if !self.is_in_one {
            self.last.set(walk(self.complex, self.last.get(), point));
        }
        self.last.get()
    }
}

/// Where to begin when nothing is known.
pub(super) fn first_cell(complex: &Complex) -> u32 {
    complex.cells.ids().next().unwrap_or(0)
}

/// The cell of a point. Cells are convex, so a walk that leaves each through any facet that
/// the point is beyond crosses every plane once at most.
pub(super) fn walk(complex: &Complex, start: u32, point: DVec3) -> u32 {
    let point = point.clamp(complex.bounds.min, complex.bounds.max);
    let mut cell = start;
    loop {
        let beyond = complex.facets_of(cell).find_map(|(_, facet)| {
            let [front, behind] = facet.cells;
            let (own, other) = if front == Some(cell) { (1, behind) } else { (-1, front) };
            let next = other?;
            (side(&complex.planes[facet.plane], point) != own).then_some(next)
        });
        match beyond {
            Some(next) => cell = next,
            None => return cell,
        }
    }
}

/// The side (−1, 1) of a plane that a point is on, exactly. On the plane it is that of the
/// point moved by (δ, δ², δ³) for a small δ.
fn side(plane: &Plane, point: DVec3) -> i8 {
    let products = plane.normal * point;
    let value = products.x + products.y + products.z - plane.offset;
    // Products and sums are each rounded by less than 2^-52, unless they are too small for that.
    let size = products.abs().element_sum() + plane.offset.abs();
    let is_certain = value.abs() > 4e-15 * size + TINY;
    let value = if is_certain { value } else { exact_value(&enlarged(plane, size), point) };
    let along = || plane.normal.to_array().into_iter().find(|&part| part != 0.0).unwrap_or(1.0);
    let value = if value == 0.0 { along() } else { value };
    if value > 0.0 { 1 } else { -1 }
}

/// A plane whose products with points do not underflow: where their size is near to that, all
/// numbers are multiplied by a power of two.
fn enlarged(plane: &Plane, size: f64) -> Plane {
    let factor = if size < TINY { 2.0_f64.powi(600) } else { 1.0 };
    Plane { normal: factor * plane.normal, offset: factor * plane.offset }
}

/// A number with the sign of n · x − o: the last part of its sum as an expansion, in which
/// rounding errors are parts of their own (Shewchuk 1997).
fn exact_value(plane: &Plane, point: DVec3) -> f64 {
    let mut sum = vec![-plane.offset];
    for axis in 0..3 {
        let (factor, other) = (plane.normal[axis], point[axis]);
        let product = factor * other;
        for part in [factor.mul_add(other, -product), product] {
            let mut carried = part;
            for term in &mut sum {
                let total = carried + *term;
                let virtual_term = total - carried;
                let error = (carried - (total - virtual_term)) + (*term - virtual_term);
                (*term, carried) = (error, total);
            }
            sum.push(carried);
        }
    }
    sum.into_iter().rev().find(|&term| term != 0.0).unwrap_or(0.0)
}
