//! A candidate with the tables that do not depend on the direction.

use super::candidate::{CandidateCutter, FeedRange};
use super::settings::PlanSettings;
use super::slopes::sines;
use super::spacing::{CutterSpacing, FeedLaw, SpacingInputs};
use super::workpiece::Workpiece;
use crate::milling::Profile;

/// A candidate with its spacings and feeds.
#[derive(Debug, Clone)]
pub(super) struct Prepared {
    pub(super) index: usize,
    pub(super) candidate: CandidateCutter,
    pub(super) profile: Profile,
    pub(super) spacing: CutterSpacing,
    pub(super) feeds: FeedLaw,
    pub(super) range: Option<FeedRange>,
    /// The feed rate of links on the surface and of plunges, in mm/s.
    pub(super) link_rate: f64,
}

impl Prepared {
    /// The candidate with spacings at the rows of slopes that `rows` marks. Once `stop` returns true, it ends early
    /// with spacings that must be discarded.
    pub(super) fn new(
        index: usize,
        candidate: &CandidateCutter,
        settings: &PlanSettings,
        rows: &[bool],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let feed_rate = settings.machine.limits.feed_rate.mm_s();
        let range = candidate.drive.map(|drive| FeedRange::of(drive, &settings.machine));
        let (spacing, feeds) = CutterSpacing::new(&SpacingInputs {
            cutter: candidate.cutter,
            height: settings.scallop_height,
            model: settings.model,
            feeds: range,
            feed_rate,
            is_needed: &|row| rows[row] && !stop(),
        });
        let link_rate = range.map_or(feed_rate, |range| range.rate(range.largest));
        Self { index, candidate: *candidate, profile: candidate.cutter.profile(), spacing, feeds, range, link_rate }
    }
}

/// For each row of the tables, whether a slope of the workpiece needs it.
pub(super) fn rows_of(workpiece: &Workpiece) -> Vec<bool> {
    let mut rows = vec![false; sines().len()];
    for tangent in &workpiece.tangents {
        let row = tangent.place.row as usize;
        rows[row] = true;
        rows[row + 1] = true;
    }
    rows
}
