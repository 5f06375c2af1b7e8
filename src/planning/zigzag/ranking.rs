//! All candidates on one surface: each one's fastest plan, checked, in the order of their times.

use super::candidate::CandidateCutter;
use super::check::{Inspector, checked};
use super::confidence::{SurfaceConfidence, SurfaceEvidence};
use super::least_time::least_seconds;
use super::march::Spaced;
use super::plan::{NotRanked, NotRankedReason, SpacingFigures, ZigzagPlan};
use super::prepared::{Prepared, rows_of};
use super::room::{PlanRoom, Room};
use super::search::{TimeOfDirection, fastest, times_by_direction};
use super::settings::ZigzagSettings;
use super::sweep::Sweep;
use super::workpiece::{SurfaceFigures, Workpiece};
use crate::milling::{Cutter, Model};
use crate::planning::{RectanglePlan, plan_on_rectangle};
use crate::quantity::{Length, Speed, Time};
use crate::surface::FinishFacet;
use rayon::prelude::*;

/// All candidates on one surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// The plans, fastest first.
    pub plans: Vec<ZigzagPlan>,
    /// The candidates without a plan.
    pub not_ranked: Vec<NotRanked>,
    /// What was taken of the surface.
    pub surface: SurfaceFigures,
    /// How far to trust the order of the plans; `None` without a plan.
    pub confidence: Option<SurfaceConfidence>,
}

/// The area without a height from which on a cutter is not ranked.
const LARGEST_SHARE_WITHOUT_HEIGHT: f64 = 0.5;

/// Plans zigzag passes for each candidate over the facets and ranks them by time.
///
/// The facets must be visible from above, with n_z > 0; `evidence` holds what the mesh tells beside them.
/// `stop` is asked before each candidate and direction and every 32 planes; `None` as soon as it returns true.
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

/// Why nothing was ranked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoRanking {
    /// `stop` returned true.
    Stopped,
    /// A plan has more planes or runs than there is room for, and would fit a larger room.
    NoRoom,
}

/// The same as [`rank`] with bounds on the size of plans, and thereby on memory. The result does not depend on the room.
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
    // A plan that does not fit ends the others, too.
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
    let workpiece = Workpiece::new(facets, settings.max_slope.cos());
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
    let prepare = |&index: &usize| (!stop()).then(|| Prepared::new(index, &candidates[index], settings, &rows));
    let prepared: Vec<Prepared> = reaching.par_iter().map(prepare).collect::<Option<_>>()?;
    let times = times_by_direction(&workpiece, &prepared, settings, room, stop)?;
    let work: Vec<_> = prepared.iter().zip(times).collect();
    let mut plans = Vec::new();
    // A candidate in work holds all facets in the order of its direction: no more of them at once than there are threads.
    for group in work.chunks(settings.candidates_at_once.clamp(1, rayon::current_num_threads())) {
        let planned: Vec<Result<ZigzagPlan, NotRanked>> = group
            .par_iter()
            .map(|(prepared, times)| {
                let plan = plan(facets, &workpiece, prepared, times, settings, room, stop);
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
    let confidence = SurfaceConfidence::of(&plans, &surface, settings.scallop_height, evidence);
    Some(Ranking { plans, not_ranked, surface, confidence })
}

/// Drops the planes of all plans but the fastest: fifty thousand planes of two hundred cutters would take half a gigabyte.
fn keep_planes_of_fastest(plans: &mut [ZigzagPlan]) {
    let fastest = plans.iter().enumerate().min_by(|(_, a), (_, b)| a.time.seconds().total_cmp(&b.time.seconds())).map(|(index, _)| index);
    plans.iter_mut().enumerate().filter(|(index, _)| Some(*index) != fastest).for_each(|(_, plan)| plan.passes = Vec::new());
}

fn plan(
    facets: &[FinishFacet],
    workpiece: &Workpiece,
    prepared: &Prepared,
    times: &[TimeOfDirection],
    settings: &ZigzagSettings,
    room: &Room,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<ZigzagPlan, NotRankedReason> {
    let best = fastest(times).ok_or(NotRankedReason::NoStepOver)?;
    let cutter = prepared.candidate.cutter;
    let inspector = Inspector::new(facets, prepared, settings);
    // By model `analytic` the spacing is the published one; it is checked, but does not follow.
    let follows = settings.model == Model::Envelope;
    let sweep = Sweep::new(workpiece, best.direction);
    let spaced = Spaced::new(workpiece, &sweep, &prepared.spacing, prepared.diameter(), settings.left_out_share);
    // A plan that was cancelled is discarded with the whole ranking.
    let (simulated, scallop_height) =
        checked(spaced, prepared.operation(settings, room), inspector, follows, stop).map_err(|_| NotRankedReason::NoStepOver)?;
    if scallop_height.without_height_share > LARGEST_SHARE_WITHOUT_HEIGHT {
        return Err(NotRankedReason::NoHeight { share: scallop_height.without_height_share });
    }
    let tour = simulated.figures;
    if tour.runs == 0 {
        return Err(NotRankedReason::NoStepOver);
    }
    let rate = tour.run_length / tour.cutting_seconds;
    let depth = 2.0 * workpiece.top;
    Ok(ZigzagPlan {
        candidate: prepared.index,
        direction: best.direction,
        time: Time::computed(tour.seconds),
        tour,
        planes: simulated.planes.len(),
        step_over: SpacingFigures::of(&simulated.planes),
        feed_rate: Speed::computed(rate),
        feed_per_tooth: prepared.range.map(|range| Length::computed(rate / range.teeth_per_second)),
        scallop_height,
        least_time: Time::computed(least_seconds(workpiece, prepared)),
        by_direction: times.iter().map(|time| (time.direction, time.seconds.map(Time::computed))).collect(),
        reach: prepared.candidate.reach,
        rectangle: on_rectangle(cutter, settings),
        flutes_too_short: prepared.candidate.flute_length.is_some_and(|flutes| flutes.mm() < depth),
        passes: simulated.planes,
    })
}

/// The published method with its own model; sides outside the bounds of lengths give none.
fn on_rectangle(cutter: Cutter, settings: &ZigzagSettings) -> Option<RectanglePlan> {
    let shape = settings.shape.as_ref()?;
    plan_on_rectangle(cutter, shape, settings.scallop_height, settings.machine.limits, Model::Analytic).ok().flatten()
}
