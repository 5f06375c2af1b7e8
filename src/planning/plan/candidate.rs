//! A candidate cutter: its shape and its drive (teeth, spindle speed, feed limit).

use crate::milling::Cutter;
use crate::motion::Machine;
use crate::quantity::{Length, SpindleSpeed};

/// A candidate of the ranking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidateCutter {
    /// The cutter.
    pub cutter: Cutter,
    /// Teeth and spindle speed; `None` if they are not stated. The scallop height is then that of the step-over alone,
    /// and the cutter runs at the machine's feed rate.
    pub drive: Option<Drive>,
    /// The length of the flutes.
    pub flute_length: Option<Length>,
}

impl CandidateCutter {
    /// A cutter without drive and flute length.
    #[must_use]
    pub fn new(cutter: Cutter) -> Self {
        Self { cutter, drive: None, flute_length: None }
    }
}

/// The drive of a cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// z, the number of teeth, at least 1.
    pub teeth: u32,
    /// n, the spindle speed; the machine may limit it.
    pub spindle_speed: SpindleSpeed,
    /// The cutter maker's limit on the feed per tooth.
    pub max_feed_per_tooth: Option<Length>,
}

/// The feeds that a drive allows on a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::planning) struct FeedRange {
    /// The largest feed per tooth, in mm: the cutter maker's limit or the machine's feed rate over the teeth per
    /// second, the lower one.
    pub(in crate::planning) largest: f64,
    /// z n, the teeth that pass in a second.
    pub(in crate::planning) teeth_per_second: f64,
}

impl FeedRange {
    pub(in crate::planning) fn of(drive: Drive, machine: &Machine) -> Self {
        let rpm = machine.max_spindle_speed.map_or(drive.spindle_speed.rpm(), |limit| drive.spindle_speed.rpm().min(limit.rpm()));
        let teeth_per_second = f64::from(drive.teeth.max(1)) * rpm / 60.0;
        let by_machine = machine.limits.feed_rate.mm_s() / teeth_per_second;
        let largest = drive.max_feed_per_tooth.map_or(by_machine, |limit| limit.mm().min(by_machine));
        Self { largest: largest.clamp(Length::SMALLEST, Length::LARGEST), teeth_per_second }
    }

    /// The feed rate of a feed per tooth, in mm/s.
    pub(in crate::planning) fn rate(&self, feed_per_tooth: f64) -> f64 {
        feed_per_tooth * self.teeth_per_second
    }
}
