//! `/v1/scallop-height`, by `POST` and `GET`, and its batch: the height left by a step-over and a feed.

use super::{Calculation, Texts};
use crate::http::reading::{Faulted, Faults, JsonPath, members};
use crate::http::wire::{COMMON_FIGURES, Figure, Figures, Heights, SharedParameters, StatedParameters};
use crate::milling::{EvaluatedPass, NoAnswer};
use crate::quantity::Length;

members! {
    /// This calculation has only the members that all calculations share.
    pub(crate) struct NoMembers {}
}

/// The height at a contact.
pub(crate) struct ScallopHeight;

impl Calculation for ScallopHeight {
    const TEXTS: Texts = Texts {
        name: "scallop-height",
        summary: "The scallop height at one contact",
        about: "The height that a step-over and a feed per tooth leave on the surface: h1 from the step-over, and the part that the\n\
            tooth marks along the feed add.",
        answer: "The height, its parts, and the effective radii",
        batch_summary: "The scallop heights of a tool path",
    };
    const STATED: StatedParameters = StatedParameters { step_over: true, feed_per_tooth: true };
    type Members = NoMembers;
    const FIGURES: &'static [&'static [Figure]] = &[COMMON_FIGURES];

    fn new(_: NoMembers, _: Result<&SharedParameters, Faulted>, _: &JsonPath<'_>, _: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self)
    }

    fn compute(
        &self,
        _: &SharedParameters,
        pass: &EvaluatedPass,
        step_over: Option<Length>,
        feed: Option<Length>,
        heights: Heights,
    ) -> Result<Figures, NoAnswer> {
        let step_over = step_over.unwrap_or_else(|| unreachable!("a request of this calculation states a step-over"));
        // A contact without a height has no answer, whichever figures are named.
        Figures::at(pass, step_over, feed, heights.max(Heights::Total), None)
    }
}
