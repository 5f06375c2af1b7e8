//! The step-over of a request: along the surface, or seen from above.

use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath, Quantity, at_most_one, members};
use crate::milling::StepOver;
use crate::quantity::Length;

members! {
    /// The members for the step-over, of which at most one may be given.
    pub(super) struct StepOverMembers {
        along_surface: optional STEP_OVER: Quantity<Length> = ("step_over_mm", Quantity::length(0.687),
            "step-over s along the surface, perpendicular to the feed; or give step_over_xy_mm"),
        seen_from_above: optional STEP_OVER_XY: Quantity<Length> = ("step_over_xy_mm", Quantity::length(0.65),
            "step-over d between parallel vertical planes, seen from above; or give step_over_mm"),
    }
}

impl StepOverMembers {
    /// The step-over, if one is given.
    pub(super) fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Option<StepOver>, Faulted> {
        let along_surface = self.along_surface.map(|stated| stated.map(StepOver::AlongSurface));
        let seen_from_above = self.seen_from_above.map(|stated| stated.map(StepOver::SeenFromAbove));
        at_most_one(along_surface, seen_from_above).unwrap_or_else(|| {
            let detail = "give step_over_mm or step_over_xy_mm, not both";
            Err(faults.add(&path.member(STEP_OVER_XY.name), RequestFault::ConflictingFields, detail))
        })
    }
}

/// Records the fault of a missing step-over.
pub(super) fn missing(path: &JsonPath<'_>, faults: &mut Faults) -> Faulted {
    let detail = "give step_over_mm (along the surface) or step_over_xy_mm (seen from above)";
    faults.add(&path.member(STEP_OVER.name), RequestFault::MissingField, detail)
}

/// The member in which a step-over was given.
pub(super) fn member_of(step_over: Option<StepOver>) -> &'static str {
    match step_over {
        Some(StepOver::SeenFromAbove(_)) => STEP_OVER_XY.name,
        Some(StepOver::AlongSurface(_)) | None => STEP_OVER.name,
    }
}
