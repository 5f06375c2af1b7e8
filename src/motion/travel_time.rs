//! A straight move with limited speed, acceleration and jerk: its time from rest to rest, and the speed that it reaches.

use crate::quantity::{Acceleration, Jerk, Length, Speed, Time};

/// The limits of a straight move. Every combination of valid values is valid, because a move need not reach every
/// limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MachineLimits {
    /// V, the programmed feed rate, which the machine does not exceed.
    pub feed_rate: Speed,
    /// A, the largest acceleration and deceleration.
    pub acceleration: Acceleration,
    /// J, the largest jerk.
    pub jerk: Jerk,
}

impl MachineLimits {
    /// t_A = A/J, the time to build up the acceleration A [Herraz et al. 2020, section 2.2], in s.
    pub(super) fn time_to_acceleration(self) -> f64 {
        self.acceleration.mm_s2() / self.jerk.mm_s3()
    }

    /// t_V = sqrt(V/J), half the time to reach the feed rate V if A is not reached [Herraz et al. 2020, section 2.2],
    /// in s.
    pub(super) fn time_to_feed_rate(self) -> f64 {
        (self.feed_rate.mm_s() / self.jerk.mm_s3()).sqrt()
    }

    /// The time that a move which reaches the feed rate loses by starting and stopping, compared with constant speed: 2
    /// sqrt(V/J) if the acceleration is not reached, otherwise A/J + V/A [Herraz et al. 2020, eq. 2 and 3].
    #[must_use]
    pub fn time_lost_to_stops(self) -> Time {
        let (t_a, t_v) = (self.time_to_acceleration(), self.time_to_feed_rate());
        Time::computed(if t_v <= t_a { 2.0 * t_v } else { t_a + self.feed_rate.mm_s() / self.acceleration.mm_s2() })
    }

    /// The shortest length at which a move reaches the feed rate: 2 V sqrt(V/J) if the acceleration is not reached,
    /// otherwise V (A/J + V/A). Both are V times the time lost to stops.
    #[must_use]
    pub fn shortest_at_feed_rate(self) -> Length {
        Length::computed(self.feed_rate.mm_s() * self.time_lost_to_stops().seconds())
    }

    /// The longest length at which only the jerk limits a move, 2 J min(A/J, sqrt(V/J))^3 [Herraz et al. 2020, section
    /// 2.2].
    #[must_use]
    pub fn longest_by_jerk_alone(self) -> Length {
        Length::computed(2.0 * self.jerk.mm_s3() * self.time_to_acceleration().min(self.time_to_feed_rate()).powi(3))
    }
}

/// The limits that a straight move from rest to rest reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TravelCase {
    /// Neither the feed rate nor the acceleration: the move is short, and the jerk alone limits it.
    JerkOnly,
    /// The feed rate, but not the acceleration.
    FeedRate,
    /// The feed rate and the acceleration.
    FeedRateAndAcceleration,
    /// The acceleration, but not the feed rate.
    Acceleration,
}

impl TravelCase {
    /// The case of a move over `length`.
    ///
    /// The smallest of t_A = A/J, t_V = sqrt(V/J) and t_L = cbrt(L/2J) determines the case [Herraz et al. 2020, section
    /// 2.2]. If t_A is the smallest, the feed rate is reached only if the move is at least as long as speeding up and
    /// slowing down, L >= V (A/J + V/A); the paper omits the other case.
    #[must_use]
    pub fn of(length: Length, limits: MachineLimits) -> Self {
        let (t_a, t_v, t_l) = (limits.time_to_acceleration(), limits.time_to_feed_rate(), half_time_by_jerk(length, limits));
        if t_l <= t_a && t_l <= t_v {
            Self::JerkOnly
        } else if t_v <= t_a {
            Self::FeedRate
        } else if length >= limits.shortest_at_feed_rate() {
            Self::FeedRateAndAcceleration
        } else {
            Self::Acceleration
        }
    }

    /// Whether part of the move runs at the feed rate.
    #[must_use]
    pub fn reaches_feed_rate(self) -> bool {
        matches!(self, Self::FeedRate | Self::FeedRateAndAcceleration)
    }
}

/// The time, in s, of the fastest straight move over L from rest to rest, with speed up to V, acceleration up to A and
/// jerk up to J:
///
/// - jerk only: 4 cbrt(L/2J) [Herraz et al. 2020, eq. 4];
/// - feed rate: L/V + 2 sqrt(V/J) [eq. 3];
/// - feed rate and acceleration: L/V + A/J + V/A [eq. 2];
/// - acceleration: 2 (A/J + v/A) with the top speed v = A (sqrt((A/J)^2 + 4L/A) - A/J) / 2, which the paper omits.
///
/// The formulas agree at the borders between the cases. A length of 0 takes a time of 0.
#[must_use]
pub fn travel_time(length: Length, limits: MachineLimits) -> Time {
    Time::computed(match TravelCase::of(length, limits) {
        TravelCase::JerkOnly => 4.0 * half_time_by_jerk(length, limits),
        TravelCase::FeedRate | TravelCase::FeedRateAndAcceleration => {
            length.mm() / limits.feed_rate.mm_s() + limits.time_lost_to_stops().seconds()
        }
        TravelCase::Acceleration => {
            let (t_a, l_over_a) = (limits.time_to_acceleration(), length.mm() / limits.acceleration.mm_s2());
            // v/A = (sqrt(t_A^2 + 4L/A) - t_A) / 2, expanded by the sum of its terms, which avoids cancellation.
            2.0 * (t_a + 2.0 * l_over_a / (t_a.hypot(2.0 * l_over_a.sqrt()) + t_a))
        }
    })
}

/// t_L = cbrt(L/2J), a quarter of the time of a move that only the jerk limits, in s.
fn half_time_by_jerk(length: Length, limits: MachineLimits) -> f64 {
    (length.mm() / (2.0 * limits.jerk.mm_s3())).cbrt()
}

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
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests {
    use super::*;
    use crate::quantity::{Acceleration, Jerk, Speed};
    use approx::assert_relative_eq;
    use proptest::prelude::*;

    /// Limits in mm, s.
    fn limits(v: f64, a: f64, j: f64) -> MachineLimits {
        MachineLimits {
            feed_rate: Speed::from_mm_min(v * 60.0).unwrap(),
            acceleration: Acceleration::from_m_s2(a / 1e3).unwrap(),
            jerk: Jerk::from_m_s3(j / 1e3).unwrap(),
        }
    }

    fn time(length: f64, limits: MachineLimits) -> f64 {
        travel_time(Length::from_mm(length).unwrap(), limits).seconds()
    }

    #[test]
    fn published_times_of_an_independent_solver_one_for_each_case() {
        for (v, a, j, case, published) in [
            (1.0, 1.0, 1.0, TravelCase::JerkOnly, 3.174_802_103_9),
            (1.0, 1.0, 2.0, TravelCase::Acceleration, 2.561_552_812_8),
            (0.6, 1.0, 2.0, TravelCase::FeedRateAndAcceleration, 2.766_666_666_7),
            (0.4, 1.0, 2.0, TravelCase::FeedRate, 3.394_427_191),
        ] {
            let limits = limits(v, a, j);
            assert_eq!(TravelCase::of(Length::from_mm(1.0).unwrap(), limits), case);
            // The published values have ten decimals.
            approx::assert_abs_diff_eq!(time(1.0, limits), published, epsilon = 0.5e-10);
        }
    }

    #[test]
    fn a_length_of_zero_takes_a_time_of_zero() {
        assert_eq!(travel_time(Length::ZERO, limits(1.0, 1.0, 1.0)).seconds(), 0.0);
    }

    /// Distance, end speed, top speed and top acceleration of the symmetric profile, integrated phase by phase: the
    /// acceleration rises for `t_jerk`, stays for `t_hold`, falls for `t_jerk`, and is 0 for `t_cruise`.
    fn integrate(jerk: f64, t_jerk: f64, t_hold: f64, t_cruise: f64) -> (f64, f64, f64, f64) {
        let phases = [(jerk, t_jerk), (0.0, t_hold), (-jerk, t_jerk), (0.0, t_cruise), (-jerk, t_jerk), (0.0, t_hold), (jerk, t_jerk)];
        let (mut x, mut v, mut a, mut top_v, mut top_a) = (0.0, 0.0, 0.0_f64, 0.0_f64, 0.0_f64);
        for (j, t) in phases {
            x += t * (v + t * (a / 2.0 + t * j / 6.0));
            v += t * (a + t * j / 2.0);
            a += t * j;
            (top_v, top_a) = (top_v.max(v), top_a.max(a.abs()));
        }
        (x, v, top_v, top_a)
    }

    /// Lengths and limits over several decades, so that every case occurs.
    fn moves() -> impl Strategy<Value = (f64, f64, f64, f64)> {
        let decades = |low: f64, high: f64| (low..high).prop_map(|exponent| 10.0_f64.powf(exponent));
        (decades(-3.0, 4.0), decades(0.0, 3.0), decades(0.0, 5.0), decades(0.0, 6.0))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn the_jerk_profile_of_the_time_covers_the_length((length, v, a, j) in moves()) {
            let limits = limits(v, a, j);
            let total = time(length, limits);
            let case = TravelCase::of(Length::from_mm(length).unwrap(), limits);
            let t_jerk = match case {
                TravelCase::JerkOnly => total / 4.0,
                TravelCase::FeedRate => (v / j).sqrt(),
                TravelCase::FeedRateAndAcceleration | TravelCase::Acceleration => a / j,
            };
            let t_hold = match case {
                TravelCase::JerkOnly | TravelCase::FeedRate => 0.0,
                TravelCase::FeedRateAndAcceleration => v / a - a / j,
                TravelCase::Acceleration => (total - 4.0 * t_jerk) / 2.0,
            };
            let t_cruise = if case.reaches_feed_rate() { total - 4.0 * t_jerk - 2.0 * t_hold } else { 0.0 };
            // At a border, a phase may be negative by the rounding error of the total.
            prop_assert!(t_hold >= -1e-12 * total && t_cruise >= -1e-12 * total);
            let (x, end_v, top_v, top_a) = integrate(j, t_jerk, t_hold, t_cruise);
            // The rounding of the sum of up to seven phases, each rounded to 2e-16, is amplified if a short phase is a
            // difference of long ones.
            assert_relative_eq!(x, length, max_relative = 1e-11);
            prop_assert!(end_v.abs() <= 1e-11 * top_v);
            prop_assert!(top_v <= v * (1.0 + 1e-11) && top_a <= a * (1.0 + 1e-11));
        }

        #[test]
        fn raising_a_limit_never_takes_longer((length, v, a, j) in moves(), factor in 1.0..10.0_f64) {
            let stated = time(length, limits(v, a, j));
            // Neighbouring cases may differ by a rounding at their border.
            let bound = stated * (1.0 + 1e-14);
            prop_assert!(time(length, limits(v * factor, a, j)) <= bound);
            prop_assert!(time(length, limits(v, a * factor, j)) <= bound);
            prop_assert!(time(length, limits(v, a, j * factor)) <= bound);
            prop_assert!(time(length / factor, limits(v, a, j)) <= bound);
        }

        #[test]
        fn cases_agree_at_their_borders((_, v, a, j) in moves()) {
            let limits = limits(v, a, j);
            let shortest = limits.shortest_at_feed_rate().mm();
            let jerk_only = limits.longest_by_jerk_alone().mm();
            for border in [shortest, jerk_only].into_iter().filter(|border| (1e-5..1e5).contains(border)) {
                // The time grows at most in proportion to the length, so over 2e-9 of the length it changes by at most
                // 2e-9 of itself.
                assert_relative_eq!(time(border * (1.0 - 1e-9), limits), time(border * (1.0 + 1e-9), limits), max_relative = 2.01e-9);
            }
        }

        #[test]
        fn an_independent_trajectory_solver_finds_the_same_time((length, v, a, j) in moves()) {
            use rsruckig::prelude::*;
            // In units of the move's length and jerk, the solver's numbers stay near 1. Times scale back by cbrt(L/J).
            let unit = (length / j).cbrt();
            // The solver refuses moves of more than 7600 of its units.
            prop_assume!(time(length, limits(v, a, j)) < 7000.0 * unit);
            let mut input = InputParameter::<1>::new(None);
            input.target_position[0] = 1.0;
            input.max_velocity[0] = v * unit / length;
            input.max_acceleration[0] = a * unit * unit / length;
            input.max_jerk[0] = 1.0;
            let mut trajectory = Trajectory::<1>::new(None);
            let planned = Ruckig::<1, ThrowErrorHandler>::new(None, 0.001).calculate(&input, &mut trajectory);
            prop_assert_eq!(planned.unwrap(), RuckigResult::Working);
            // The solver accepts a solution with a residual of up to 1e-8 of the length.
            assert_relative_eq!(time(length, limits(v, a, j)), trajectory.get_duration() * unit, max_relative = 1e-8);
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
