//! Several numbers on which the same is done at once. Written so that a compiler makes vector instructions of it: the sums over a
//! million facets are a matter of how many of these run side by side.

#![allow(clippy::inline_always, reason = "a call among these operations keeps the compiler from making vector instructions of them")]

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Sub};

/// Two vectors of the smallest set of instructions that every 64-bit x86 processor has; with more, the registers do not suffice.
pub(super) const LANES: usize = 4;

/// Numbers side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    #[inline(always)]
    pub(super) fn all(value: f64) -> Self {
        Self([value; LANES])
    }

    /// `f` of the numbers at each place of two.
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

    /// The smaller of each two; comparisons are one instruction each, where f64::min also looks for NaN.
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
