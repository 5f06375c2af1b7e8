//! `/v1/scallop-height`, by `POST` and `GET`, and its batch: the height left by a step-over and a feed.

use super::{Calculation, Inputs, Texts};
use crate::http::reading::{Faulted, Faults, members};
use crate::http::wire::{COMMON_FIGURES, Figure, Figures, Heights, SharedParameters, StatedParameters};
use crate::milling::NoAnswer;

members! {
    /// This calculation has only the members that all calculations share.
    pub(crate) struct NoMembers {}
}

/// The height at a contact.
pub(crate) struct ScallopHeightOperation;

impl Calculation for ScallopHeightOperation {
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

    fn new(_: NoMembers, _: Result<&SharedParameters, Faulted>, _: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self)
    }

    fn compute(&self, inputs: &Inputs<'_>) -> Result<Figures, NoAnswer> {
        // A contact without a height has no answer, whichever figures are named.
        let heights = inputs.heights.max(Heights::Total);
        Figures::at(inputs.pass, inputs.stated_step_over()?, inputs.feed_per_tooth, heights, None)
    }
}
