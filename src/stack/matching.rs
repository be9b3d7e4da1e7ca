//! Which parts of two slices belong together when those of one are moved.
//!
//! Of every two parts the best translation is found, and pairs are chosen so that they
//! match best together: parts side by side that move alike keep their order, though one's
//! neighbour may be nearer than where it went.

use super::parts::Part;

/// How well parts must match, as intersection over union: a part may halve its width.
const LEAST_OVERLAP: f64 = 0.25;
/// How many parts of a label are looked at on a slice, the largest first.
const MOST: usize = 256;

/// Two parts, by their numbers, and the translation from the first to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    /// Of the first slice.
    pub from: usize,
    /// Of the second.
    pub to: usize,
    /// In pixels.
    pub step: [i32; 2],
    /// How well they match then: intersection over union.
    pub overlap: f64,
}

impl Pair {
    /// What it adds to the sum that is to be largest: less for a longer way.
    fn gain(&self, farthest: f64) -> f64 {
        self.overlap * (1.0 - (length(self.step) / farthest).powi(2))
    }
}

/// How long a translation is.
pub fn length([right, up]: [i32; 2]) -> f64 {
    f64::from(right).hypot(f64::from(up))
}

/// The pairs of parts of one label that match best together, of those that move by less than
/// `farthest` pixels.
pub fn pairs(from: &[Part], to: &[Part], farthest: f64) -> Vec<Pair> {
    let [from_order, to_order] = [from, to].map(largest);
    let candidate = |&from_part: &usize, &to_part: &usize| {
        let (step, overlap) = translation(&from[from_part], &to[to_part], farthest)?;
        Some(Pair { from: from_part, to: to_part, step, overlap })
    };
    let candidates: Vec<Vec<Option<Pair>>> = from_order
        .iter()
        .map(|from| to_order.iter().map(|to| candidate(from, to)).collect())
        .collect();
    let gains: Vec<Vec<f64>> = candidates
        .iter()
        .map(|row| row.iter().map(|pair| pair.map_or(0.0, |pair| pair.gain(farthest))).collect())
        .collect();
    let chosen = assignment(&gains).into_iter().zip(&candidates);
    let mut pairs: Vec<Pair> = chosen.filter_map(|(column, row)| row[column?]).collect();
    pairs.sort_unstable_by_key(|pair| pair.from);
    pairs
}

/// The numbers of the largest parts.
fn largest(parts: &[Part]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by_key(|&part| std::cmp::Reverse(parts[part].area));
    order.truncate(MOST);
    order
}

/// The translation by which a part matches another one best, looked for around that of their
/// middles in steps that halve.
fn translation(from: &Part, to: &Part, farthest: f64) -> Option<([i32; 2], f64)> {
    let [least, most] = [from.area.min(to.area), from.area.max(to.area)];
    let start = to.middle - from.middle;
    if (least as f64) < LEAST_OVERLAP * most as f64 {
        return None;
    }
    let widest = from.size.into_iter().chain(to.size).max().unwrap_or(1) as i32;
    if start.length() > farthest + f64::from(widest) {
        return None;
    }
    let overlap = |step: [i32; 2]| {
        let common = from.common(to, step) as f64;
        common / ((from.area + to.area) as f64 - common)
    };
    let start = start.round().to_array().map(|along| along as i32);
    let mut best = (start, overlap(start));
    let mut reach = (widest / 8).max(1);
    while reach > 0 {
        let [x, y] = best.0;
        let sides = [-reach, 0, reach];
        let around = sides.iter().flat_map(|up| sides.map(|right| [x + right, y + up]));
        let found = around.map(|step| (step, overlap(step)));
        // The first of equals is kept.
        let next = found.fold(best, |best, next| if next.1 > best.1 { next } else { best });
        if next.0 == best.0 {
            reach /= 2;
        }
        best = next;
    }
    let (step, overlap) = best;
    (overlap >= LEAST_OVERLAP && length(step) < farthest).then_some(best)
}

/// For every row the column that it gets, so that the sum of all gains is largest; none where
/// the gain would be 0 (H. W. Kuhn, The Hungarian method for the assignment problem, Naval
/// Research Logistics 2, 1955; by shortest augmenting paths).
fn assignment(gains: &[Vec<f64>]) -> Vec<Option<usize>> {
    let (rows, columns) = (gains.len(), gains.first().map_or(0, Vec::len));
    // As many columns more as there are rows gain nothing, so a row may go without.
    let all = columns + rows;
    let cost = |row: usize, column: usize| gains[row].get(column).map_or(0.0, |gain| -gain);
    // Numbers begin with 1: 0 is the row that is being placed, and no column.
    let (mut row_price, mut price) = (vec![0.0; rows + 1], vec![0.0; all + 1]);
    let mut owner = vec![0; all + 1];
    for row in 1..=rows {
        owner[0] = row;
        let mut column = 0;
        let (mut least, mut before) = (vec![f64::INFINITY; all + 1], vec![0; all + 1]);
        let mut is_used = vec![false; all + 1];
        while owner[column] != 0 {
            is_used[column] = true;
            let (own, mut delta, mut next) = (owner[column], f64::INFINITY, 0);
            for other in (1..=all).filter(|&other| !is_used[other]) {
                let reduced = cost(own - 1, other - 1) - row_price[own] - price[other];
                if reduced < least[other] {
                    (least[other], before[other]) = (reduced, column);
                }
                if least[other] < delta {
                    (delta, next) = (least[other], other);
                }
            }
            for other in 0..=all {
                if is_used[other] {
                    row_price[owner[other]] += delta;
                    price[other] -= delta;
                } else {
                    least[other] -= delta;
                }
            }
            column = next;
        }
        while column != 0 {
            owner[column] = owner[before[column]];
            column = before[column];
        }
    }
    let mut chosen = vec![None; rows];
    for column in 1..=columns {
        if let Some(row) = owner[column].checked_sub(1).filter(|&row| gains[row][column - 1] > 0.0)
        {
            chosen[row] = Some(column - 1);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn an_assignment_has_the_largest_sum() {
        let mut random = Random::new(3);
        for _ in 0..300 {
            let [rows, columns] = [0, 0].map(|_: i32| 1 + (random.bits() % 4) as usize);
            let mut gain = || if random.unit() < 0.3 { 0.0 } else { random.unit() };
            let gains: Vec<Vec<f64>> =
                (0..rows).map(|_| (0..columns).map(|_| gain()).collect()).collect();
            let chosen = assignment(&gains);
            let mut columns: Vec<usize> = chosen.iter().flatten().copied().collect();
            let count = columns.len();
            columns.sort_unstable();
            columns.dedup();
            assert_eq!(columns.len(), count, "one to one");
            let sum: f64 = (chosen.iter().zip(&gains))
                .filter_map(|(column, row)| column.map(|column| row[column]))
                .sum();
            assert!((sum - best(&gains, 0, 0)).abs() < 1e-12, "{gains:?} {chosen:?}");
        }
        assert!(assignment(&[]).is_empty());
        assert_eq!(assignment(&[vec![]]), [None]);
    }

    /// By trying all.
    fn best(gains: &[Vec<f64>], row: usize, used: u32) -> f64 {
        let Some(own) = gains.get(row) else { return 0.0 };
        let free = (0..own.len()).filter(|column| used >> column & 1 == 0);
        let with = free.map(|column| own[column] + best(gains, row + 1, used | 1 << column));
        with.fold(best(gains, row + 1, used), f64::max)
    }
}
