//! Functions of one number: a bracketed root finder, and rounding to whole numbers and to significant digits.

/// The root of `f` between `low`, where f is negative, and `high`, where f is positive, to the rounding of numbers of
/// their size. Chandrupatla's method uses inverse quadratic interpolation if it is safe and bisection otherwise. It
/// takes about ten steps, and never many more than bisection alone [Chandrupatla 1997,
/// doi:10.1016/s0965-9978(96)00051-8].
///
/// The searches of the envelope model do not use it where they have more than a continuous function in a bracket: where
/// a derivative gives Newton's steps, where there is no bracket at first, or where the function has steps, at which each
/// end of the bracket must be kept.
///
/// # Errors
/// Those of `f`.
pub(crate) fn bracketed_root<E>(low: f64, high: f64, mut f: impl FnMut(f64) -> Result<f64, E>) -> Result<f64, E> {
    // a is the newest point, b the other end of the bracket, c the point removed last.
    let (mut a, mut b) = (high, low);
    let (mut f_a, mut f_b) = (f(a)?, f(b)?);
    let resolution = 2.0 * f64::EPSILON * low.abs().max(high.abs());
    let mut share = 0.5;
    loop {
        let x = a + share * (b - a);
        let f_x = f(x)?;
        let (c, f_c);
        if (f_x < 0.0) == (f_a < 0.0) {
            (c, f_c) = (a, f_a);
        } else {
            (c, f_c) = (b, f_b);
            (b, f_b) = (a, f_a);
        }
        (a, f_a) = (x, f_x);
        let best = if f_a.abs() < f_b.abs() { a } else { b };
        let smallest_share = resolution / (b - a).abs();
        // At f_a == 0 the root is exact. For a bracket of one point, the share is infinite.
        if smallest_share >= 0.5 || f_a == 0.0 {
            return Ok(best);
        }
        let (xi, phi) = ((a - b) / (c - b), (f_a - f_b) / (f_c - f_b));
        let is_safe = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        let interpolated = || f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b);
        share = if is_safe { interpolated().clamp(smallest_share, 1.0 - smallest_share) } else { 0.5 };
    }
}

/// The smallest whole number that is not below `value`. A value beyond the bounds of the type becomes the nearest bound.
/// The standard library's functions for whole numbers are slow calls unless SSE4.1 is assumed.
#[inline]
#[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "numbers beyond 2^52 are whole")]
pub(crate) fn ceil(value: f64) -> i64 {
    let truncated = value as i64;
    truncated.saturating_add(i64::from((truncated as f64) < value))
}

/// The largest whole number that is not above `value`, with the same limits.
#[inline]
pub(crate) fn floor(value: f64) -> i64 {
    ceil(-value).saturating_neg()
}

/// `value` rounded to `digits` significant digits. A double has at most 17.
pub(crate) fn to_digits(value: f64, digits: u32) -> f64 {
    if digits >= 17 {
        return value;
    }
    let text = format!("{value:.*e}", digits.saturating_sub(1) as usize);
    text.parse().unwrap_or_else(|_| unreachable!("a number that was written can be read"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;
    use std::convert::Infallible;

    #[test]
    fn the_root_survives_a_plateau() {
        // The function is -1 up to x = 3 and then rises: only bisection finds the rise.
        let Ok(found) = bracketed_root(0.0, 100.0, |x| Ok::<_, Infallible>(if x < 3.0 { -1.0 } else { (x - 3.0).powi(2) - 1.0 }));
        // The slope at the root is 2, and the resolution two roundings of the bracket's 100.
        assert_abs_diff_eq!(found, 4.0, epsilon = 4.0 * f64::EPSILON * 100.0);
    }

    proptest! {
        #[test]
        fn the_root_is_found_in_few_steps(at in -0.999..0.999_f64, power in 1..8_i32, steepness in 0.01..100.0_f64) {
            let mut steps = 0;
            let increasing = |x: f64| -> Result<f64, Infallible> {
                steps += 1;
                Ok((steepness * (x - at)).exp_m1() + (x - at).powi(2 * power - 1))
            };
            let Ok(found) = bracketed_root(-1.0, 1.0, increasing);
            // Near its root, the function is at least the steepness times the distance. Its rounding of 2e-16, divided
            // by a steepness of 0.01, is 2e-14.
            assert_abs_diff_eq!(found, at, epsilon = 1e-13);
            // Bisection alone takes 53 steps from 2 to 2 EPSILON.
            prop_assert!(steps <= 60, "{steps} steps");
        }
    }

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "as in the functions")]
    fn whole_numbers_on_both_sides_are_those_of_the_library() {
        for value in [0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 2.5, -2.5, 1e12, -1e12, 4_503_599_627_370_495.5, 1e300, -1e300, 1e-300] {
            assert_eq!((ceil(value), floor(value)), (value.ceil() as i64, (value.floor() as i64).max(-i64::MAX)), "{value}");
        }
    }
}
