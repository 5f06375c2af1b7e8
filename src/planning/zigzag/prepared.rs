//! A candidate with the tables that do not depend on the direction.

use super::candidate::{CandidateCutter, FeedRange};
use super::room::Room;
use super::settings::ZigzagSettings;
use super::simulate::Operation;
use super::slopes::sines;
use super::spacing::{CutterSpacing, FeedLaw, SpacingInputs};
use super::workpiece::Workpiece;

/// A candidate with its spacings.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) index: usize,
    pub(super) candidate: CandidateCutter,
    pub(super) spacing: CutterSpacing,
    pub(super) feeds: FeedLaw,
    pub(super) range: Option<FeedRange>,
    /// The feed rate of links on the surface, in mm/s.
    link_rate: f64,
}

impl Prepared {
    /// The candidate with spacings at the rows of slopes that `rows` marks. Once `stop` returns true, it ends early
    /// with spacings that must be discarded.
    pub(super) fn new(
        index: usize,
        candidate: &CandidateCutter,
        settings: &ZigzagSettings,
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
        Self { index, candidate: *candidate, spacing, feeds, range, link_rate }
    }

    /// The spacings of the cutter, and the widest one in mm: the diameter less a rounding error of single precision, so
    /// that passes still overlap.
    pub(super) fn allowance(&self) -> (&CutterSpacing, f64) {
        (&self.spacing, 2.0 * self.candidate.cutter.outer_radius().mm() * (1.0 - 1e-6))
    }

    /// The operation of the cutter, for all directions.
    pub(super) fn operation<'a>(&'a self, settings: &'a ZigzagSettings, room: &'a Room) -> Operation<'a> {
        Operation { machine: &settings.machine, pattern: settings.pattern, feeds: &self.feeds, link_rate: self.link_rate, room }
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
