//! What a machine's drives and control allow along a straight line.

use crate::quantity::{Acceleration, Jerk, Speed};

/// The limits of a straight move. Every combination of valid values is valid: where one limit is never reached, another decides.
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

    /// t_V = sqrt(V/J), half the time to reach the feed rate V where A is not reached [Herraz et al. 2020, section 2.2], in s.
    pub(super) fn time_to_feed_rate(self) -> f64 {
        (self.feed_rate.mm_s() / self.jerk.mm_s3()).sqrt()
    }
}
