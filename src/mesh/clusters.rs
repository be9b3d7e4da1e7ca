//! A network with far fewer triangles, to be looked at and nothing else: vertices that are in one
//! cell of a grid become one (Rossignac and Borrel 1993, "Multi-resolution 3D approximations for
//! rendering complex scenes").

use std::collections::HashMap;

use glam::DVec3;

use super::Mesh;
use crate::label::Label;

/// Triangles in a square of the grid, on the average of surfaces in all directions.
const TRIANGLES: f64 = 3.0;

/// The network with about `wanted` triangles. Vertices become one only where the same labels meet, so
/// that borders of three labels stay lines and surfaces of different structures stay apart. What is
/// thinner than a cell may vanish.
pub(crate) fn clustered(mesh: &Mesh, wanted: usize) -> Mesh {
    let area = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    };
    let area: f64 = (0..mesh.triangles.len()).map(area).sum();
    let side = (TRIANGLES * area / wanted.max(1) as f64).sqrt();
    if side <= 0.0 || !side.is_finite() {
        return mesh.clone();
    }
    // Which pairs of labels meet at a vertex: a bit for each.
    let mut pairs: HashMap<[Label; 2], u32> = HashMap::new();
    let mut meeting = vec![0u64; mesh.vertices.len()];
    for (triangle, sides) in mesh.triangles.iter().zip(&mesh.sides) {
        let count = pairs.len() as u32;
        let number = *pairs.entry(*sides).or_insert(count);
        triangle.iter().for_each(|&vertex| meeting[vertex as usize] |= 1 << (number % 64));
    }
    let mut cells: HashMap<([i64; 3], u64), u32> = HashMap::new();
    let mut sums: Vec<(DVec3, f64)> = Vec::new();
    let numbers: Vec<u32> = (mesh.vertices.iter().zip(&meeting))
        .map(|(&vertex, &meeting)| {
            let cell = (vertex / side).floor().to_array().map(|index| index as i64);
            let number = *cells.entry((cell, meeting)).or_insert_with(|| {
                sums.push((DVec3::ZERO, 0.0));
                sums.len() as u32 - 1
            });
            let (sum, count) = &mut sums[number as usize];
            (*sum, *count) = (*sum + vertex, *count + 1.0);
            number
        })
        .collect();
    let mut all: Vec<([u32; 3], [u32; 3], [Label; 2])> = (mesh.triangles.iter().zip(&mesh.sides))
        .map(|(triangle, &sides)| {
            let corners = triangle.map(|vertex| numbers[vertex as usize]);
            let mut sorted = corners;
            sorted.sort_unstable();
            (sorted, corners, sides)
        })
        .filter(|([a, b, c], ..)| a != b && b != c)
        .collect();
    all.sort_unstable();
    all.dedup_by_key(|&mut (sorted, _, sides)| (sorted, sides));
    Mesh {
        vertices: sums.into_iter().map(|(sum, count)| sum / count).collect(),
        triangles: all.iter().map(|&(_, corners, _)| corners).collect(),
        sides: all.iter().map(|&(.., sides)| sides).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::solid;

    #[test]
    fn a_ball_with_fewer_triangles_is_about_the_same_ball() {
        let ball = solid(81, 1.0, |point| 0.7 - (point - 0.013).length());
        let wanted = ball.triangles.len() / 10;
        let few = clustered(&ball, wanted);
        let count = few.triangles.len();
        assert!((wanted / 2..wanted * 2).contains(&count), "{count} {wanted}");
        let [whole, own] =
            [&ball, &few].map(|mesh| mesh.surface(Label(1)).facts(false).expect("facts"));
        assert!(own.closed && own.outward);
        assert!((own.volume / whole.volume - 1.0).abs() < 0.03, "{} {}", own.volume, whole.volume);
        let off = few.vertices.iter().map(|vertex| ((*vertex - 0.013).length() - 0.7).abs());
        assert!(off.fold(0.0, f64::max) < 0.02);
    }

    #[test]
    fn structures_side_by_side_stay_apart() {
        let ball = solid(41, 1.0, |point| 0.7 - point.length());
        let count = ball.vertices.len() as u32;
        let mut both = ball.clone();
        both.vertices.extend_from_slice(&ball.vertices);
        both.triangles.extend(ball.triangles.iter().map(|own| own.map(|vertex| vertex + count)));
        both.sides.extend(ball.sides.iter().map(|_| [Label(2), Label::OUTSIDE]));
        let few = clustered(&both, 800);
        let [one, other] = [1, 2].map(|label| few.surface(Label(label)));
        assert_eq!(one.triangles.len(), other.triangles.len());
        assert_eq!(one.vertices.len() + other.vertices.len(), few.vertices.len());
        assert_eq!(clustered(&Mesh::default(), 100), Mesh::default());
    }
}
