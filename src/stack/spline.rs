//! Cubic interpolation of a column over heights with any spacing.
//!
//! The slopes are those of the natural spline, which is twice continuously differentiable,
//! limited so that the data decide where it rises and falls (J. M. Hyman, Accurate monotonicity
//! preserving cubic interpolation, SIAM Journal on Scientific and Statistical Computing 4, 1983;
//! Marker et al. §2.4). At a local extremum his rule lets a column overshoot; where that would
//! make it change its sign between two values of one sign, which is a blob that no section shows,
//! slopes are less (J. W. Schmidt and W. Hess, Positivity of cubic polynomials on intervals and
//! positive spline interpolation, BIT 28, 1988).

/// Heights of values, and what their natural spline needs of them.
#[derive(Debug, Clone)]
pub struct Spline {
    heights: Vec<f64>,
    /// What elimination makes of the system's rows: the factor of the row above, and 1 over the
    /// pivot.
    rows: Vec<[f64; 2]>,
}

impl Spline {
    /// Of heights that increase; at least two.
    pub fn new(heights: Vec<f64>) -> Self {
        let mut rows: Vec<[f64; 2]> = Vec::with_capacity(heights.len());
        let mut own = Self { heights, rows: Vec::new() };
        let mut above = 0.0;
        for row in 0..own.heights.len() {
            let [before, middle, after] = own.row(row);
            let factor = rows.last().map_or(0.0, |[_, inverse]| before * inverse);
            let pivot = middle - factor * above;
            rows.push([factor, 1.0 / pivot]);
            above = after;
        }
        own.rows = rows;
        own
    }

    /// The heights.
    pub fn heights(&self) -> &[f64] {
        &self.heights
    }

    fn width(&self, interval: usize) -> f64 {
        self.heights[interval + 1] - self.heights[interval]
    }

    /// What the slopes at a height and those before and after it count in its equation: second
    /// derivatives agree there, and vanish at the ends.
    fn row(&self, at: usize) -> [f64; 3] {
        let before = if at > 0 { 1.0 / self.width(at - 1) } else { 0.0 };
        let after = if at + 1 < self.heights.len() { 1.0 / self.width(at) } else { 0.0 };
        [before, 2.0 * (before + after), after]
    }

    fn secant(&self, values: &[f64], interval: usize) -> f64 {
        (values[interval + 1] - values[interval]) / self.width(interval)
    }

    /// The natural spline's slopes at all heights.
    pub fn natural_slopes(&self, values: &[f64], slopes: &mut [f64]) {
        let count = self.heights.len();
        for at in 0..count {
            let [before, _, after] = self.row(at);
            let mut wanted = 0.0;
            if at > 0 {
                wanted += 3.0 * before * self.secant(values, at - 1);
            }
            if at + 1 < count {
                wanted += 3.0 * after * self.secant(values, at);
            }
            if at > 0 {
                wanted -= self.rows[at][0] * slopes[at - 1];
            }
            slopes[at] = wanted;
        }
        let mut below = 0.0;
        for at in (0..count).rev() {
            slopes[at] = (slopes[at] - self.row(at)[2] * below) * self.rows[at][1];
            below = slopes[at];
        }
    }

    /// The limited slopes.
    pub fn slopes(&self, values: &[f64], slopes: &mut [f64]) {
        self.natural_slopes(values, slopes);
        let count = self.heights.len();
        let sides = |at: usize| {
            let before = self.secant(values, at.max(1) - 1);
            let after = self.secant(values, at.min(count - 2));
            [before, after]
        };
        for (at, slope) in slopes.iter_mut().enumerate() {
            let [before, after] = sides(at);
            let most = 3.0 * before.abs().min(after.abs());
            *slope = match before * after > 0.0 {
                true => {
                    before.signum() * (slope.abs() * f64::from(*slope * before > 0.0)).min(most)
                }
                false => slope.clamp(-most, most),
            };
        }
        for interval in 0..count - 1 {
            let [from, to] = [values[interval], values[interval + 1]];
            if from * to < 0.0 {
                continue;
            }
            // All of Bézier's ordinates are on one side then.
            let (sign, rate) = ((from + to).signum(), 3.0 / self.width(interval));
            slopes[interval] = sign * (sign * slopes[interval]).max(-rate * from.abs());
            slopes[interval + 1] = sign * (sign * slopes[interval + 1]).min(rate * to.abs());
        }
    }

    /// The interval that a height lies in, and the part of the way through it; beyond the ends
    /// these.
    pub fn place(&self, height: f64) -> (usize, f64) {
        let last = self.heights.len() - 2;
        let interval =
            self.heights.partition_point(|&own| own <= height).saturating_sub(1).min(last);
        let part = (height - self.heights[interval]) / self.width(interval);
        (interval, part.clamp(0.0, 1.0))
    }

    /// The same; none beyond the ends.
    pub fn place_within(&self, height: f64) -> Option<(usize, f64)> {
        let ends = self.heights[0]..=self.heights[self.heights.len() - 1];
        ends.contains(&height).then(|| self.place(height))
    }

    /// A column's value in an interval, between two values with slopes.
    pub fn value(&self, (interval, part): (usize, f64), values: [f64; 2], slopes: [f64; 2]) -> f64 {
        let width = self.width(interval);
        hermite(values, slopes.map(|slope| slope * width), part)
    }
}

fn hermite([from, to]: [f64; 2], [rise_from, rise_to]: [f64; 2], part: f64) -> f64 {
    let rest = 1.0 - part;
    let (toward, back) = (part * part * (3.0 - 2.0 * part), rest * rest * (3.0 - 2.0 * rest));
    back * from + toward * to + part * rest * (rest * rise_from - part * rise_to)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    struct Column {
        spline: Spline,
        values: Vec<f64>,
        slopes: Vec<f64>,
    }

    impl Column {
        fn new(heights: &[f64], values: &[f64], is_limited: bool) -> Self {
            let spline = Spline::new(heights.to_vec());
            let mut slopes = vec![0.0; heights.len()];
            match is_limited {
                true => spline.slopes(values, &mut slopes),
                false => spline.natural_slopes(values, &mut slopes),
            }
            Self { spline, values: values.to_vec(), slopes }
        }

        fn at(&self, height: f64) -> f64 {
            let (interval, part) = self.spline.place(height);
            let ends = |own: &[f64]| [own[interval], own[interval + 1]];
            self.spline.value((interval, part), ends(&self.values), ends(&self.slopes))
        }
    }

    fn close(found: impl IntoIterator<Item = f64>, right: &[f64]) {
        let found: Vec<f64> = found.into_iter().collect();
        assert_eq!(found.len(), right.len());
        assert!(found.iter().zip(right).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?} {right:?}");
    }

    #[test]
    fn a_step_is_natural_or_limited() {
        let (heights, values) = ([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.0, 0.0, 1.0, 1.0]);
        let places = [0.5, 1.5, 2.25, 2.5, 2.75, 3.5];
        let natural = Column::new(&heights, &values, false);
        let right = [0.033482143, -0.100446429, 0.212332589, 0.493303571, 0.777622768, 1.127232143];
        close(places.map(|height| natural.at(height)), &right);
        let limited = Column::new(&heights, &values, true);
        close(places.map(|height| limited.at(height)), &[0.0, 0.0, 0.15625, 0.5, 0.84375, 1.0]);
    }

    #[test]
    fn slopes_over_uneven_heights() {
        let column = Column::new(&[0.0, 1.0, 3.0, 4.0, 8.0], &[-5.0, -4.0, 2.0, 3.0, 3.5], true);
        close(column.slopes.clone(), &[0.502388535, 1.99522293, 2.02388535, 0.375, 0.0]);
        let right = [-4.686604299, -1.007165605, 2.706110669, 3.4375];
        close([0.5, 2.0, 3.5, 6.0].map(|height| column.at(height)), &right);
    }

    #[test]
    fn what_nearly_touches_zero_does_not_cross_it() {
        let (heights, values) = ([0.0, 1.0, 2.0, 3.0], [-6.0, -0.1, -0.2, -9.0]);
        let peak = |is_limited| {
            let column = Column::new(&heights, &values, is_limited);
            (0..=1000).map(|step| column.at(1.0 + 0.001 * f64::from(step))).fold(-9.0, f64::max)
        };
        assert!((peak(false) - 0.953).abs() < 1e-3, "{}", peak(false));
        assert!((peak(true) + 0.0586).abs() < 1e-4, "{}", peak(true));
    }

    #[test]
    fn no_column_changes_its_sign_where_the_values_do_not() {
        let mut random = Random::new(5);
        let mut guarded = 0;
        for _ in 0..10_000 {
            let count = 2 + (9.0 * random.unit()) as usize;
            let mut height = 0.0;
            let heights: Vec<f64> = (0..count)
                .map(|_| {
                    height += 0.1 + 3.0 * random.unit();
                    height
                })
                .collect();
            let value = |random: &mut Random| {
                let size = 10f64.powf(3.0 * random.unit() - 2.0);
                if random.unit() < 0.05 { 0.0 } else { size * (2.0 * random.unit() - 1.0) }
            };
            let values: Vec<f64> = (0..count).map(|_| value(&mut random)).collect();
            let column = Column::new(&heights, &values, true);
            let natural = Column::new(&heights, &values, false);
            for interval in 0..count - 1 {
                let [from, to] = [values[interval], values[interval + 1]];
                if from * to < 0.0 {
                    continue;
                }
                let width = heights[interval + 1] - heights[interval];
                for step in 0..=64 {
                    let height = heights[interval] + width * f64::from(step) / 64.0;
                    assert!(column.at(height) * (from + to) >= -1e-12, "{heights:?} {values:?}");
                    guarded += u32::from(natural.at(height) * (from + to) < 0.0);
                }
            }
        }
        assert!(guarded > 10_000, "{guarded}");
    }
}
