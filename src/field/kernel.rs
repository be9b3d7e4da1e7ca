//! The evaluation of one cell for a block of points, one point per lane.
//!
//! There are loops where iterators would be shorter: what is handed a closure
//! may become a function of its own, which is compiled without the caller's
//! vector instructions.

use glam::DVec3;

use super::lanes::Lanes;
use super::packing::{BORDER, Chain, Frame, PackedCell, PackedEdge, PackedFace, Part, split};

/// A block's feet on a plane.
pub(super) struct Feet<const N: usize, const FMA: bool> {
    /// The parts on the grid.
    coarse: [Lanes<N, FMA>; 2],
    /// The remainders.
    rest: [Lanes<N, FMA>; 2],
    /// |γ|, clamped.
    pub gamma: [f32; N],
}

/// A vertex as seen from a block's feet.
#[derive(Clone, Copy)]
pub(super) struct Corner<const N: usize, const FMA: bool> {
    p: [Lanes<N, FMA>; 2],
    /// ‖p‖² + γ².
    pub r_squared: Lanes<N, FMA>,
    r: Lanes<N, FMA>,
}

/// W_l of every label l of a cell, up to a common factor, for up to `N`
/// points; the lanes beyond them repeat the last one. What `scratch` holds does
/// not matter.
#[inline(always)]
pub(super) fn weights<const N: usize, const FMA: bool>(
    cell: &PackedCell,
    part: Part,
    points: &[DVec3],
    scratch: &mut Vec<Corner<N, FMA>>,
    weights: &mut [[f32; N]],
) {
    let Some(last) = points.len().checked_sub(1) else { return };
    let local: [DVec3; N] = std::array::from_fn(|lane| cell.localize(points[lane.min(last)]));
    let axes = [0, 1, 2].map(|axis| local.map(|point| point[axis]));
    weights.fill([0.0; N]);
    for (index, face) in cell.faces.iter().enumerate() {
        let [known, unknown] = part.of_face(index);
        if known || unknown && face.first_ramp < face.end_ramp {
            let feet = Feet::<N, FMA>::new(&face.frame, &axes, cell.clearance);
            if known {
                add_chains(cell, face, &feet, weights);
            }
            if unknown {
                add_ramps(cell, part, face, &feet, scratch, weights);
            }
        }
    }
}

#[inline(always)]
fn add_chains<const N: usize, const FMA: bool>(
    cell: &PackedCell,
    face: &PackedFace,
    feet: &Feet<N, FMA>,
    weights: &mut [[f32; N]],
) {
    for chain in &cell.chains[face.first_chain as usize..face.end_chain as usize] {
        let edges = &cell.edges[chain.first_edge as usize..chain.end_edge as usize];
        let sum = feet.chain_sum(chain, edges);
        // I = S / (2 |γ|); the 2 cancels in f.
        let share: [f32; N] = std::array::from_fn(|lane| sum.0[lane] / feet.gamma[lane]);
        add(&mut weights[chain.left as usize], &share, 1.0);
        if chain.right != BORDER {
            add(&mut weights[chain.right as usize], &share, -1.0);
        }
    }
}

#[inline(always)]
fn add_ramps<const N: usize, const FMA: bool>(
    cell: &PackedCell,
    part: Part,
    face: &PackedFace,
    feet: &Feet<N, FMA>,
    corners: &mut Vec<Corner<N, FMA>>,
    weights: &mut [[f32; N]],
) {
    let gamma = Lanes(feet.gamma);
    let gamma_squared = gamma * gamma;
    corners.clear();
    for corner in &cell.corners[face.corners()] {
        corners.push(feet.corner(corner.at, corner.rest, gamma_squared));
    }
    let mut inverse = gamma.reciprocal();
    if part != Part::All {
        // Two unknown regions that meet on a line would see nothing there but
        // each other.
        inverse = gamma.map(|gamma| if gamma > cell.clearance { 1.0 / gamma } else { 0.0 });
    }
    for ramp in &cell.ramps[face.ramps()] {
        let (start, end) = (&corners[ramp.ends[0] as usize], &corners[ramp.ends[1] as usize]);
        let Angle { ratio, cross, c_squared } =
            angle(start, end, ramp.span, ramp.span_squared, gamma_squared);
        let ratio = ratio * inverse;
        // What a share of one at the edge adds, what its rise along the edge
        // does, and what its rise across it.
        let constant = cross * ratio;
        let (dx, dy) = (Lanes::splat(-ramp.span[0]), Lanes::splat(-ramp.span[1]));
        let along = constant * (start.p[0] * dx + start.p[1] * dy);
        let across = c_squared * ratio;
        for slope in &cell.slopes[ramp.first_slope as usize..ramp.end_slope as usize] {
            let value = Lanes::splat(slope.value) * constant;
            let value = Lanes::splat(slope.along).mul_add(along, value);
            let value = Lanes::splat(slope.across).mul_add(across, value);
            add(&mut weights[slope.label as usize], &value.0, 1.0);
        }
    }
}

#[inline(always)]
fn add<const N: usize>(sum: &mut [f32; N], share: &[f32; N], sign: f32) {
    for lane in 0..N {
        sum[lane] += sign * share[lane];
    }
}

impl<const N: usize, const FMA: bool> Feet<N, FMA> {
    /// In f64: a cell can be thin, and γ is a small difference of large
    /// numbers close to a plane.
    #[inline(always)]
    pub fn new(frame: &Frame, [x, y, z]: &[[f64; N]; 3], clearance: f32) -> Self {
        let along = |direction: DVec3, offset: f64, lane: usize| {
            direction.x * x[lane] + (direction.y * y[lane] + (direction.z * z[lane] + offset))
        };
        let mut feet = Self {
            coarse: [Lanes::splat(0.0); 2],
            rest: [Lanes::splat(0.0); 2],
            gamma: [clearance; N],
        };
        for lane in 0..N {
            for axis in 0..2 {
                let (coarse, rest) = split(along(frame.tangents[axis], 0.0, lane));
                feet.coarse[axis].0[lane] = coarse;
                feet.rest[axis].0[lane] = rest;
            }
            let gamma = along(frame.normal, frame.offset, lane).abs() as f32;
            feet.gamma[lane] = gamma.max(clearance);
        }
        feet
    }

    #[inline(always)]
    pub fn corner(
        &self,
        at: [f32; 2],
        rest: [f32; 2],
        gamma_squared: Lanes<N, FMA>,
    ) -> Corner<N, FMA> {
        let p = [self.offset(0, at, rest), self.offset(1, at, rest)];
        let r_squared = p[0].mul_add(p[0], p[1].mul_add(p[1], gamma_squared));
        Corner { p, r_squared, r: r_squared.sqrt() }
    }

    /// One coordinate of a vertex relative to the feet.
    #[inline(always)]
    fn offset(&self, axis: usize, at: [f32; 2], rest: [f32; 2]) -> Lanes<N, FMA> {
        let coarse = Lanes::splat(at[axis]) - self.coarse[axis];
        coarse + (Lanes::splat(rest[axis]) - self.rest[axis])
    }

    /// Σ θ · cross(p, q) / c along a chain.
    #[inline(always)]
    fn chain_sum(&self, chain: &Chain, edges: &[PackedEdge]) -> Lanes<N, FMA> {
        let gamma = Lanes(self.gamma);
        let gamma_squared = gamma * gamma;
        let mut start = self.corner(chain.start, chain.start_rest, gamma_squared);
        let mut sum = Lanes::splat(0.0);
        for edge in edges {
            let end = self.corner(edge.end, edge.end_rest, gamma_squared);
            let Angle { ratio, cross, .. } =
                angle(&start, &end, edge.span, edge.span_squared, gamma_squared);
            sum = sum + cross * ratio;
            start = end;
        }
        sum
    }
}

/// What an edge is to a block's points.
pub(super) struct Angle<const N: usize, const FMA: bool> {
    /// θ / c.
    pub ratio: Lanes<N, FMA>,
    /// cross(p, q).
    pub cross: Lanes<N, FMA>,
    c_squared: Lanes<N, FMA>,
}

/// θ / c, cross(p, q) and c² for one edge.
///
/// With D = p·q + γ² = r_p r_q cos θ and c = r_p r_q sin θ, the tangent
/// t = c / (r_p r_q + |D|) is that of θ/2, or of (π − θ)/2 where D < 0, and
/// always in [0, 1]; no large numbers cancel in it. So θ/c is
/// g = 2 (atan t / t) / (r_p r_q + |D|), or π/c − g where D < 0. Only there,
/// where the edge is seen under more than a right angle, c itself is needed.
#[inline(always)]
pub(super) fn angle<const N: usize, const FMA: bool>(
    start: &Corner<N, FMA>,
    end: &Corner<N, FMA>,
    span: [f32; 2],
    span_squared: f32,
    gamma_squared: Lanes<N, FMA>,
) -> Angle<N, FMA> {
    let [dx, dy] = span.map(Lanes::<N, FMA>::splat);
    let [px, py] = start.p;
    // cross(p, q) = cross(p, d) and p·q + γ² = r_p² + p·d, with d = q − p.
    let cross = px * dy - py * dx;
    let dot = px.mul_add(dx, py.mul_add(dy, start.r_squared));
    let c_squared = cross.mul_add(cross, gamma_squared * Lanes::splat(span_squared));
    let inverse = start.r.mul_add(end.r, dot.map(f32::abs)).reciprocal();
    let tangent_squared = (c_squared * inverse) * inverse;
    let ratio = Lanes::splat(2.0) * tangent_squared.arctangent_ratio() * inverse;
    if !dot.any_negative() {
        return Angle { ratio, cross, c_squared };
    }
    let supplement = Lanes::splat(std::f32::consts::PI) * c_squared.sqrt().reciprocal() - ratio;
    Angle { ratio: dot.if_negative(supplement, ratio), cross, c_squared }
}
