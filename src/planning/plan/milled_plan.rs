//! The plan of a candidate with one family of lines: lines, their runs, the path, and what it leaves, milled; the lines move until
//! the scallop height is kept and used.

use super::cut_lines::CutLines;
use super::estimate::MOST_LINES;
use super::family::{Allowed, Family, Spread};
use super::judged::{FinishFigures, Judged, KEPT, deepest_cut, judged, missed, respace};
use super::levels::LevelMaker;
use super::missed::Missed;
use super::runs::{Run, RunMaker};
use super::settings::PlanSettings;
use super::spacing::Prepared;
use super::stations::{Cells, Region, Set, Station};
use super::tour::{Order, Tour};
use super::workpiece::Workpiece;
use crate::milling::Profile;
use crate::path::{Milled, Move, MoveKind, Sampling};
use crate::quantity::Length;
use std::cell::Cell;
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// The share of the scallop height by which chords between the tips of a plan may differ from the tips' surface.
pub(super) const CHORD_SHARE: f64 = 0.1;

/// How closely tips are sampled, and how long the lines of a plan are moved.
#[derive(Debug, Clone)]
struct Effort {
    /// The sampling of tips for a cutter and a chord tolerance in mm.
    sampling: fn(&Profile, f64) -> Sampling,
    /// The share of the scallop height by which chords between tips may differ from the tips' surface.
    chord_share: f64,
    /// The fewest and the most rounds. After the fewest, another one follows while the scallop height is not kept.
    rounds: RangeInclusive<usize>,
    /// The share of the lines that another round must spare to be worth its time.
    spared: f64,
    /// The share of the area that may be far over the scallop height.
    enough: f64,
    /// The share of the area that lines may miss before further runs pass it.
    missed: f64,
}

impl Effort {
    const DRAFT: Self = Self { sampling: Sampling::coarse, chord_share: 0.3, rounds: 1..=1, spared: 1.0, enough: ENOUGH, missed: ENOUGH };
    const PLAN: Self =
        Self { sampling: Sampling::fine, chord_share: CHORD_SHARE, rounds: 3..=5, spared: 0.005, enough: ENOUGH, missed: 0.0 };
    /// For a plan that does not keep the scallop height where it was not spaced.
    const AGAIN: Self = Self { rounds: 2..=4, spared: 0.02, enough: UNSEEN_ENOUGH, ..Self::PLAN };
}

/// The samples of a path's lines: the most, twelve to twenty-four seconds on two threads, and those from which on the path is long.
const MOST_SAMPLES: usize = 6_000_000;
const LONG: usize = 300_000;

/// A tip of level curves takes as long as this many samples of lines.
const SAMPLES_OF_TIP: usize = 20;

/// A station at which a path is judged takes as long as this many samples of lines, times the root of the number of moves within the
/// cutter's radius of it.
const SAMPLES_OF_STATION: f64 = 0.06;

/// The samples of all candidates beyond which no candidate is planned, 25 to 45 s on two threads. Where several operations are asked
/// for, time is left for these: the samples beyond which no candidate is planned after one that keeps the scallop height, and those
/// beyond which no operations are.
pub(super) const MOST_OF_ALL: usize = 9_000_000;
pub(super) const MOST_BEFORE_OPERATIONS: usize = 3_000_000;
pub(super) const MOST_WITH_OPERATIONS: usize = 6_000_000;

/// The samples of all candidates beyond which no further round of lines is made.
const MOST_OF_ROUNDS: usize = 10_000_000;

/// A plan keeps the scallop height where this share of the area, at most, is far over it: of two that do, the faster one is taken.
const ENOUGH: f64 = 0.002;

/// The share up to which it counts as kept on stations on which lines were not spaced.
const UNSEEN_ENOUGH: f64 = 0.003;

/// The share of the area that lines in part may leave worse than whole ones.
pub(super) const WORSE: f64 = 0.001;

/// Runs over what a path misses are added in steps, each with the distance from walls in radii of the cutter: first against walls, then
/// beside them. After each step what is still missed is known.
const FURTHER_RUNS: [f64; 5] = [0.02, 0.02, 0.25, 0.25, 0.25];

/// A station is high from this share of the scallop height on. Further places are drawn in cells around high ones; the width of a cell,
/// in mean distances of stations.
const HIGH: f64 = 0.5;
const CELL: f64 = 1.5;

/// The plan of a candidate with one family of lines.
#[derive(Debug, Clone)]
pub(super) struct MilledPlan {
    pub(super) family: Family,
    pub(super) lines: CutLines,
    pub(super) runs: Vec<Run>,
    order: Order,
    pub(super) tour: Tour,
    pub(super) finish: FinishFigures,
    pub(super) judged: Vec<Judged>,
}

/// Spacings of a family of lines, found on coarsely sampled tips.
pub(super) struct Draft {
    family: Family,
    /// The time of a path with these spacings, as far as the draft tells.
    pub(super) seconds: f64,
    /// The same with lines in part, before stretches come back.
    pub(super) seconds_in_part: f64,
    spread: Spread,
    allowed: Allowed,
}

/// A plan, the spacings that it was made with, and those that what it leaves allows.
struct Spaced {
    plan: MilledPlan,
    allowed: Allowed,
    next: Allowed,
}

/// Why a family of lines has no plan.
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
    /// What is machined; the stations are in it.
    pub(super) region: &'a Region,
    /// The stations on which lines are spaced.
    pub(super) stations: &'a [Station],
    /// The stations of a further set of places, or of those in some cells.
    pub(super) further: &'a dyn Fn(Set, Option<&Cells>) -> Vec<Station>,
    /// The samples of all lines planned so far.
    pub(super) samples: &'a Cell<usize>,
    pub(super) stop: &'a (dyn Fn() -> bool + Sync),
}

impl Planner<'_> {
    /// A draft of the plan of a family of lines: spaced on coarsely sampled tips, which suffice for that.
    pub(super) fn draft(&self, family: Family) -> Result<Draft, NoPlan> {
        let Self { workpiece, prepared, settings, stations, .. } = *self;
        let spread = Spread::new(workpiece, stations, prepared, &family, settings.scallop_height.mm());
        let allowed = Allowed::of(&spread, &prepared.candidate, settings.left_out_share);
        let Spaced { plan, allowed, next } = self.spaced(stations, family, &spread, allowed, &Effort::DRAFT, None)?;
        let lines = next.lines(spread.range, MOST_LINES).ok_or(NoPlan::NoLines)?.len();
        let before = plan.lines.at.len();
        let keeps_lines = plan.finish.far_over_share <= ENOUGH && lines >= before;
        #[expect(clippy::cast_precision_loss, reason = "counts of lines")]
        let more_lines = if keeps_lines { 1.0 } else { lines as f64 / before as f64 };
        let seconds = plan.tour.figures.seconds * more_lines;
        let seconds_in_part = seconds * self.share_in_part(&plan, &spread);
        Ok(Draft { family, seconds, seconds_in_part, spread, allowed: if keeps_lines { allowed } else { next } })
    }

    /// The plan of a draft, finely sampled, with the figures of stations on which it was not spaced. If it does not keep the scallop
    /// height there, it is spaced on these too, and on many around high ones. Its lines are in part where that is faster; then, or
    /// spaced again, it is measured on further stations.
    pub(super) fn finished(&self, draft: Draft) -> Result<MilledPlan, NoPlan> {
        let Draft { family, spread, allowed, .. } = draft;
        let Spaced { plan, allowed, .. } = self.spaced(self.stations, family, &spread, allowed, &Effort::PLAN, None)?;
        let unseen = (self.further)(Set::Unseen, None);
        let mut plan = self.measured(&unseen, plan)?;
        let is_kept = plan.finish.far_over_share <= UNSEEN_ENOUGH;
        let mut seen: Vec<Station> = self.stations.iter().chain(&unseen).copied().collect();
        if !is_kept {
            seen.extend(self.near_high_places(&plan, &unseen));
            let of_lines = plan.runs.into_iter().filter(|run| run.line.is_some()).collect();
            plan = self.spaced(&seen, family, &spread, allowed, &Effort::AGAIN, Some(of_lines))?.plan;
        }
        if let Some(thinner) = self.thinned(&plan, &seen)? {
            let last = (self.further)(Set::Last, None);
            let thinner = self.measured(&last, thinner)?;
            // Shares of different places differ by chance: both plans are compared at the same.
            let far_over = thinner.finish.far_over_share;
            if far_over <= UNSEEN_ENOUGH || far_over <= self.slightly_worse(&last, &plan)? {
                return self.with_deepest_cut(&last, thinner);
            }
        }
        if is_kept {
            return self.with_deepest_cut(&unseen, plan);
        }
        let last = (self.further)(Set::Last, None);
        let plan = self.measured(&last, plan)?;
        self.with_deepest_cut(&last, plan)
    }

    /// The share of the area that may be far over the scallop height with lines in part, where whole ones leave the share of a plan
    /// at these stations.
    fn slightly_worse(&self, stations: &[Station], plan: &MilledPlan) -> Result<f64, NoPlan> {
        let share = self.finish(stations, &self.judged(stations, &plan.family, &plan.tour.moves())?).far_over_share;
        Ok((share + WORSE).min(KEPT).max(share))
    }

    /// Further stations around those of `stations` that a plan leaves high. A flat-end cutter on a curved surface leaves most in a
    /// narrow band, where lines run level. Many strips between lines cross it, and few of them have a station in it: the others stay
    /// too wide. The further stations have no area, so that shares are those of places drawn evenly.
    fn near_high_places(&self, plan: &MilledPlan, stations: &[Station]) -> Vec<Station> {
        let height = self.settings.scallop_height.mm();
        let is_high = |judged: &Judged| (HIGH * height..f64::INFINITY).contains(&judged.material());
        let high = stations.iter().zip(&plan.judged).filter(|(station, judged)| station.lift <= height && is_high(judged));
        let area: f64 = stations.iter().map(|station| station.place.area).sum();
        #[expect(clippy::cast_precision_loss, reason = "thousands")]
        let side = CELL * (area / stations.len().max(1) as f64).sqrt();
        let cells = Cells::around(high.map(|(station, _)| station.place.seen_from_above()), side);
        let mut near = (self.further)(Set::Dense, Some(&cells));
        for station in &mut near {
            station.place.area = 0.0;
        }
        near
    }

    /// The best of some rounds. In each round lines move to the spacings that the round before allows. The runs of the first round's lines
    /// may be known.
    fn spaced(
        &self,
        stations: &[Station],
        family: Family,
        spread: &Spread,
        mut allowed: Allowed,
        effort: &Effort,
        mut known: Option<Vec<Run>>,
    ) -> Result<Spaced, NoPlan> {
        let Self { prepared, settings, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        let sampling = (effort.sampling)(&prepared.profile, effort.chord_share * height);
        let maker = self.line_maker(&family, spread, sampling);
        let mut best: Option<Spaced> = None;
        for round in 1..=*effort.rounds.end() {
            let lines = allowed.lines(spread.range, MOST_LINES).ok_or(NoPlan::NoLines)?;
            let mut of_round = maker.samples(&lines);
            let runs = match known.take() {
                Some(runs) => runs,
                None if of_round > MOST_SAMPLES => return Err(NoPlan::TooLong),
                None => {
                    self.samples.set(self.samples.get() + of_round);
                    let runs = maker.runs(&lines).ok_or(NoPlan::TooLong)?;
                    let of_tips = maker.samples_of_tips(&runs);
                    self.samples.set(self.samples.get() + of_tips);
                    of_round += of_tips;
                    runs
                }
            };
            if stop() {
                return Err(NoPlan::Stopped);
            }
            if runs.is_empty() {
                return Err(NoPlan::NoRuns);
            }
            let plan = self.judged_plan(stations, family, CutLines::whole(lines.clone()), runs, Order::ByLines)?;
            let plan = self.with_missed_places(stations, plan, effort.missed)?;
            // Where a few rounds do not keep the scallop height, places between the stations are the reason.
            let margin = if round <= *effort.rounds.start() { 0.995 } else { 0.97 };
            let spaced_by = allowed.clone();
            respace(&mut allowed, &lines, &family, stations, &plan.judged, height, margin);
            let is_enough = round >= *effort.rounds.start()
                && !is_worthwhile(&plan, allowed.lines(spread.range, MOST_LINES).map_or(usize::MAX, |next| next.len()), effort);
            let is_best = best.as_ref().is_none_or(|best| rank_of(&plan) < rank_of(&best.plan));
            if is_best {
                best = Some(Spaced { plan, allowed: spaced_by, next: allowed.clone() });
            }
            // The rounds of a long path take seconds: none follows one that was no better.
            let is_no_better = of_round > LONG && !is_best;
            if is_enough || is_no_better || self.samples.get() + of_round > MOST_OF_ROUNDS {
                break;
            }
        }
        best.ok_or(NoPlan::NoRuns)
    }

    /// The plan with further runs over what its lines miss, if that is more than the share `least` of the area.
    pub(super) fn with_missed_places(&self, stations: &[Station], plan: MilledPlan, least: f64) -> Result<MilledPlan, NoPlan> {
        let Self { workpiece, prepared, settings, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        let mut missed = missed(stations, &plan.judged, &plan.family, height);
        let mut further = Vec::new();
        for beside in FURTHER_RUNS {
            if missed.iter().map(|missed| missed.share).sum::<f64>() <= least {
                break;
            }
            let runs = Missed::of(workpiece, prepared, &missed, beside, height, CHORD_SHARE * height, stop).runs();
            if !runs.is_empty() {
                // Other stations, and links of the new path, are left out here: the whole of it is judged in the end.
                let at: Vec<Station> = missed.iter().map(|missed| *missed.station).collect();
                let moves: Vec<Move> = runs.iter().flat_map(Run::moves).collect();
                let alone = self.judged(&at, &plan.family, &moves)?;
                missed = missed.into_iter().zip(&alone).filter_map(|(missed, alone)| missed.after(alone, &plan.family, height)).collect();
                further.extend(runs);
            }
        }
        if further.is_empty() {
            return Ok(plan);
        }
        let MilledPlan { family, lines, mut runs, order, tour, .. } = plan;
        // The path takes tens of megabytes on a large part, and the next one as much.
        drop(tour);
        runs.extend(further);
        self.judged_plan(stations, family, lines, runs, order)
    }

    fn line_maker<'b>(&'b self, family: &'b Family, spread: &'b Spread, sampling: Sampling) -> LineMaker<'b> {
        let Self { workpiece, prepared, settings, region, stop, .. } = *self;
        match family {
            Family::Planes(heading) => LineMaker::Planes(RunMaker {
                workpiece,
                prepared,
                region,
                machine: &settings.machine,
                heading,
                spread,
                sampling,
                clearance: workpiece.top + settings.machine.clearance_height.mm(),
                stop,
            }),
            Family::Levels => LineMaker::Levels(LevelMaker::new(workpiece, prepared, region, sampling.chord_tolerance, stop)),
        }
    }

    fn judged_plan(
        &self,
        stations: &[Station],
        family: Family,
        lines: CutLines,
        runs: Vec<Run>,
        order: Order,
    ) -> Result<MilledPlan, NoPlan> {
        let Self { workpiece, prepared, settings, .. } = *self;
        let tour = Tour::of(workpiece, prepared, settings, &runs, order, CHORD_SHARE * settings.scallop_height.mm());
        self.judged_tour(stations, family, lines, runs, order, tour)
    }

    /// The plan of runs in a path, judged at stations.
    pub(super) fn judged_tour(
        &self,
        stations: &[Station],
        family: Family,
        lines: CutLines,
        runs: Vec<Run>,
        order: Order,
        tour: Tour,
    ) -> Result<MilledPlan, NoPlan> {
        let judged = self.judged(stations, &family, &tour.moves())?;
        let finish = self.finish(stations, &judged);
        Ok(MilledPlan { family, lines, runs, order, tour, finish, judged })
    }

    /// What moves leave at stations.
    pub(super) fn judged(&self, stations: &[Station], family: &Family, moves: &[Move]) -> Result<Vec<Judged>, NoPlan> {
        let Self { workpiece, prepared, settings, samples, stop, .. } = *self;
        samples.set(samples.get() + self.samples_of_judging(stations.len(), moves.len()));
        let milled = Milled::new(&prepared.profile, moves, stop).ok_or(NoPlan::Stopped)?;
        judged(workpiece, stations, prepared, family, &milled, settings.scallop_height.mm(), stop).ok_or(NoPlan::Stopped)
    }

    /// About how many samples of lines take as long as judging that many moves at that many stations.
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts")]
    fn samples_of_judging(&self, stations: usize, moves: usize) -> usize {
        let [low, high] = self.workpiece.bounds;
        let share = PI * self.prepared.profile.outer_radius().powi(2) / ((high[0] - low[0]) * (high[1] - low[1]));
        (SAMPLES_OF_STATION * stations as f64 * (moves as f64 * share.min(1.0)).sqrt()) as usize
    }

    fn finish(&self, stations: &[Station], judged: &[Judged]) -> FinishFigures {
        FinishFigures::of(stations, judged, self.settings.scallop_height.mm())
    }

    /// A plan with the figures of further stations.
    fn measured(&self, stations: &[Station], plan: MilledPlan) -> Result<MilledPlan, NoPlan> {
        let judged = self.judged(stations, &plan.family, &plan.tour.moves())?;
        let finish = self.finish(stations, &judged);
        let gouge = Length::computed(finish.gouge.mm().max(plan.finish.gouge.mm()));
        Ok(MilledPlan { finish: FinishFigures { gouge, ..finish }, judged, ..plan })
    }

    /// A plan that was measured at these stations, with its deepest cut, and without its runs, which only further plans need.
    fn with_deepest_cut(&self, stations: &[Station], mut plan: MilledPlan) -> Result<MilledPlan, NoPlan> {
        let Self { workpiece, prepared, stop, .. } = *self;
        // Rapids too are to cut nothing.
        let moves: Vec<Move> = plan.tour.moves().into_iter().map(|each| Move { kind: MoveKind::Cut, ..each }).collect();
        let milled = Milled::new(&prepared.profile, &moves, stop).ok_or(NoPlan::Stopped)?;
        let deepest = deepest_cut(workpiece, stations, &milled);
        plan.finish.gouge = Length::computed(deepest.max(plan.finish.gouge.mm()));
        plan.runs = Vec::new();
        Ok(plan)
    }
}

/// What makes the runs of a family of lines.
enum LineMaker<'a> {
    Planes(RunMaker<'a>),
    Levels(LevelMaker<'a>),
}

impl LineMaker<'_> {
    /// About how many samples lines take; what level curves take is known from their tips alone.
    fn samples(&self, lines: &[f64]) -> usize {
        match self {
            Self::Planes(maker) => maker.samples(lines),
            Self::Levels(_) => 0,
        }
    }

    /// The samples that the tips of level curves count as; those of planes are counted before.
    fn samples_of_tips(&self, runs: &[Run]) -> usize {
        match self {
            Self::Planes(_) => 0,
            Self::Levels(_) => SAMPLES_OF_TIP * runs.iter().map(|run| run.tips.len()).sum::<usize>(),
        }
    }

    /// The runs of lines; `None` if they have too many tips.
    fn runs(&self, lines: &[f64]) -> Option<Vec<Run>> {
        match self {
            Self::Planes(maker) => maker.runs(lines),
            Self::Levels(maker) => maker.runs(lines),
        }
    }
}

/// The time in s of plans that keep the scallop height; of others, longer by the factor by which they do not. The smaller is the
/// better plan.
fn rank_of(plan: &MilledPlan) -> f64 {
    plan.tour.figures.seconds * (plan.finish.far_over_share / ENOUGH).max(1.0)
}

/// Whether another round with `next` lines is worth its time after this one.
#[expect(clippy::cast_precision_loss, reason = "counts of lines")]
fn is_worthwhile(this: &MilledPlan, next: usize, effort: &Effort) -> bool {
    this.finish.far_over_share > effort.enough || (next as f64) < (1.0 - effort.spared) * this.lines.at.len() as f64
}
