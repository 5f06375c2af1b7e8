//! `/v1/cutting-parameters`, by `POST` and `GET`, and its batch: the step-over and feed that finish the most area per
//! time within a tolerance.

use super::feed_limits::{BINDING_LIMIT, FEED_RATE, FeedLimits, Limit, MAX_FEED_PER_TOOTH, MAX_FEED_RATE, SPINDLE_SPEED};
use super::{Calculation, Inputs, Texts};
use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath, Kind, Quantity, members};
use crate::http::wire::{
    COMMON_FIGURES, ContactParameters, Figure, Figures, Get, Heights, ROUGHNESS, RoughnessKind, SharedParameters, StatedParameters,
    TOLERANCE, stated_height,
};
use crate::milling::{CuttingLimits, LimitedBy, NoAnswer};
use crate::quantity::Length;

members! {
    /// The tolerance to keep, and the limits of cutter, machine and step-over.
    pub(crate) struct CuttingParametersMembers {
        tolerance: optional TOLERANCE: Quantity<Length>,
        roughness: optional ROUGHNESS: RoughnessKind,
        spindle_speed_rpm: optional SPINDLE_SPEED: Quantity<f64>,
        per_tooth_limit: optional MAX_FEED_PER_TOOTH: Quantity<Length>,
        rate_limit_mm_min: optional MAX_FEED_RATE: Quantity<f64>,
        min_step_over: optional MIN_STEP_OVER: Quantity<Length> = ("min_step_over_mm", Quantity::length(0.1),
            "the smallest step-over along the surface"),
        max_step_over: optional MAX_STEP_OVER: Quantity<Length> = ("max_step_over_mm", Quantity::length(1.0),
            "the largest step-over along the surface, at least min_step_over_mm"),
    }
}

/// The fastest cutting parameters at a contact.
pub(crate) struct FastestParameters {
    tolerance: Length,
    feed: FeedLimits,
    min_step_over: Option<Length>,
    max_step_over: Option<Length>,
}

const FIGURES: &[Figure] = &[
    Figure::number("feed_per_tooth_mm", "the feed per tooth", |figures| figures.feed_per_tooth.map(Length::mm)),
    Figure::new(
        "limited_by",
        "the limits that bind",
        Get::Words(|figures| figures.binding_limits, |about, components| BINDING_LIMIT.schema(about, components)),
    ),
    FEED_RATE,
    Figure::number("area_rate_mm2_min", "the area finished per minute, the step-over along the surface times the feed rate", |figures| {
        figures.feed_rate_mm_min.map(|rate| rate * figures.step_over.mm())
    })
    .only("if the cutter's teeth and the spindle speed are given"),
];

/// Two limits on the feed within this ratio count as equal, as in the limits that the calculation finds.
const EQUAL: f64 = 1e-9;

impl FastestParameters {
    /// The wire names of a limit that binds. A limit on the feed per tooth is the cutter manufacturer's, the machine's,
    /// or both.
    fn words(limit: LimitedBy, per_tooth: Option<Length>, by_machine: Option<Length>) -> [Option<Limit>; 2] {
        let is_smallest = |one: Option<Length>, other: Option<Length>| {
            one.is_some_and(|one| other.is_none_or(|other| one.mm() <= other.mm() * (1.0 + EQUAL)))
        };
        match limit {
            LimitedBy::ScallopTolerance => [Some(Limit::ScallopTolerance), None],
            LimitedBy::MaxFeedPerTooth => [
                is_smallest(per_tooth, by_machine).then_some(Limit::MaxFeedPerTooth),
                is_smallest(by_machine, per_tooth).then_some(Limit::MaxFeedRate),
            ],
            LimitedBy::MinStepOver => [Some(Limit::MinStepOver), None],
            LimitedBy::MaxStepOver => [Some(Limit::MaxStepOver), None],
        }
    }
}

impl Calculation for FastestParameters {
    const TEXTS: Texts = Texts {
        name: "cutting-parameters",
        summary: "The fastest step-over and feed at one contact",
        about: "The step-over and feed per tooth that finish the most area per time while the scallop height keeps a tolerance,\n\
            within the limits of cutter, machine and step-over if these are stated.",
        answer: "Step-over and feed, the limits that bind, and the heights",
        batch_summary: "The fastest step-overs and feeds of a tool path",
    };
    const STATED: StatedParameters = StatedParameters { step_over: false, feed_per_tooth: false };
    // The calculation searches for a step-over dozens of times.
    const TAKES_LONG: bool = true;
    type Members = CuttingParametersMembers;
    const FIGURES: &'static [&'static [Figure]] = &[FIGURES, COMMON_FIGURES];

    fn new(members: CuttingParametersMembers, shared: Result<&SharedParameters, Faulted>, faults: &mut Faults) -> Result<Self, Faulted> {
        let CuttingParametersMembers {
            tolerance,
            roughness,
            spindle_speed_rpm,
            per_tooth_limit,
            rate_limit_mm_min,
            min_step_over,
            max_step_over,
        } = members;
        let tolerance = stated_height(tolerance, roughness, &TOLERANCE, &JsonPath::Root, faults);
        let feed = FeedLimits::new(spindle_speed_rpm, per_tooth_limit, rate_limit_mm_min, shared, faults);
        let (min_step_over, max_step_over) = (min_step_over?, max_step_over?);
        CuttingLimits::new(None, min_step_over, max_step_over)
            .map_err(|error| faults.add(&JsonPath::Root.member(MIN_STEP_OVER.name), RequestFault::OutOfRange, error))?;
        Ok(Self { tolerance: tolerance?, feed: feed?, min_step_over, max_step_over })
    }

    fn step_over_member(&self, _: &ContactParameters) -> &'static str {
        if self.min_step_over.is_some() { MIN_STEP_OVER.name } else { TOLERANCE.name }
    }

    fn compute(&self, &Inputs { shared, pass, cancel, .. }: &Inputs<'_>) -> Result<Figures, NoAnswer> {
        let (per_tooth, by_machine) = (self.feed.per_tooth, self.feed.by_machine(shared));
        let feed_limit = per_tooth.into_iter().chain(by_machine).reduce(|a, b| if b < a { b } else { a });
        let limits = CuttingLimits::new(feed_limit, self.min_step_over, self.max_step_over);
        let limits = limits.unwrap_or_else(|_| unreachable!("the step-overs were compared when the request was read"));
        let fastest = pass.fastest_until(self.tolerance, &limits, &|| cancel.is_cancelled())?;
        let mut figures = Figures::at(pass, fastest.step_over, Some(fastest.feed_per_tooth), Heights::Parts, None)?;
        figures.feed_rate_mm_min = self.feed.rate_mm_min(shared, fastest.feed_per_tooth);
        let words = fastest.limited_by().flat_map(|limit| Self::words(limit, per_tooth, by_machine)).flatten();
        for (slot, word) in figures.binding_limits.iter_mut().zip(words) {
            *slot = Some(BINDING_LIMIT.word(&word));
        }
        Ok(figures)
    }
}
