//! Points spread evenly over a surface.

use glam::DVec3;

use crate::mesh::Surface;

/// The points alone of [`draw_on`].
pub fn draw(surface: &Surface, count: u32, seed: u64) -> Vec<DVec3> {
    draw_on(surface, count, seed).into_iter().map(|(_, point)| point).collect()
}

/// `count` points with the triangles that they are on, one from each of as many
/// parts of equal area: the surface's triangles in a row, cut at equal distances.
pub fn draw_on(surface: &Surface, count: u32, seed: u64) -> Vec<(usize, DVec3)> {
    let areas: Vec<f64> = (0..surface.triangles.len())
        .map(|triangle| surface.corners(triangle))
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .collect();
    let total: f64 = areas.iter().sum();
    let mut random = Random(seed);
    let (mut triangle, mut passed) = (0, 0.0);
    (0..count)
        .map(|part| {
            let target = total * (f64::from(part) + random.unit()) / f64::from(count);
            while triangle + 1 < areas.len() && passed + areas[triangle] < target {
                passed += areas[triangle];
                triangle += 1;
            }
            (triangle, random.point_in(surface.corners(triangle)))
        })
        .collect()
}

/// The generator *SplitMix64*.
struct Random(u64);

impl Random {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in a triangle: a point of a parallelogram, folded over.
    fn point_in(&mut self, [a, b, c]: [DVec3; 3]) -> DVec3 {
        let (s, t) = (self.unit(), self.unit());
        let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        a + s * (b - a) + t * (c - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_follow_area() {
        // Two triangles in the floor, of areas 1/2 (x < 1) and 3/2.
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 0.0], [5.0, 0.0], [2.0, 1.0]];
        let surface = Surface {
            vertices: corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
        };
        let points = draw(&surface, 4000, 9);
        assert_eq!(points.iter().filter(|point| point.x <= 1.0).count(), 1000);
        // The mean of each triangle's points is its centre.
        let mean = points.iter().filter(|point| point.x > 1.0).sum::<DVec3>() / 3000.0;
        assert!((mean - DVec3::new(3.0, 1.0 / 3.0, 0.0)).length() < 0.03, "{mean}");
        assert_eq!(points, draw(&surface, 4000, 9));
    }
}
