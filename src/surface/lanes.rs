//! Arithmetic on several numbers at once, written so that the compiler uses vector instructions, which determine the
//! time of the sums over a million facets.

#![allow(clippy::inline_always, reason = "a call among these operations keeps the compiler from making vector instructions of them")]

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

/// The count of numbers: a vector of AVX2, or two of SSE2, which every 64-bit x86 processor has; with more, the
/// registers do not suffice.
pub(super) const LANES: usize = 4;

/// Several numbers with the same operation on each.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    #[inline(always)]
    pub(super) fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    /// `f` of the numbers at each position of both.
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

    /// The smaller of each two; comparisons are one instruction each, where f64::min also checks for NaN.
    #[inline(always)]
    pub(super) fn lesser(self, other: Self) -> Self {
        self.zip(other, |own, other| if own < other { own } else { other })
    }

    /// The greater of each two.
    #[inline(always)]
    pub(super) fn greater(self, other: Self) -> Self {
        self.zip(other, |own, other| if own > other { own } else { other })
    }

    /// Where `self` is greater than `bound`, `then`, elsewhere `otherwise`.
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
