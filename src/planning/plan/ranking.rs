//! The ranking of all candidates on a part: directions by estimate, the best of each candidate milled, sorted by the time
//! of the tips' path.

use super::candidate::CandidateCutter;
use super::candidate_plan::{CandidatePlan, MilledFigures, PlannedPath};
use super::cells::Cells;
use super::drawn_places::{DrawnPlace, ESTIMATED_ON, Set, drawn, within};
use super::estimate::{least_seconds, seconds};
use super::family::{Family, Heading};
use super::judged::KEPT;
use super::milled_plan::{Draft, MilledPlan, NoPlan, Planner};
use super::operations::{OperationsPlan, operations};
use super::prepared::{Prepared, rows_of};
use super::region::Region;
use super::rest::{drawn_until, left_by};
use super::settings::{Directions, PlanSettings};
use super::stations::{Station, stations};
use super::workpiece::{SurfaceFigures, Workpiece};
use crate::milling::{Cutter, Model};
use crate::planning::{Confidence, Level, Reason, RectanglePlan, SurfaceEvidence, SurfaceWeakness, plan_on_rectangle};
use crate::quantity::{Angle, Length, Time};
use rayon::prelude::*;
use std::cell::{Cell, OnceCell};
use std::cmp::Ordering;
use std::fmt;

/// Candidates whose estimated time is over this factor of the shortest one stay estimated.
const FAR_BEHIND: f64 = 1.5;

/// The candidates that are milled at most, those with the shortest estimates. A library has 200, and a path takes seconds.
const MOST_CANDIDATES: usize = 8;

/// The samples of lines that are planned at most for all candidates, some twenty seconds on two threads, and those of a
/// direction's plans from which on a candidate is planned in no other.
const MOST_SAMPLES: usize = 20_000_000;
const ONE_DIRECTION: usize = 3_000_000;

/// The directions of a candidate that are milled at most, and the factor over the shortest estimate beyond which a direction
/// is not.
const MOST_MILLED: usize = 3;
const MILLED_WITHIN: f64 = 1.15;

/// A candidate whose first draft takes longer by this factor than a plan that keeps the scallop height is drafted in no other
/// direction.
const BEHIND: f64 = 1.15;

/// Estimates of directions nearer than this, in deg, err by nearly the same share. Directions further apart are milled first.
const FAR_APART: f64 = 30.0;

/// The smallest angle between milled directions in deg. Nearer ones have nearly the same lines.
const MILLED_APART: f64 = 2.0;

/// The angle in deg under which one direction repeats another.
const REPEATED: f64 = 0.2;

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

/// A candidate without a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnrankedCandidate {
    /// The position of the cutter among the candidates.
    pub candidate: usize,
    /// The reason why it has no plan.
    pub reason: NotRankedReason,
}

/// The reason why a candidate has no plan.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NotRankedReason {
    /// The cutter leaves more of the area uncut than allowed.
    CannotReach {
        /// The share of the area, 0 to 1.
        uncut_share: f64,
        /// The largest height by which the cutter stands over a place that it should touch.
        uncut_height: Length,
    },
    /// In every direction, some part of the surface has no step-over that keeps the scallop height, or step-overs are so
    /// small that there would be more than 50,000 lines.
    NoStepOver,
}

impl fmt::Display for NotRankedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CannotReach { uncut_share, uncut_height } => write!(
                f,
                "the cutter does not reach {:.2} % of the area and stands up to {:.4} mm over it there",
                100.0 * uncut_share,
                uncut_height.mm()
            ),
            Self::NoStepOver => f.write_str("in no direction do 50,000 lines or fewer keep the scallop height everywhere"),
        }
    }
}

/// A candidate with the estimates of its directions.
struct Estimated {
    prepared: Prepared,
    directions: Vec<(Angle, Option<f64>)>,
    least_seconds: f64,
    uncut_share: f64,
    uncut_height: f64,
}

impl Estimated {
    fn shortest(&self) -> f64 {
        self.directions.iter().filter_map(|(_, seconds)| *seconds).fold(f64::INFINITY, f64::min)
    }

    /// The directions to mill, the one with the shortest estimate first. One of them is along the part, unless all such are far
    /// behind: estimates do not know that passes along a straight wall need no further ones at its foot.
    fn to_mill(&self, along_part: &[Angle]) -> Vec<Angle> {
        let limit = MILLED_WITHIN * self.shortest();
        let within = |&(angle, seconds): &(Angle, Option<f64>)| seconds.filter(|seconds| *seconds <= limit).map(|seconds| (angle, seconds));
        let mut sorted: Vec<(Angle, f64)> = self.directions.iter().filter_map(within).collect();
        sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
        let is_along = |angle: &Angle| along_part.iter().any(|along| lines_apart(*along, *angle) < REPEATED);
        let mut chosen: Vec<Angle> = sorted.first().map(|(angle, _)| *angle).into_iter().collect();
        let along = sorted.iter().map(|(angle, _)| *angle).find(is_along);
        chosen.extend(along.filter(|angle| !chosen.contains(angle)));
        for apart in [FAR_APART, MILLED_APART] {
            for (angle, _) in &sorted {
                if chosen.len() < MOST_MILLED && chosen.iter().all(|other| lines_apart(*other, *angle) >= apart) {
                    chosen.push(*angle);
                }
            }
        }
        chosen
    }
}

/// The directions along the part: X and Y, as parts are drawn, and those of its shape.
fn along_part(settings: &PlanSettings) -> Vec<Angle> {
    let of_shape: &[Angle] = if let Directions::All { beside } = &settings.directions { beside } else { &[] };
    [Angle::ZERO, Angle::RIGHT].iter().chain(of_shape).copied().collect()
}

/// The angle between two lines, in deg.
fn lines_apart(one: Angle, other: Angle) -> f64 {
    let apart = (one.degrees() - other.degrees()).abs() % 180.0;
    apart.min(180.0 - apart)
}

/// The directions of `more` without those that repeat one of `tried` or an earlier one.
fn apart_from(tried: &[(Angle, Option<f64>)], more: impl Iterator<Item = Angle>) -> Vec<Angle> {
    let mut new: Vec<Angle> = Vec::new();
    for angle in more {
        let is_new = |other: &Angle| lines_apart(*other, angle) > REPEATED;
        if tried.iter().all(|(other, _)| is_new(other)) && new.iter().all(is_new) {
            new.push(angle);
        }
    }
    new
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
    let height = settings.scallop_height.mm();
    let rows = rows_of(workpiece);
    let rest_of = settings.rest_of.map(Cutter::profile);
    let places = |count: usize, seed: u64| match &rest_of {
        None => drawn(workpiece, count, seed),
        Some(profile) => {
            drawn_until(workpiece, count, seed, &|_| true, &|places: Vec<DrawnPlace>| left_by(workpiece, profile, &places, height, stop))
        }
    };
    let few = places(ESTIMATED_ON, 0);
    // The parts of large facets that others hide do not count.
    let area_of = |places: &[DrawnPlace]| places.iter().map(|place| place.area).sum::<f64>();
    let rest_share = rest_of.as_ref().map(|_| (area_of(&few) / area_of(&drawn(workpiece, ESTIMATED_ON, 0))).min(1.0));
    let mut not_ranked = Vec::new();
    let mut estimated: Vec<Estimated> = Vec::new();
    for (index, candidate) in candidates.iter().enumerate() {
        if stop() {
            return None;
        }
        match estimate(workpiece, index, candidate, settings, &rows, &few, stop) {
            Ok(_) if rest_of.is_some() && few.is_empty() => {}
            Ok(of_candidate) => estimated.push(of_candidate),
            Err(reason) => not_ranked.push(UnrankedCandidate { candidate: index, reason }),
        }
    }
    let mut shortest: Vec<f64> = estimated.iter().map(Estimated::shortest).collect();
    shortest.sort_by(f64::total_cmp);
    let last = shortest.get(MOST_CANDIDATES - 1).copied().unwrap_or(f64::INFINITY);
    let limit = shortest.first().map_or(0.0, |shortest| (FAR_BEHIND * shortest).min(last));
    let sets: [OnceCell<Vec<DrawnPlace>>; 4] = Default::default();
    let (samples, along_part) = (Cell::new(0), along_part(settings));
    let mut plans = Vec::new();
    estimated.sort_by(|a, b| a.shortest().total_cmp(&b.shortest()));
    for of_candidate in estimated {
        let index = of_candidate.prepared.index;
        if of_candidate.shortest() > limit || samples.get() >= MOST_SAMPLES {
            plans.push(of_candidate.unmilled(workpiece, settings));
            continue;
        }
        let prepared = &of_candidate.prepared;
        let of_set = |set: Set, cells: Option<&Cells>| {
            let places = sets[set as usize - 1].get_or_init(|| places(set.count(), set.seed()));
            stations(workpiece, &prepared.profile, &within(places, cells), height, stop)
        };
        let on = of_set(Set::Spaced, None);
        let region = if rest_of.is_some() { Region::of_rest(&on, &prepared.profile, height) } else { Region::WHOLE };
        let planner = Planner { workpiece, prepared, settings, region: &region, stations: &on, further: &of_set, samples: &samples, stop };
        let Directed { best, times, is_too_long } = in_best_direction(&planner, of_candidate.to_mill(&along_part), fastest_of(&plans))?;
        match best {
            Some(best) => plans.push(of_candidate.milled(workpiece, settings, best, &times)),
            None if is_too_long => plans.push(of_candidate.unmilled(workpiece, settings)),
            None => not_ranked.push(UnrankedCandidate { candidate: index, reason: NotRankedReason::NoStepOver }),
        }
        keep_path_of_first(&mut plans);
    }
    if stop() {
        return None;
    }
    plans.sort_by(in_order);
    not_ranked.sort_by_key(|not_ranked| not_ranked.candidate);
    let surface = workpiece.figures();
    let confidence = Confidence::of(&plans, candidates, &surface, settings, evidence);
    let single = plans.first().filter(|_| rest_of.is_none());
    let operations = single.and_then(|single| operations(workpiece, candidates, settings, single, stop));
    if stop() {
        return None;
    }
    Some(Ranking { plans, not_ranked, surface, rest_share, operations, confidence })
}

/// The plans of a candidate in several directions.
struct Directed {
    best: Option<(Angle, MilledPlan)>,
    /// The time of each direction that was planned, `None` without a plan.
    times: Vec<(Angle, Option<Time>)>,
    is_too_long: bool,
}

/// The shortest time in s of the plans that keep the scallop height; infinite without any.
fn fastest_of(plans: &[CandidatePlan]) -> f64 {
    let kept = plans.iter().filter(|plan| plan.milled.is_some_and(|milled| milled.finish.far_over_share <= KEPT));
    kept.map(|plan| plan.time.seconds()).fold(f64::INFINITY, f64::min)
}

/// Drafts the plans of a candidate in these directions, as long as its paths are short enough for further ones and it is not behind
/// another one that takes `fastest` seconds, and finishes the best; `None` once `stop` returns true.
fn in_best_direction(planner: &Planner, directions: Vec<Angle>, fastest: f64) -> Option<Directed> {
    let mut directed = Directed { best: None, times: Vec::new(), is_too_long: false };
    let mut best: Option<(Angle, Draft)> = None;
    let is_behind = |best: &Option<(Angle, Draft)>| best.as_ref().is_some_and(|(_, draft)| draft.seconds > BEHIND * fastest);
    for direction in directions {
        let before = planner.samples.get();
        let draft = planner.draft(Family::Planes(Heading::of(direction.radians())));
        let after = planner.samples.get();
        match draft {
            Ok(draft) => {
                directed.times.push((direction, Some(Time::computed(draft.seconds))));
                if best.as_ref().is_none_or(|(_, best)| draft.seconds < best.seconds) {
                    best = Some((direction, draft));
                }
                if after - before > ONE_DIRECTION || after >= MOST_SAMPLES || is_behind(&best) {
                    break;
                }
            }
            Err(NoPlan::Stopped) => return None,
            Err(NoPlan::NoLines | NoPlan::NoRuns) => directed.times.push((direction, None)),
            Err(NoPlan::TooLong) => {
                directed.is_too_long = true;
                break;
            }
        }
    }
    let Some((direction, draft)) = best else { return Some(directed) };
    match planner.finished(draft) {
        Ok(plan) => {
            let time = Time::computed(plan.tour.figures.seconds);
            directed.times.retain(|(other, _)| *other != direction);
            directed.times.push((direction, Some(time)));
            directed.best = Some((direction, plan));
        }
        Err(NoPlan::Stopped) => return None,
        Err(NoPlan::NoLines | NoPlan::NoRuns) => {}
        Err(NoPlan::TooLong) => directed.is_too_long = true,
    }
    Some(directed)
}

/// The estimated time of each candidate in its best direction, `None` for one that `rank` would not rank. It takes
/// milliseconds a candidate, however large the part. The result is `None` soon after `stop` returns true.
#[must_use]
pub fn estimated_times(
    workpiece: &Workpiece,
    candidates: &[CandidateCutter],
    settings: &PlanSettings,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Option<Time>>> {
    let (rows, few) = (rows_of(workpiece), drawn(workpiece, ESTIMATED_ON, 0));
    let mut times = Vec::with_capacity(candidates.len());
    for (index, candidate) in candidates.iter().enumerate() {
        let estimated = estimate(workpiece, index, candidate, settings, &rows, &few, stop);
        times.push(estimated.ok().map(|estimated| Time::computed(estimated.shortest())));
        if stop() {
            return None;
        }
    }
    Some(times)
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

fn estimate(
    workpiece: &Workpiece,
    index: usize,
    candidate: &CandidateCutter,
    settings: &PlanSettings,
    rows: &[bool],
    places: &[DrawnPlace],
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Estimated, NotRankedReason> {
    let height = settings.scallop_height.mm();
    let prepared = Prepared::new(index, candidate, settings, rows, stop);
    let on = stations(workpiece, &prepared.profile, places, height, stop);
    let out_of_reach: Vec<&Station> = on.iter().filter(|station| station.lift > height).collect();
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let uncut_share = out_of_reach.len() as f64 / on.len().max(1) as f64;
    let uncut_height = out_of_reach.iter().map(|station| station.lift).filter(|lift| lift.is_finite()).fold(0.0, f64::max);
    // In a hollow of coarse facets a cutter that fits the surface stands on their edges, by as much as they are off the surface.
    let is_refused = |station: &&&Station| station.lift > height + workpiece.sagitta_of(station.place.target);
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let refused_share = out_of_reach.iter().filter(is_refused).count() as f64 / on.len().max(1) as f64;
    // The limit is a share of the whole area also where the places are those of a rest.
    let part = places.iter().map(|place| place.area).sum::<f64>() / workpiece.area();
    if refused_share * part.min(1.0) > settings.max_uncut_share {
        return Err(NotRankedReason::CannotReach { uncut_share, uncut_height: Length::computed(uncut_height) });
    }
    let time =
        |direction: Angle| (direction, seconds(workpiece, &on, &prepared, settings, &Family::Planes(Heading::of(direction.radians()))));
    let all = |angles: Vec<Angle>| -> Vec<(Angle, Option<f64>)> { angles.into_par_iter().map(time).collect() };
    let directions = match &settings.directions {
        Directions::Only(only) => all(only.clone()),
        Directions::All { beside } => {
            let coarse = (0..36).map(|step| Angle::from_radians((5.0 * f64::from(step)).to_radians()));
            let mut times = all(apart_from(&[], beside.iter().copied().chain(coarse)));
            for step in [2.5_f64, 1.0, 0.5] {
                let mut best: Vec<(Angle, f64)> = times.iter().filter_map(|&(angle, seconds)| Some((angle, seconds?))).collect();
                best.sort_by(|a, b| a.1.total_cmp(&b.1));
                best.truncate(MOST_MILLED);
                let beside = |(angle, _): (Angle, f64)| {
                    [-step, step].map(|by| Angle::from_radians((angle.degrees() + by).rem_euclid(180.0).to_radians()))
                };
                let new = apart_from(&times, best.into_iter().flat_map(beside));
                times.extend(all(new));
            }
            times.sort_by(|a, b| a.0.radians().total_cmp(&b.0.radians()));
            times
        }
    };
    if directions.iter().all(|(_, seconds)| seconds.is_none()) {
        return Err(NotRankedReason::NoStepOver);
    }
    let least_seconds = least_seconds(workpiece, &on, &prepared, height);
    Ok(Estimated { prepared, directions, least_seconds, uncut_share, uncut_height })
}

impl Estimated {
    fn plan(&self, workpiece: &Workpiece, settings: &PlanSettings, direction: Angle, seconds: f64) -> CandidatePlan {
        let candidate = &self.prepared.candidate;
        let depth = workpiece.bounds[1][2] - workpiece.bounds[0][2];
        CandidatePlan {
            candidate: self.prepared.index,
            direction,
            time: Time::computed(seconds),
            milled: None,
            uncut_share: self.uncut_share,
            uncut_height: Length::computed(self.uncut_height),
            least_time: Time::computed(self.least_seconds),
            by_direction: self.directions.iter().map(|&(angle, seconds)| (angle, seconds.map(Time::computed))).collect(),
            rectangle: on_rectangle(candidate, settings),
            flutes_too_short: candidate.flute_length.is_some_and(|flutes| flutes.mm() < depth),
            path: None,
        }
    }

    fn unmilled(self, workpiece: &Workpiece, settings: &PlanSettings) -> CandidatePlan {
        let shortest = self.shortest();
        let direction = self.directions.iter().find(|(_, seconds)| *seconds == Some(shortest)).map_or(Angle::ZERO, |(angle, _)| *angle);
        self.plan(workpiece, settings, direction, shortest)
    }

    fn milled(
        self,
        workpiece: &Workpiece,
        settings: &PlanSettings,
        (direction, best): (Angle, MilledPlan),
        times: &[(Angle, Option<Time>)],
    ) -> CandidatePlan {
        let figures = MilledFigures::of(workpiece, settings, &self.prepared, &best, self.least_seconds);
        let mut plan = self.plan(workpiece, settings, direction, figures.tour.seconds);
        for (direction, time) in &mut plan.by_direction {
            if let Some((_, milled)) = times.iter().find(|(angle, _)| angle == direction) {
                *time = *milled;
            }
        }
        CandidatePlan {
            milled: Some(figures),
            uncut_share: best.finish.uncut_share,
            uncut_height: best.finish.uncut_height,
            path: Some(PlannedPath { plan: best, prepared: self.prepared }),
            ..plan
        }
    }
}

/// The plan by the published method with its own model; `None` if a side is outside the range of lengths.
fn on_rectangle(candidate: &CandidateCutter, settings: &PlanSettings) -> Option<RectanglePlan> {
    let shape = settings.shape.as_ref()?;
    plan_on_rectangle(candidate, shape, settings, Model::Analytic).ok().flatten()
}

impl Confidence<SurfaceWeakness> {
    /// The confidence in plans in their order; `None` without any.
    fn of(
        plans: &[CandidatePlan],
        candidates: &[CandidateCutter],
        surface: &SurfaceFigures,
        settings: &PlanSettings,
        evidence: SurfaceEvidence,
    ) -> Option<Self> {
        let best = plans.first()?;
        let PlanSettings { scallop_height, machine, .. } = settings;
        let mut reasons = Vec::new();
        let is_stated = |plan: &CandidatePlan| candidates[plan.candidate].drive.is_some();
        // The machine's feed rate is the largest of all: a cutter that is slower with it is slower with any.
        let stated = if is_stated(best) { 0 } else { plans.iter().filter(|plan| is_stated(plan)).count() };
        let sooner = plans.iter().filter(|plan| plan.milled.is_none() && plan.time.seconds() <= best.time.seconds()).count();
        #[expect(clippy::cast_precision_loss, reason = "counts of candidates and pieces")]
        let [stated, sooner, pieces] = [stated, sooner, evidence.pieces].map(|count| count as f64);
        reasons.extend(Reason::over(SurfaceWeakness::NotMilled, sooner, 0.0, if best.milled.is_some() { f64::INFINITY } else { 0.0 }));
        reasons.extend(Reason::over(SurfaceWeakness::AssumedFeed, stated, 0.0, f64::INFINITY));
        if let Some(next) = plans.get(1) {
            let lead = (1.0 - best.time.seconds() / next.time.seconds()).abs();
            if lead < 0.02 {
                reasons.push(Reason { weakness: SurfaceWeakness::SmallLead, level: Level::Moderate, figure: lead, threshold: 0.02 });
            }
        }
        let sagittas = surface.sagitta.mm() / scallop_height.mm();
        if let Some(milled) = best.milled {
            let size = surface.facet_size.mm() / milled.step_over.median.mm();
            let (coarse, far) = (SurfaceWeakness::CoarseTessellation, if sagittas > 1.0 { 8.0 } else { f64::INFINITY });
            reasons.extend(Reason::over(coarse, size, 2.0, far).filter(|_| sagittas > 0.1));
            reasons.extend(Reason::over(SurfaceWeakness::OverTolerance, milled.finish.far_over_share, KEPT, 0.1));
            reasons.extend(Reason::over(SurfaceWeakness::Gouge, milled.finish.gouge.mm() / scallop_height.mm(), 0.4, 4.0));
        }
        if let Some(path) = best.path.as_ref().filter(|_| machine.path_tolerance.is_none()) {
            let longer = path.plan.tour.seconds_with_stops(machine) / best.time.seconds();
            reasons.extend(Reason::over(SurfaceWeakness::SharpCorners, longer, 1.1, f64::INFINITY));
        }
        reasons.extend(Reason::over(SurfaceWeakness::SteepArea, surface.steep_area_share, 0.02, 0.2));
        reasons.extend(Reason::over(SurfaceWeakness::HiddenArea, evidence.hidden_area_share, 0.02, 0.2));
        reasons.extend(Reason::over(SurfaceWeakness::SeveralPieces, pieces, 1.0, f64::INFINITY));
        reasons.extend(Reason::over(SurfaceWeakness::InconsistentOrientation, evidence.turned_area_share, 0.002, 0.2));
        reasons.extend(Reason::missing_area(SurfaceWeakness::NotClosed, evidence.missing_area, *scallop_height));
        Some(Self::from_reasons(reasons))
    }
}
