//! The points of a plan's passes in cutting order: contacts, normals, tips and feeds.

use super::candidate::{CandidateCutter, FeedRange};
use super::contacts::FacetContact;
use super::cuts::{Cut, count_of_cuts, cuts_by_plane, runs_of};
use super::links::{End, Links};
use super::march::Plane;
use super::plan::ZigzagPlan;
use super::prepared::{Prepared, rows_of};
use super::regions::{Stretch, in_order};
use super::room::{PlanRoom, Room};
use super::settings::ZigzagSettings;
use super::simulate::Operation;
use super::spaced::Spaced;
use super::sweep::Sweep;
use super::tip_path::{BYTES_AT_ONCE, BYTES_OF_A_LINE, Place, TipPath};
use super::tour::run_time;
use super::workpiece::Workpiece;
use crate::milling::{EvaluatedPass, NoAnswer, ScallopHeight};
use crate::quantity::{Length, Speed, Time};
use crate::surface::FinishFacet;
use rayon::prelude::*;
use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The passes of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Passes {
    /// The index in `points` at which each run begins. A link leads from the end of a run to the start of the next.
    pub run_starts: Vec<usize>,
    /// All points in cutting order.
    pub points: Vec<PassPoint>,
    /// The time of all runs and links along the path of the tips. The time of a plan is that of the contacts, whose
    /// path is shorter if the contact moves over the cutter's bottom or tips are raised.
    pub time: Time,
    /// The largest distance of omitted contacts, and along the normal of omitted tips, from the lines between the ones kept.
    pub chord_tolerance: Length,
}

/// A point of a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassPoint {
    /// The point at which the cutter touches the surface, or the extended plane of a facet beside the pass, in mm; `None`
    /// if the tip is raised because the cutter would gouge the surface elsewhere, and beside such places.
    pub contact: Option<[f64; 3]>,
    /// The unit normal of the surface there.
    pub normal: [f64; 3],
    /// The lowest point of the cutter on its axis, in mm.
    pub tip: [f64; 3],
    /// The step-over to the farther of the neighbouring passes, along the surface.
    pub step_over: Length,
    /// The largest feed per tooth that keeps the scallop height, within the limits of cutter and machine; `None` for
    /// cutters without a drive.
    pub feed_per_tooth: Option<Length>,
    /// The feed rate: that of the feed per tooth; the machine's for cutters without a drive.
    pub feed_rate: Speed,
    /// The scallop height that step-over and feed leave, by the model of the plan; `None` if the model has none.
    pub scallop_height: Option<Length>,
    /// The curvature of the surface along the feed, across it and the mixed one, in 1/mm, positive where convex.
    pub curvature: [f64; 3],
}

/// The passes have more points than allowed, even with the largest chord tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TooManyPoints {
    /// The largest number of points.
    pub limit: usize,
}

impl fmt::Display for TooManyPoints {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the passes need more than {} points", self.limit)
    }
}

impl std::error::Error for TooManyPoints {}

/// The first chord tolerance that is tried, as a share of the scallop height.
const CHORD_SHARE: f64 = 0.1;

/// The largest number of doublings of the chord tolerance, to 0.8 of the scallop height, before the passes count as having
/// too many points.
const DOUBLINGS: u32 = 3;

/// The tolerance of the path of tips, as a share of the scallop height.
const PATH_SHARE: f64 = 0.25;

/// Tips are compared with the surface after this share of the cutter's radius, and at most this often along all runs.
const STEP_SHARE: f64 = 1.0 / 16.0;
const MOST_STEPS: f64 = 300_000.0;

/// A run in the direction of cutting.
struct OrderedRun {
    plane: Plane,
    /// Its cuts, in the direction of the passes.
    cuts: Vec<Cut>,
    /// Whether it is cut in that direction.
    forward: bool,
    /// Its start and its end.
    ends: [End; 2],
}

/// The passes of `plan` with at most `limit` points. `plan` must be a result of [`super::rank`] for the same facets,
/// candidate and settings.
///
/// A point is left out if contact and tip, along the normal, are within the chord tolerance of the lines between their
/// neighbours. The chord tolerance is a tenth of the scallop height, doubled until the points are few enough, at most three times. `raised` takes
/// a tip and returns the lowest height, at least the tip's own, at which the cutter does not cut into the surface. Tips more
/// than half a scallop height below it are raised to it, at the points and between them. Where a straight link on the surface
/// would cut into it, the run before it ends with raised points along the link.
///
/// # Errors
/// [`TooManyPoints`]
pub fn passes(
    plan: &ZigzagPlan,
    facets: &[FinishFacet],
    candidate: &CandidateCutter,
    settings: &ZigzagSettings,
    raised: &(dyn Fn([f64; 3]) -> f64 + Sync),
    limit: usize,
) -> Result<Passes, TooManyPoints> {
    passes_until(plan, facets, candidate, settings, raised, limit, &|| false)
}

/// The same as [`passes`]. Once `stop` returns true, it returns early, and the result must be discarded.
///
/// # Errors
/// [`TooManyPoints`]
pub fn passes_until(
    plan: &ZigzagPlan,
    facets: &[FinishFacet],
    candidate: &CandidateCutter,
    settings: &ZigzagSettings,
    raised: &(dyn Fn([f64; 3]) -> f64 + Sync),
    limit: usize,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Passes, TooManyPoints> {
    let workpiece = Workpiece::new(facets, settings.max_slope.cos(), stop);
    let sweep = Sweep::new(&workpiece, plan.direction, stop);
    let prepared = Prepared::new(plan.candidate, candidate, settings, &rows_of(&workpiece), stop);
    let spaced = Spaced::new(&workpiece, &sweep, prepared.allowance(), settings.left_out_share, stop);
    if stop() {
        return Err(TooManyPoints { limit });
    }
    // The plan exists, so it fits the largest room.
    let room = Room::new(PlanRoom::LARGEST);
    let operation = prepared.operation(settings, &room);
    let runs = runs_in_order(plan, &spaced, operation, stop);
    let height = settings.scallop_height.mm();
    let step = STEP_SHARE * candidate.cutter.outer_radius().mm();
    let mut path = TipPath { facets, spaced: &spaced, cutter: candidate.cutter, raised, step, tolerance: PATH_SHARE * height };
    let length: f64 = runs.par_iter().map(|run| path.length(run.ends[0].place[1], &run.cuts)).sum();
    path.step = step.max(length / MOST_STEPS);
    let mut chord = CHORD_SHARE * height;
    let kept = (0..=DOUBLINGS).find_map(|_| {
        let kept = kept_places(&runs, &path, &operation.links(&spaced), chord, limit, stop);
        if kept.is_none() {
            chord *= 2.0;
        }
        kept
    });
    let kept = kept.ok_or(TooManyPoints { limit })?;
    let source = PointSource { facets, spaced: &spaced, prepared: &prepared, settings };
    let points: Vec<Vec<PassPoint>> = runs
        .par_iter()
        .zip(&kept)
        .map(|(run, kept)| kept.iter().take_while(|_| !stop()).map(|place| source.point(&run.plane, place)).collect())
        .collect();
    let time = time_of_tips(&runs, &points, &spaced, operation);
    let mut run_starts = Vec::with_capacity(points.len());
    let mut next = 0;
    for run in &points {
        run_starts.push(next);
        next += run.len();
    }
    Ok(Passes { run_starts, points: points.into_iter().flatten().collect(), time, chord_tolerance: Length::computed(chord) })
}

/// The places of all runs that are kept with a chord tolerance, each in the direction of cutting, with those of the links after
/// them; `None` if they are more than `limit`.
fn kept_places(
    runs: &[OrderedRun],
    path: &TipPath,
    links: &Links,
    chord: f64,
    limit: usize,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Vec<Place>>> {
    let count = AtomicUsize::new(0);
    let counted = |places: Vec<Place>| {
        count.fetch_add(places.len(), Ordering::Relaxed);
        places
    };
    let is_over = || stop() || count.load(Ordering::Relaxed) > limit;
    let of_run = |run: &OrderedRun| {
        if is_over() {
            return Vec::new();
        }
        let mut places = path.over(run.ends[0].place[1], &run.cuts, chord, stop);
        if !run.forward {
            places.reverse();
        }
        counted(places)
    };
    let mut kept: Vec<Vec<Place>> = runs.par_iter().map(of_run).collect();
    let of_link = |index: usize| {
        let [from, to] = [kept[index].last()?, kept[index + 1].first()?];
        let ends = [end_at(path.spaced, runs[index].ends[1], from.tip), end_at(path.spaced, runs[index + 1].ends[0], to.tip)];
        if is_over() || links.between(ends[0], ends[1]).is_lift {
            return None;
        }
        let mut places = path.thinned(&path.raise(&[from, to].map(|place| Place { is_contact: false, ..*place })), chord, stop);
        // Both ends belong to the runs.
        places.pop();
        Some(counted(places.split_off(1)))
    };
    let of_links: Vec<Option<Vec<Place>>> = (0..kept.len().saturating_sub(1)).into_par_iter().map(of_link).collect();
    for (places, of_link) in kept.iter_mut().zip(of_links) {
        places.extend(of_link.into_iter().flatten());
    }
    (count.into_inner() <= limit).then_some(kept)
}

/// The memory in bytes of [`passes`] with at most `limit` points, in addition to the memory of ranking a candidate: the cuts
/// of all planes, the places that are kept, and the points.
#[must_use]
pub fn bytes_of_passes(plan: &ZigzagPlan, facets: &[FinishFacet], limit: usize) -> usize {
    let at_once = rayon::current_num_threads() * BYTES_AT_ONCE;
    // A growing vector has two copies of the cuts; the tip moves over a line for each.
    let cuts = count_of_cuts(plan, facets) * (2 * size_of::<Cut>() + BYTES_OF_A_LINE);
    cuts + at_once + plan.passes.len() * BYTES_OF_A_PLANE + limit * (2 * size_of::<Place>() + BYTES_OF_A_POINT)
}

/// The vectors of a plane: its cuts, its runs, their places.
const BYTES_OF_A_PLANE: usize = 512;

/// A point, its copy in cutting order, and its figures in columns and as text.
const BYTES_OF_A_POINT: usize = 1000;

/// The runs of all planes with their cuts, in the order of cutting.
fn runs_in_order(plan: &ZigzagPlan, spaced: &Spaced, operation: Operation, stop: &(dyn Fn() -> bool + Sync)) -> Vec<OrderedRun> {
    let by_plane = cuts_by_plane(plan, spaced, stop);
    let of_plane = |(number, (plane, cuts)): (usize, (&Plane, Vec<Cut>))| runs_of(number, plane.at, cuts, spaced);
    let runs: Vec<(Stretch, Vec<Cut>)> = plan.passes.par_iter().zip(by_plane).enumerate().flat_map_iter(of_plane).collect();
    let (stretches, mut cuts): (Vec<Stretch>, Vec<Vec<Cut>>) = runs.into_iter().unzip();
    let ordered = in_order(&stretches, operation.pattern, &operation.links(spaced)).into_iter().map(|leg| {
        let stretch = stretches[leg.run];
        let ends = [!leg.forward, leg.forward].map(|is_upper| stretch.end(usize::from(is_upper)));
        OrderedRun { plane: plan.passes[stretch.plane], cuts: std::mem::take(&mut cuts[leg.run]), forward: leg.forward, ends }
    });
    ordered.collect()
}

/// The time of all runs and links along the tips. Each run has the mean of its points' feed rates, as in
/// [`TourFigures`](super::TourFigures) along the contacts.
fn time_of_tips(runs: &[OrderedRun], points: &[Vec<PassPoint>], spaced: &Spaced, operation: Operation) -> Time {
    let links = operation.links(spaced);
    let (mut total, mut last) = (0.0, None);
    for (run, points) in runs.iter().zip(points) {
        let (Some(first), Some(end)) = (points.first(), points.last()) else { continue };
        if let Some(last) = last {
            total += links.between(last, end_at(spaced, run.ends[0], first.tip)).seconds;
        }
        let (mut length, mut seconds) = (0.0, 0.0);
        for pair in points.windows(2) {
            let part = (0..3).map(|axis| (pair[1].tip[axis] - pair[0].tip[axis]).powi(2)).sum::<f64>().sqrt();
            length += part;
            seconds += 0.5 * part * (pair[0].feed_rate.mm_s().recip() + pair[1].feed_rate.mm_s().recip());
        }
        if seconds > 0.0 {
            total += run_time(length, seconds, operation.machine);
        }
        last = Some(end_at(spaced, run.ends[1], end.tip));
    }
    Time::computed(total)
}

/// The end of a run, with the tip in place of the contact.
fn end_at(spaced: &Spaced, end: End, tip: [f64; 3]) -> End {
    let (heading, origin) = (spaced.sweep.heading, spaced.workpiece.origin);
    let [x, y, z] = [0, 1, 2].map(|axis| tip[axis] - origin[axis]);
    End { place: [heading.along(x, y), heading.across(x, y), z], ..end }
}

/// The plan's facets, spacings, candidate and settings, from which its points are computed.
struct PointSource<'a> {
    facets: &'a [FinishFacet],
    spaced: &'a Spaced<'a>,
    prepared: &'a Prepared,
    settings: &'a ZigzagSettings,
}

impl PointSource<'_> {
    fn point(&self, plane: &Plane, place: &Place) -> PassPoint {
        let Place { facet, contact, tip, is_contact } = *place;
        let (e, index) = (self.spaced.sweep.heading.e, facet as usize);
        let tangent = &self.spaced.workpiece.tangents[index];
        let (cos_alpha, _) = tangent.alpha(e);
        let spacing = plane.spacing();
        let mut step_over = spacing / tangent.ratio_squared(cos_alpha).sqrt();
        // The feed of the plan, which is used if the model has no answer.
        let planned = self.prepared.feeds.rate(tangent, cos_alpha, spacing * spacing / self.spaced.squared(index));
        let range = self.prepared.range;
        let mut feed = range.map(|range| planned / range.teeth_per_second);
        let (mut curvature, mut height) = ([0.0; 3], None);
        if let Ok(of_facet) = FacetContact::new(&self.facets[index], e) {
            curvature = of_facet.curvature;
            step_over = of_facet.step_over(spacing);
            if let Ok(evaluated) = of_facet.evaluated(self.prepared.candidate.cutter, self.settings.model) {
                feed = range.and_then(|range| self.largest_feed(&evaluated, step_over, range)).or(feed);
                height = evaluated.scallop_height(Length::computed(step_over), feed.map(Length::computed)).ok().map(ScallopHeight::total);
            }
        }
        let rate = range.zip(feed).map_or(planned, |(range, feed)| range.rate(feed));
        PassPoint {
            contact: is_contact.then_some(contact),
            normal: self.facets[index].normal,
            tip,
            step_over: Length::computed(step_over),
            feed_per_tooth: feed.map(Length::computed),
            feed_rate: Speed::computed(rate),
            scallop_height: height,
            curvature,
        }
    }

    /// The largest feed per tooth within the range that keeps the scallop height; `None` if the step-over alone uses up
    /// the scallop height.
    fn largest_feed(&self, evaluated: &EvaluatedPass, step_over: f64, range: FeedRange) -> Option<f64> {
        // The range limits most feeds; evaluating one height shows this without a search.
        let tolerance = self.settings.scallop_height;
        let at_largest = evaluated.scallop_height(Length::computed(step_over), Some(Length::computed(range.largest)));
        if at_largest.is_ok_and(|height| height.total() <= tolerance) {
            return Some(range.largest);
        }
        match evaluated.max_feed_per_tooth(tolerance, Length::computed(step_over)) {
            Ok(feed) => Some(feed.mm().min(range.largest)),
            Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth }) => Some(largest_feed_per_tooth.mm().min(range.largest)),
            Err(_) => None,
        }
    }
}
