//! A machine tool: the limits of its feed moves, its rapid rate, its spindle speed and its clearance height.

use super::MachineLimits;
use crate::quantity::{Length, Speed, SpindleSpeed};

/// A machine tool. Rapid moves have the acceleration and the jerk of feed moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Machine {
    /// The limits of moves at the feed rate.
    pub limits: MachineLimits,
    /// The speed of moves that do not cut.
    pub rapid_rate: Speed,
    /// The largest spindle speed; `None` if no limit is known.
    pub max_spindle_speed: Option<SpindleSpeed>,
    /// The height over the highest point of the surface at which rapid moves cross it.
    pub clearance_height: Length,
}

impl Machine {
    /// The limits of a straight move at the rapid rate.
    #[must_use]
    pub fn rapid_limits(&self) -> MachineLimits {
        MachineLimits { feed_rate: self.rapid_rate, ..self.limits }
    }
}

impl From<MachineLimits> for Machine {
    /// A machine of which only the limits of feed moves are known. Its rapid rate is the feed rate, its spindle speed
    /// has no limit, and it crosses the part 5 mm above the highest point.
    fn from(limits: MachineLimits) -> Self {
        Self { limits, rapid_rate: limits.feed_rate, max_spindle_speed: None, clearance_height: Length::computed(5.0) }
    }
}
