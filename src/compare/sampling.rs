//! Points spread evenly over a surface.

use glam::DVec3;

use crate::mesh::Surface;
use crate::random::Random;

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
    let mut random = Random::new(seed);
    let (mut triangle, mut passed) = (0, 0.0);
    (0..count)
        .map(|part| {
            let target = total * (f64::from(part) + random.unit()) / f64::from(count);
            while triangle + 1 < areas.len() && passed + areas[triangle] < target {
                passed += areas[triangle];
                triangle += 1;
            }
            (triangle, point_in(surface.corners(triangle), &mut random))
        })
        .collect()
}

/// Uniform in a triangle: a point of a parallelogram, folded over.
fn point_in([a, b, c]: [DVec3; 3], random: &mut Random) -> DVec3 {
    let (s, t) = (random.unit(), random.unit());
    let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
    a + s * (b - a) + t * (c - a)
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
