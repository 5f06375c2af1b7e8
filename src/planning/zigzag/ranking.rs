//! The ranking of all candidates on a surface: the fastest plan of each after the check, sorted by time.

use super::candidate::CandidateCutter;
use super::check::{ScallopFigures, checked};
use super::confidence::{SurfaceEvidence, SurfaceWeakness};
use super::inspector::Inspector;
use super::least_time::least_seconds;
use super::march::NoPlanes;
use super::plan::{NotRanked, NotRankedReason, SpacingFigures, ZigzagPlan};
use super::prepared::{Prepared, rows_of};
use super::room::{PlanRoom, Room};
use super::search::{TimeOfDirection, fastest, times_by_direction};
use super::settings::ZigzagSettings;
use super::simulate::Simulated;
use super::spaced::Spaced;
use super::sweep::Sweep;
use super::workpiece::{SurfaceFigures, Workpiece};
use crate::milling::{Cutter, Model};
use crate::planning::{Confidence, RectanglePlan, plan_on_rectangle};
use crate::quantity::{Angle, Length, Speed, Time};
use crate::surface::FinishFacet;
use rayon::prelude::*;

/// The plans of all candidates on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// The plans, fastest first.
    pub plans: Vec<ZigzagPlan>,
    /// The candidates without a plan.
    pub not_ranked: Vec<NotRanked>,
    /// The figures of the surface.
    pub surface: SurfaceFigures,
    /// The confidence in the order of the plans; `None` without a plan.
    pub confidence: Option<Confidence<SurfaceWeakness>>,
}

/// A cutter with more than this share of the area without a height is not ranked.
const LARGEST_SHARE_WITHOUT_HEIGHT: f64 = 0.5;

/// Plans zigzag passes for each candidate over the facets and ranks them by time.
///
/// The facets must be visible from above, with n_z > 0; `evidence` has the properties of the mesh that the facets do
/// not show. `stop` is called about every millisecond, by all threads. The result is `None` soon after it returns true.
#[must_use]
pub fn rank(
    facets: &[FinishFacet],
    candidates: &[CandidateCutter],
    settings: &ZigzagSettings,
    evidence: SurfaceEvidence,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Ranking> {
    rank_within(facets, candidates, settings, evidence, PlanRoom::LARGEST, stop).ok()
}

/// The reason why nothing was ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoRanking {
    /// `stop` returned true.
    Stopped,
    /// A plan needs more planes or runs than the room has, but fewer than a larger room has.
    NoRoom,
}

/// The same as [`rank`] with limits on the size of plans, and so on memory. A result does not depend on the limits.
///
/// # Errors
/// [`NoRanking`]
pub fn rank_within(
    facets: &[FinishFacet],
    candidates: &[CandidateCutter],
    settings: &ZigzagSettings,
    evidence: SurfaceEvidence,
    room: PlanRoom,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Ranking, NoRanking> {
    let room = Room::new(room);
    // A plan that does not fit ends the whole ranking.
    let ranking = ranked(facets, candidates, settings, evidence, &room, &|| room.is_exceeded() || stop());
    ranking.ok_or(if room.is_exceeded() { NoRanking::NoRoom } else { NoRanking::Stopped })
}

fn ranked(
    facets: &[FinishFacet],
    candidates: &[CandidateCutter],
    settings: &ZigzagSettings,
    evidence: SurfaceEvidence,
    room: &Room,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Ranking> {
    let workpiece = Workpiece::new(facets, settings.max_slope.cos(), stop);
    let surface = workpiece.figures();
    let mut not_ranked = Vec::new();
    let mut reaching = Vec::new();
    for (candidate, cutter) in candidates.iter().enumerate() {
        match cutter.reach.filter(|reach| reach.uncut_share > settings.max_uncut_share) {
            Some(reach) => not_ranked.push(NotRanked { candidate, reason: NotRankedReason::CannotReach(reach) }),
            None => reaching.push(candidate),
        }
    }
    let rows = rows_of(&workpiece);
    let prepare = |&index: &usize| (!stop()).then(|| Prepared::new(index, &candidates[index], settings, &rows, stop));
    let prepared: Vec<Prepared> = reaching.par_iter().map(prepare).collect::<Option<_>>()?;
    let times = times_by_direction(&workpiece, &prepared, settings, room, stop)?;
    let work: Vec<_> = prepared.iter().zip(times).collect();
    let planner = Planner { facets, workpiece: &workpiece, settings, room, stop };
    let mut plans = Vec::new();
    // Each candidate in progress stores all facets in the order of its direction. More candidates at once than threads
    // would only take memory.
    for group in work.chunks(settings.candidates_at_once.clamp(1, rayon::current_num_threads())) {
        let planned: Vec<Result<ZigzagPlan, NotRanked>> = group
            .par_iter()
            .map(|(prepared, times)| {
                let plan = planner.plan(prepared, times);
                plan.map_err(|reason| NotRanked { candidate: prepared.index, reason })
            })
            .collect();
        if stop() {
            return None;
        }
        for planned in planned {
            match planned {
                Ok(plan) => plans.push(plan),
                Err(reason) => not_ranked.push(reason),
            }
        }
        keep_planes_of_fastest(&mut plans);
    }
    plans.sort_by(|a, b| a.time.seconds().total_cmp(&b.time.seconds()));
    not_ranked.sort_by_key(|not_ranked| not_ranked.candidate);
    let confidence = Confidence::of(&plans, &surface, settings.scallop_height, evidence);
    Some(Ranking { plans, not_ranked, surface, confidence })
}

/// Drops the planes and slivers of all plans except the fastest: fifty thousand planes of two hundred cutters would take
/// half a gigabyte.
fn keep_planes_of_fastest(plans: &mut [ZigzagPlan]) {
    let fastest = plans.iter().enumerate().min_by(|(_, a), (_, b)| a.time.seconds().total_cmp(&b.time.seconds())).map(|(index, _)| index);
    for (_, plan) in plans.iter_mut().enumerate().filter(|(index, _)| Some(*index) != fastest) {
        (plan.passes, plan.slivers) = (Vec::new(), Vec::new());
    }
}

/// The largest number of directions in which the plan of a candidate is checked.
const MOST_CHECKED: usize = 3;

/// A direction is checked after the fastest one only if its time before the check is shorter by more than this factor:
/// less is within the error of these times.
const LEAST_GAIN: f64 = 1.005;

/// The smallest angle between checked directions, in deg. Directions nearer to each other have nearly the same
/// spacings.
const CHECKED_APART: f64 = 5.0;

/// The zigzag of one direction after its check.
struct CheckedPlan {
    direction: Angle,
    simulated: Simulated,
    scallop_height: ScallopFigures,
}

/// The data that the plans of all candidates share.
#[derive(Clone, Copy)]
struct Planner<'a> {
    facets: &'a [FinishFacet],
    workpiece: &'a Workpiece,
    settings: &'a ZigzagSettings,
    room: &'a Room,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl Planner<'_> {
    /// The plan of a candidate in its fastest direction.
    fn plan(&self, prepared: &Prepared, times: &[TimeOfDirection]) -> Result<ZigzagPlan, NotRankedReason> {
        let Self { workpiece, settings, .. } = *self;
        let cutter = prepared.candidate.cutter;
        let (best, times) = self.fastest_checked(prepared, times)?;
        let CheckedPlan { direction, simulated, scallop_height } = best;
        if scallop_height.without_height_share > LARGEST_SHARE_WITHOUT_HEIGHT {
            return Err(NotRankedReason::NoHeight { share: scallop_height.without_height_share });
        }
        let tour = simulated.figures;
        // The rounding of the sums may carry the mean over the machine's limit.
        let rate = (tour.run_length / tour.cutting_seconds).min(settings.machine.limits.feed_rate.mm_s());
        let depth = 2.0 * workpiece.top;
        Ok(ZigzagPlan {
            candidate: prepared.index,
            direction,
            time: Time::computed(tour.seconds),
            tour,
            planes: simulated.planes.len(),
            step_over: SpacingFigures::of(&simulated.planes),
            feed_rate: Speed::computed(rate),
            feed_per_tooth: prepared.range.map(|range| Length::computed(rate / range.teeth_per_second)),
            scallop_height,
            least_time: Time::computed(least_seconds(workpiece, prepared)),
            by_direction: times.iter().map(|time| (time.direction, time.seconds.ok().map(Time::computed))).collect(),
            reach: prepared.candidate.reach,
            rectangle: on_rectangle(cutter, settings),
            flutes_too_short: prepared.candidate.flute_length.is_some_and(|flutes| flutes.mm() < depth),
            slivers: simulated.slivers,
            passes: simulated.planes,
        })
    }

    /// The fastest zigzag of a candidate after the check, and the times of all directions. The times that were not
    /// checked are multiplied by the factor by which the check changed the fastest one.
    ///
    /// The check changes the spacing, so that the fastest direction may become slower than another. Directions whose
    /// time before the check is clearly less than the fastest after it are therefore checked as well.
    fn fastest_checked(
        &self,
        prepared: &Prepared,
        times: &[TimeOfDirection],
    ) -> Result<(CheckedPlan, Vec<TimeOfDirection>), NotRankedReason> {
        let Self { facets, workpiece, settings, room, stop } = *self;
        let inspector = Inspector::new(facets, prepared, settings, stop);
        // With model `analytic` the spacing is the published one: it is checked, but not corrected.
        let follows = settings.model == Model::Envelope;
        let mut best: Option<CheckedPlan> = None;
        let mut reason =
            times.iter().filter_map(|time| time.seconds.err()).max().map_or(NotRankedReason::NoStepOver, NotRankedReason::from);
        let mut checked_times: Vec<TimeOfDirection> = Vec::new();
        let mut factor = None;
        while checked_times.len() < MOST_CHECKED {
            let is_open =
                |time: &&TimeOfDirection| checked_times.iter().all(|other| lines_apart(other.direction, time.direction) >= CHECKED_APART);
            let open: Vec<TimeOfDirection> = times.iter().filter(is_open).copied().collect();
            let Some(next) = fastest(&open) else { break };
            if best.as_ref().zip(next.seconds.ok()).is_some_and(|(best, seconds)| LEAST_GAIN * seconds >= best.simulated.figures.seconds) {
                break;
            }
            let sweep = Sweep::new(workpiece, next.direction, stop);
            let spaced = Spaced::new(workpiece, &sweep, prepared.allowance(), settings.left_out_share, stop);
            let seconds = match checked(spaced, prepared.operation(settings, room), inspector, follows, stop) {
                Ok((simulated, scallop_height)) if simulated.figures.runs > 0 => {
                    let seconds = simulated.figures.seconds;
                    if best.as_ref().is_none_or(|best| seconds < best.simulated.figures.seconds) {
                        best = Some(CheckedPlan { direction: next.direction, simulated, scallop_height });
                    }
                    factor = factor.or(next.seconds.ok().map(|before| seconds / before));
                    Ok(seconds)
                }
                Ok(_) => Err(NoPlanes::NoSpacing),
                Err(error) => {
                    reason = error.into();
                    Err(error)
                }
            };
            checked_times.push(TimeOfDirection { seconds, ..next });
        }
        let after = |time: &TimeOfDirection| {
            let checked = checked_times.iter().find(|checked| checked.direction == time.direction);
            checked.copied().unwrap_or(TimeOfDirection { seconds: time.seconds.map(|seconds| seconds * factor.unwrap_or(1.0)), ..*time })
        };
        best.map(|best| (best, times.iter().map(after).collect())).ok_or(reason)
    }
}

/// The angle between two lines, in deg.
fn lines_apart(one: Angle, other: Angle) -> f64 {
    let apart = (one.degrees() - other.degrees()).abs();
    apart.min(180.0 - apart)
}

/// The plan by the published method with its own model; `None` if a side is outside the range of lengths.
fn on_rectangle(cutter: Cutter, settings: &ZigzagSettings) -> Option<RectanglePlan> {
    let shape = settings.shape.as_ref()?;
    plan_on_rectangle(cutter, shape, settings.scallop_height, settings.machine.limits, Model::Analytic).ok().flatten()
}
