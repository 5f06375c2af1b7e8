//! Numbers with their derivatives, for forward-mode automatic differentiation.

use std::ops::{Add, Mul, Neg, Sub};

/// A value with its derivatives by N unknowns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Dual<const N: usize> {
    pub(crate) value: f64,
    pub(crate) by: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// A value that depends on no unknown.
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, by: [0.0; N] }
    }

    /// The unknown with this index.
    pub(crate) fn unknown(value: f64, index: usize) -> Self {
        let mut by = [0.0; N];
        by[index] = 1.0;
        Self { value, by }
    }

    /// A function of this number, from its value and its derivative.
    fn map(self, value: f64, derivative: f64) -> Self {
        Self { value, by: self.by.map(|by| derivative * by) }
    }

    pub(crate) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.map(root, 0.5 / root)
    }

    pub(crate) fn recip(self) -> Self {
        let inverse = self.value.recip();
        self.map(inverse, -inverse * inverse)
    }

    pub(crate) fn square(self) -> Self {
        self.map(self.value * self.value, 2.0 * self.value)
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, by: std::array::from_fn(|i| self.by[i] + other.by[i]) }
    }
}

impl<const N: usize> Add<f64> for Dual<N> {
    type Output = Self;

    fn add(self, other: f64) -> Self {
        Self { value: self.value + other, ..self }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    fn neg(self) -> Self {
        self.map(-self.value, -1.0)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    #[expect(clippy::suspicious_arithmetic_impl, reason = "the product rule adds")]
    fn mul(self, other: Self) -> Self {
        Self { value: self.value * other.value, by: std::array::from_fn(|i| self.value * other.by[i] + other.value * self.by[i]) }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        self.map(self.value * factor, factor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn derivatives_are_those_of_central_differences(x in 0.5..3.0_f64, y in -2.0..2.0_f64) {
            let function = |x: Dual<2>, y: Dual<2>| (x * y - x.recip() + 4.0).square() * (x * 3.0 - -y * y).sqrt();
            let found = function(Dual::unknown(x, 0), Dual::unknown(y, 1));
            let at = |x: f64, y: f64| function(Dual::constant(x), Dual::constant(y)).value;
            // The error of central differences is of the order of the step's square, and 1e-16 over the step.
            let step = 1e-5;
            let expected = [(at(x + step, y) - at(x - step, y)) / (2.0 * step), (at(x, y + step) - at(x, y - step)) / (2.0 * step)];
            prop_assert!((found.value - at(x, y)).abs() <= 0.0);
            for (found, expected) in found.by.into_iter().zip(expected) {
                assert_relative_eq!(found, expected, max_relative = 1e-6, epsilon = 1e-6);
            }
        }
    }
}
