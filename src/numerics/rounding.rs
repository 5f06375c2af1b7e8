//! Rounding to whole numbers and to significant digits. The standard library's functions for whole numbers are slow
//! calls unless SSE4.1 is assumed.

/// The smallest whole number that is not below `value`. A value beyond the bounds of the type becomes the nearest bound.
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

    #[test]
    #[expect(clippy::cast_possible_truncation, reason = "as in the functions")]
    fn whole_numbers_on_both_sides_are_those_of_the_library() {
        for value in [0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 2.5, -2.5, 1e12, -1e12, 4_503_599_627_370_495.5, 1e300, -1e300, 1e-300] {
            assert_eq!((ceil(value), floor(value)), (value.ceil() as i64, (value.floor() as i64).max(-i64::MAX)), "{value}");
        }
    }
}
