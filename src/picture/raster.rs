//! Triangles to samples: which one is nearest at every sample of some rows.
//!
//! Corners are rounded to 1/256 of a sample, so that edge functions are exact
//! integers: neighbours leave no gap, and a sample on a shared edge belongs to
//! one of them. Distance is kept as its inverse, which is linear on the screen.

use std::ops::Range;

use glam::Vec2;

/// Where a sample has no triangle.
pub const NOTHING: u32 = u32::MAX;

const SUBSAMPLES: f32 = 256.0;
const HALF: i64 = 128;

/// A projected corner.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ScreenPoint {
    /// Column in 1/256 of a sample; the first sample's centre is at 128.
    x: i32,
    /// Row, likewise, downward.
    y: i32,
    /// One over the distance from the eye.
    pub near: f32,
}

impl ScreenPoint {
    /// A corner at a place given in samples.
    pub fn new(at: Vec2, near: f32) -> Self {
        let fixed = (at * SUBSAMPLES).clamp(Vec2::splat(-1e9), Vec2::splat(1e9));
        Self { x: fixed.x.round() as i32, y: fixed.y.round() as i32, near }
    }

    fn offset(self, x: i64, y: i64) -> [i64; 2] {
        [i64::from(self.x) - x, i64::from(self.y) - y]
    }
}

/// The rows of samples that a triangle may touch.
pub fn rows(corners: [ScreenPoint; 3]) -> Range<i32> {
    let [a, b, c] = corners.map(|corner| corner.y);
    a.min(b).min(c).div_euclid(256)..a.max(b).max(c).div_euclid(256) + 1
}

/// Twice the signed areas opposite to each corner of a triangle as seen from a
/// sample, in 1/65536 of a sample; all have the sign of the whole inside.
pub fn edge_functions(corners: [ScreenPoint; 3], column: i32, row: i32) -> [i64; 3] {
    let (x, y) = (i64::from(column) * 256 + HALF, i64::from(row) * 256 + HALF);
    let [a, b, c] = corners.map(|corner| corner.offset(x, y));
    let cross = |p: [i64; 2], q: [i64; 2]| p[0] * q[1] - p[1] * q[0];
    [cross(b, c), cross(c, a), cross(a, b)]
}

/// Some rows of samples.
#[derive(Debug, Clone)]
pub struct Target {
    width: i32,
    rows: Range<i32>,
    /// One over the distance, 0 where nothing is; row by row.
    pub near: Vec<f32>,
    /// The triangle's number, or [`NOTHING`].
    pub id: Vec<u32>,
}

impl Target {
    /// Empty samples.
    pub fn new(width: u32, rows: Range<u32>) -> Self {
        let count = width as usize * rows.len();
        Self {
            width: width as i32,
            rows: rows.start as i32..rows.end as i32,
            near: vec![0.0; count],
            id: vec![NOTHING; count],
        }
    }

    /// Draws a triangle where it is nearer than what is there.
    pub fn fill(&mut self, id: u32, mut corners: [ScreenPoint; 3]) {
        let area = signed_area(corners);
        if area == 0 {
            return;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        let [a, b, c] = corners.map(|corner| corner.x);
        let first = a.min(b).min(c).div_euclid(256).max(0);
        let last = a.max(b).max(c).div_euclid(256).min(self.width - 1);
        let touched = rows(corners);
        for row in touched.start.max(self.rows.start)..touched.end.min(self.rows.end) {
            self.fill_row(id, corners, row, first..last + 1, area.abs());
        }
    }

    fn fill_row(
        &mut self,
        id: u32,
        corners: [ScreenPoint; 3],
        row: i32,
        columns: Range<i32>,
        area: i64,
    ) {
        let mut edges = edge_functions(corners, columns.start, row);
        let [a, b, c] = corners;
        // One column to the right changes each edge function by a constant.
        let step = [(b, c), (c, a), (a, b)].map(|(p, q)| 256 * i64::from(p.y - q.y));
        let bias = [(b, c), (c, a), (a, b)].map(|(p, q)| i64::from(!owns_edge(p, q)));
        let scale = 1.0 / area as f32;
        let base = (row - self.rows.start) as usize * self.width as usize;
        for column in columns {
            if (0..3).all(|i| edges[i] >= bias[i]) {
                let weights = edges.map(|edge| edge as f32 * scale);
                let near = weights[0] * a.near + weights[1] * b.near + weights[2] * c.near;
                let sample = base + column as usize;
                if near > self.near[sample] {
                    self.near[sample] = near;
                    self.id[sample] = id;
                }
            }
            for i in 0..3 {
                edges[i] += step[i];
            }
        }
    }
}

fn signed_area([a, b, c]: [ScreenPoint; 3]) -> i64 {
    let [bx, by] = b.offset(a.x.into(), a.y.into());
    let [cx, cy] = c.offset(a.x.into(), a.y.into());
    bx * cy - by * cx
}

/// Whether samples exactly on the edge from p to q belong to the triangle on
/// its inner side: so for exactly one of the two directions of an edge.
fn owns_edge(p: ScreenPoint, q: ScreenPoint) -> bool {
    p.y > q.y || (p.y == q.y && p.x < q.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32, y: f32, near: f32) -> ScreenPoint {
        ScreenPoint::new(Vec2::new(x, y), near)
    }

    #[test]
    fn two_halves_of_a_square_cover_every_sample_once() {
        // Samples on the diagonal lie exactly on the shared edge.
        let corners = [at(0.5, 0.5, 1.0), at(4.5, 0.5, 1.0), at(4.5, 4.5, 1.0), at(0.5, 4.5, 1.0)];
        let covered = |triangle: [usize; 3]| {
            let mut target = Target::new(8, 0..8);
            target.fill(0, triangle.map(|i| corners[i]));
            target.id
        };
        let (one, other) = (covered([0, 1, 2]), covered([0, 2, 3]));
        let count = |ids: &[u32]| ids.iter().filter(|&&id| id == 0).count();
        assert_eq!(count(&one) + count(&other), 16);
        assert!(one.iter().zip(&other).all(|(&a, &b)| a == NOTHING || b == NOTHING));
    }

    #[test]
    fn the_nearer_triangle_wins_in_either_order() {
        let triangle = |near| [at(0.0, 0.0, near), at(9.0, 0.0, near), at(0.0, 9.0, near)];
        for order in [[0, 1], [1, 0]] {
            let mut target = Target::new(4, 0..4);
            for id in order {
                target.fill(id, triangle(if id == 0 { 0.5 } else { 0.25 }));
            }
            assert_eq!(target.id[0], 0);
            assert_eq!(target.near[0], 0.5);
        }
    }

    #[test]
    fn a_band_is_a_cut_out_of_the_whole() {
        let triangle = [at(0.3, 0.2, 0.1), at(7.7, 3.1, 0.9), at(2.2, 7.4, 0.4)];
        let mut whole = Target::new(8, 0..8);
        whole.fill(5, triangle);
        let mut band = Target::new(8, 3..6);
        band.fill(5, triangle);
        assert_eq!(band.id, whole.id[24..48]);
        assert_eq!(band.near, whole.near[24..48]);
    }
}
