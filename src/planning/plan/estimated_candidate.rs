//! A candidate by estimates alone: whether it reaches the surface, its time in each direction, and the directions that deserve
//! a plan.

use super::candidate_plan::{CandidatePlan, MilledFigures, NotRankedReason, PlannedPath};
use super::estimate::{least_seconds, seconds};
use super::family::{Family, Heading};
use super::milled_plan::MilledPlan;
use super::settings::{CandidateCutter, Directions, PlanSettings};
use super::spacing::{Prepared, rows_of};
use super::stations::{AT_ONCE, DrawnPlace, ESTIMATED_ON, Station, cut_by_fitting, drawn, stands_at, stations};
use super::workpiece::Workpiece;
use crate::milling::{Model, Profile};
use crate::planning::{RectanglePlan, plan_on_rectangle};
use crate::quantity::{Angle, Length, Time};
use rayon::prelude::*;

/// The directions of a candidate that are milled at most, and the factor over the shortest estimate beyond which a direction
/// is not.
const MOST_MILLED: usize = 4;
const MILLED_WITHIN: f64 = 1.15;

/// Estimates of directions nearer than this, in deg, err by nearly the same share. Directions further apart are milled first.
const FAR_APART: f64 = 30.0;

/// A direction along the part is milled before another one whose estimate is over this share of its own: estimates know neither what
/// passes along a straight wall spare nor what lines in part do.
const ALONG_PART: f64 = 0.95;

/// The smallest angle between milled directions in deg. Nearer ones have nearly the same lines.
const MILLED_APART: f64 = 2.0;

/// The angle in deg under which one direction repeats another.
const REPEATED: f64 = 0.2;

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
        let estimated = EstimatedCandidate::new(workpiece, index, candidate, settings, &rows, &few, stop);
        times.push(estimated.ok().map(|estimated| Time::computed(estimated.shortest())));
        if stop() {
            return None;
        }
    }
    Some(times)
}

/// The time of a direction in s; `None` if no lines keep the scallop height in it.
type DirectionTime = (Angle, Option<f64>);

/// A candidate that reaches the surface, with the estimates of its directions.
pub(super) struct EstimatedCandidate {
    pub(super) prepared: Prepared,
    directions: Vec<DirectionTime>,
    least_seconds: f64,
    uncut: Uncut,
}

impl EstimatedCandidate {
    /// The estimates of the candidate at `index` from `places` on the surface; `rows` are those of [`rows_of`]. Once `stop` returns
    /// true, it ends early with estimates that must be discarded.
    ///
    /// # Errors
    ///
    /// The reason why the candidate has no plan.
    pub(super) fn new(
        workpiece: &Workpiece,
        index: usize,
        candidate: &CandidateCutter,
        settings: &PlanSettings,
        rows: &[bool],
        places: &[DrawnPlace],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, NotRankedReason> {
        let height = settings.scallop_height.mm();
        let prepared = Prepared::new(index, candidate, settings, rows, stop);
        let on = stations(workpiece, &prepared.profile, places, height, stop);
        let uncut = Uncut::at(workpiece, &prepared.profile, &on, height);
        // The limit is a share of the whole area also where the places are those of a rest.
        let part = places.iter().map(|place| place.area).sum::<f64>() / workpiece.area();
        // A cutter that reaches nothing has no plan, whatever may be left.
        if uncut.share >= 1.0 || uncut.refused_share * part.min(1.0) > settings.max_uncut_share {
            return Err(uncut.refusal());
        }
        let time = |direction: Angle| seconds(workpiece, &on, &prepared, settings, &Family::Planes(Heading::of(direction.radians())));
        let directions = times_by_direction(&settings.directions, &time);
        if directions.iter().all(|(_, seconds)| seconds.is_none()) {
            return Err(NotRankedReason::NoStepOver);
        }
        let least_seconds = least_seconds(workpiece, &on, &prepared, height);
        Ok(Self { prepared, directions, least_seconds, uncut })
    }

    /// The shortest time of all directions in s; infinite without any.
    pub(super) fn shortest(&self) -> f64 {
        self.directions.iter().filter_map(|(_, seconds)| *seconds).fold(f64::INFINITY, f64::min)
    }

    /// Why it has no plan if no line meets anything that the cutter reaches.
    pub(super) fn refusal(&self) -> NotRankedReason {
        self.uncut.refusal()
    }

    /// The directions to mill, the one with the shortest estimate first. One of them is along the part, unless all such are far
    /// behind.
    pub(super) fn to_mill(&self, settings: &PlanSettings) -> Vec<Angle> {
        let along_part = along_part(settings);
        let limit = MILLED_WITHIN * self.shortest();
        let within = |&(angle, seconds): &(Angle, Option<f64>)| seconds.filter(|seconds| *seconds <= limit).map(|seconds| (angle, seconds));
        let mut sorted: Vec<(Angle, f64)> = self.directions.iter().filter_map(within).collect();
        let fastest = sorted.iter().min_by(|a, b| a.1.total_cmp(&b.1));
        let mut chosen: Vec<Angle> = fastest.map(|(angle, _)| *angle).into_iter().collect();
        let is_along = |angle: &Angle| along_part.iter().any(|along| lines_apart(*along, *angle) < REPEATED);
        let favoured = |(angle, seconds): &(Angle, f64)| if is_along(angle) { ALONG_PART * seconds } else { *seconds };
        sorted.sort_by(|a, b| favoured(a).total_cmp(&favoured(b)));
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

    fn plan(&self, workpiece: &Workpiece, settings: &PlanSettings, direction: Angle, seconds: f64) -> CandidatePlan {
        let candidate = &self.prepared.candidate;
        let depth = workpiece.bounds[1][2] - workpiece.bounds[0][2];
        CandidatePlan {
            candidate: self.prepared.index,
            direction,
            time: Time::computed(seconds),
            milled: None,
            uncut_share: self.uncut.share,
            uncut_height: self.uncut.height,
            least_time: Time::computed(self.least_seconds),
            by_direction: self.directions.iter().map(|&(angle, seconds)| (angle, seconds.map(Time::computed))).collect(),
            rectangle: on_rectangle(candidate, settings),
            flutes_too_short: candidate.flute_length.is_some_and(|flutes| flutes.mm() < depth),
            path: None,
        }
    }

    /// Its plan without a path, in the direction with the shortest time.
    pub(super) fn unmilled(self, workpiece: &Workpiece, settings: &PlanSettings) -> CandidatePlan {
        let shortest = self.shortest();
        let direction = self.directions.iter().find(|(_, seconds)| *seconds == Some(shortest)).map_or(Angle::ZERO, |(angle, _)| *angle);
        self.plan(workpiece, settings, direction, shortest)
    }

    /// Its plan with the best path, and the times of the directions that were planned in place of their estimates.
    pub(super) fn milled(
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

/// What a cutter leaves because it does not fit.
struct Uncut {
    /// The share of the stations that it leaves over the scallop height.
    share: f64,
    /// The largest height left there.
    height: Length,
    /// The share for which it can be refused.
    refused_share: f64,
}

impl Uncut {
    fn at(workpiece: &Workpiece, profile: &Profile, stations: &[Station], scallop_height: f64) -> Self {
        let over: Vec<&Station> = stations.iter().filter(|station| station.lift > scallop_height).collect();
        // In a hollow of coarse facets a cutter that fits the surface stands on their edges.
        let fits = |place: &DrawnPlace| stands_at(workpiece, profile, place, scallop_height + cut_by_fitting(workpiece, place));
        let refused = over.par_iter().with_max_len(AT_ONCE).filter(|station| !fits(&station.place)).count();
        #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
        let [share, refused_share] = [over.len(), refused].map(|count| count as f64 / stations.len().max(1) as f64);
        let height = over.iter().map(|station| station.lift).filter(|lift| lift.is_finite()).fold(0.0, f64::max);
        Self { share, height: Length::computed(height), refused_share }
    }

    fn refusal(&self) -> NotRankedReason {
        NotRankedReason::CannotReach { uncut_share: self.share, uncut_height: self.height }
    }
}

/// The times of the directions asked for: without any, those of every 5 deg and of the part's shape, then of ever nearer ones
/// beside the best.
fn times_by_direction(asked: &Directions, seconds: &(dyn Fn(Angle) -> Option<f64> + Sync)) -> Vec<DirectionTime> {
    let all = |angles: Vec<Angle>| -> Vec<DirectionTime> { angles.into_par_iter().map(|angle| (angle, seconds(angle))).collect() };
    let beside = match asked {
        Directions::Only(only) => return all(only.clone()),
        Directions::All { beside } => beside,
    };
    let coarse = (0..36).map(|step| Angle::from_radians((5.0 * f64::from(step)).to_radians()));
    let mut times = all(apart_from(&[], beside.iter().copied().chain(coarse)));
    for step in [2.5_f64, 1.0, 0.5] {
        let mut best: Vec<(Angle, f64)> = times.iter().filter_map(|&(angle, seconds)| Some((angle, seconds?))).collect();
        best.sort_by(|a, b| a.1.total_cmp(&b.1));
        best.truncate(MOST_MILLED);
        let beside = best
            .into_iter()
            .flat_map(|(angle, _)| [-step, step].map(|by| Angle::from_radians((angle.degrees() + by).rem_euclid(180.0).to_radians())));
        let new = apart_from(&times, beside);
        times.extend(all(new));
    }
    times.sort_by(|a, b| a.0.radians().total_cmp(&b.0.radians()));
    times
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
fn apart_from(tried: &[DirectionTime], more: impl Iterator<Item = Angle>) -> Vec<Angle> {
    let mut new: Vec<Angle> = Vec::new();
    for angle in more {
        let is_new = |other: &Angle| lines_apart(*other, angle) > REPEATED;
        if tried.iter().all(|(other, _)| is_new(other)) && new.iter().all(is_new) {
            new.push(angle);
        }
    }
    new
}

/// The plan by the published method with its own model; `None` if a side is outside the range of lengths.
fn on_rectangle(candidate: &CandidateCutter, settings: &PlanSettings) -> Option<RectanglePlan> {
    let shape = settings.shape.as_ref()?;
    plan_on_rectangle(candidate, shape, settings, Model::Analytic).ok().flatten()
}
