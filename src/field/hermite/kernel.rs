//! The evaluation of one cell for a block of points, one point per lane; as in `field/kernel`
//! there are loops where iterators would be shorter.
//!
//! Small triangles far away take most of the time, and the closed form loses digits on them: it
//! is a small difference of large numbers. There the integral that it is, of γ/r⁴ times a corner's
//! share, is taken from the values in the middle of the edges, which is right for quadratic ones.

use glam::DVec3;

use super::packing::{HermiteCell, HermiteEdge, HermiteFace, HermiteTriangle};
use crate::field::kernel::{Corner, Feet, angle};
use crate::field::lanes::Lanes;

/// What is needed on the way; what it holds does not matter.
pub struct Scratch<const N: usize, const FMA: bool> {
    corners: Vec<Corner<N, FMA>>,
    edges: Vec<Lanes<N, FMA>>,
    /// For every node its weight.
    weights: Vec<[f32; N]>,
}

impl<const N: usize, const FMA: bool> Default for Scratch<N, FMA> {
    fn default() -> Self {
        Self { corners: Vec::new(), edges: Vec::new(), weights: Vec::new() }
    }
}

/// Every label's value for up to `N` points; the lanes beyond them repeat the last one.
#[inline(always)]
pub fn values<const N: usize, const FMA: bool>(
    cell: &HermiteCell,
    points: &[DVec3],
    scratch: &mut Scratch<N, FMA>,
    values: &mut [[f32; N]],
) {
    let Some(last) = points.len().checked_sub(1) else { return };
    let local: [DVec3; N] = std::array::from_fn(|lane| cell.localize(points[lane.min(last)]));
    let axes = [0, 1, 2].map(|axis| local.map(|point| point[axis]));
    scratch.weights.clear();
    scratch.weights.resize(cell.densities.len(), [0.0; N]);
    for face in &cell.faces {
        let feet = Feet::<N, FMA>::new(&face.frame, &axes, cell.clearance);
        add_face(cell, face, &feet, scratch);
    }
    blend(cell, axes.map(|axis| axis.map(|along| along as f32)), &scratch.weights, values);
}

/// Adds the weights of a face's corners to those of the nodes.
#[inline(always)]
fn add_face<const N: usize, const FMA: bool>(
    cell: &HermiteCell,
    face: &HermiteFace,
    feet: &Feet<N, FMA>,
    scratch: &mut Scratch<N, FMA>,
) {
    let Scratch { corners, edges, weights } = scratch;
    let gamma = Lanes(feet.gamma);
    let gamma_squared = gamma * gamma;
    let inverse = gamma.reciprocal();
    corners.clear();
    for corner in &cell.corners[face.corners.clone()] {
        corners.push(feet.corner(corner.at, corner.rest, gamma_squared));
    }
    // 1 / r⁴ in the middle of every edge.
    edges.clear();
    for edge in &cell.edges[face.edges.clone()] {
        let (start, end) = (&corners[edge.ends[0] as usize], &corners[edge.ends[1] as usize]);
        let sum = start.r_squared + end.r_squared;
        let middle = sum.mul_add(Lanes::splat(0.5), Lanes::splat(-0.25 * edge.span_squared));
        let inverse = middle.reciprocal();
        edges.push(inverse * inverse);
    }
    let own_edges = &cell.edges[face.edges.clone()];
    for triangle in &cell.triangles[face.triangles.clone()] {
        let [a, b, c] = triangle.edges.map(|edge| edges[edge as usize]);
        let share = gamma * Lanes::splat(triangle.sixth);
        let mut found = [share * (b + c), share * (c + a), share * (a + b)];
        let [x, y, z] = triangle.corners.map(|corner| corners[corner as usize].r_squared);
        let beyond = x.min(y).min(z) - Lanes::splat(triangle.far);
        if beyond.any_negative() {
            let near = near_weights(triangle, own_edges, corners, [gamma, gamma_squared, inverse]);
            for corner in 0..3 {
                found[corner] = beyond.if_negative(near[corner], found[corner]);
            }
        }
        for corner in 0..3 {
            let sum = &mut weights[triangle.nodes[corner] as usize];
            *sum = (Lanes::<N, FMA>(*sum) + found[corner]).0;
        }
    }
}

/// The weights of a triangle's corners in closed form. Both triangles of an edge must take the
/// same angle, else what is wrong with it does not cancel between them.
#[inline(always)]
fn near_weights<const N: usize, const FMA: bool>(
    triangle: &HermiteTriangle,
    edges: &[HermiteEdge],
    corners: &[Corner<N, FMA>],
    [gamma, gamma_squared, inverse]: [Lanes<N, FMA>; 3],
) -> [Lanes<N, FMA>; 3] {
    let mut crosses = [Lanes::splat(0.0); 3];
    let mut spans = [[Lanes::splat(0.0); 2]; 3];
    let mut all = Lanes::splat(0.0);
    let (mut all_u, mut all_v) = (Lanes::splat(0.0), Lanes::splat(0.0));
    for own in 0..3 {
        let (edge, sign) = (&edges[triangle.edges[own] as usize], triangle.signs[own]);
        let (start, end) = (&corners[edge.ends[0] as usize], &corners[edge.ends[1] as usize]);
        let angle = angle(start, end, edge.span, edge.span_squared, gamma_squared);
        crosses[own] = angle.cross * Lanes::splat(sign);
        spans[own] = edge.span.map(|along| Lanes::splat(sign * along));
        all = angle.ratio.mul_add(crosses[own], all);
        all_u = angle.ratio.mul_add(spans[own][0], all_u);
        all_v = angle.ratio.mul_add(spans[own][1], all_v);
    }
    let quarter = Lanes::splat(triangle.quarter);
    let across = all * inverse * quarter;
    let along = gamma * quarter;
    let mut weights = [Lanes::splat(0.0); 3];
    for own in 0..3 {
        let [du, dv] = spans[own];
        weights[own] = crosses[own] * across + along * du.mul_add(all_u, dv * all_v);
    }
    weights
}

/// Eq. 3 from the nodes' weights.
#[inline(always)]
fn blend<const N: usize>(
    cell: &HermiteCell,
    [x, y, z]: [[f32; N]; 3],
    weights: &[[f32; N]],
    values: &mut [[f32; N]],
) {
    let mut total = [0.0; N];
    for weight in weights {
        for lane in 0..N {
            total[lane] += weight[lane];
        }
    }
    let inverse = total.map(|total| 1.0 / total);
    let labels = cell.labels.len();
    let mut sum = [0.0; N];
    values.fill([0.0; N]);
    for (node, weight) in weights.iter().enumerate() {
        let density = cell.densities[node];
        let mut part = [0.0; N];
        for lane in 0..N {
            let share = weight[lane] * inverse[lane];
            part[lane] = density * share * share * (3.0 - 2.0 * share);
            sum[lane] += part[lane];
        }
        let tangents = &cell.tangents[node * labels..(node + 1) * labels];
        for (value, [c, gx, gy, gz]) in values.iter_mut().zip(tangents) {
            for lane in 0..N {
                let tangent = c + gx * x[lane] + gy * y[lane] + gz * z[lane];
                value[lane] += part[lane] * tangent;
            }
        }
    }
    for value in values {
        for lane in 0..N {
            value[lane] /= sum[lane];
        }
    }
}
