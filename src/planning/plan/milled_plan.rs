//! The zigzag of a candidate in one direction: lines, their runs, the path, and what it leaves, milled; the lines move until
//! the scallop height is kept and used.

use super::border::Feet;
use super::estimate::MOST_LINES;
use super::judged::{FinishFigures, Judged, judged, respace};
use super::prepared::Prepared;
use super::runs::{Run, RunMaker};
use super::settings::PlanSettings;
use super::spread::{Allowed, Heading, Spread};
use super::stations::Station;
use super::tour::Tour;
use super::workpiece::Workpiece;
use crate::path::Milled;
use crate::quantity::{Angle, Length};
use std::cell::{Cell, OnceCell};

/// The share of the scallop height by which chords between tips may differ from the tips' surface.
pub(super) const CHORD_SHARE: f64 = 0.1;

/// The fewest and the most rounds in which lines move. After the fewest, a round is followed by another while the scallop height
/// is not kept, or if it saves this share of the time.
const FEWEST_ROUNDS: usize = 3;
const ROUNDS: usize = 6;
const WORTHWHILE: f64 = 0.01;

/// The most samples of a path's lines, some four seconds on two threads.
const MOST_SAMPLES: usize = 4_000_000;

/// A plan is taken as it is once this share of the area, at most, is over the scallop height.
const ENOUGH: f64 = 0.002;

/// The plan of a candidate in one direction.
#[derive(Debug, Clone)]
pub(super) struct MilledPlan {
    pub(super) direction: Angle,
    pub(super) lines: Vec<f64>,
    pub(super) tour: Tour,
    pub(super) finish: FinishFigures,
    pub(super) judged: Vec<Judged>,
}

/// Why a direction has no plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NoPlan {
    /// Somewhere no spacing keeps the scallop height, or there are too many lines.
    NoLines,
    /// The lines meet nothing that the cutter reaches.
    NoRuns,
    /// The path is longer than one that is milled.
    TooLong,
    /// `stop` returned true.
    Stopped,
}

/// What the plans of a candidate share.
pub(super) struct Planner<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) prepared: &'a Prepared,
    pub(super) settings: &'a PlanSettings,
    /// The stations on which lines are spaced.
    pub(super) stations: &'a [Station],
    /// Those on which the plan is judged. Where lines are spaced, a plan is better than elsewhere.
    pub(super) unseen: &'a [Station],
    /// The feet of walls, once a plan needs them.
    pub(super) feet: OnceCell<Feet>,
    /// The samples of all lines planned so far.
    pub(super) samples: &'a Cell<usize>,
    pub(super) stop: &'a (dyn Fn() -> bool + Sync),
}

impl Planner<'_> {
    /// The milled plan in a direction.
    pub(super) fn plan(&self, direction: Angle) -> Result<MilledPlan, NoPlan> {
        let Self { workpiece, prepared, settings, stations, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        let heading = Heading::of(direction.radians());
        let spread = Spread::new(workpiece, stations, prepared, &heading, height);
        let mut allowed = Allowed::of(&spread, &prepared.candidate, settings.left_out_share);
        let maker = RunMaker {
            workpiece,
            prepared,
            machine: &settings.machine,
            heading: &heading,
            spread: &spread,
            chord_tolerance: CHORD_SHARE * height,
            clearance: workpiece.top + settings.machine.clearance_height.mm(),
            stop,
        };
        let mut best: Option<MilledPlan> = None;
        for round in 1..=ROUNDS {
            let lines = allowed.lines(spread.range, MOST_LINES).ok_or(NoPlan::NoLines)?;
            let samples = maker.samples(&lines);
            if samples > MOST_SAMPLES {
                return Err(NoPlan::TooLong);
            }
            self.samples.set(self.samples.get() + samples);
            let mut runs = maker.runs(&lines).ok_or(NoPlan::TooLong)?;
            if stop() {
                return Err(NoPlan::Stopped);
            }
            if runs.is_empty() {
                return Err(NoPlan::NoRuns);
            }
            let mut plan = self.judged_plan(&maker, direction, &lines, &runs)?;
            // Where a few rounds do not keep the scallop height, places between the stations are the reason.
            let margin = if round <= FEWEST_ROUNDS { 0.995 } else { 0.97 };
            respace(&mut allowed, &lines, &heading, stations, &plan.judged, height, margin);
            if self.left_standing(&plan) > 0.0 {
                let along_borders = self.feet.get_or_init(|| Feet::of(workpiece, prepared, maker.chord_tolerance, stop)).runs(
                    stations,
                    &plan.judged,
                    height,
                );
                if !along_borders.is_empty() {
                    runs.extend(along_borders);
                    plan = self.judged_plan(&maker, direction, &lines, &runs)?;
                }
            }
            let is_last = round >= FEWEST_ROUNDS && best.as_ref().is_some_and(|best| !is_worthwhile(rank_of(best), rank_of(&plan)));
            if best.as_ref().is_none_or(|best| rank_of(&plan) < rank_of(best)) {
                best = Some(plan);
            }
            if is_last {
                break;
            }
        }
        self.measured(&maker, best.ok_or(NoPlan::NoRuns)?)
    }

    fn judged_plan(&self, maker: &RunMaker, direction: Angle, lines: &[f64], runs: &[Run]) -> Result<MilledPlan, NoPlan> {
        let Self { workpiece, prepared, settings, stations, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        let tour = Tour::of(workpiece, prepared, settings, runs, maker.chord_tolerance);
        let milled = Milled::new(&prepared.profile, &tour.moves(), stop).ok_or(NoPlan::Stopped)?;
        let judged = judged(workpiece, stations, prepared, maker.heading.along, &milled, height, stop).ok_or(NoPlan::Stopped)?;
        let finish = FinishFigures::of(stations, &judged, height);
        Ok(MilledPlan { direction, lines: lines.to_vec(), tour, finish, judged })
    }

    /// A plan with the figures of the unseen stations.
    fn measured(&self, maker: &RunMaker, plan: MilledPlan) -> Result<MilledPlan, NoPlan> {
        let Self { workpiece, prepared, settings, unseen, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        let milled = Milled::new(&prepared.profile, &plan.tour.moves(), stop).ok_or(NoPlan::Stopped)?;
        let judged = judged(workpiece, unseen, prepared, maker.heading.along, &milled, height, stop).ok_or(NoPlan::Stopped)?;
        let finish = FinishFigures::of(unseen, &judged, height);
        let gouge = Length::computed(finish.gouge.mm().max(plan.finish.gouge.mm()));
        Ok(MilledPlan { finish: FinishFigures { gouge, ..finish }, ..plan })
    }

    /// The area in mm^2 of places that the cutter reaches and the path leaves far over the scallop height.
    fn left_standing(&self, plan: &MilledPlan) -> f64 {
        let height = self.settings.scallop_height.mm();
        let stands = |(station, judged): &(&Station, &Judged)| station.lift <= height && judged.left.is_none_or(|left| left > 1.5 * height);
        self.stations.iter().zip(&plan.judged).filter(stands).map(|(station, _)| station.place.area).sum()
    }
}

/// Plans that keep the scallop height before those that do not, then by time, or by how much they exceed it.
pub(super) fn rank_of(plan: &MilledPlan) -> (bool, f64) {
    let over = plan.finish.far_over_share;
    if over <= ENOUGH { (false, plan.tour.figures.seconds) } else { (true, over) }
}

/// Whether a round after one with the rank `before` has saved enough for another: as long as the scallop height is not kept,
/// and while the time falls.
fn is_worthwhile(before: (bool, f64), after: (bool, f64)) -> bool {
    match (before.0, after.0) {
        (true, _) => true,
        (false, true) => false,
        (false, false) => after.1 < (1.0 - WORTHWHILE) * before.1,
    }
}
