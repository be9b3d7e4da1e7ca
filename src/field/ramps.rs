//! Regions on which the labels' shares are linear: the triangles of unknown
//! regions.
//!
//! Over a triangle with the share φ(y), Ju et al.'s weights of the corners
//! (Bermano, Appendix A) sum up to ∬ φ γ/‖y − x‖⁴ dA. With φ(y) = φ₀ + g·y in
//! coordinates relative to x's foot this is, by Gauss' theorem,
//!
//! ```text
//! 1/(2γ) · Σ_edges (θ/c) · (φ₀ cross(p, q) − γ² cross(g, q − p)),
//! ```
//!
//! θ and c as for constant labels. Let φ be continued linearly from an edge's
//! start p along d = q − p by Δ and across it, to the left, by k per unit of
//! length. Then φ₀ is φ_p + s Δ + k cross(p, q)/|d|, with s = −p·d/|d|² where
//! the foot's own foot on the edge lies, and an edge's term becomes
//!
//! ```text
//! (θ/c) · (cross(p, q) (φ_p + s Δ) + c² k/|d|).
//! ```
//!
//! At an edge between two triangles φ and Δ are the same on both sides; only
//! the difference of k remains. So an edge is evaluated once, for all labels,
//! like a contour.

use glam::DVec2;

/// Below this part of its longest side squared, a triangle's area is
/// rounding, and the shares are not taken to change across it.
pub(super) const NEEDLE: f64 = 1e-9;

/// Triangles on one face, by their edges.
#[derive(Debug, Clone, Default)]
pub(super) struct Ramps {
    /// The triangles' corners.
    triangles: Vec<[u32; 3]>,
    /// All of them, sorted.
    pub corners: Vec<u32>,
    pub edges: Vec<RampEdge>,
}

/// An edge, with a triangle on its left.
#[derive(Debug, Clone)]
pub(super) struct RampEdge {
    /// In the face's frame.
    pub start: DVec2,
    pub end: DVec2,
    corners: [u32; 2],
    /// The same, as places among all corners.
    pub ends: [u32; 2],
    left: Slope,
    right: Option<Slope>,
}

/// How fast shares change across an edge within a triangle, to the edge's
/// left, as weights of the triangle's corners; divided by the edge's length.
#[derive(Debug, Clone)]
struct Slope {
    triangle: u32,
    weights: [f64; 3],
}

/// What an edge adds to a label.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Change {
    /// φ_p.
    pub value: f64,
    /// Δ/|d|².
    pub along: f64,
    /// k/|d|.
    pub across: f64,
}

impl Ramps {
    /// The edges of triangles whose corners are numbers that `place` finds in
    /// the face's frame, counter-clockwise.
    pub fn new(triangles: Vec<[u32; 3]>, place: impl Fn(u32) -> DVec2) -> Self {
        let mut sides: Vec<([u32; 2], u32, [u32; 2])> = Vec::with_capacity(3 * triangles.len());
        for (index, [a, b, c]) in triangles.iter().enumerate() {
            for (start, end) in [(*a, *b), (*b, *c), (*c, *a)] {
                sides.push(([start.min(end), start.max(end)], index as u32, [start, end]));
            }
        }
        sides.sort_unstable();
        let mut all: Vec<u32> = triangles.iter().flatten().copied().collect();
        all.sort_unstable();
        all.dedup();
        let mut ramps = Self { triangles, corners: all, edges: Vec::new() };
        for same in sides.chunk_by(|one, other| one.0 == other.0) {
            let (_, left, corners) = same[0];
            let [start, end] = corners.map(&place);
            if start == end {
                continue;
            }
            let slope = |triangle: u32| Slope {
                triangle,
                weights: weights(ramps.triangles[triangle as usize].map(&place), end - start),
            };
            let (left, right) = (slope(left), same.get(1).map(|&(_, right, _)| slope(right)));
            let ends =
                corners.map(|corner| ramps.corners.partition_point(|&other| other < corner) as u32);
            ramps.edges.push(RampEdge { start, end, corners, ends, left, right });
        }
        ramps
    }

    /// What an edge adds to a label with these shares at the corners.
    pub fn change(&self, edge: &RampEdge, share: impl Fn(u32) -> f64) -> Change {
        let across = |slope: &Slope| -> f64 {
            let corners = self.triangles[slope.triangle as usize];
            corners.iter().zip(slope.weights).map(|(&corner, weight)| weight * share(corner)).sum()
        };
        let left = across(&edge.left);
        if let Some(right) = &edge.right {
            return Change { value: 0.0, along: 0.0, across: left - across(right) };
        }
        let [start, end] = edge.corners.map(share);
        let along = (end - start) / (edge.end - edge.start).length_squared();
        Change { value: start, along, across: left }
    }
}

/// The change of each corner's barycentric coordinate to the left of d, divided
/// by |d|: its gradient is the opposite side, turned left, over twice the area.
fn weights([a, b, c]: [DVec2; 3], d: DVec2) -> [f64; 3] {
    let opposite = [c - b, a - c, b - a];
    let doubled_area = opposite[2].perp_dot(-opposite[1]);
    let longest = opposite.iter().map(|side| side.length_squared()).fold(0.0, f64::max);
    if doubled_area <= NEEDLE * longest {
        return [0.0; 3];
    }
    opposite.map(|side| side.perp().dot(d.perp()) / (doubled_area * d.length_squared()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit square of two triangles, with the share x + 2 y.
    #[test]
    fn shares_linear_on_a_square_change_at_its_border_only() {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
        let place = |corner: u32| points[corner as usize];
        let ramps = Ramps::new(vec![[0, 1, 2], [0, 2, 3]], place);
        let share = |corner: u32| place(corner).x + 2.0 * place(corner).y;
        assert_eq!(ramps.edges.len(), 5);
        for edge in &ramps.edges {
            let change = ramps.change(edge, share);
            let d = edge.end - edge.start;
            if edge.right.is_some() {
                assert_eq!((change.value, change.along), (0.0, 0.0));
                assert!(change.across.abs() < 1e-15);
            } else {
                let gradient = DVec2::new(1.0, 2.0);
                assert_eq!(change.value, share(edge.corners[0]));
                assert!((change.along - gradient.dot(d)).abs() < 1e-15);
                assert!((change.across - gradient.dot(d.perp())).abs() < 1e-15);
            }
        }
    }

    /// A fold: 0 on the left of the diagonal, rising on its right.
    #[test]
    fn a_fold_is_a_change_across_its_edge() {
        let points = [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        let ramps = Ramps::new(vec![[0, 1, 2], [0, 2, 3]], |corner| points[corner as usize]);
        let fold = ramps.edges.iter().find(|edge| edge.right.is_some()).unwrap();
        // One at the lower right corner, which lies √2 from the diagonal and on
        // its left in the first triangle; the diagonal's length is 2 √2.
        let change = ramps.change(fold, |corner| f64::from(u8::from(corner == 1)));
        assert_eq!((change.value, change.along), (0.0, 0.0));
        assert!((change.across - 0.25).abs() < 1e-15);
    }
}
