//! All candidates on one surface: each one's fastest plan, checked, in the order of their times.

use super::candidate::{CandidateCutter, FeedRange, ReachFigures};
use super::check::{Inspector, ScallopFigures, checked};
use super::confidence::{SurfaceConfidence, SurfaceEvidence};
use super::least_time::least_seconds;
use super::march::{MOST_PLANES, Plane, Spaced};
use super::search::{Contender, TimeOfDirection, fastest, times_by_direction};
use super::settings::ZigzagSettings;
use super::simulate::Operation;
use super::slopes::sines;
use super::spacing::{CutterSpacing, FeedLaw};
use super::sweep::Sweep;
use super::tour::TourFigures;
use super::workpiece::Workpiece;
use crate::milling::{Cutter, Model};
use crate::planning::{RectanglePlan, plan_on_rectangle};
use crate::quantity::{Angle, Area, Length, Speed, Time};
use crate::surface::FinishFacet;
use rayon::prelude::*;
use std::fmt;

/// The plan of one candidate: zigzag in its fastest direction.
#[derive(Debug, Clone, PartialEq)]
pub struct ZigzagPlan {
    /// The place of the cutter among the candidates.
    pub candidate: usize,
    /// The line of the passes seen from above, in [0, pi) from X unless it was stated otherwise.
    pub direction: Angle,
    /// The time of all runs and links.
    pub time: Time,
    /// Runs, links and their lengths.
    pub tour: TourFigures,
    /// The number of planes in which the passes lie.
    pub planes: usize,
    /// The spacing of the planes, seen from above.
    pub step_over: SpacingFigures,
    /// The mean feed rate of the runs: their length over the time they would take without stops.
    pub feed_rate: Speed,
    /// The mean feed per tooth, for cutters with a drive.
    pub feed_per_tooth: Option<Length>,
    /// The scallop height over the area.
    pub scallop_height: ScallopFigures,
    /// A bound from below: no zigzag that keeps the scallop height is faster.
    pub least_time: Time,
    /// The time of each direction that was tried, in s, before the check; `None` where no spacing keeps the scallop height.
    pub by_direction: Vec<(Angle, Option<Time>)>,
    /// What the cutter cannot reach.
    pub reach: Option<ReachFigures>,
    /// The same cutter on the rectangle of the published method, for comparison; `None` without a shape or a step-over there.
    pub rectangle: Option<RectanglePlan>,
    /// Whether the flutes are shorter than the surface is deep.
    pub flutes_too_short: bool,
    pub(super) passes: Vec<Plane>,
}

impl ZigzagPlan {
    /// The length of all runs and links.
    #[must_use]
    pub fn path_length(&self) -> Length {
        Length::computed(self.tour.run_length + self.tour.link_length)
    }
}

/// Spacings of planes, seen from above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpacingFigures {
    /// The smallest.
    pub min: Length,
    /// The median.
    pub median: Length,
    /// The largest.
    pub max: Length,
}

impl SpacingFigures {
    fn of(planes: &[Plane]) -> Self {
        let mut spacings: Vec<f64> = planes.iter().map(|plane| plane.after).collect();
        spacings.sort_by(f64::total_cmp);
        let at = |index: usize| Length::computed(spacings.get(index).copied().unwrap_or(0.0));
        Self { min: at(0), median: at(spacings.len() / 2), max: at(spacings.len().saturating_sub(1)) }
    }
}

/// A candidate without a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NotRanked {
    /// The place of the cutter among the candidates.
    pub candidate: usize,
    /// Why it has no plan.
    pub reason: NotRankedReason,
}

/// Why a candidate has no plan.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum NotRankedReason {
    /// The cutter leaves more of the area uncut than allowed.
    CannotReach(ReachFigures),
    /// In every direction some slope of the surface has no step-over that keeps the scallop height, or one so small that there would be more
    /// than 50,000 passes.
    NoStepOver,
    /// The cutter gouges the surface beside the contact, or leaves uncut material between its passes, on so much of the area: with its flat end it has no
    /// passes there.
    NoHeight {
        /// The share of the area.
        share: f64,
    },
}

impl fmt::Display for NotRankedReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CannotReach(reach) => write!(
                f,
                "the cutter does not reach {:.2} % of the area and leaves up to {:.4} mm there",
                100.0 * reach.uncut_share,
                reach.uncut_height.mm()
            ),
            Self::NoStepOver => write!(f, "in no direction do {MOST_PLANES} passes or fewer keep the scallop height"),
            Self::NoHeight { share } => {
                write!(f, "the cutter gouges the surface beside its contacts on {:.1} % of the area", 100.0 * share)
            }
        }
    }
}

/// What the simulation takes of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFigures {
    /// The area of all facets.
    pub area: Area,
    /// The mean slope over the area.
    pub mean_slope: Angle,
    /// The share of the area that is steeper than the largest slope and sets no spacing.
    pub steep_area_share: f64,
    /// The edge length of a square of the mean facet's area: two triangles to a square of it are as many facets.
    pub facet_size: Length,
    /// How far facets of that size lie from the surface, by the mean of its curvature over the area: k size^2 / 8.
    pub sagitta: Length,
}

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
#[must_use]
pub fn rank(facets: &[FinishFacet], candidates: &[CandidateCutter], settings: &ZigzagSettings, evidence: SurfaceEvidence) -> Ranking {
    let workpiece = Workpiece::new(facets, settings.max_slope.cos());
    let surface = surface_figures(&workpiece);
    let mut not_ranked = Vec::new();
    let mut reaching = Vec::new();
    for (candidate, cutter) in candidates.iter().enumerate() {
        match cutter.reach.filter(|reach| reach.uncut_share > settings.max_uncut_share) {
            Some(reach) => not_ranked.push(NotRanked { candidate, reason: NotRankedReason::CannotReach(reach) }),
            None => reaching.push(candidate),
        }
    }
    let rows = rows_of(&workpiece);
    let prepared: Vec<Prepared> = reaching.par_iter().map(|&index| Prepared::new(index, &candidates[index], settings, &rows)).collect();
    let contenders: Vec<Contender> = prepared.iter().map(|prepared| prepared.contender(settings)).collect();
    let times = times_by_direction(&workpiece, &contenders, &settings.directions, settings.left_out_share);
    let work: Vec<_> = prepared.iter().zip(&contenders).zip(times).collect();
    let mut plans = Vec::new();
    // A candidate in work holds all facets in the order of its direction: no more of them at once than there are threads.
    for group in work.chunks(settings.candidates_at_once.clamp(1, rayon::current_num_threads())) {
        let planned: Vec<Result<ZigzagPlan, NotRanked>> = group
            .par_iter()
            .map(|((prepared, contender), times)| {
                let plan = plan(facets, &workpiece, prepared, contender, times, settings);
                plan.map_err(|reason| NotRanked { candidate: prepared.index, reason })
            })
            .collect();
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
    Ranking { plans, not_ranked, surface, confidence }
}

/// Drops the planes of all plans but the fastest: fifty thousand planes of two hundred cutters would take half a gigabyte.
fn keep_planes_of_fastest(plans: &mut [ZigzagPlan]) {
    let fastest = plans.iter().enumerate().min_by(|(_, a), (_, b)| a.time.seconds().total_cmp(&b.time.seconds())).map(|(index, _)| index);
    plans.iter_mut().enumerate().filter(|(index, _)| Some(*index) != fastest).for_each(|(_, plan)| plan.passes = Vec::new());
}

/// A candidate with its spacings.
#[derive(Debug)]
pub(super) struct Prepared {
    pub(super) index: usize,
    pub(super) candidate: CandidateCutter,
    pub(super) spacing: CutterSpacing,
    pub(super) feeds: FeedLaw,
    pub(super) range: Option<FeedRange>,
    /// The feed rate of links on the surface, in mm/s.
    link_rate: f64,
}

impl Prepared {
    pub(super) fn new(index: usize, candidate: &CandidateCutter, settings: &ZigzagSettings, rows: &[bool]) -> Self {
        let feed_rate = settings.machine.limits.feed_rate.mm_s();
        let range = candidate.drive.map(|drive| FeedRange::of(drive, &settings.machine));
        let (spacing, feeds) = CutterSpacing::new(candidate.cutter, settings.scallop_height, settings.model, range, rows, feed_rate);
        let link_rate = range.map_or(feed_rate, |range| range.rate(range.largest));
        Self { index, candidate: *candidate, spacing, feeds, range, link_rate }
    }

    pub(super) fn diameter(&self) -> f64 {
        2.0 * self.candidate.cutter.outer_radius().mm()
    }

    fn contender<'a>(&'a self, settings: &'a ZigzagSettings) -> Contender<'a> {
        let operation = Operation { machine: &settings.machine, pattern: settings.pattern, feeds: &self.feeds, link_rate: self.link_rate };
        Contender { spacing: &self.spacing, operation, diameter: self.diameter() }
    }
}

/// Which rows of the tables the slopes of the workpiece need.
pub(super) fn rows_of(workpiece: &Workpiece) -> Vec<bool> {
    let mut rows = vec![false; sines().len()];
    for tangent in &workpiece.tangents {
        let row = tangent.place.row as usize;
        rows[row] = true;
        rows[row + 1] = true;
    }
    rows
}

fn plan(
    facets: &[FinishFacet],
    workpiece: &Workpiece,
    prepared: &Prepared,
    contender: &Contender,
    times: &[TimeOfDirection],
    settings: &ZigzagSettings,
) -> Result<ZigzagPlan, NotRankedReason> {
    let best = fastest(times).ok_or(NotRankedReason::NoStepOver)?;
    let cutter = prepared.candidate.cutter;
    let inspector = Inspector::new(facets, prepared, settings);
    // By model `analytic` the spacing is the published one; it is checked, but does not follow.
    let follows = settings.model == Model::Envelope;
    let sweep = Sweep::new(workpiece, best.direction);
    let spaced = Spaced::new(workpiece, &sweep, contender.spacing, contender.diameter, settings.left_out_share);
    let (simulated, scallop_height) = checked(spaced, contender.operation, inspector, follows).map_err(|_| NotRankedReason::NoStepOver)?;
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

fn surface_figures(workpiece: &Workpiece) -> SurfaceFigures {
    let (mut slopes, mut steep, mut curvature) = (0.0, 0.0, 0.0);
    for (tangent, area) in workpiece.tangents.iter().zip(&workpiece.areas) {
        slopes += area * tangent.sin.atan2(tangent.cos);
        let [steepest, twist, level] = tangent.curvature;
        curvature += area * steepest.hypot(level).hypot(std::f64::consts::SQRT_2 * twist);
        steep += if tangent.is_steep { *area } else { 0.0 };
    }
    let area = workpiece.area;
    let of_area = |sum: f64| if area > 0.0 { sum / area } else { 0.0 };
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let count = workpiece.len().max(1) as f64;
    SurfaceFigures {
        area: Area::computed(area),
        mean_slope: Angle::from_radians(of_area(slopes)),
        steep_area_share: of_area(steep),
        facet_size: Length::computed((2.0 * area / count).sqrt()),
        sagitta: Length::computed(of_area(curvature) * 2.0 * area / count / 8.0),
    }
}
