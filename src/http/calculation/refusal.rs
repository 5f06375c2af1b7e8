//! A pass without an answer, as a fault of the request: which member is to blame, under which name, with which figures.

use super::contact::StatedContact;
use super::terms::{names, step_over_member};
use crate::http::codes::NoAnswerCode;
use crate::http::reading::{Fault, Place};
use crate::milling::{NoAnswer, StepOver};

/// The fault that `cause` is in the request at `place`, given in what form contact and step-over were stated.
pub(super) fn fault(cause: NoAnswer, place: &Place<'_>, contact: StatedContact, step_over: Option<StepOver>) -> Fault {
    let in_contact = place.member("contact");
    let place = match cause {
        NoAnswer::FlatFloor => in_contact.member(contact.slope_member),
        NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::PassesCoincideFromAbove | NoAnswer::StepOverUsesUpTolerance { .. } => {
            place.member(step_over_member(step_over))
        }
        NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::FeedUsesUpTolerance { .. } => place.member(names::FEED_PER_TOOTH),
        NoAnswer::Gouges { .. } | NoAnswer::FlatGouges | NoAnswer::SharpEdgeOnCurve => place.member(names::SURFACE_RADIUS),
        NoAnswer::SharpEdge => place.member("cutter"),
        NoAnswer::RunoutUsesUpTolerance => place.member(names::RUNOUT),
        NoAnswer::ToleranceLimitsNoStepOver { .. } | NoAnswer::ToleranceLimitsNoFeed { .. } => place.member(names::TOLERANCE),
    };
    let (code, figures) = NoAnswerCode::of(cause);
    Fault { figures, ..Fault::new(&place, code, cause) }
}
