//! What an operation machines: the facets within a range of slopes, and the places that an earlier operation has left.

use super::cells::Cells;
use super::stations::Station;
use super::workpiece::Workpiece;
use crate::milling::Profile;

/// A part of the surface to machine.
#[derive(Debug, Clone)]
pub(super) struct Region {
    /// For each target whether it belongs to the region; `None` for all.
    targets: Option<Vec<bool>>,
    /// Where the cutter's axis may stand; `None` for everywhere.
    standing: Option<Cells>,
}

impl Region {
    /// Everything that is to be machined.
    pub(super) const WHOLE: Self = Self { targets: None, standing: None };

    /// The targets that `belongs` accepts.
    pub(super) fn of_targets(workpiece: &Workpiece, belongs: impl Fn(usize) -> bool) -> Self {
        Self { targets: Some((0..workpiece.targets.len()).map(belongs).collect()), standing: None }
    }

    /// Where a cutter stands on those of these stations that it reaches, and up to a quarter of its radius around them.
    pub(super) fn of_rest(stations: &[Station], profile: &Profile, height: f64) -> Self {
        let reached = stations.iter().filter(|station| station.lift <= height);
        Self { targets: None, standing: Some(Cells::around(reached.map(|station| station.axis), profile.outer_radius() / 4.0)) }
    }

    /// Whether a tip over a point that finishes a target belongs to the region.
    pub(super) fn includes(&self, target: usize, axis: [f64; 2]) -> bool {
        self.targets.as_ref().is_none_or(|targets| targets[target]) && self.standing.as_ref().is_none_or(|cells| cells.contain(axis))
    }
}
