//! Arithmetic on several numbers at once, written so that the compiler uses vector instructions, which determine the
//! time of the sums over a million facets.

#![allow(clippy::inline_always, reason = "a call among these operations keeps the compiler from making vector instructions of them")]

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

/// The count of numbers: one vector of AVX2, or two of SSE2, which every 64-bit x86 processor has. More would need more
/// registers than there are.
pub(super) const LANES: usize = 4;

/// Several numbers on which each operation acts in parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    #[inline(always)]
    pub(super) fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    /// Applies `f` to the numbers at each position.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(from_fn(|lane| f(self.0[lane], other.0[lane])))
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        Self(self.0.map(f64::abs))
    }

    /// The smaller number at each position. A comparison is one instruction; `f64::min` also tests for NaN.
    #[inline(always)]
    pub(super) fn lesser(self, other: Self) -> Self {
        self.zip(other, |own, other| if own < other { own } else { other })
    }

    /// The greater number at each position.
    #[inline(always)]
    pub(super) fn greater(self, other: Self) -> Self {
        self.zip(other, |own, other| if own > other { own } else { other })
    }

    /// At each position, `then` if `self` is greater than `bound`, otherwise `otherwise`.
    #[inline(always)]
    pub(super) fn above(self, bound: Self, then: Self, otherwise: Self) -> Self {
        Self(from_fn(|lane| if self.0[lane] > bound.0[lane] { then.0[lane] } else { otherwise.0[lane] }))
    }

    #[inline(always)]
    pub(super) fn sum(self) -> f64 {
        self.0.iter().sum()
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |own, other| own + other)
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |own, other| own - other)
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |own, other| own * other)
    }
}

impl Div for Lanes {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |own, other| own / other)
    }
}
