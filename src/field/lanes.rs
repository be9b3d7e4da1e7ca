//! Arithmetic on a fixed number of f32 side by side. The loops have constant
//! bounds and no branches: compiled for a processor with vector registers
//! they become vector instructions.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// `N` numbers; `FMA` says whether the processor multiplies and adds in one
/// step (where it does not, asking for it would call a library function).
#[derive(Clone, Copy)]
pub(super) struct Lanes<const N: usize, const FMA: bool>(pub [f32; N]);

impl<const N: usize, const FMA: bool> Lanes<N, FMA> {
    #[inline(always)]
    pub fn splat(value: f32) -> Self {
        Self([value; N])
    }

    #[inline(always)]
    pub fn map(self, function: impl Fn(f32) -> f32) -> Self {
        Self(from_fn(|lane| function(self.0[lane])))
    }

    /// self · factor + term.
    #[inline(always)]
    pub fn mul_add(self, factor: Self, term: Self) -> Self {
        if FMA {
            Self(from_fn(|lane| self.0[lane].mul_add(factor.0[lane], term.0[lane])))
        } else {
            self * factor + term
        }
    }

    #[inline(always)]
    pub fn sqrt(self) -> Self {
        self.map(f32::sqrt)
    }

    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane].min(other.0[lane])))
    }

    #[inline(always)]
    pub fn reciprocal(self) -> Self {
        self.map(|value| 1.0 / value)
    }

    /// Whether any lane is below zero.
    #[inline(always)]
    pub fn any_negative(self) -> bool {
        self.0.iter().fold(0, |signs, value| signs | value.to_bits()) >> 31 == 1
    }

    /// `negative` in the lanes in which `self` is below zero, else `other`.
    #[inline(always)]
    pub fn if_negative(self, negative: Self, other: Self) -> Self {
        Self(from_fn(|lane| if self.0[lane] < 0.0 { negative.0[lane] } else { other.0[lane] }))
    }

    /// atan(t) / t for t² in [0, 1], to 1.7e-7 relative: the minimax
    /// polynomial of degree 7 in t².
    #[inline(always)]
    pub fn arctangent_ratio(self) -> Self {
        const COEFFICIENTS: [f32; 7] = [
            2.425_239_4e-2,
            -5.948_638e-2,
            9.914_292e-2,
            -0.140_194_8,
            0.199_697_24,
            -0.333_319_9,
            0.999_999_9,
        ];
        let mut sum = Self::splat(-4.693_273_5e-3);
        for coefficient in COEFFICIENTS {
            sum = sum.mul_add(self, Self::splat(coefficient));
        }
        sum
    }
}

impl<const N: usize, const FMA: bool> Add for Lanes<N, FMA> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] + other.0[lane]))
    }
}

impl<const N: usize, const FMA: bool> Sub for Lanes<N, FMA> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] - other.0[lane]))
    }
}

impl<const N: usize, const FMA: bool> Mul for Lanes<N, FMA> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(from_fn(|lane| self.0[lane] * other.0[lane]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arctangent_ratio_is_accurate() {
        let steps = 10_000;
        for i in 1..=steps {
            let t = f64::from(i) / f64::from(steps);
            let found = Lanes::<8, false>::splat((t * t) as f32).arctangent_ratio().0[0];
            let error = f64::from(found) * t / t.atan() - 1.0;
            assert!(error.abs() < 2.5e-7, "atan {t}: {error:e}");
        }
    }

    #[test]
    fn negative_lanes_are_found_and_chosen() {
        let mixed = Lanes::<4, false>([1.0, -1.0, 0.0, -0.5]);
        assert!(mixed.any_negative());
        assert!(!mixed.map(f32::abs).any_negative());
        let chosen = mixed.if_negative(Lanes::splat(7.0), Lanes::splat(9.0));
        assert_eq!(chosen.0, [9.0, 7.0, 9.0, 7.0]);
    }
}
