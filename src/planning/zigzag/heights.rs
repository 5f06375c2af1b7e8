//! The scallop heights of a plan at single facets, for drawing.

use super::candidate::CandidateCutter;
use super::inspector::Inspector;
use super::plan::ZigzagPlan;
use super::prepared::{Prepared, rows_of};
use super::settings::ZigzagSettings;
use super::spaced::Spaced;
use super::sweep::Sweep;
use super::workpiece::Workpiece;
use crate::quantity::Length;
use crate::surface::FinishFacet;

/// The scallop height that `plan` leaves at each of the facets `wanted`, by model `envelope` with the curvature of
/// the facet. `None` if the cutter gouges beside the contact or leaves uncut material between its passes, and on
/// facets that are too steep to set a spacing.
///
/// `plan` must be a result of [`super::rank`] for the same facets, candidate and settings. Once `stop` returns true, it
/// returns early without heights.
#[must_use]
pub fn heights(
    plan: &ZigzagPlan,
    facets: &[FinishFacet],
    candidate: &CandidateCutter,
    settings: &ZigzagSettings,
    wanted: &[u32],
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Option<Length>> {
    let workpiece = Workpiece::new(facets, settings.max_slope.cos(), stop);
    let sweep = Sweep::new(&workpiece, plan.direction, stop);
    let prepared = Prepared::new(plan.candidate, candidate, settings, &rows_of(&workpiece), stop);
    let spaced = Spaced::new(&workpiece, &sweep, prepared.allowance(), settings.left_out_share, stop);
    if stop() {
        return vec![None; wanted.len()];
    }
    let heights = Inspector::new(facets, &prepared, settings, stop).heights(&spaced, &plan.passes, wanted);
    heights.into_iter().map(|height| height.filter(|height| height.is_finite()).map(Length::computed)).collect()
}
