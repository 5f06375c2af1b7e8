//! Which operations are worth planning: the surface whole or divided at a slope, each part with the cutter and the lines that
//! take the least estimated time, and a smaller cutter for what those cannot reach.

use super::estimate::seconds;
use super::family::{Family, Heading};
use super::settings::{Pattern, PlanSettings};
use super::spacing::Prepared;
use super::stations::Station;
use super::workpiece::Workpiece;
use rayon::prelude::*;

/// The slopes in deg at which a surface is divided: flats from the rest, and shallow from steep.
const SPLITS: [f64; 4] = [1.0, 20.0, 35.0, 50.0];

/// The angle in deg between the directions that are tried.
const DIRECTIONS_APART: u16 = 15;

/// A part with a smaller share of the area is not worth an operation.
const SMALLEST_PART: f64 = 0.005;

/// The divisions whose leftovers a smaller cutter is tried on.
const TRIED_WITH_REST: usize = 4;

/// A cutter with the stations of the places on which operations are estimated: station i belongs to place i for every tool.
pub(super) struct Tool {
    pub(super) prepared: Prepared,
    pub(super) stations: Vec<Station>,
}

/// An operation to plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planned {
    /// The position among the tools.
    pub(super) tool: usize,
    pub(super) family: Family,
    /// The slopes of the facets that it machines, in rad.
    pub(super) slopes: [f64; 2],
    /// Whether it machines only what the operations before it cannot reach.
    pub(super) is_rest: bool,
    /// The estimated time.
    pub(super) seconds: f64,
}

impl Planned {
    /// Whether both have the same cutter and lines, and so the same estimate that they machine the same facets.
    fn is_alike(&self, other: &Self) -> bool {
        (self.tool, self.family, self.is_rest, self.seconds) == (other.tool, other.family, other.is_rest, other.seconds)
    }

    /// Whether both are the same operation. What a rest machines depends on the operations before it.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.is_alike(other) && self.has_such_lines(other)
    }

    /// Whether both have planes or both have levels, on the same slopes.
    #[expect(clippy::float_cmp, reason = "bounds are those of a list")]
    pub(super) fn has_such_lines(&self, other: &Self) -> bool {
        !self.is_rest && !other.is_rest && self.slopes == other.slopes && self.family.is_like(&other.family)
    }
}

/// Operations in their order.
#[derive(Debug, Clone)]
pub(super) struct Arrangement {
    pub(super) operations: Vec<Planned>,
    /// The estimated time, tool changes included.
    pub(super) seconds: f64,
}

impl Arrangement {
    /// The number of tool changes.
    pub(super) fn tool_changes(&self) -> usize {
        self.operations.windows(2).filter(|pair| pair[0].tool != pair[1].tool).count()
    }

    /// The time of the tool changes in s.
    #[expect(clippy::cast_precision_loss, reason = "a few")]
    pub(super) fn change_seconds(&self, settings: &PlanSettings) -> f64 {
        self.tool_changes() as f64 * settings.machine.change_time().seconds()
    }
}

/// What arrangements are found from.
pub(super) struct Arranger<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) settings: &'a PlanSettings,
    pub(super) tools: &'a [Tool],
    /// The most operations.
    pub(super) most: usize,
}

impl Arranger<'_> {
    /// Arrangements of at least two operations, the one with the shortest estimate first.
    pub(super) fn arrangements(&self) -> Vec<Arrangement> {
        let whole = [0.0, std::f64::consts::FRAC_PI_2];
        let divisions = SPLITS.iter().map(|split| split.to_radians()).map(|split| vec![[whole[0], split], [split, whole[1]]]);
        let mut found: Vec<Arrangement> = Vec::new();
        for slopes in divisions.chain([vec![whole]]) {
            if slopes.iter().any(|slopes| self.share(|index| self.is_within(index, *slopes)) < SMALLEST_PART) {
                continue;
            }
            let of_parts: Vec<Vec<Planned>> = slopes.iter().map(|slopes| self.of_part(*slopes)).collect();
            found.extend(combined(&of_parts).into_iter().map(|operations| self.arranged(operations)));
        }
        found.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let mut with_rest: Vec<Arrangement> = Vec::new();
        for operations in
            found.iter().filter(|found| found.operations.len() < self.most).map(|found| &found.operations).take(TRIED_WITH_REST)
        {
            with_rest.extend(self.rest_of(operations).map(|rest| {
                let all = operations.iter().copied().chain([rest]).collect();
                self.arranged(all)
            }));
        }
        found.retain(|found| self.share(|index| !self.is_reached(index, &found.operations)) <= self.settings.max_uncut_share);
        found.extend(with_rest);
        found.retain(|found| (2..=self.most).contains(&found.operations.len()));
        found.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        // Divisions at several slopes are one where no facet lies between the slopes.
        found.dedup_by(|a, b| {
            a.operations.len() == b.operations.len() && a.operations.iter().zip(&b.operations).all(|(a, b)| a.is_alike(b))
        });
        found
    }

    fn arranged(&self, mut operations: Vec<Planned>) -> Arrangement {
        // Operations with the same cutter follow each other; what is left comes last.
        operations.sort_by_key(|operation| (operation.is_rest, operation.tool));
        let mut arrangement = Arrangement { operations, seconds: 0.0 };
        arrangement.seconds =
            arrangement.change_seconds(self.settings) + arrangement.operations.iter().map(|operation| operation.seconds).sum::<f64>();
        arrangement
    }

    /// The shares of the area for which `holds`, by the index of the station.
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    fn share(&self, holds: impl Fn(usize) -> bool) -> f64 {
        let count = self.tools.first().map_or(0, |tool| tool.stations.len());
        (0..count).filter(|index| holds(*index)).count() as f64 / count.max(1) as f64
    }

    fn is_within(&self, index: usize, slopes: [f64; 2]) -> bool {
        self.tools.first().is_some_and(|tool| self.workpiece.is_sloped(tool.stations[index].place.target, slopes))
    }

    /// Whether one of the operations that machine a place reaches it.
    fn is_reached(&self, index: usize, operations: &[Planned]) -> bool {
        let height = self.settings.scallop_height.mm();
        operations
            .iter()
            .any(|operation| self.is_within(index, operation.slopes) && self.tools[operation.tool].stations[index].lift <= height)
    }

    /// The fastest lines of each tool on the facets of these slopes.
    fn of_part(&self, slopes: [f64; 2]) -> Vec<Planned> {
        let of_tool = |tool: usize| self.fastest(tool, slopes, false, &|index| self.is_within(index, slopes));
        (0..self.tools.len()).into_par_iter().filter_map(of_tool).collect()
    }

    /// The fastest operation on what others cannot reach; `None` if they reach nearly all of it, or none keeps what may be left
    /// uncut.
    fn rest_of(&self, operations: &[Planned]) -> Option<Planned> {
        let is_left = |index: usize| !self.is_reached(index, operations);
        if self.share(is_left) < SMALLEST_PART / 10.0 {
            return None;
        }
        let height = self.settings.scallop_height.mm();
        let whole = [0.0, std::f64::consts::FRAC_PI_2];
        let of_tool = |tool: usize| {
            let stations = &self.tools[tool].stations;
            let is_kept = self.share(|index| is_left(index) && stations[index].lift > height) <= self.settings.max_uncut_share;
            if is_kept { self.fastest(tool, whole, true, &is_left) } else { None }
        };
        (0..self.tools.len()).into_par_iter().filter_map(of_tool).min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }

    /// The fastest lines of a tool on the stations that `belongs` accepts.
    fn fastest(&self, tool: usize, slopes: [f64; 2], is_rest: bool, belongs: &(dyn Fn(usize) -> bool + Sync)) -> Option<Planned> {
        let Tool { prepared, stations } = &self.tools[tool];
        let of_part: Vec<Station> = stations.iter().enumerate().filter(|(index, _)| belongs(*index)).map(|(_, station)| *station).collect();
        let planes = (0..180 / DIRECTIONS_APART).map(|step| Family::Planes(Heading::of(f64::from(step * DIRECTIONS_APART).to_radians())));
        // Level facets have no level lines.
        let levels = (slopes[0] > 0.0 && self.settings.pattern == Pattern::Zigzag).then_some(Family::Levels);
        let timed = |family: Family| {
            let seconds = seconds(self.workpiece, &of_part, prepared, self.settings, &family)?;
            Some(Planned { tool, family, slopes, is_rest, seconds })
        };
        planes.chain(levels).filter_map(timed).min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }
}

/// Every choice of one operation for each part.
fn combined(of_parts: &[Vec<Planned>]) -> Vec<Vec<Planned>> {
    of_parts.iter().fold(vec![Vec::new()], |chosen, of_part| {
        let with = |chosen: &Vec<Planned>| -> Vec<Vec<Planned>> {
            of_part.iter().map(|operation| chosen.iter().copied().chain([*operation]).collect()).collect()
        };
        chosen.iter().flat_map(with).collect()
    })
}
