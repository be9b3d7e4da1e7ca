//! Anderson's acceleration of a fixed-point iteration x ← g(x): the next x is the combination of
//! the last ones whose changes g(x) − x cancel best.
//!
//! D. G. Anderson, Iterative procedures for nonlinear integral equations, Journal of the ACM 12,
//! 1965; H. F. Walker and P. Ni, Anderson acceleration for fixed-point iterations, SIAM Journal
//! on Numerical Analysis 49, 2011. Where g is linear this comes as near as GMRES does.

use std::collections::VecDeque;

use rayon::prelude::*;

/// Combinations are of so many iterates.
const WINDOW: usize = 10;
/// What may be kept of them, in numbers; with more unknowns there are fewer.
const MOST_KEPT: usize = 1 << 24;
/// Iterates that say nearly the same as others count less by this, beside 1.
const RIDGE: f64 = 1e-10;

/// The last iterates.
#[derive(Default)]
pub(super) struct Mixing {
    last: VecDeque<Iterate>,
}

struct Iterate {
    /// g(x).
    next: Vec<f32>,
    /// g(x) − x.
    change: Vec<f32>,
}

impl Mixing {
    /// What to go on with instead of g(x), in its place.
    pub fn mix(&mut self, x: &[f32], next: &mut [f32]) {
        let change: Vec<f32> = next.iter().zip(x).map(|(next, x)| next - x).collect();
        let window = WINDOW.min(MOST_KEPT / (2 * x.len().max(1)));
        let apart: Vec<Vec<f32>> =
            self.last.iter().map(|last| minus(&change, &last.change)).collect();
        let factors = least_squares(&apart, &change);
        let own = next.to_vec();
        for (last, factor) in self.last.iter().zip(factors) {
            for ((next, own), was) in next.iter_mut().zip(&own).zip(&last.next) {
                *next -= factor as f32 * (own - was);
            }
        }
        self.last.push_back(Iterate { next: own, change });
        while self.last.len() > window {
            self.last.pop_front();
        }
    }
}

fn minus(one: &[f32], other: &[f32]) -> Vec<f32> {
    one.iter().zip(other).map(|(one, other)| one - other).collect()
}

/// In one order, whatever the threads.
fn dot(one: &[f32], other: &[f32]) -> f64 {
    one.iter().zip(other).map(|(one, other)| f64::from(*one) * f64::from(*other)).sum()
}

/// How often to take each column so that the sum is nearest to a target: Cholesky's
/// decomposition of the normal equations, whose pivots a little of the diagonal keeps positive.
fn least_squares(columns: &[Vec<f32>], target: &[f32]) -> Vec<f64> {
    let count = columns.len();
    let row = |column: &Vec<f32>| -> Vec<f64> {
        columns.iter().chain([&target.to_vec()]).map(|other| dot(column, other)).collect()
    };
    let mut rows: Vec<Vec<f64>> = columns.par_iter().map(row).collect();
    let largest = (0..count).map(|own| rows[own][own]).fold(f64::MIN_POSITIVE, f64::max);
    for (own, row) in rows.iter_mut().enumerate() {
        row[own] += RIDGE * row[own] + f64::EPSILON * largest;
    }
    for pivot in 0..count {
        let (above, below) = rows.split_at_mut(pivot + 1);
        let above = &above[pivot];
        for row in below {
            let factor = row[pivot] / above[pivot];
            row.iter_mut().zip(above).skip(pivot).for_each(|(own, above)| *own -= factor * above);
        }
    }
    let mut factors = vec![0.0; count];
    for own in (0..count).rev() {
        let others: f64 = (own + 1..count).map(|other| rows[own][other] * factors[other]).sum();
        factors[own] = (rows[own][count] - others) / rows[own][own];
    }
    factors
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain of means, one end of which is held at 1 and the other at 0, converges slowly by
    /// itself.
    fn means(x: &[f32]) -> Vec<f32> {
        let at = |index: usize| if index == 0 { 1.0 } else { x.get(index - 1).map_or(0.0, |&x| x) };
        (1..=x.len()).map(|own| 0.5 * (at(own - 1) + at(own + 1))).collect()
    }

    #[test]
    fn a_slow_iteration_becomes_a_fast_one() {
        let exact = |own: usize| 1.0 - (own + 1) as f32 / 21.0;
        let error = |x: &[f32]| {
            let apart = x.iter().enumerate().map(|(own, x)| (x - exact(own)).abs());
            apart.fold(0.0, f32::max)
        };
        let (mut mixed, mut plain) = (vec![0.0; 20], vec![0.0; 20]);
        let mut mixing = Mixing::default();
        for _ in 0..40 {
            plain = means(&plain);
            let mut next = means(&mixed);
            mixing.mix(&mixed, &mut next);
            mixed = next;
        }
        assert!(error(&plain) > 0.1, "{}", error(&plain));
        assert!(error(&mixed) < 2e-3, "{}", error(&mixed));
        assert_eq!(mixing.last.len(), WINDOW);
    }

    #[test]
    fn what_does_not_change_stays() {
        let mut mixing = Mixing::default();
        let x = vec![0.25, 0.5];
        for _ in 0..5 {
            let mut next = x.clone();
            mixing.mix(&x, &mut next);
            assert_eq!(next, x);
        }
    }
}
