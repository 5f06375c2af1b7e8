//! `/v1/max-feed`, by `POST` and `GET`, and its batch: the largest feed that keeps the scallop height within a
//! tolerance.

use super::feed_limits::{FEED_RATE, FeedLimits, LIMITED_BY, Limit, MAX_FEED_PER_TOOTH, MAX_FEED_RATE, SPINDLE_SPEED};
use super::{Calculation, Inputs, Texts};
use crate::http::reading::{Faulted, Faults, JsonPath, Kind, Quantity, members};
use crate::http::wire::{
    COMMON_FIGURES, Figure, Figures, Get, ROUGHNESS, RoughnessKind, SharedParameters, StatedParameters, TOLERANCE, stated_height,
};
use crate::milling::NoAnswer;
use crate::quantity::Length;

members! {
    /// The tolerance to keep, and the limits of cutter and machine.
    pub(crate) struct MaxFeedMembers {
        tolerance: optional TOLERANCE: Quantity<Length>,
        roughness: optional ROUGHNESS: RoughnessKind,
        spindle_speed_rpm: optional SPINDLE_SPEED: Quantity<f64>,
        per_tooth_limit: optional MAX_FEED_PER_TOOTH: Quantity<Length>,
        rate_limit_mm_min: optional MAX_FEED_RATE: Quantity<f64>,
    }
}

/// The largest feed at a contact.
pub(crate) struct MaxFeed {
    tolerance: Length,
    limits: FeedLimits,
}

const FIGURES: &[Figure] = &[
    Figure::number("feed_per_tooth_mm", "the largest feed per tooth", |figures| figures.feed_per_tooth.map(Length::mm)),
    Figure::new(
        "limited_by",
        "the limit that the feed reaches",
        Get::Word(|figures| figures.limited_by, |about, components| LIMITED_BY.schema(about, components)),
    ),
    FEED_RATE,
];

impl Calculation for MaxFeed {
    const TEXTS: Texts = Texts {
        name: "max-feed",
        summary: "The largest feed at one contact",
        about: "The largest feed per tooth, and feed rate, that keep the scallop height within a tolerance at a given step-over, and\n\
            within the limits of cutter and machine if these are stated.",
        answer: "The feed, its limit, and the heights at this feed",
        batch_summary: "The largest feeds of a tool path",
    };
    const STATED: StatedParameters = StatedParameters { step_over: true, feed_per_tooth: false };
    type Members = MaxFeedMembers;
    const FIGURES: &'static [&'static [Figure]] = &[FIGURES, COMMON_FIGURES];

    fn new(members: MaxFeedMembers, shared: Result<&SharedParameters, Faulted>, faults: &mut Faults) -> Result<Self, Faulted> {
        let MaxFeedMembers { tolerance, roughness, spindle_speed_rpm, per_tooth_limit, rate_limit_mm_min } = members;
        let tolerance = stated_height(tolerance, roughness, &TOLERANCE, &JsonPath::Root, faults);
        let limits = FeedLimits::new(spindle_speed_rpm, per_tooth_limit, rate_limit_mm_min, shared, faults);
        Ok(Self { tolerance: tolerance?, limits: limits? })
    }

    fn compute(&self, inputs: &Inputs<'_>) -> Result<Figures, NoAnswer> {
        let &Inputs { shared, pass, heights, .. } = inputs;
        let step_over = inputs.stated_step_over()?;
        let by_machine = self.limits.by_machine(shared);
        let stated = [(self.limits.per_tooth, Limit::MaxFeedPerTooth), (by_machine, Limit::MaxFeedRate)];
        let stated = stated.into_iter().filter_map(|(limit, by)| Some((limit?, by))).reduce(|a, b| if b.0 < a.0 { b } else { a });
        let step_over_height = pass.step_over_height(step_over)?;
        let by_tolerance = pass.max_feed_per_tooth_above(step_over_height, self.tolerance, step_over);
        let (feed_per_tooth, limited_by) = match (by_tolerance, stated) {
            (Ok(by_tolerance), Some(stated)) if stated.0 < by_tolerance => stated,
            (Ok(by_tolerance), _) => (by_tolerance, Limit::ScallopTolerance),
            // The tolerance sets no limit while the marks overlap. A limit that the request states is then the only
            // one.
            (Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth }), Some(stated)) if stated.0 <= largest_feed_per_tooth => stated,
            (Err(cause), _) => return Err(cause),
        };
        let feed_rate_mm_min = self.limits.rate_mm_min(shared, feed_per_tooth);
        let mut figures = Figures::at(pass, step_over, Some(feed_per_tooth), heights, Some(step_over_height))?;
        figures.feed_rate_mm_min = feed_rate_mm_min;
        figures.limited_by = Some(LIMITED_BY.word(&limited_by));
        Ok(figures)
    }
}
