//! `/v1/step-over`, by `POST` and `GET`, and its batch: the largest step-over that keeps the scallop height within a
//! tolerance.

use super::{Calculation, Texts};
use crate::http::reading::{Faulted, Faults, JsonPath, Quantity, members};
use crate::http::wire::{COMMON_FIGURES, Figure, Figures, Heights, SharedParameters, StatedParameters, TOLERANCE};
use crate::milling::{EvaluatedPass, NoAnswer};
use crate::quantity::Length;

members! {
    /// The tolerance to keep.
    pub(crate) struct ToleranceMembers {
        tolerance: required TOLERANCE: Quantity<Length>,
    }
}

/// The largest step-over at a contact.
pub(crate) struct MaxStepOver {
    tolerance: Length,
}

impl Calculation for MaxStepOver {
    const TEXTS: Texts = Texts {
        name: "step-over",
        summary: "The largest step-over at one contact",
        about: "The largest step-over that keeps the scallop height within a tolerance, along the surface and seen from above, at a\n\
            given feed per tooth.",
        answer: "The step-over, and the heights at this step-over",
        batch_summary: "The largest step-overs of a tool path",
    };
    const STATED: StatedParameters = StatedParameters { step_over: false, feed_per_tooth: true };
    type Members = ToleranceMembers;
    const FIGURES: &'static [&'static [Figure]] = &[COMMON_FIGURES];

    fn new(members: ToleranceMembers, _: Result<&SharedParameters, Faulted>, _: &JsonPath<'_>, _: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self { tolerance: members.tolerance? })
    }

    fn compute(
        &self,
        _: &SharedParameters,
        pass: &EvaluatedPass,
        _: Option<Length>,
        feed: Option<Length>,
        heights: Heights,
    ) -> Result<Figures, NoAnswer> {
        Figures::at(pass, pass.max_step_over(self.tolerance, feed)?, feed, heights, None)
    }
}
