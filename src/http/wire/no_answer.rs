//! A pass without an answer, as a fault of the request: which member is to blame, under which code, with which figures.

use super::contact::{CONTACT, StatedContact};
use super::curvature::SURFACE_RADIUS;
use super::cutter::CUTTER;
use super::feed::FEED_PER_TOOTH;
use super::parameters::TOLERANCE;
use super::runout::RUNOUT;
use super::step_over;
use crate::http::codes::NoAnswerCode;
use crate::http::reading::{Fault, JsonPath};
use crate::milling::{NoAnswer, StepOver};

/// The fault that `cause` is in the request at `path`, given in which form contact and step-over were stated.
pub(crate) fn no_answer(cause: NoAnswer, path: &JsonPath<'_>, contact: StatedContact, step_over: Option<StepOver>) -> Fault {
    let in_contact = path.member(CONTACT.name);
    let path = match cause {
        NoAnswer::FlatFloor => in_contact.member(contact.slope_member),
        NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::PassesCoincideFromAbove | NoAnswer::StepOverUsesUpTolerance { .. } => {
            path.member(step_over::member_of(step_over))
        }
        NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::FeedUsesUpTolerance { .. } => path.member(FEED_PER_TOOTH.name),
        NoAnswer::Gouges { .. } => path.member(SURFACE_RADIUS.name),
        NoAnswer::SharpEdge => path.member(CUTTER.name),
        NoAnswer::RunoutUsesUpTolerance => path.member(RUNOUT.name),
        NoAnswer::ToleranceLimitsNoStepOver { .. } | NoAnswer::ToleranceLimitsNoFeed { .. } => path.member(TOLERANCE.name),
    };
    let (code, figures) = NoAnswerCode::of(cause);
    Fault { figures, ..Fault::new(&path, code, cause) }
}
