//! The limits of a machine along a straight line: feed rate, acceleration and jerk.

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
