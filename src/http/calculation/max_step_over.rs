//! `/v1/step-over`, by `POST` and `GET`, and its batch: the largest step-over that keeps the scallop height within a
//! tolerance.

use super::{Calculation, Inputs, Texts};
use crate::http::reading::{Faulted, Faults, JsonPath, Quantity, members};
use crate::http::wire::{
    COMMON_FIGURES, Figure, Figures, ROUGHNESS, RoughnessKind, SharedParameters, StatedParameters, TOLERANCE, stated_height,
};
use crate::milling::NoAnswer;
use crate::quantity::Length;

members! {
    /// The tolerance to keep.
    pub(crate) struct ToleranceMembers {
        tolerance: optional TOLERANCE: Quantity<Length>,
        roughness: optional ROUGHNESS: RoughnessKind,
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

    fn new(members: ToleranceMembers, _: Result<&SharedParameters, Faulted>, faults: &mut Faults) -> Result<Self, Faulted> {
        let ToleranceMembers { tolerance, roughness } = members;
        Ok(Self { tolerance: stated_height(tolerance, roughness, &TOLERANCE, &JsonPath::Root, faults)? })
    }

    fn compute(&self, inputs: &Inputs<'_>) -> Result<Figures, NoAnswer> {
        let &Inputs { pass, feed_per_tooth, heights, .. } = inputs;
        let step_over = pass.max_step_over(self.tolerance, feed_per_tooth)?;
        Figures::at(pass, step_over, feed_per_tooth, heights, None)
    }
}
