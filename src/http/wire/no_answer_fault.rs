//! Converts the reason why a pass has no answer to a fault of the request, with its member, code and figures.

use super::contact_object::{CONTACT, StatedContact};
use super::contact_parameters::FEED_PER_TOOTH;
use super::contact_parameters::{CUTTER, ContactParameters, RUNOUT, TOLERANCE};
use crate::http::reading::{Fault, JsonPath};
use crate::milling::NoAnswer;

/// The fault for `cause` in the request at `path`. It points to the member by which contact or parameters were stated;
/// `step_over` is the member that bounds the step-over.
pub(crate) fn no_answer(
    cause: NoAnswer,
    path: &JsonPath<'_>,
    contact: StatedContact,
    parameters: &ContactParameters,
    step_over: &'static str,
) -> Fault {
    let in_contact = path.member(CONTACT.name);
    let path = match cause {
        NoAnswer::FlatFloor | NoAnswer::StraightFlank | NoAnswer::TooSteep { .. } => in_contact.member(contact.slope_member),
        NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::PassesCoincideFromAbove | NoAnswer::StepOverUsesUpTolerance { .. } => {
            path.member(step_over)
        }
        NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::FeedUsesUpTolerance { .. } => path.member(FEED_PER_TOOTH.name),
        NoAnswer::Gouges { .. } => path.member(parameters.curvature_member()),
        NoAnswer::SharpEdge => path.member(CUTTER.name),
        NoAnswer::RunoutUsesUpTolerance => path.member(RUNOUT.name),
        NoAnswer::ToleranceLimitsNoStepOver { .. } | NoAnswer::ToleranceLimitsNoFeed { .. } => path.member(TOLERANCE.name),
    };
    Fault::no_answer(cause, &path, cause)
}
