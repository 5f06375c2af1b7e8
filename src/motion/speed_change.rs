//! The speed that a machine reaches within a length, with limited acceleration and jerk.

use super::MachineLimits;
use crate::quantity::{Length, Speed};

/// The greatest speed reached from the speed `start` within a length, with no acceleration at either end, at most the feed rate.
/// Read backwards, it is the greatest speed from which the machine slows down to `start` within that length.
///
/// A change of speed by d takes 2 sqrt(d/J) if the acceleration is not reached, otherwise d/A + A/J, at the mean speed
/// `start` + d/2, because the profile is symmetric. So the length is (start + d/2) times that; it is solved for d in closed form.
#[must_use]
pub fn speed_after(start: Speed, length: Length, limits: MachineLimits) -> Speed {
    let (v, s) = (start.mm_s(), length.mm());
    let (a, j) = (limits.acceleration.mm_s2(), limits.jerk.mm_s3());
    let change = if s <= (v + 0.5 * a * limits.time_to_acceleration()) * 2.0 * limits.time_to_acceleration() {
        by_jerk_alone(v, s * j.sqrt())
    } else {
        // d^2/2 + d b = c, which is s A with the length of the two ramps of the jerk taken off, without cancellation.
        let (b, c) = (v + 0.5 * a * a / j, s * a - v * a * a / j);
        2.0 * c / (b + (b * b + 2.0 * c).sqrt())
    };
    Speed::computed((v + change).min(limits.feed_rate.mm_s()))
}

/// The square of the root u of u^3 + 2 v u = q, v over 0 and q at least 0.
fn by_jerk_alone(v: f64, q: f64) -> f64 {
    let scale = (8.0 * v / 3.0).sqrt();
    let u = scale * ((4.0 * q / scale.powi(3)).asinh() / 3.0).sinh();
    u * u
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::travel_time;
    use crate::quantity::{Acceleration, Jerk};
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    fn limits(v: f64, a: f64, j: f64) -> MachineLimits {
        MachineLimits {
            feed_rate: Speed::from_mm_min(v * 60.0).unwrap(),
            acceleration: Acceleration::from_m_s2(a / 1e3).unwrap(),
            jerk: Jerk::from_m_s3(j / 1e3).unwrap(),
        }
    }

    fn after(start: f64, length: f64, limits: MachineLimits) -> f64 {
        speed_after(Speed::computed(start), Length::computed(length), limits).mm_s()
    }

    /// Length and end speed of a rise in speed by `change`, the three phases of its jerk integrated.
    fn integrated(start: f64, change: f64, a: f64, j: f64) -> (f64, f64) {
        let ramp = (a / j).min((change / j).sqrt());
        let hold = change / (j * ramp) - ramp;
        let (mut x, mut v, mut now) = (0.0, start, 0.0);
        for (jerk, t) in [(j, ramp), (0.0, hold), (-j, ramp)] {
            x += t * (v + t * (now / 2.0 + t * jerk / 6.0));
            v += t * (now + t * jerk / 2.0);
            now += t * jerk;
        }
        (x, v)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn the_jerk_profile_to_the_speed_covers_the_length(start in 0.0..200.0, change in 1e-3..500.0, a in 1.0..2e4, j in 10.0..1e6) {
            let (length, end) = integrated(start, change, a, j);
            assert_relative_eq!(end, start + change, max_relative = 1e-9);
            assert_relative_eq!(after(start, length, limits(1e4, a, j)), start + change, max_relative = 1e-9);
        }

        #[test]
        fn a_move_from_rest_is_at_its_top_speed_half_way(length in 1e-3..1e3, a in 1.0..2e4, j in 10.0..1e6) {
            let limits = limits(1e4, a, j);
            let top = after(1e-12, 0.5 * length, limits);
            let rise = if top <= a * a / j { 2.0 * (top / j).sqrt() } else { top / a + a / j };
            prop_assume!(top < 1e4);
            assert_relative_eq!(travel_time(Length::from_mm(length).unwrap(), limits).seconds(), 2.0 * rise, max_relative = 1e-9);
        }

        #[test]
        fn less_jerk_reaches_less_and_without_a_limit_it_is_that_of_the_acceleration(start in 0.0..200.0, length in 1e-3..1e2, a in 10.0..1e4) {
            let speeds = [1e2, 1e4, 1e6, 1e9].map(|j| after(start, length, limits(1e4, a, j)));
            prop_assert!(speeds.is_sorted());
            let by_acceleration = (start * start + 2.0 * a * length).sqrt();
            prop_assert!(speeds[3] <= by_acceleration * (1.0 + 1e-12) && speeds[3] >= 0.98 * by_acceleration);
        }
    }

    #[test]
    fn the_feed_rate_is_not_exceeded() {
        let limits = limits(50.0, 1e3, 1e4);
        assert_relative_eq!(after(10.0, 1e3, limits), 50.0);
        assert_relative_eq!(after(10.0, 0.0, limits), 10.0);
    }
}
