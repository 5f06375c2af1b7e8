//! A smooth bound of a length: y / (1 + (y/b)^8)^(1/8), which is y for short lengths and b for long ones.

/// (y/b)^8 up to which series replace the roots. Their first terms left out are 4e-18 and 1e-16 there.
const SHORT: f64 = 1e-4;

/// What the bound does to a length y.
#[derive(Debug, Clone, Copy)]
pub(super) struct SmoothBound {
    /// The bounded length as a share of y.
    pub(super) factor: f64,
    /// The derivative of the bounded length by y.
    pub(super) slope: f64,
}

impl SmoothBound {
    /// For a length whose square is `share` of the square of the bound.
    pub(super) fn of(share: f64) -> Self {
        let eighth_power = share.powi(4);
        if eighth_power < SHORT {
            let series = |[first, second, third]: [f64; 3]| 1.0 - eighth_power * (first - eighth_power * (second - eighth_power * third));
            let factor = series([1.0 / 8.0, 9.0 / 128.0, 51.0 / 1024.0]);
            return Self { factor, slope: series([9.0 / 8.0, 153.0 / 128.0, 1275.0 / 1024.0]) };
        }
        let factor = (1.0 + eighth_power).sqrt().sqrt().sqrt().recip();
        Self { factor, slope: factor / (1.0 + eighth_power) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_series_are_the_powers(share in 1e-4..3.0_f64) {
            let SmoothBound { factor, slope } = SmoothBound::of(share);
            approx::assert_relative_eq!(factor, (1.0 + share.powi(4)).powf(-0.125), max_relative = 1e-15);
            approx::assert_relative_eq!(slope, (1.0 + share.powi(4)).powf(-1.125), max_relative = 1e-15);
        }
    }
}
