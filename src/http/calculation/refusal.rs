//! A pass without an answer, as a fault of the request: which member is to blame, under which name, with which figures.

use super::contact::StatedContact;
use super::terms::{names, step_over_member};
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
        NoAnswer::Gouges { .. } => place.member(names::SURFACE_RADIUS),
        NoAnswer::SharpEdge => place.member("cutter"),
        NoAnswer::RunoutUsesUpTolerance => place.member(names::RUNOUT),
        _ => place.member(names::TOLERANCE),
    };
    let (code, title) = name(cause);
    let figures = match cause {
        NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over } => {
            vec![("step_over_height_mm", step_over_height.mm()), ("max_step_over_mm", max_step_over.mm())]
        }
        NoAnswer::PassesDoNotOverlap { largest_step_over } | NoAnswer::ToleranceLimitsNoStepOver { largest_step_over } => {
            vec![("largest_step_over_mm", largest_step_over.mm())]
        }
        NoAnswer::Gouges { smallest_radius: Some(radius) } => vec![("smallest_radius_mm", radius.mm())],
        NoAnswer::FeedUsesUpTolerance { feed_height } => vec![("feed_height_mm", feed_height.mm())],
        _ => Vec::new(),
    };
    Fault { title: Some(title), figures, ..Fault::new(&place, code, cause) }
}

/// The stable name and the title of a cause.
pub(crate) fn name(cause: NoAnswer) -> (&'static str, &'static str) {
    match cause {
        NoAnswer::FlatFloor => ("flat-floor", "The analytic model has no answer on a floor"),
        NoAnswer::PassesDoNotOverlap { .. } => ("passes-do-not-overlap", "The passes do not overlap"),
        NoAnswer::MarksDoNotOverlap { .. } => ("marks-do-not-overlap", "The tooth marks do not overlap"),
        NoAnswer::Gouges { .. } => ("gouging", "The cutter gouges"),
        NoAnswer::SharpEdge => ("sharp-edge", "The analytic model has no answer for a sharp edge"),
        NoAnswer::PassesCoincideFromAbove => ("passes-coincide-from-above", "The passes lie above each other"),
        NoAnswer::StepOverUsesUpTolerance { .. } => ("tolerance-exceeded", "The step-over alone uses up the tolerance"),
        NoAnswer::FeedUsesUpTolerance { .. } => ("tolerance-exceeded-by-feed", "The feed alone uses up the tolerance"),
        NoAnswer::RunoutUsesUpTolerance => ("tolerance-exceeded-by-runout", "Runout alone uses up the tolerance"),
        _ => ("tolerance-sets-no-limit", "The tolerance sets no limit"),
    }
}
