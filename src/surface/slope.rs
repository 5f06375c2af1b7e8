//! The slope of facets, the angle between the normal and the vertical, for several normals at once.

#![allow(clippy::inline_always, reason = "a call among these operations keeps the compiler from making vector instructions of them")]

use super::lanes::Lanes;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

/// atan r = r P(r^2) for |r| <= tan(pi/8): P is the polynomial that agrees with it at the twelve Chebyshev points of
/// 0 <= r^2 <= 3 - 2 sqrt 2. The nearest singularity, r^2 = -1, lies 12.7 half-widths from the middle, so that the
/// error falls by 25 with each term: 25^-12 = 2e-17.
const P: [f64; 12] = [
    1.0,
    -0.333_333_333_333_331_2,
    0.199_999_999_999_408_93,
    -0.142_857_142_792_502_45,
    0.111_111_107_449_196_58,
    -0.090_908_968_090_640_27,
    0.076_920_453_309_022_25,
    -0.066_629_518_136_291_91,
    0.058_468_782_973_308_72,
    -0.050_351_024_566_015_52,
    0.037_965_257_453_865_93,
    -0.017_805_397_205_419_446,
];

/// atan2(h, z) for h, z >= 0, not both 0: the slope, from 0 to pi/2, of a normal with the horizontal part h and the
/// vertical part z. It is within 4e-16 of the angle, and exact at both ends.
///
/// The tangent is the smaller part over the larger, so that the angle is up to pi/4; above pi/8, pi/4 is subtracted by
/// the theorem for the tangent of a difference. The standard library's atan2 processes one pair at a time with
/// branches, which vector instructions do not have.
#[inline(always)]
pub(super) fn slope(h: Lanes, z: Lanes) -> Lanes {
    let (low, high) = (h.lesser(z), h.greater(z));
    let bound = Lanes::all(SQRT_2 - 1.0) * high;
    let none = Lanes::all(0.0);
    let numerator = low - low.above(bound, high, none);
    let denominator = high + low.above(bound, low, none);
    let r = numerator / denominator;
    let angle = low.above(bound, Lanes::all(FRAC_PI_4), none) + r * polynomial(r * r);
    h.above(z, Lanes::all(FRAC_PI_2) - angle, angle)
}

/// P(q), evaluated in pairs of pairs, which has the shortest chain of dependent operations.
#[inline(always)]
fn polynomial(q: Lanes) -> Lanes {
    let (q2, q4) = (q * q, q * q * (q * q));
    let two = |i: usize| Lanes::all(P[i]) + Lanes::all(P[i + 1]) * q;
    let four = |i: usize| two(i) + two(i + 2) * q2;
    four(0) + (four(4) + four(8) * q4) * q4
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(h: f64, z: f64) -> f64 {
        slope(Lanes::all(h), Lanes::all(z)).0[0]
    }

    #[test]
    fn level_upright_and_tiny_slopes_are_exact() {
        assert_eq!((of(0.0, 3.0), of(3.0, 0.0)), (0.0, FRAC_PI_2));
        assert_eq!((of(1e-9, 1.0), of(1e-300, 1.0)), (1e-9, 1e-300));
        assert_eq!(of(2.0, 2.0), FRAC_PI_4);
    }

    #[test]
    fn each_lane_has_its_own_slope() {
        let slopes = slope(Lanes([0.0, 0.1, 1.0, 5.0]), Lanes([1.0, 1.0, 1.0, 1.0])).0;
        for (slope, h) in slopes.into_iter().zip([0.0_f64, 0.1, 1.0, 5.0]) {
            approx::assert_abs_diff_eq!(slope, h.atan(), epsilon = 4e-16);
        }
    }

    proptest! {
        #[test]
        fn agrees_with_the_library(angle in 0.0..=FRAC_PI_2, length in 1e-20..1e20_f64) {
            let (sin, cos) = angle.sin_cos();
            let (h, z) = (length * sin, length * cos.abs());
            // The roundings of r, of its product with P, and of the sums with pi/4 and pi/2 are at most 0.5, 0.5, 0.5
            // and 1 unit of 2.2e-16; that of the library is half a unit.
            prop_assert!((of(h, z) - h.atan2(z)).abs() <= 5e-16);
        }

        #[test]
        fn rises_with_the_horizontal_part(h in 0.0..10.0_f64, more in 1e-14..1.0_f64) {
            // A step of 1e-14 turns the normal by at least 1e-14/(1 + 11^2) = 8e-17, which is less than the error. So
            // the slope may fall, but by no more than the error.
            prop_assert!(of(h + more, 1.0) - of(h, 1.0) >= -1e-15);
        }
    }
}
