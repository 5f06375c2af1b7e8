//! The limits of cutter and machine on the feed, and the conversion between feed per tooth and feed rate.

use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Faulted, Faults, JsonPath, Member, Quantity};
use crate::http::wire::{CUTTER, Figure, SharedParameters, TEETH};
use crate::quantity::{Length, OutOfRange};

pub(super) const SPINDLE_SPEED: Member<Quantity<f64>> = Member::new(
    "spindle_speed_rpm",
    "spindle speed n; with the cutter's teeth, the answer has the feed rate",
    Quantity::new(|rpm| OutOfRange::check(rpm, 1.0, 1e6), 10_000.0),
);

pub(super) const MAX_FEED_PER_TOOTH: Member<Quantity<Length>> =
    Member::new("max_feed_per_tooth_mm", "the largest feed per tooth that the cutter's manufacturer allows", Quantity::length(0.35));

pub(super) const MAX_FEED_RATE: Member<Quantity<f64>> = Member::new(
    "max_feed_rate_mm_min",
    "the largest feed rate of the machine; needs spindle_speed_rpm and the cutter's teeth",
    Quantity::new(|mm_min| OutOfRange::check(mm_min, 1e-3, 1e7), 15_000.0),
);

pub(super) const FEED_RATE: Figure = Figure::number("feed_rate_mm_min", "the feed rate f_z z n", |figures| figures.feed_rate_mm_min)
    .only("if the cutter's teeth and the spindle speed are given");

/// A limit that binds, as answers name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Limit {
    /// The tolerance of the scallop height.
    ScallopTolerance,
    /// The manufacturer's largest feed per tooth.
    MaxFeedPerTooth,
    /// The machine's largest feed rate.
    MaxFeedRate,
    /// The smallest step-over that the request allows.
    MinStepOver,
    /// The largest step-over that the request allows.
    MaxStepOver,
}

/// The limits, those on the feed first.
const LIMITS: &[(&str, Limit)] = &[
    ("scallop_tolerance", Limit::ScallopTolerance),
    ("max_feed_per_tooth", Limit::MaxFeedPerTooth),
    ("max_feed_rate", Limit::MaxFeedRate),
    ("min_step_over", Limit::MinStepOver),
    ("max_step_over", Limit::MaxStepOver),
];

/// The limit that a feed reaches.
pub(super) const LIMITED_BY: Choice<Limit> = Choice { name: Some("LimitedBy"), words: LIMITS.split_at(3).0 };

/// A limit on feed or step-over that binds.
pub(super) const BINDING_LIMIT: Choice<Limit> = Choice { name: Some("BindingLimit"), words: LIMITS };

/// The limits on the feed that a request states.
pub(super) struct FeedLimits {
    spindle_speed_rpm: Option<f64>,
    pub(super) per_tooth: Option<Length>,
    rate_mm_min: Option<f64>,
}

impl FeedLimits {
    /// Checks the limits. A largest feed rate without spindle speed or teeth is a fault.
    pub(super) fn new(
        spindle_speed_rpm: Result<Option<f64>, Faulted>,
        per_tooth: Result<Option<Length>, Faulted>,
        rate_mm_min: Result<Option<f64>, Faulted>,
        shared: Result<&SharedParameters, Faulted>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        let mut complete = Ok(());
        if let Ok(Some(_)) = rate_mm_min {
            let mut need = |path: &JsonPath<'_>, what: &str| {
                let detail = format_args!("a largest feed rate limits the feed per tooth only with {what}");
                complete = Err(faults.add(path, RequestFault::MissingField, detail));
            };
            if spindle_speed_rpm == Ok(None) {
                need(&JsonPath::Root.member(SPINDLE_SPEED.name), "a spindle speed");
            }
            if shared.is_ok_and(|shared| shared.tool.teeth.is_none()) {
                need(&JsonPath::Root.member(CUTTER.name).member(TEETH.name), "a number of teeth");
            }
        }
        complete?;
        Ok(Self { spindle_speed_rpm: spindle_speed_rpm?, per_tooth: per_tooth?, rate_mm_min: rate_mm_min? })
    }

    /// z n, the feed rate for each mm of feed per tooth; `None` if the number of teeth or the spindle speed is not
    /// stated.
    fn teeth_per_min(&self, shared: &SharedParameters) -> Option<f64> {
        shared.tool.teeth.zip(self.spindle_speed_rpm).map(|(teeth, speed)| f64::from(teeth) * speed)
    }

    /// The feed rate of a feed per tooth within the limits; at most the machine's largest, which rounding could exceed.
    pub(super) fn rate_mm_min(&self, shared: &SharedParameters, feed_per_tooth: Length) -> Option<f64> {
        let rate = self.teeth_per_min(shared)? * feed_per_tooth.mm();
        Some(self.rate_mm_min.map_or(rate, |largest| rate.min(largest)))
    }

    /// The feed per tooth at the machine's largest feed rate.
    pub(super) fn by_machine(&self, shared: &SharedParameters) -> Option<Length> {
        self.rate_mm_min.zip(self.teeth_per_min(shared)).map(|(rate, teeth_per_min)| Length::computed(rate / teeth_per_min))
    }
}
