//! Implicit curves through the points of an outline: local curves of second degree, blended
//! (*multi-level partition of unity*).
//!
//! Y. Ohtake, A. Belyaev, M. Alexa, G. Turk and H.-P. Seidel, Multi-level partition of unity
//! implicits, ACM Transactions on Graphics 22, 2003, in the plane; as in Marker et al. 2006, §2.1.
//!
//! The cells of a quadtree have each a ball around them and a curve through the points in it. A
//! cell whose curve misses its points is divided, unless its ball is as small already as noise
//! allows. That is said as a length: noise makes an outline longer, so that a number of points, as
//! in the papers, would allow less where more is needed. At corners, and in parts thinner than a
//! ball, smaller ones are taken: what noise never does is turn the normals of half a ball away
//! from the other half's.

use glam::DVec2;

use super::fit::{Quadratic, Sample};
use super::outline::Outline;

/// A ball's radius, as a part of its cell's diagonal, and by which part of that it grows where it
/// has too few points for a curve.
const RADIUS: f64 = 0.75;
const GROWTH: f64 = 0.1;
/// Cells are not smaller, in pixels.
const SMALLEST: f64 = 1.0;
/// Curves go through so many points at least,
const LEAST_POINTS: usize = 6;
/// and reach over so many pixels, from end to end.
const LEAST_SUPPORT: f64 = 6.0;
/// Where an outline turns a corner, and its curve misses points within so many pixels by more than
/// that on their mean, a smaller ball will do.
const NEAR: f64 = 4.0;
const FAR: f64 = 0.3;
/// The cosine between the normals of two halves of an outline that turn a corner.
const CORNER: f64 = 0.766;
/// The side of a bucket, in pixels.
const BUCKET: f64 = 8.0;

/// How closely curves follow pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveOptions {
    /// Where a curve misses the pixels' outline by more, in pixels, it is divided.
    pub tolerance: f64,
    /// How far each local curve reaches at least, in pixels, from end to end. Farther is smoother.
    pub support: f64,
}

impl Default for CurveOptions {
    fn default() -> Self {
        Self { tolerance: 0.75, support: 24.0 }
    }
}

/// An implicit curve: 0 on it, positive inside, in about pixels.
#[derive(Debug, Clone)]
pub struct Implicit {
    balls: Vec<Ball>,
    low: DVec2,
    columns: usize,
    /// The balls that reach into each bucket, row by row.
    buckets: Vec<Vec<u32>>,
}

#[derive(Debug, Clone, Copy)]
struct Ball {
    center: DVec2,
    radius: f64,
    curve: Quadratic,
}

impl Implicit {
    /// Through the points of an outline.
    pub fn new(outline: &Outline, options: &CurveOptions) -> Self {
        let mut builder = Builder { outline, tolerance: options.tolerance, balls: Vec::new() };
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let ends = |[low, high]: [DVec2; 2], &at: &DVec2| [low.min(at), high.max(at)];
        let [low, high] = outline.points.iter().fold(start, ends);
        let side = (high - low).max_element().max(SMALLEST) + 1.0;
        let support = options.support.min(outline.points.len() as f64 / 3.0).max(LEAST_SUPPORT);
        builder.cell(0.5 * (low + high), side, support);
        Self::of(builder.balls)
    }

    fn of(balls: Vec<Ball>) -> Self {
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let ends = |[low, high]: [DVec2; 2], ball: &Ball| {
            [low.min(ball.center - ball.radius), high.max(ball.center + ball.radius)]
        };
        let [low, high] = balls.iter().fold(start, ends);
        let place = |at: DVec2| ((at - low) / BUCKET).floor().as_uvec2();
        let count = if balls.is_empty() { glam::UVec2::ZERO } else { place(high) + 1 };
        let columns = count.x as usize;
        let mut buckets = vec![Vec::new(); columns * count.y as usize];
        for (number, ball) in (0u32..).zip(&balls) {
            let [from, to] = [place(ball.center - ball.radius), place(ball.center + ball.radius)];
            for row in from.y..=to.y {
                for column in from.x..=to.x {
                    buckets[row as usize * columns + column as usize].push(number);
                }
            }
        }
        Self { balls, low, columns, buckets }
    }

    /// The value at a point; `None` far from the curve.
    pub fn value(&self, at: DVec2) -> Option<f64> {
        let place = ((at - self.low) / BUCKET).floor();
        if place.min_element() < 0.0 || place.x >= self.columns as f64 {
            return None;
        }
        let bucket = self.buckets.get(place.y as usize * self.columns + place.x as usize)?;
        let (mut sum, mut weights) = (0.0, 0.0);
        for &number in bucket {
            let ball = &self.balls[number as usize];
            let weight = blending(ball.center.distance(at) / ball.radius);
            if weight > 0.0 {
                weights += weight;
                sum += weight * ball.curve.value(at);
            }
        }
        (weights > 0.0).then(|| sum / weights)
    }
}

/// The quadratic B-spline that ends at 1.
fn blending(distance: f64) -> f64 {
    match 1.5 * distance {
        near @ ..0.5 => 0.75 - near * near,
        far @ ..1.5 => 0.5 * (1.5 - far) * (1.5 - far),
        _ => 0.0,
    }
}

struct Builder<'a> {
    outline: &'a Outline,
    tolerance: f64,
    balls: Vec<Ball>,
}

impl Builder<'_> {
    fn cell(&mut self, center: DVec2, side: f64, mut support: f64) {
        let own = RADIUS * side * std::f64::consts::SQRT_2;
        if self.within(center, own).is_empty() {
            return;
        }
        loop {
            let has_grown = own < 0.5 * support;
            let mut radius = own.max(0.5 * support);
            let mut samples = self.within(center, radius);
            while samples.len() < LEAST_POINTS.min(self.outline.points.len()) {
                radius += GROWTH * own;
                samples = self.within(center, radius);
            }
            let curve = Quadratic::through(&samples);
            let misses = |curve: &Quadratic| {
                samples.iter().map(|own| curve.offset(own.at).abs()).fold(0.0, f64::max)
            };
            let is_off = curve.as_ref().map_or(f64::INFINITY, misses) > self.tolerance;
            if is_off && !has_grown && side > SMALLEST {
                for (right, up) in [(-0.25, -0.25), (0.25, -0.25), (0.25, 0.25), (-0.25, 0.25)] {
                    self.cell(center + side * DVec2::new(right, up), 0.5 * side, support);
                }
                return;
            }
            let is_far = || {
                turns(&samples) && curve.as_ref().is_none_or(|curve| bias(curve, &samples) > FAR)
            };
            if has_grown && support > LEAST_SUPPORT && is_far() {
                support = (0.5 * support).max(LEAST_SUPPORT);
                continue;
            }
            self.balls.extend(curve.map(|curve| Ball { center, radius, curve }));
            return;
        }
    }

    fn within(&self, center: DVec2, radius: f64) -> Vec<Sample> {
        let Outline { points, normals } = self.outline;
        let sample = |(&at, &normal): (&DVec2, &DVec2)| {
            let weight = blending(center.distance(at) / radius);
            (weight > 0.0).then_some(Sample { at, normal, weight })
        };
        points.iter().zip(normals).filter_map(sample).collect()
    }
}

/// By how much a curve misses neighbouring points on their mean, at most.
fn bias(curve: &Quadratic, samples: &[Sample]) -> f64 {
    let off: Vec<f64> = samples.iter().map(|own| curve.offset(own.at)).collect();
    let mean = |middle: &Sample| {
        let near = samples.iter().zip(&off).filter(|(own, _)| own.at.distance(middle.at) < NEAR);
        let (count, sum) = near.fold((0.0, 0.0), |(count, sum), (_, off)| (count + 1.0, sum + off));
        sum / count
    };
    samples.iter().map(|middle| mean(middle).abs()).fold(0.0, f64::max)
}

/// Whether an outline turns a corner: whether the normals of its two halves differ by far, which
/// noise makes on neither.
fn turns(samples: &[Sample]) -> bool {
    let sum = |of: &dyn Fn(&Sample) -> DVec2| {
        samples.iter().map(|own| own.weight * of(own)).sum::<DVec2>()
    };
    let along = sum(&|own| own.normal).perp();
    let weight: f64 = samples.iter().map(|own| own.weight).sum();
    let middle = sum(&|own| own.at) / weight;
    let half = |sign: f64| {
        let is_here = |own: &&Sample| sign * along.dot(own.at - middle) > 0.0;
        samples.iter().filter(is_here).map(|own| own.normal).sum::<DVec2>().normalize_or_zero()
    };
    half(1.0).dot(half(-1.0)) < CORNER
}
