//! The ranking of all candidates on a part: directions by estimate, the best of each candidate milled, sorted by the time
//! of the tips' path.

use super::candidate_plan::{CandidatePlan, NotRankedReason, UnrankedCandidate};
use super::estimated_candidate::EstimatedCandidate;
use super::family::{Family, Heading};
use super::judged::KEPT;
use super::milled_plan::{Draft, MOST_BEFORE_OPERATIONS, MOST_OF_ALL, MilledPlan, NoPlan, Planner};
use super::operations::{OperationsPlan, OperationsSearch, operations};
use super::settings::{CandidateCutter, PlanSettings};
use super::spacing::rows_of;
use super::stations::{Cells, DrawnPlace, ESTIMATED_ON, Region, Set, drawn, drawn_until, left_by, stations, within};
use super::workpiece::{SurfaceFigures, Workpiece};
use crate::milling::{Cutter, Profile};
use crate::planning::{Confidence, SurfaceEvidence, SurfaceWeakness};
use crate::quantity::{Angle, Time};
use std::cell::{Cell, OnceCell};
use std::cmp::Ordering;

/// Candidates whose estimated time is over this factor of the shortest one stay estimated.
const FAR_BEHIND: f64 = 1.5;

/// The candidates that are milled at most, those with the shortest estimates. A library has 200, and a path takes seconds.
const MOST_CANDIDATES: usize = 8;

/// The samples of a direction's lines from which on a candidate is planned in no other.
const ONE_DIRECTION: usize = 800_000;

/// A candidate whose first two drafts take longer by this factor than a plan that keeps the scallop height is drafted in no other
/// direction. One draft says too little: beside walls directions differ by more.
const BEHIND: f64 = 1.15;
const FEWEST_DRAFTS: usize = 2;

/// A direction is planned beside that with the fastest whole lines if its lines in part take less than this share of the other's.
const WORTH_ANOTHER: f64 = 0.93;

/// The plans of all candidates on a part.
#[derive(Debug, Clone)]
pub struct Ranking {
    /// The plans, fastest first.
    pub plans: Vec<CandidatePlan>,
    /// The candidates without a plan.
    pub not_ranked: Vec<UnrankedCandidate>,
    /// The figures of the surface.
    pub surface: SurfaceFigures,
    /// The share of the area that the cutter of `rest_of` leaves, over which all plans and figures are; `None` without one.
    pub rest_share: Option<f64>,
    /// A plan of several operations that is faster than the first of `plans`; `None` if there is none, or one operation was asked
    /// for.
    pub operations: Option<OperationsPlan>,
    /// The confidence in the order of the plans; `None` without any.
    pub confidence: Option<Confidence<SurfaceWeakness>>,
}

/// Plans zigzags for each candidate over the part and ranks them by time. `evidence` has the properties of the mesh that the
/// part does not show. `stop` is called about every millisecond, by all threads. The result is `None` soon after it returns
/// true.
#[must_use]
pub fn rank(
    workpiece: &Workpiece,
    candidates: &[CandidateCutter],
    settings: &PlanSettings,
    evidence: SurfaceEvidence,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Ranking> {
    let samples = Cell::new(0);
    let job = Job { workpiece, candidates, settings, rest_of: settings.rest_of.map(Cutter::profile), samples: &samples, stop };
    let few = job.places(ESTIMATED_ON, 0, None);
    let (estimated, mut not_ranked) = job.estimated(&few)?;
    let (mut plans, without_lines) = job.planned(estimated)?;
    plans.sort_by(in_order);
    not_ranked.extend(without_lines);
    not_ranked.sort_by_key(|not_ranked| not_ranked.candidate);
    let surface = workpiece.figures();
    let single = plans.first().filter(|_| job.rest_of.is_none());
    let OperationsSearch { best: operations, not_planned } =
        single.map(|single| operations(workpiece, candidates, settings, single, &samples, stop)).unwrap_or_default();
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let sagitta = few.iter().map(|place| workpiece.sagitta_of(place.target)).sum::<f64>() / few.len().max(1) as f64;
    let confidence = Confidence::in_plans(&plans, not_planned, candidates, &surface, sagitta, settings, evidence);
    if stop() {
        return None;
    }
    Some(Ranking { plans, not_ranked, surface, rest_share: job.rest_share(&few), operations, confidence })
}

/// What is ranked.
struct Job<'a> {
    workpiece: &'a Workpiece,
    candidates: &'a [CandidateCutter],
    settings: &'a PlanSettings,
    /// The cutter that was there before, whose rest is planned.
    rest_of: Option<Profile>,
    /// The samples of all lines planned so far.
    samples: &'a Cell<usize>,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl Job<'_> {
    /// Places drawn over the surface, or over the rest; those in some cells, or all of them.
    fn places(&self, count: usize, seed: u64, cells: Option<&Cells>) -> Vec<DrawnPlace> {
        let Self { workpiece, settings, rest_of, stop, .. } = self;
        let Some(profile) = rest_of else { return within(&drawn(workpiece, count, seed), cells) };
        let height = settings.scallop_height.mm();
        let left = |places: Vec<DrawnPlace>| left_by(workpiece, profile, &places, height, stop);
        drawn_until(workpiece, count, seed, &|_| true, &left, cells)
    }

    /// The share of the area that the rest has, by its places `few`.
    fn rest_share(&self, few: &[DrawnPlace]) -> Option<f64> {
        // The parts of large facets that others hide do not count.
        let area_of = |places: &[DrawnPlace]| places.iter().map(|place| place.area).sum::<f64>();
        self.rest_of.as_ref().map(|_| (area_of(few) / area_of(&drawn(self.workpiece, ESTIMATED_ON, 0))).min(1.0))
    }

    /// The estimates of the candidates that reach the surface at the places `few`, the fastest first, and the candidates that do not;
    /// `None` once `stop` returns true. Where there is no rest, none has a plan.
    fn estimated(&self, few: &[DrawnPlace]) -> Option<(Vec<EstimatedCandidate>, Vec<UnrankedCandidate>)> {
        let rows = rows_of(self.workpiece);
        let (mut estimated, mut not_ranked) = (Vec::new(), Vec::new());
        for (index, candidate) in self.candidates.iter().enumerate() {
            if (self.stop)() {
                return None;
            }
            match EstimatedCandidate::new(self.workpiece, index, candidate, self.settings, &rows, few, self.stop) {
                Ok(_) if self.rest_of.is_some() && few.is_empty() => {}
                Ok(of_candidate) => estimated.push(of_candidate),
                Err(reason) => not_ranked.push(UnrankedCandidate { candidate: index, reason }),
            }
        }
        estimated.sort_by(|a: &EstimatedCandidate, b| a.shortest().total_cmp(&b.shortest()));
        Some((estimated, not_ranked))
    }

    /// The plans of the candidates, those near the fastest milled, and the candidates for which no lines were found; `None` once
    /// `stop` returns true.
    fn planned(&self, estimated: Vec<EstimatedCandidate>) -> Option<(Vec<CandidatePlan>, Vec<UnrankedCandidate>)> {
        let Self { workpiece, settings, samples, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        let last = estimated.get(MOST_CANDIDATES - 1).map_or(f64::INFINITY, EstimatedCandidate::shortest);
        let limit = estimated.first().map_or(0.0, |fastest| (FAR_BEHIND * fastest.shortest()).min(last));
        let sets: [OnceCell<Vec<DrawnPlace>>; 4] = Default::default();
        let (mut plans, mut without_lines) = (Vec::new(), Vec::new());
        for of_candidate in estimated {
            let leaves_time = settings.most_operations > 1 && fastest_of(&plans).is_finite();
            let most_samples = if leaves_time { MOST_BEFORE_OPERATIONS } else { MOST_OF_ALL };
            if of_candidate.shortest() > limit || samples.get() >= most_samples {
                plans.push(of_candidate.unmilled(workpiece, settings));
                continue;
            }
            let prepared = &of_candidate.prepared;
            let of_set = |set: Set, cells: Option<&Cells>| {
                let places = match cells {
                    Some(_) => &self.places(set.count(), set.seed(), cells),
                    None => sets[set as usize - 1].get_or_init(|| self.places(set.count(), set.seed(), None)),
                };
                stations(workpiece, &prepared.profile, places, height, stop)
            };
            let on = of_set(Set::Spaced, None);
            let region = if self.rest_of.is_some() { Region::of_rest(&on, &prepared.profile, height) } else { Region::WHOLE };
            let planner = Planner { workpiece, prepared, settings, region: &region, stations: &on, further: &of_set, samples, stop };
            let Directed { best, times, is_too_long, meets_nothing } =
                in_best_direction(&planner, of_candidate.to_mill(settings), fastest_of(&plans))?;
            match best {
                Some(best) => plans.push(of_candidate.milled(workpiece, settings, best, &times)),
                None if is_too_long => plans.push(of_candidate.unmilled(workpiece, settings)),
                None => {
                    let reason = if meets_nothing { of_candidate.refusal() } else { NotRankedReason::NoStepOver };
                    without_lines.push(UnrankedCandidate { candidate: prepared.index, reason });
                }
            }
            keep_path_of_first(&mut plans);
        }
        (!stop()).then_some((plans, without_lines))
    }
}

/// The plans of a candidate in several directions.
struct Directed {
    best: Option<(Angle, MilledPlan)>,
    /// The time of each direction that was planned, `None` without a plan.
    times: Vec<(Angle, Option<Time>)>,
    is_too_long: bool,
    /// Whether the lines of a direction meet nothing that the cutter reaches.
    meets_nothing: bool,
}

/// The shortest time in s of the plans that keep the scallop height; infinite without any.
fn fastest_of(plans: &[CandidatePlan]) -> f64 {
    let kept = plans.iter().filter(|plan| plan.milled.is_some_and(|milled| milled.finish.far_over_share <= KEPT));
    kept.map(|plan| plan.time.seconds()).fold(f64::INFINITY, f64::min)
}

/// Drafts the plans of a candidate in these directions, as long as its paths are short enough for further ones and it is not behind
/// another one that takes `fastest` seconds, and finishes the best; `None` once `stop` returns true.
///
/// A draft tells roughly what lines in part spare: which of their stretches come back is known once they are milled. So a direction
/// whose lines take far less time in part is finished beside the one with the fastest whole lines, and the faster plan is taken.
fn in_best_direction(planner: &Planner, directions: Vec<Angle>, fastest: f64) -> Option<Directed> {
    let mut directed = Directed { best: None, times: Vec::new(), is_too_long: false, meets_nothing: false };
    let mut drafts: Vec<(Angle, Draft)> = Vec::new();
    for direction in directions {
        let before = planner.samples.get();
        let draft = planner.draft(Family::Planes(Heading::of(direction.radians())));
        let after = planner.samples.get();
        match draft {
            Ok(draft) => {
                directed.times.push((direction, Some(Time::computed(draft.seconds))));
                drafts.push((direction, draft));
                let is_behind = drafts.len() >= FEWEST_DRAFTS && drafts.iter().all(|(_, draft)| draft.seconds > BEHIND * fastest);
                if after - before > ONE_DIRECTION || after >= MOST_OF_ALL || is_behind {
                    break;
                }
            }
            Err(NoPlan::Stopped) => return None,
            Err(reason @ (NoPlan::NoLines | NoPlan::NoRuns)) => {
                directed.meets_nothing |= reason == NoPlan::NoRuns;
                directed.times.push((direction, None));
            }
            Err(NoPlan::TooLong) => {
                directed.is_too_long = true;
                break;
            }
        }
    }
    for (direction, draft) in worth_a_plan(drafts) {
        if directed.best.is_some() && planner.samples.get() >= MOST_OF_ALL {
            break;
        }
        match planner.finished(draft) {
            Ok(plan) => {
                let time = Time::computed(plan.tour.figures.seconds);
                directed.times.retain(|(other, _)| *other != direction);
                directed.times.push((direction, Some(time)));
                if directed.best.as_ref().is_none_or(|(_, best)| order_of(&plan) < order_of(best)) {
                    directed.best = Some((direction, plan));
                }
            }
            Err(NoPlan::Stopped) => return None,
            Err(NoPlan::NoLines) => {}
            Err(NoPlan::NoRuns) => directed.meets_nothing = true,
            Err(NoPlan::TooLong) => directed.is_too_long = true,
        }
    }
    Some(directed)
}

/// The draft with the shortest time, and of those whose lines take far less time in part, the one with the shortest such time.
fn worth_a_plan(mut drafts: Vec<(Angle, Draft)>) -> Vec<(Angle, Draft)> {
    drafts.sort_by(|(_, a), (_, b)| a.seconds.total_cmp(&b.seconds));
    let Some(limit) = drafts.first().map(|(_, draft)| WORTH_ANOTHER * draft.seconds_in_part) else { return drafts };
    let mut others = drafts.split_off(1);
    others.retain(|(_, draft)| draft.seconds_in_part < limit);
    drafts.extend(others.into_iter().min_by(|(_, a), (_, b)| a.seconds_in_part.total_cmp(&b.seconds_in_part)));
    drafts
}

/// Plans that keep the scallop height before others, then by time in s.
fn order_of(plan: &MilledPlan) -> (bool, f64) {
    (plan.finish.far_over_share > KEPT, plan.tour.figures.seconds)
}

/// Milled plans before estimated ones, among them those that keep the scallop height before the others, then by time.
fn in_order(a: &CandidatePlan, b: &CandidatePlan) -> Ordering {
    let class = |plan: &CandidatePlan| plan.milled.map_or(2, |milled| u8::from(milled.finish.far_over_share > KEPT));
    class(a).cmp(&class(b)).then(a.time.seconds().total_cmp(&b.time.seconds()))
}

/// Drops the paths of all plans but the first in order: those of several would take hundreds of megabytes.
fn keep_path_of_first(plans: &mut [CandidatePlan]) {
    let first = plans.iter().enumerate().min_by(|(_, a), (_, b)| in_order(a, b)).map(|(index, _)| index);
    for (_, plan) in plans.iter_mut().enumerate().filter(|(index, _)| Some(*index) != first) {
        plan.path = None;
    }
}
