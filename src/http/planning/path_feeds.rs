//! The feeds of a path: those that it states, and the largest that keep the tolerance.

use super::path_object::PathCutters;
use crate::http::wire::answer;
use crate::motion::Machine;
use crate::numerics::vector::{difference, length};
use crate::path::program::{Program, ProgramPoint};
use crate::path::{LargestFeeds, Move, MoveKind, Passage, PathLengths, Place, smooth};
use crate::planning::machined_surface::Stop;
use crate::quantity::{Speed, SpindleSpeed};
use std::collections::BTreeSet;

/// Programs state feed rates in a few digits.
const ROUNDING: f64 = 1.0 + 1e-4;

answer! {
    /// The largest feeds with which tooth marks keep the tolerance where the path does, within the limits of machine and
    /// cutters, and such that the machine's acceleration and jerk can follow. Arrays have an item for each point of the path, null at
    /// points that no move at the feed rate leads to.
    #[schema(as = PathFeeds)]
    pub(crate) struct FeedsAnswer {
        /// The feed per tooth of the move to each point.
        feed_per_tooth_mm: Vec<Option<f64>>,
        /// Its feed rate.
        feed_rate_mm_min: Vec<Option<f64>>,
        /// The line of the program that states each point; absent for points.
        line?: Vec<u32>,
        /// The time of the path with these feeds.
        machining_time_s: f64 [minimum = 0],
        /// The share of the selected area that is over the tolerance at any feed, and sets none.
        never_kept_share: f64 [minimum = 0, maximum = 1],
    }
}

/// The moves of a path, the points to which they lead, and the teeth that pass in a second.
pub(super) struct PathMoves<'a> {
    pub(super) program: &'a Program,
    pub(super) cutters: &'a PathCutters,
    pub(super) machine: &'a Machine,
    pub(super) moves: &'a [Move],
    pub(super) points: &'a [usize],
}

/// The largest feeds of a path.
pub(super) struct PathFeeds {
    /// The feed rate of each move.
    pub(super) rates: Vec<Speed>,
    pub(super) answer: FeedsAnswer,
}

impl PathMoves<'_> {
    fn point_of(&self, at: usize) -> &ProgramPoint {
        &self.program.points[self.points[at]]
    }

    /// The index of the cutter of a move.
    pub(super) fn cutter_of(&self, at: usize) -> usize {
        self.cutters.index(self.point_of(at).tool)
    }

    /// The line of the program that states a move; `None` for points.
    pub(super) fn line_of(&self, at: usize) -> Option<u32> {
        Some(self.point_of(at).line).filter(|line| *line > 0)
    }

    /// The teeth that pass in a second; `None` if teeth or spindle speed is not known.
    pub(super) fn teeth_per_second(&self, at: usize) -> Option<f64> {
        let point = self.point_of(at);
        let cutter = self.cutters.of_tool(point.tool);
        let stated = cutter.candidate.drive.map(|drive| drive.spindle_speed.rpm());
        let most = self.machine.max_spindle_speed.map_or(f64::INFINITY, SpindleSpeed::rpm);
        let speed = point.spindle_speed.or(stated)?.min(most);
        cutter.teeth.map(|teeth| f64::from(teeth) * speed / 60.0)
    }

    /// The feed rate of each move: the stated one, at most the machine's.
    pub(super) fn stated_rates(&self) -> Vec<Speed> {
        let most = self.machine.limits.feed_rate;
        let rate = |at: usize| {
            let stated = self.point_of(at).feed_rate.and_then(|feed| Speed::from_mm_min(feed).ok());
            stated.map_or(most, |stated| if stated < most { stated } else { most })
        };
        (0..self.moves.len()).map(rate).collect()
    }

    /// The share of the length of the moves at the feed rate for which the path states no feed rate.
    pub(super) fn assumed_feed_share(&self) -> f64 {
        let length = |wanted: &dyn Fn(usize) -> bool| -> f64 {
            let moves = self.moves.iter().enumerate().filter(|(at, each)| each.kind != MoveKind::Rapid && wanted(*at));
            moves.map(|(_, each)| length(difference(each.to, each.from))).sum()
        };
        length(&|at| self.point_of(at).feed_rate.is_none()) / length(&|_| true).max(f64::MIN_POSITIVE)
    }

    /// The stated feed per tooth of each move in mm; `None` if one is not known. Those of rapids do not count.
    pub(super) fn stated_per_tooth(&self) -> Option<Vec<f64>> {
        let most = self.machine.limits.feed_rate.mm_s();
        let of = |at: usize| {
            if self.moves[at].kind == MoveKind::Rapid {
                return Some(f64::INFINITY);
            }
            let rate = self.point_of(at).feed_rate? / 60.0;
            self.teeth_per_second(at).map(|teeth| rate.min(most) / teeth)
        };
        (0..self.moves.len()).map(of).collect()
    }

    /// The first move of each tool with each feed rate that is over the machine's or the cutter's limit.
    pub(super) fn over_limits(&self) -> Vec<usize> {
        let mut seen = BTreeSet::new();
        let is_first = |at: &usize| {
            let point = self.point_of(*at);
            let Some(stated) = point.feed_rate.filter(|_| self.moves[*at].kind != MoveKind::Rapid) else { return false };
            stated > ROUNDING * self.largest_allowed(*at).mm_min() && seen.insert((point.tool, stated.to_bits()))
        };
        (0..self.moves.len()).filter(is_first).collect()
    }

    /// The largest feed rate that the machine and the cutter allow.
    fn largest_allowed(&self, at: usize) -> Speed {
        let by_machine = self.machine.limits.feed_rate;
        let by_tooth = self.cutters.of_tool(self.point_of(at).tool).max_feed_per_tooth;
        let by_cutter = by_tooth.zip(self.teeth_per_second(at)).map(|(per_tooth, teeth)| Speed::computed(per_tooth.mm() * teeth));
        by_cutter.filter(|by_cutter| *by_cutter < by_machine).unwrap_or(by_machine)
    }

    /// Whether teeth and spindle speed of all moves at the feed rate are known.
    pub(super) fn has_teeth(&self) -> bool {
        (0..self.moves.len()).all(|at| self.moves[at].kind == MoveKind::Rapid || self.teeth_per_second(at).is_some())
    }

    /// The largest feeds that keep the tolerance in mm at the places. `None` once `stop` returns true.
    pub(super) fn largest(&self, passage: &Passage<'_>, places: &[Place], tolerance: f64, stop: Stop) -> Option<PathFeeds> {
        let found = LargestFeeds::new(passage, places, tolerance, stop)?;
        let teeth: Vec<f64> = (0..self.moves.len()).map(|at| self.teeth_per_second(at).unwrap_or(f64::INFINITY)).collect();
        // A feed of 1 mm/min is the least that is answered.
        let rate = |at: usize| (found.per_tooth[at] * teeth[at]).min(self.largest_allowed(at).mm_s()).max(1.0 / 60.0);
        let mut speeds: Vec<Speed> = (0..self.moves.len()).map(rate).map(Speed::computed).collect();
        smooth(self.moves, &mut speeds, self.machine.limits);
        let lengths = PathLengths::new(self.moves, &speeds, self.machine);
        let count = self.program.points.len();
        let (mut feed_per_tooth_mm, mut feed_rate_mm_min) = (vec![None; count], vec![None; count]);
        for (at, point) in self.points.iter().enumerate().filter(|(at, _)| self.moves[*at].kind != MoveKind::Rapid) {
            feed_rate_mm_min[*point] = Some(speeds[at].mm_min());
            feed_per_tooth_mm[*point] = teeth[at].is_finite().then(|| speeds[at].mm_s() / teeth[at]);
        }
        #[expect(clippy::cast_precision_loss, reason = "counts are below 2^52")]
        let never_kept_share = found.never_kept as f64 / places.len().max(1) as f64;
        let line =
            self.program.points.iter().any(|point| point.line > 0).then(|| self.program.points.iter().map(|point| point.line).collect());
        let answer = FeedsAnswer { feed_per_tooth_mm, feed_rate_mm_min, line, machining_time_s: lengths.time.seconds(), never_kept_share };
        Some(PathFeeds { rates: speeds, answer })
    }

    /// The feed rate in mm/min of the move to each point; that of points without one does not count.
    pub(super) fn rates_of_points(&self, rates: &[Speed]) -> Vec<f64> {
        let mut of_points = vec![f64::INFINITY; self.program.points.len()];
        self.points.iter().zip(rates).for_each(|(point, rate)| of_points[*point] = rate.mm_min());
        of_points
    }
}
