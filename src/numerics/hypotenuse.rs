//! The hypotenuse of a right triangle.

/// The squares in which neither an overflow nor an underflow matters.
const SAFE_SQUARES: std::ops::Range<f64> = 1e-280..1e300;

/// sqrt(x^2 + y^2), to two roundings. [`f64::hypot`] errs by less than one and takes several times as long; it is called
/// where a square would overflow or underflow.
#[inline]
pub(crate) fn hypotenuse(x: f64, y: f64) -> f64 {
    let square = x * x + y * y;
    if SAFE_SQUARES.contains(&square) { square.sqrt() } else { x.hypot(y) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_that_of_the_library(x in prop::num::f64::ANY, y in prop::num::f64::ANY) {
            let library = x.hypot(y);
            if library.is_finite() {
                assert_relative_eq!(hypotenuse(x, y), library, max_relative = 4.0 * f64::EPSILON);
            } else {
                prop_assert_eq!(hypotenuse(x, y).to_bits(), library.to_bits());
            }
        }

        #[test]
        fn that_of_one_leg_is_exact(leg in prop::num::f64::NORMAL) {
            prop_assert_eq!(hypotenuse(leg, 0.0).to_bits(), leg.abs().to_bits());
            prop_assert_eq!(hypotenuse(0.0, leg).to_bits(), leg.abs().to_bits());
        }
    }
}
