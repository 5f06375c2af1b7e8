//! What an operation machines: the facets within a range of slopes, and the places that an earlier operation has left.

use super::stations::Station;
use super::workpiece::Workpiece;
use crate::milling::Profile;
use std::collections::HashSet;

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

/// Square cells of the plan view.
#[derive(Debug, Clone)]
pub(super) struct Cells {
    side: f64,
    marked: HashSet<[i32; 2]>,
}

impl Cells {
    /// The cells of points, and those around them.
    pub(super) fn around(points: impl Iterator<Item = [f64; 2]>, side: f64) -> Self {
        let mut cells = Self { side, marked: HashSet::new() };
        for [x, y] in points.map(|point| cells.cell(point)).collect::<HashSet<_>>() {
            cells.marked.extend((-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy])));
        }
        cells
    }

    #[expect(clippy::cast_possible_truncation, reason = "extents over sides are under 2^31")]
    fn cell(&self, point: [f64; 2]) -> [i32; 2] {
        point.map(|part| (part / self.side).floor() as i32)
    }

    pub(super) fn contain(&self, point: [f64; 2]) -> bool {
        self.marked.contains(&self.cell(point))
    }
}
