//! Curves of second degree through points with normals, by weighted least squares.

use glam::{DMat2, DVec2};

/// Where all normals lean from their mean by less than this cosine, points are the graph of a
/// function over the direction across it.
const LEAN: f64 = 0.2;
/// How much a normal counts beside its point, as a length in pixels: off by a radian there is as
/// bad as off by this.
const NORMAL: f64 = 1.0;
/// What is added to the diagonal of a system, relative to its largest entry, where points leave
/// something open.
const RIDGE: f64 = 1e-9;
/// Below this slope a curve is not where its value is 0 any more.
const FLAT: f64 = 0.1;

/// A point of a curve.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// In pixels.
    pub at: DVec2,
    /// Of length one, inward.
    pub normal: DVec2,
    /// How much it counts; more than 0.
    pub weight: f64,
}

/// A function of second degree: about the distance to its curve near it, in pixels, positive
/// inside.
#[derive(Debug, Clone, Copy)]
pub struct Quadratic {
    origin: DVec2,
    constant: f64,
    gradient: DVec2,
    /// The second derivatives.
    curvature: DMat2,
}

impl Quadratic {
    /// The curve through some points: v = a u² + b u + c in the frame of their mean normal, and
    /// where they turn away from it a conic.
    pub fn through(samples: &[Sample]) -> Option<Self> {
        let weight: f64 = samples.iter().map(|sample| sample.weight).sum();
        let origin = samples.iter().map(|own| own.weight * own.at).sum::<DVec2>() / weight;
        let normal: DVec2 = samples.iter().map(|own| own.weight * own.normal).sum();
        let normal = normal.normalize_or_zero();
        let is_graph = samples.iter().all(|own| own.normal.dot(normal) > LEAN);
        if is_graph { Self::graph(samples, origin, normal) } else { Self::conic(samples, origin) }
    }

    fn graph(samples: &[Sample], origin: DVec2, normal: DVec2) -> Option<Self> {
        let along = normal.perp();
        let rows = samples.iter().map(|own| {
            let [u, v] = [along, normal].map(|axis| axis.dot(own.at - origin));
            ([u * u, u, 1.0], v, own.weight)
        });
        let [a, b, c] = least_squares(rows)?;
        let scale = 1.0 / b.hypot(1.0);
        let curvature = -2.0 * a * scale * DMat2::from_cols(along.x * along, along.y * along);
        Some(Self {
            origin,
            constant: -c * scale,
            gradient: scale * (normal - b * along),
            curvature,
        })
    }

    /// With values 0 and gradients along normals at the points.
    fn conic(samples: &[Sample], origin: DVec2) -> Option<Self> {
        let rows = samples.iter().flat_map(|own| {
            let DVec2 { x, y } = own.at - origin;
            let weight = NORMAL * NORMAL * own.weight;
            [
                ([x * x, x * y, y * y, x, y, 1.0], 0.0, own.weight),
                ([2.0 * x, y, 0.0, 1.0, 0.0, 0.0], own.normal.x, weight),
                ([0.0, x, 2.0 * y, 0.0, 1.0, 0.0], own.normal.y, weight),
            ]
        });
        let [xx, xy, yy, x, y, constant] = least_squares(rows)?;
        let curvature = DMat2::from_cols_array(&[2.0 * xx, xy, xy, 2.0 * yy]);
        Some(Self { origin, constant, gradient: DVec2::new(x, y), curvature })
    }

    /// The value at a point, in pixels.
    pub fn value(&self, at: DVec2) -> f64 {
        let offset = at - self.origin;
        self.constant + (self.gradient + 0.5 * (self.curvature * offset)).dot(offset)
    }

    /// About how far a point is from the curve (Taubin), in pixels; positive inside.
    pub fn offset(&self, at: DVec2) -> f64 {
        let gradient = self.gradient + self.curvature * (at - self.origin);
        self.value(at) / gradient.length().max(FLAT)
    }
}

/// The unknowns x for which the weighted squares of rows · x − values are least; `None` where
/// numbers are not finite.
fn least_squares<const N: usize>(
    rows: impl Iterator<Item = ([f64; N], f64, f64)>,
) -> Option<[f64; N]> {
    let mut system = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (row, value, weight) in rows {
        for i in 0..N {
            right[i] += weight * row[i] * value;
            for j in 0..N {
                system[i][j] += weight * row[i] * row[j];
            }
        }
    }
    // Unknowns in units in which each counts the same.
    let scale: [f64; N] = std::array::from_fn(|i| 1.0 / system[i][i].sqrt().max(f64::MIN_POSITIVE));
    for i in 0..N {
        right[i] *= scale[i];
        for j in 0..N {
            system[i][j] *= scale[i] * scale[j];
        }
        system[i][i] += RIDGE;
    }
    // Cholesky: the system is symmetric and, with the ridge, positive.
    for i in 0..N {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| system[i][k] * system[j][k]).sum();
            let rest = system[i][j] - sum;
            system[i][j] = if i == j { rest.max(RIDGE).sqrt() } else { rest / system[j][j] };
        }
    }
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| system[i][k] * right[k]).sum();
        right[i] = (right[i] - sum) / system[i][i];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| system[k][i] * right[k]).sum();
        right[i] = (right[i] - sum) / system[i][i];
    }
    let found: [f64; N] = std::array::from_fn(|i| right[i] * scale[i]);
    found.iter().all(|number| number.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(points: impl Iterator<Item = (DVec2, DVec2)>) -> Vec<Sample> {
        points.map(|(at, normal)| Sample { at, normal, weight: 1.0 }).collect()
    }

    #[test]
    fn graphs_of_second_degree_are_found_exactly() {
        // v = ½ u² / 8 − 2 along (.6, .8).
        let (normal, along) = (DVec2::new(0.6, 0.8), DVec2::new(-0.8, 0.6));
        let points = (-4..=4).map(|step| {
            let u = f64::from(step);
            let at = u * along + (u * u / 16.0 - 2.0) * normal;
            (at, (normal - u / 8.0 * along).normalize())
        });
        let curve = Quadratic::through(&samples(points.clone())).expect("a curve");
        assert!(points.clone().all(|(at, _)| curve.offset(at).abs() < 1e-6));
        assert!(points.clone().all(|(at, normal)| curve.value(at + 0.1 * normal) > 0.05));
    }

    #[test]
    fn circles_and_strips_are_conics() {
        let circle = (0..12).map(|step| {
            let out = DVec2::from_angle(std::f64::consts::TAU * f64::from(step) / 12.0);
            (DVec2::new(5.0, 7.0) + 3.0 * out, -out)
        });
        let curve = Quadratic::through(&samples(circle)).expect("a curve");
        let value = |radius: f64| curve.value(DVec2::new(5.0, 7.0) + radius * DVec2::X);
        assert!(value(3.0).abs() < 1e-6 && value(2.0) > 0.5 && value(4.0) < -0.5);
        let strip = (0..20).map(|step| {
            let side = if step < 10 { 1.0 } else { -1.0 };
            (DVec2::new(f64::from(step % 10), 1.5 * side), DVec2::new(0.0, -side))
        });
        let curve = Quadratic::through(&samples(strip)).expect("a curve");
        assert!((curve.value(DVec2::new(4.0, 0.0)) - 0.75).abs() < 1e-6);
        assert!(curve.value(DVec2::new(4.0, 1.5)).abs() < 1e-6);
    }
}
