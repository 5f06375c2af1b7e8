//! Roots of functions that never fall. Both searches keep a bracket, so they end whatever the function is like inside it.

/// A value and its derivative.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slope {
    pub(super) value: f64,
    pub(super) derivative: f64,
}

/// More steps than doubling to the largest number (1024) and halving back to a rounding (about 64) can need.
const MOST_STEPS: usize = 1100;

/// The root of a function that never falls and goes from negative to positive, to `resolution` or to a rounding of the root where that is
/// coarser, starting at `start`.
///
/// Newton's step is taken where it stays inside the bracket and the value falls to less than half from step to step; otherwise the
/// bracket is halved. While one side of the bracket is still open the step towards it doubles each time, so the bracket closes as
/// soon as the function changes sign, and halving then ends the search.
pub(super) fn rising_root(start: f64, mut reach: f64, resolution: f64, mut function: impl FnMut(f64) -> Slope) -> f64 {
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let (mut at, mut previous) = (start, f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let Slope { value, derivative } = function(at);
        if value == 0.0 {
            return at;
        }
        if value < 0.0 {
            low = at;
        } else {
            high = at;
        }
        let resolution = resolution.max(2.0 * f64::EPSILON * at.abs());
        if high - low <= resolution {
            return at;
        }
        let newton = at - value / derivative;
        let open = low == f64::NEG_INFINITY || high == f64::INFINITY;
        let fast = value.abs() < previous / 2.0 && newton > low && newton < high && !(open && (newton - at).abs() > reach);
        previous = value.abs();
        let next = if fast {
            newton
        } else if open {
            let next = at - reach.copysign(value);
            reach *= 2.0;
            next
        } else {
            f64::midpoint(low, high)
        };
        if (next - at).abs() <= resolution {
            return next;
        }
        at = next;
    }
    at
}

/// The root in `[low, high]` of a function that never falls, is negative at `low` and not negative at `high`.
///
/// Inverse quadratic interpolation where its condition holds, halving elsewhere (Chandrupatla 1997, Advances in Engineering
/// Software 28, 145-149). The bracket shrinks to a few roundings of the root.
pub(super) fn bracketed_root(low: (f64, f64), high: (f64, f64), mut function: impl FnMut(f64) -> f64) -> f64 {
    let ((mut a, mut fa), (mut b, mut fb)) = (high, low);
    let mut share = 0.5;
    for _ in 0..MOST_STEPS {
        let x = a + share * (b - a);
        let fx = function(x);
        let (c, fc) = if (fx < 0.0) == (fa < 0.0) {
            (a, fa)
        } else {
            let old = (b, fb);
            (b, fb) = (a, fa);
            old
        };
        (a, fa) = (x, fx);
        let (best, f_best) = if fa.abs() < fb.abs() { (a, fa) } else { (b, fb) };
        let least_share = (2.0 * f64::EPSILON * best.abs() + f64::MIN_POSITIVE) / (b - a).abs();
        if least_share > 0.5 || f_best == 0.0 {
            return best;
        }
        let xi = (a - b) / (c - b);
        let phi = (fa - fb) / (fc - fb);
        share = if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
            fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        } else {
            0.5
        };
        share = share.clamp(least_share, 1.0 - least_share);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_root_is_found_from_far_off_and_with_a_null_derivative() {
        for start in [0.0, -1e3, 1e6] {
            let root = rising_root(start, 1e-3, 1e-15, |x| Slope { value: x * x * x - 2.0, derivative: 3.0 * x * x });
            // The last step is below 1e-15; the root itself is 1.26, rounded to 2e-16.
            approx::assert_abs_diff_eq!(root, 2.0_f64.cbrt(), epsilon = 1e-15);
        }
    }

    #[test]
    fn a_corner_does_not_trap_newton() {
        let root = rising_root(5.0, 1.0, 1e-14, |x| {
            let derivative = if x < 1.0 { 1e-3 } else { 1e3 };
            Slope { value: derivative * (x - 1.0), derivative }
        });
        approx::assert_abs_diff_eq!(root, 1.0, epsilon = 1e-14);
    }

    #[test]
    fn a_bracketed_root_survives_a_plateau() {
        // -1 up to x = 3, where the function starts to rise: halving has to find the rise.
        let function = |x: f64| if x < 3.0 { -1.0 } else { (x - 3.0).powi(2) - 1.0 };
        let root = bracketed_root((0.0, -1.0), (100.0, 9408.0), function);
        approx::assert_relative_eq!(root, 4.0, max_relative = 4.0 * f64::EPSILON);
    }
}
