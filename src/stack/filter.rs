//! A filter for distance fields that leaves the curve alone: the farther from it, the more is
//! smoothed (Marker et al. §2.3, Eq. 3).
//!
//! A distance has a crease where two parts of the curve are equally near. Between sections,
//! where fields are interpolated, such creases would show on the surface.

use rayon::prelude::*;

/// The pixels of an image's longest side for which distances and σ are given.
const UNIT_PIXELS: f64 = 500.0;
/// Nearer to the curve nothing changes.
const NEAR: f64 = 4.0;
/// Farther away σ is the largest.
const FAR: f64 = 15.0;
/// σ next to [`NEAR`], and from [`FAR`] on.
const SMALLEST: f64 = 0.5;
const LARGEST: f64 = 3.0;

/// An image of distances, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels of a row.
    pub width: usize,
    /// In pixels.
    pub values: Vec<f32>,
}

/// σ at a distance, both in pixels of an image of [`UNIT_PIXELS`].
fn sigma(distance: f64) -> f64 {
    let part = ((distance - NEAR) / (FAR - NEAR)).min(1.0);
    let ramp = (1.0 - (part * std::f64::consts::PI).cos()) / 2.0;
    if distance <= NEAR { 0.0 } else { SMALLEST + ramp * (LARGEST - SMALLEST) }
}

impl Image {
    fn height(&self) -> usize {
        self.values.len() / self.width
    }

    /// Smooths away from the curve. No mean is taken across it, so it stays exactly where it is.
    /// Beyond the image is what is on its border.
    pub fn filtered(&self) -> Self {
        self.filtered_as(self.width.max(self.height()))
    }

    /// The same as a part of an image whose longest side has so many pixels.
    pub fn filtered_as(&self, longest: usize) -> Self {
        let scale = longest as f64 / UNIT_PIXELS;
        let far = self.separated(LARGEST * scale);
        let value = |(index, &own): (usize, &f32)| {
            let distance = f64::from(own.abs());
            let sigma = scale * sigma(distance / scale);
            if distance < (3.0 * sigma).ceil() || sigma == 0.0 {
                own
            } else if distance >= FAR * scale && distance >= 2f64.sqrt() * (3.0 * sigma).ceil() {
                far[index]
            } else {
                self.mean(index, sigma)
            }
        };
        let values = self.values.par_iter().enumerate().map(value).collect();
        Self { width: self.width, values }
    }

    /// The weighted mean around a pixel over a disc.
    fn mean(&self, index: usize, sigma: f64) -> f32 {
        let factors = factors(sigma);
        let reach = factors.len() as isize - 1;
        let [x, y] = [index % self.width, index / self.width].map(|at| at as isize);
        let (mut sum, mut total) = (0.0, 0.0);
        for down in -reach..=reach {
            let start = (y + down).clamp(0, self.height() as isize - 1) as usize * self.width;
            let aside = ((reach * reach - down * down) as f64).sqrt() as isize;
            for right in -aside..=aside {
                let column = (x + right).clamp(0, self.width as isize - 1) as usize;
                let weight = factors[down.unsigned_abs()] * factors[right.unsigned_abs()];
                sum += weight * f64::from(self.values[start + column]);
                total += weight;
            }
        }
        (sum / total) as f32
    }

    /// The mean around every pixel over a square, first along rows and then along columns.
    fn separated(&self, sigma: f64) -> Vec<f32> {
        let factors = factors(sigma);
        let reach = factors.len() as isize - 1;
        let total: f64 = (-reach..=reach).map(|step| factors[step.unsigned_abs()]).sum();
        let along = |at: usize, count: usize, value: &dyn Fn(usize) -> f32| {
            let weighted = |step: isize| {
                let other = (at as isize + step).clamp(0, count as isize - 1) as usize;
                factors[step.unsigned_abs()] * f64::from(value(other))
            };
            ((-reach..=reach).map(weighted).sum::<f64>() / total) as f32
        };
        let (width, height) = (self.width, self.height());
        let rows: Vec<f32> = (0..self.values.len())
            .into_par_iter()
            .map(|index| {
                let start = index - index % width;
                along(index % width, width, &|x| self.values[start + x])
            })
            .collect();
        (0..self.values.len())
            .into_par_iter()
            .map(|index| {
                let x = index % width;
                along(index / width, height, &|y| rows[y * width + x])
            })
            .collect()
    }
}

/// What a step of 0, 1, … ⌈3σ⌉ pixels along an axis counts.
fn factors(sigma: f64) -> Vec<f64> {
    let reach = (3.0 * sigma).ceil() as u32;
    (0..=reach).map(|step| (-0.5 * (f64::from(step) / sigma).powi(2)).exp()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: usize = 96;

    /// The signed distance to a square of half side 30 in the middle, at a pixel's centre.
    fn square(x: f64, y: f64) -> f64 {
        let (x, y) = (x.abs() - 30.0, y.abs() - 30.0);
        if x > 0.0 && y > 0.0 { -x.hypot(y) } else { -x.max(y) }
    }

    fn image(distance: impl Fn(f64, f64) -> f64) -> Image {
        let at = |pixel: usize| pixel as f64 - 47.5;
        let values =
            (0..WIDTH * WIDTH).map(|index| distance(at(index % WIDTH), at(index / WIDTH)) as f32);
        Image { width: WIDTH, values: values.collect() }
    }

    fn index(x: f64, y: f64) -> usize {
        (y + 47.5) as usize * WIDTH + (x + 47.5) as usize
    }

    #[test]
    fn sigma_rises_with_the_distance() {
        let right = [
            (4.0, 0.0),
            (5.0, 0.550634),
            (7.0, 0.931424),
            (9.5, 1.75),
            (12.0, 2.568576),
            (14.0, 2.949366),
            (15.0, 3.0),
            (100.0, 3.0),
        ];
        for (distance, expected) in right {
            assert!((sigma(distance) - expected).abs() < 1e-6, "{distance}: {}", sigma(distance));
        }
    }

    #[test]
    fn a_square_is_smoothed_as_published() {
        let image = image(square);
        let right = [
            (0.5, 0.5, 26.604094487),
            (10.5, 10.5, 17.825624073),
            (18.5, 18.5, 10.143840915),
            (22.5, 22.5, 6.916391409),
            (25.5, 25.5, 4.295303154),
            (26.5, 26.5, 3.5),
            (10.5, 0.5, 19.484691301),
            (40.5, 40.5, -15.138203305),
        ];
        for (x, y, expected) in right {
            let index = index(x, y);
            let distance = f64::from(image.values[index].abs());
            let found = match sigma(distance) {
                0.0 => image.values[index],
                sigma => image.separated(sigma)[index],
            };
            // The image is in single precision.
            assert!((f64::from(found) - expected).abs() < 1e-5, "({x}, {y}): {found} {expected}");
        }
    }

    #[test]
    fn a_curve_stays_where_it_is() {
        for image in [image(square), image(|x, y| 20.3 - x.hypot(y)), image(|x, _| 6.0 - x.abs())] {
            let filtered = image.filtered();
            let scale = WIDTH as f64 / UNIT_PIXELS;
            let mut moved = 0;
            for (was, is) in image.values.iter().zip(&filtered.values) {
                assert_eq!(*was > 0.0, *is > 0.0);
                if f64::from(was.abs()) <= NEAR * scale {
                    assert_eq!(was, is);
                }
                moved += u32::from(was != is);
            }
            assert!(moved > 500, "{moved}");
        }
    }

    /// Across the middle of a strip the second difference is that of a crease: 2 at first.
    #[test]
    fn creases_are_smoothed() {
        for (half, times) in [(8, 5.0), (15, 7.0), (20, 6.5)] {
            // As if it were a part of an image of 500 pixels.
            let width = 500;
            let strip = |index: usize| {
                let at = (index % width) as i32 - 250;
                (half - at.abs()) as f32
            };
            let image = Image { width, values: (0..width * width).map(strip).collect() };
            let filtered = image.filtered();
            let crease = |image: &Image| {
                let middle = width * width / 2 + 250;
                let at = |step: isize| image.values[middle.wrapping_add_signed(step)];
                (at(-1) - 2.0 * at(0) + at(1)).abs()
            };
            assert!((crease(&image) - 2.0).abs() < 1e-6);
            assert!(crease(&image) > times * crease(&filtered), "{half}: {}", crease(&filtered));
        }
    }
}
