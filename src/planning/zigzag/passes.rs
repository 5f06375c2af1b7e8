//! The points of a plan's passes in cutting order: contacts, normals, tips and feeds.

use super::candidate::{CandidateCutter, FeedRange};
use super::contacts::FacetContact;
use super::links::End;
use super::march::Plane;
use super::plan::ZigzagPlan;
use super::prepared::{Prepared, rows_of};
use super::regions::{Stretch, in_order};
use super::room::{PlanRoom, Room};
use super::settings::ZigzagSettings;
use super::simulate::Operation;
use super::spaced::Spaced;
use super::sweep::{Heading, Slice, Sweep};
use super::tour::run_time;
use super::workpiece::Workpiece;
use crate::milling::{Cutter, EvaluatedPass, NoAnswer, ScallopHeight};
use crate::planning::reach::tip_of;
use crate::quantity::{Length, Speed, Time};
use crate::surface::FinishFacet;
use rayon::prelude::*;
use std::fmt;

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
    /// The largest distance of omitted contacts and tips from the lines between the ones kept.
    pub chord_tolerance: Length,
}

/// A point of a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassPoint {
    /// The point at which the cutter touches the surface, or the extended plane of a facet beside the pass, in mm; `None`
    /// if the tip is raised because the cutter would gouge the surface elsewhere.
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

/// The largest number of doublings of the chord tolerance, to about a thousand times, before the passes count as having
/// too many points.
const DOUBLINGS: u32 = 10;

/// A tip is raised if it is deeper below the height at which the cutter rests than this share of the scallop height.
const SUNK_SHARE: f64 = 0.5;

/// A run in the direction of cutting.
struct OrderedRun {
    plane: Plane,
    places: Vec<Place>,
    /// Its start and its end.
    ends: [End; 2],
}

/// A point of a pass before points are left out.
#[derive(Debug, Clone, Copy)]
struct Place {
    facet: u32,
    contact: [f64; 3],
    tip: [f64; 3],
}

/// The passes of `plan` with at most `limit` points. `plan` must be a result of [`super::rank`] for the same facets,
/// candidate and settings.
///
/// There is a contact at the middle of each facet's cut and at the ends of runs. A point is left out if contact and tip
/// are within the chord tolerance of the lines between their neighbours. The chord tolerance is a tenth of the scallop
/// height, doubled until the points are few enough. `raised` takes a tip and returns the lowest height, at least the
/// tip's own, at which the cutter does not cut into the surface. Tips more than half a scallop height below it are
/// raised to it.
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
    let runs = runs_in_order(plan, facets, &spaced, prepared.operation(settings, &room), candidate.cutter, stop);
    let mut chord = CHORD_SHARE * settings.scallop_height.mm();
    let kept = (0..=DOUBLINGS).find_map(|_| {
        let kept: Vec<Vec<usize>> = runs.par_iter().map(|run| thinned(&run.places, chord, stop)).collect();
        let fits = kept.iter().map(Vec::len).sum::<usize>() <= limit;
        if !fits {
            chord *= 2.0;
        }
        fits.then_some(kept)
    });
    let kept = kept.ok_or(TooManyPoints { limit })?;
    let source = PointSource { facets, spaced: &spaced, prepared: &prepared, settings, raised };
    let points: Vec<Vec<PassPoint>> = runs
        .par_iter()
        .zip(&kept)
        .map(|(run, kept)| kept.iter().take_while(|_| !stop()).map(|&index| source.point(&run.plane, run.places[index])).collect())
        .collect();
    let time = time_of_tips(&runs, &points, &spaced, prepared.operation(settings, &room));
    let mut run_starts = Vec::with_capacity(points.len());
    let mut next = 0;
    for run in &points {
        run_starts.push(next);
        next += run.len();
    }
    Ok(Passes { run_starts, points: points.into_iter().flatten().collect(), time, chord_tolerance: Length::computed(chord) })
}

/// The memory in bytes of [`passes`] with at most `limit` points, in addition to the memory of ranking a candidate: the
/// points of all planes before and after thinning.
#[must_use]
pub fn bytes_of_passes(plan: &ZigzagPlan, facets: &[FinishFacet], limit: usize) -> usize {
    let heading = Heading::new(plan.direction);
    let crossed = |facet: &FinishFacet| {
        let across = facet.corners.map(|[x, y, _]| heading.across(x, y));
        let before = |at: f64| plan.passes.partition_point(|plane| plane.at < at);
        before(across.into_iter().fold(f64::NEG_INFINITY, f64::max)) - before(across.into_iter().fold(f64::INFINITY, f64::min))
    };
    let cuts: usize = facets.par_iter().with_min_len(4096).map(crossed).sum();
    // A run has one place for each cut and two for its ends. The simulation joins over slightly wider gaps, so that it
    // has fewer runs: up to twice as many are counted here. The cuts of a plane are dropped before its places are
    // stored.
    let cuts = cuts + plan.slivers.len();
    let places = cuts + (2 * cuts).min(4 * plan.tour.runs);
    places * BYTES_OF_A_PLACE + plan.passes.len() * BYTES_OF_A_PLANE + places.min(limit) * BYTES_OF_A_POINT
}

/// A place and, during thinning, its index; twice, because a growing vector is copied to one of twice its size.
const BYTES_OF_A_PLACE: usize = 2 * size_of::<Place>() + 2 * size_of::<usize>();

/// The vectors of a plane: its cuts, its runs, their places.
const BYTES_OF_A_PLANE: usize = 512;

/// A point, its copy in cutting order, and its figures in columns and as text.
const BYTES_OF_A_POINT: usize = 1000;

/// The runs of all planes with their places, in the order and direction of cutting.
fn runs_in_order(
    plan: &ZigzagPlan,
    facets: &[FinishFacet],
    spaced: &Spaced,
    operation: Operation,
    cutter: Cutter,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<OrderedRun> {
    let by_plane = cuts_by_plane(plan, spaced, stop);
    let of_plane = |(number, (plane, cuts)): (usize, (&Plane, Vec<Cut>))| runs_of(number, plane.at, cuts, facets, spaced, cutter);
    let runs: Vec<(Stretch, Vec<Place>)> = plan.passes.par_iter().zip(by_plane).enumerate().flat_map_iter(of_plane).collect();
    let stretches: Vec<Stretch> = runs.iter().map(|&(stretch, _)| stretch).collect();
    let mut places: Vec<Vec<Place>> = runs.into_iter().map(|(_, places)| places).collect();
    let ordered = in_order(&stretches, operation.pattern, &operation.links(spaced)).into_iter().map(|leg| {
        let mut places = std::mem::take(&mut places[leg.run]);
        if !leg.forward {
            places.reverse();
        }
        let stretch = stretches[leg.run];
        let ends = [!leg.forward, leg.forward].map(|is_upper| stretch.end(usize::from(is_upper)));
        OrderedRun { plane: plan.passes[stretch.plane], places, ends }
    });
    ordered.collect()
}

/// The time of all runs and links along the tips. Each run has the mean of its points' feed rates, as in
/// [`TourFigures`](super::TourFigures) along the contacts.
fn time_of_tips(runs: &[OrderedRun], points: &[Vec<PassPoint>], spaced: &Spaced, operation: Operation) -> Time {
    let links = operation.links(spaced);
    let (heading, origin) = (spaced.sweep.heading, spaced.workpiece.origin);
    let at = |end: End, point: &PassPoint| {
        let [x, y, z] = [0, 1, 2].map(|axis| point.tip[axis] - origin[axis]);
        End { place: [heading.along(x, y), heading.across(x, y), z], ..end }
    };
    let (mut total, mut last) = (0.0, None);
    for (run, points) in runs.iter().zip(points) {
        let (Some(first), Some(end)) = (points.first(), points.last()) else { continue };
        if let Some(last) = last {
            total += links.between(last, at(run.ends[0], first)).seconds;
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
        last = Some(at(run.ends[1], end));
    }
    Time::computed(total)
}

/// The cut of a facet: both ends, along the pass and in height.
#[derive(Debug, Clone, Copy)]
struct Cut {
    facet: u32,
    ends: [[f64; 2]; 2],
}

/// The number of facets and cuts between two checks for cancellation.
const TURN: usize = 16_384;

/// The cuts of each plane of a plan, those over slivers among them; none once `stop` returns true.
fn cuts_by_plane(plan: &ZigzagPlan, spaced: &Spaced, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Vec<Cut>> {
    let planes = &plan.passes;
    let mut by_plane = vec![Vec::new(); planes.len()];
    let cut = |facet: u32, slice: &Slice, at: f64, ends: [f64; 2]| Cut { facet, ends: ends.map(|along| [along, slice.height(along, at)]) };
    let mut examined = 0;
    for (covered, slice) in spaced.sweep.covered.iter().zip(&spaced.sweep.slices) {
        examined += 1;
        if examined >= TURN {
            examined = 0;
            if stop() {
                return vec![Vec::new(); planes.len()];
            }
        }
        let first = planes.partition_point(|plane| plane.at < covered.low);
        for (plane, cuts) in planes[first..].iter().zip(&mut by_plane[first..]) {
            if plane.at >= covered.high {
                break;
            }
            examined += 1;
            let [from, to] = slice.cut(plane.at);
            if to > from {
                cuts.push(cut(covered.facet, slice, plane.at, [from, to]));
            }
        }
    }
    for sliver in &plan.slivers {
        let (slice, plane) = (Slice::new(sliver.facet, spaced.workpiece, spaced.sweep.heading), sliver.plane as usize);
        by_plane[plane].push(cut(sliver.facet, &slice, planes[plane].at, sliver.ends));
    }
    by_plane
}

/// The runs of one plane: its cuts, sorted along it and split at gaps wider than the cutter.
fn runs_of(
    plane: usize,
    at: f64,
    mut cuts: Vec<Cut>,
    facets: &[FinishFacet],
    spaced: &Spaced,
    cutter: Cutter,
) -> Vec<(Stretch, Vec<Place>)> {
    cuts.sort_by(|a, b| a.ends[0][0].total_cmp(&b.ends[0][0]));
    let place = |facet: u32, [along, height]: [f64; 2]| {
        let [e, origin] = [spaced.sweep.heading.e, [spaced.workpiece.origin[0], spaced.workpiece.origin[1]]];
        let contact = [origin[0] + e[0] * along - e[1] * at, origin[1] + e[1] * along + e[0] * at, spaced.workpiece.origin[2] + height];
        Place { facet, contact, tip: tip_of(cutter, contact, facets[facet as usize].normal) }
    };
    let mut runs: Vec<(Stretch, Vec<Place>)> = Vec::new();
    // The index of the cut that reaches farthest in the current run.
    let mut farthest = 0;
    for &Cut { facet, ends: [from, to] } in &cuts {
        let middle = [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])];
        match runs.last_mut() {
            Some((stretch, places)) if from[0] - stretch.ends[1][0] <= spaced.widest => {
                places.push(place(facet, middle));
                if to[0] > stretch.ends[1][0] {
                    stretch.ends[1] = to;
                    farthest = facet;
                }
            }
            last => {
                if let Some((stretch, places)) = last {
                    places.push(place(farthest, stretch.ends[1]));
                }
                runs.push((Stretch { plane, at, ends: [from, to] }, vec![place(facet, from), place(facet, middle)]));
                farthest = facet;
            }
        }
    }
    if let Some((stretch, places)) = runs.last_mut() {
        places.push(place(farthest, stretch.ends[1]));
    }
    runs
}

/// The indices of the places to keep, so that contact and tip of each omitted one are at most `chord` from the lines
/// between its kept neighbours. The algorithm of Douglas and Peucker: it keeps the two ends, then repeatedly the
/// farthest place. Once `stop` returns true, it ends early.
fn thinned(places: &[Place], chord: f64, stop: &(dyn Fn() -> bool + Sync)) -> Vec<usize> {
    let mut keep = vec![false; places.len()];
    let Some(last) = places.len().checked_sub(1) else { return Vec::new() };
    (keep[0], keep[last]) = (true, true);
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop().filter(|_| !stop()) {
        let far = |index: usize| {
            let contact = distance(places[index].contact, places[from].contact, places[to].contact);
            contact.max(distance(places[index].tip, places[from].tip, places[to].tip))
        };
        let farthest = (from + 1..to).map(|index| (index, far(index))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, _)) = farthest.filter(|&(_, far)| far > chord) {
            keep[index] = true;
            open.push((from, index));
            open.push((index, to));
        }
    }
    (0..places.len()).filter(|&index| keep[index]).collect()
}

/// The distance of a point from the segment between two others.
fn distance(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let line = [to[0] - from[0], to[1] - from[1], to[2] - from[2]];
    let out = [point[0] - from[0], point[1] - from[1], point[2] - from[2]];
    let squared = line.iter().map(|c| c * c).sum::<f64>();
    let along = (line[0] * out[0] + line[1] * out[1] + line[2] * out[2]) / squared;
    let share = if squared > 0.0 { along.clamp(0.0, 1.0) } else { 0.0 };
    (out[0] - share * line[0]).hypot(out[1] - share * line[1]).hypot(out[2] - share * line[2])
}

/// The plan's facets, spacings, candidate and settings, from which its points are computed.
struct PointSource<'a> {
    facets: &'a [FinishFacet],
    spaced: &'a Spaced<'a>,
    prepared: &'a Prepared,
    settings: &'a ZigzagSettings,
    raised: &'a (dyn Fn([f64; 3]) -> f64 + Sync),
}

impl PointSource<'_> {
    fn point(&self, plane: &Plane, place: Place) -> PassPoint {
        let Place { facet, contact, mut tip } = place;
        let resting = (self.raised)(tip);
        let is_raised = resting - tip[2] > SUNK_SHARE * self.settings.scallop_height.mm();
        if is_raised {
            tip[2] = resting;
        }
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
            contact: if is_raised { None } else { Some(contact) },
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
