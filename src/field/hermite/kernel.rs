//! The evaluation of one cell for a block of points, one point per lane; as in `field/kernel`
//! there are loops where iterators would be shorter.

use glam::DVec3;

use super::packing::{HermiteCell, HermiteFace};
use crate::field::kernel::{Corner, Feet, angle};
use crate::field::lanes::Lanes;

/// What is needed on the way; what it holds does not matter.
pub struct Scratch<const N: usize, const FMA: bool> {
    corners: Vec<Corner<N, FMA>>,
    edges: Vec<[Lanes<N, FMA>; 2]>,
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
    // Triangles on both sides of an edge must take the same angle, else what is wrong with it
    // does not cancel between them.
    edges.clear();
    for edge in &cell.edges[face.edges.clone()] {
        let (start, end) = (&corners[edge.ends[0] as usize], &corners[edge.ends[1] as usize]);
        let angle = angle(start, end, edge.span, edge.span_squared, gamma_squared);
        edges.push([angle.ratio, angle.cross]);
    }
    let spans = &cell.edges[face.edges.clone()];
    for triangle in &cell.triangles[face.triangles.clone()] {
        let mut all = Lanes::splat(0.0);
        let (mut all_u, mut all_v) = (Lanes::splat(0.0), Lanes::splat(0.0));
        for corner in 0..3 {
            let (own, sign) = (triangle.edges[corner] as usize, triangle.signs[corner]);
            let [ratio, cross] = edges[own];
            let signed = ratio * Lanes::splat(sign);
            all = signed.mul_add(cross, all);
            all_u = signed.mul_add(Lanes::splat(spans[own].span[0]), all_u);
            all_v = signed.mul_add(Lanes::splat(spans[own].span[1]), all_v);
        }
        let quarter = Lanes::splat(triangle.quarter);
        let across = all * inverse * quarter;
        let along = gamma * quarter;
        for corner in 0..3 {
            let (own, sign) = (triangle.edges[corner] as usize, triangle.signs[corner]);
            let [du, dv] = spans[own].span.map(|along| Lanes::<N, FMA>::splat(sign * along));
            let cross = edges[own][1] * Lanes::splat(sign);
            let weight = cross * across + along * du.mul_add(all_u, dv * all_v);
            let sum = &mut weights[triangle.nodes[corner] as usize];
            for lane in 0..N {
                sum[lane] += weight.0[lane];
            }
        }
    }
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
