//! Operations on small vectors in arrays. Squares must neither overflow nor underflow, except in [`hypotenuse`].

/// a . b
#[inline]
pub(crate) fn dot<const N: usize>(a: [f64; N], b: [f64; N]) -> f64 {
    let mut sum = a[0] * b[0];
    for axis in 1..N {
        sum += a[axis] * b[axis];
    }
    sum
}

/// |a|
#[inline]
pub(crate) fn length<const N: usize>(a: [f64; N]) -> f64 {
    dot(a, a).sqrt()
}

/// a - b
#[inline]
pub(crate) fn difference<const N: usize>(a: [f64; N], b: [f64; N]) -> [f64; N] {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

/// a x b
#[inline]
pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a + t (b - a)
pub(crate) fn mixed(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + t * (b[axis] - a[axis]))
}

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
    use nalgebra::Vector3;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn they_are_those_of_nalgebra(a in prop::array::uniform3(-1e9..1e9_f64), b in prop::array::uniform3(-1e9..1e9_f64)) {
            let [u, v] = [a, b].map(Vector3::from);
            assert_relative_eq!(dot(a, b), u.dot(&v));
            assert_relative_eq!(length(a), u.norm());
            assert_relative_eq!(Vector3::from(difference(a, b)), u - v);
            assert_relative_eq!(Vector3::from(cross(a, b)), u.cross(&v));
            assert_relative_eq!(Vector3::from(mixed(a, b, 0.25)), u.lerp(&v, 0.25), max_relative = 1e-9, epsilon = 1e-6);
        }
    }

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
