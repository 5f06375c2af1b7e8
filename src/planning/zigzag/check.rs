//! The check of a plan: scallop heights and spacings at single facets, by model `envelope` with the curvature of each.

use super::contacts::{FacetContact, NoContact};
use super::imprint::Imprints;
use super::march::{Fit, NoPlanes, Plane, Spaced};
use super::prepared::Prepared;
use super::refine::{Tightest, refine, tightest};
use super::settings::ZigzagSettings;
use super::simulate::{Operation, Simulated, simulate};
use super::spacing::FeedLaw;
use super::workpiece::Workpiece;
use crate::milling::{Cutter, CutterKind, Model, NoAnswer};
use crate::quantity::Length;
use crate::surface::FinishFacet;
use rayon::prelude::*;

/// Scallop heights over the area of a plan, by model `envelope` with the curvature of each facet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScallopFigures {
    /// The median over the area.
    pub p50: Length,
    /// The 90th percentile over the area.
    pub p90: Length,
    /// The 99th percentile over the area.
    pub p99: Length,
    /// The largest of all heights that were calculated.
    pub max: Length,
    /// The share of the area whose height exceeds the scallop height by more than a third of a per cent, the accuracy
    /// of the spacing.
    pub over_tolerance_share: f64,
    /// The share of the area whose height exceeds the scallop height by more than 3 %.
    pub far_over_share: f64,
    /// The share of the area where the cutter gouges the surface beside the contact, or leaves uncut material between
    /// the passes. This area has no height and is not in the percentiles. Facets that are too steep to set a spacing
    /// count in none of these shares.
    pub without_height_share: f64,
    /// The number of points at which the height was calculated.
    pub places: usize,
}

/// The number of points sampled in proportion to area.
const DRAWN: usize = 400;

/// The number of further points, about: those that determine the strips.
const CHOSEN: usize = 1000;

/// Shares of the tolerance: spacings are set to `AIM`, with feed marks to `AIM_WITH_MARKS`, because the feed of a
/// spacing under the largest one exceeds the tolerance by up to 1.4 %; heights above `OVER` are too high.
const AIM: f64 = 0.99;
const AIM_WITH_MARKS: f64 = 0.975;
const OVER: f64 = 1.0033;

/// A plan whose heights exceed this share of the tolerance on more than a thousandth of the area loses confidence.
const FAR_OVER: f64 = 1.03;

/// The steps in which spacing and feed are brought together.
const FEED_STEPS: usize = 3;

/// Facets whose spacing by the envelope is over this multiple of the strip's width are not compared with imprints.
const BINDING: f64 = 1.8;

/// Spacings are widened where imprints leave less than this share of the tolerance, to at most `WIDEST` of the
/// envelope's.
const TIGHT: f64 = 0.97;
const WIDEST: f64 = 1.4;

/// The relative curvature up to which spacings are not widened, because the imprints cut into the surface.
pub(super) const NEAR_GOUGING: f64 = 0.6;

/// The least share of the tolerance from which on the envelope's height is compared with that of imprints.
const LEAST_COMPARED: f64 = 0.4;

/// The largest number of steps in which a spacing is reduced to the height of its imprints.
const IMPRINT_STEPS: usize = 6;

/// The data for the check of a plan.
#[derive(Clone, Copy)]
pub(super) struct Inspector<'a> {
    pub(super) facets: &'a [FinishFacet],
    pub(super) cutter: Cutter,
    pub(super) tolerance: f64,
    pub(super) feeds: &'a FeedLaw,
    pub(super) teeth_per_second: Option<f64>,
    /// Once it returns true, the check ends early with a result that has no meaning.
    pub(super) stop: &'a (dyn Fn() -> bool + Sync),
}

/// A height at a facet.
#[derive(Debug, Clone, Copy)]
struct Evaluated {
    facet: u32,
    height: Option<f64>,
}

/// Simulates with the model's spacings, or, if `follows` is set, with spacings that are refined where they bind the
/// strips, and checks the heights.
///
/// # Errors
/// [`NoPlanes`]
pub(super) fn checked(
    mut spaced: Spaced,
    operation: Operation,
    inspector: Inspector,
    follows: bool,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<(Simulated, ScallopFigures), NoPlanes> {
    if follows {
        refine(&mut spaced, &inspector, operation.room, stop)?;
    }
    let fit = |place: u32, at: f64, width: f64, limit: f64| inspector.fitted(&spaced, place, at, [width, limit]);
    let fit: Option<&Fit> = if follows { Some(&fit) } else { None };
    let simulated = simulate(&spaced, operation, fit, stop)?;
    let drawn = drawn_by_area(spaced.workpiece, DRAWN);
    let evaluated = inspector.evaluate(&spaced, &simulated.planes, &drawn);
    let figures = figures(&evaluated, drawn.len(), spaced.workpiece, inspector.tolerance);
    Ok((simulated, figures))
}

impl<'a> Inspector<'a> {
    pub(super) fn new(
        facets: &'a [FinishFacet],
        prepared: &'a Prepared,
        settings: &ZigzagSettings,
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        Self {
            facets,
            cutter: prepared.candidate.cutter,
            tolerance: settings.scallop_height.mm(),
            feeds: &prepared.feeds,
            teeth_per_second: prepared.range.map(|range| range.teeth_per_second),
            stop,
        }
    }

    /// The heights at these facets, in their order.
    pub(super) fn heights(&self, spaced: &Spaced, planes: &[Plane], facets: &[u32]) -> Vec<Option<f64>> {
        self.evaluate_all(spaced, planes, &Self::by_strip(spaced, planes, facets)).into_iter().map(|evaluated| evaluated.height).collect()
    }

    /// The heights at the sampled facets, followed by those at the facets that determine the strips.
    fn evaluate(&self, spaced: &Spaced, planes: &[Plane], drawn: &[u32]) -> Vec<Evaluated> {
        let tightest = tightest(spaced, planes, self, CHOSEN).into_iter();
        let chosen = tightest.map(|Tightest { strip, place }| (strip, spaced.sweep.covered[place as usize].facet));
        let places: Vec<(usize, u32)> = Self::by_strip(spaced, planes, drawn).into_iter().chain(chosen).collect();
        self.evaluate_all(spaced, planes, &places)
    }

    /// Pairs each facet with the strip that contains its centroid.
    fn by_strip(spaced: &Spaced, planes: &[Plane], facets: &[u32]) -> Vec<(usize, u32)> {
        let heading = spaced.sweep.heading;
        let middle = |facet: u32| {
            let corners = spaced.workpiece.corners[facet as usize];
            corners.iter().map(|&[x, y, _]| heading.across(x, y)).sum::<f64>() / 3.0
        };
        facets.iter().map(|&facet| (strip_of(planes, middle(facet)), facet)).collect()
    }

    fn evaluate_all(&self, spaced: &Spaced, planes: &[Plane], places: &[(usize, u32)]) -> Vec<Evaluated> {
        let height = |&(strip, facet): &(usize, u32)| (!(self.stop)()).then(|| self.height(spaced, facet, planes[strip].after));
        let heights = places.par_iter().with_min_len(64).map(height).collect::<Option<Vec<_>>>();
        // Cancelled: the heights have no meaning.
        let heights = heights.unwrap_or_else(|| vec![None; places.len()]);
        places.iter().zip(heights).map(|(&(_, facet), height)| Evaluated { facet, height }).collect()
    }

    /// The height at a facet; `None` if the model has none, infinite if material stays uncut between the passes.
    fn height(&self, spaced: &Spaced, facet: u32, spacing: f64) -> Option<f64> {
        let index = facet as usize;
        let tangent = &spaced.workpiece.tangents[index];
        if tangent.is_steep {
            return None;
        }
        match self.height_at(spaced, index, spacing) {
            Ok(height) => Some(height),
            Err(NoContact::Model(NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::MarksDoNotOverlap { .. })) => Some(f64::INFINITY),
            Err(_) => None,
        }
    }

    /// The height at a facet that is not too steep: by the envelope, and by imprints for a flat-end cutter on a
    /// curved surface, whose marks are of the second order in the envelope.
    fn height_at(&self, spaced: &Spaced, index: usize, spacing: f64) -> Result<f64, NoContact> {
        let e = spaced.sweep.heading.e;
        let contact = FacetContact::new(&self.facets[index], e)?;
        let evaluated = contact.evaluated(self.cutter, Model::Envelope)?;
        let step_over = Length::computed(contact.step_over(spacing));
        let feed = self.feed(spaced, index, spacing).map(Length::computed);
        let height = evaluated.scallop_height(step_over, feed).map_err(NoContact::Model)?;
        let total = height.total().mm();
        if total < LEAST_COMPARED * self.tolerance || self.cutter.kind() != CutterKind::FlatEnd || contact.is_plane() {
            return Ok(total);
        }
        let by_imprints = Imprints::new(self.cutter, &self.facets[index], e).height(spacing, 0.0) + height.feed.mm();
        // Imprints that nearly gouge are low because they cut into the surface.
        Ok(if evaluated.relative_curvature() > NEAR_GOUGING { by_imprints.max(0.0) } else { total.max(by_imprints) })
    }

    /// The feed per tooth of the plan at a facet; `None` without a drive.
    fn feed(&self, spaced: &Spaced, index: usize, spacing: f64) -> Option<f64> {
        let tangent = &spaced.workpiece.tangents[index];
        let (cos_alpha, _) = tangent.alpha(spaced.sweep.heading.e);
        let taken = spacing * spacing / spaced.squared(index);
        self.teeth_per_second.map(|teeth| self.feeds.rate(tangent, cos_alpha, taken) / teeth)
    }

    /// The widest spacing that keeps [`AIM`] of the tolerance at a facet that meets a strip `spacing` wide: by the
    /// envelope, and by imprints for a flat-end cutter on a curved surface, where the envelope leaves out the third
    /// order, and where passes run level, which gives heights a narrow peak within the facet.
    pub(super) fn widest(&self, spaced: &Spaced, facet: u32, spacing: f64) -> Option<f64> {
        let (index, e) = (facet as usize, spaced.sweep.heading.e);
        let contact = FacetContact::new(&self.facets[index], e).ok()?;
        let evaluated = contact.evaluated(self.cutter, Model::Envelope).ok()?;
        let aim = if self.teeth_per_second.is_some() { AIM_WITH_MARKS } else { AIM };
        let inverse = |feed: Option<f64>| match evaluated.max_step_over(Length::computed(aim * self.tolerance), feed.map(Length::computed))
        {
            Ok(step_over) | Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: step_over }) => {
                Some(step_over.mm() * contact.contact.spacing_ratio())
            }
            Err(_) => None,
        };
        let without_marks = inverse(None)?;
        let mut widest = without_marks;
        if self.teeth_per_second.is_some() {
            // The feed depends on the spacing: from the estimate of both, three times.
            widest = spaced.squared(index).sqrt();
            for _ in 0..FEED_STEPS {
                widest = inverse(self.feed(spaced, index, widest))?;
            }
        }
        let imprints = Imprints::new(self.cutter, &self.facets[index], e);
        let range = Self::range_along(spaced, index);
        let is_flat = self.cutter.kind() == CutterKind::FlatEnd;
        // A facet that allows far more than the strip's width does not bind it.
        if widest > BINDING * spacing || contact.is_plane() || !(is_flat || imprints.run_level(range)) {
            return Some(widest);
        }
        let widens = is_flat && self.teeth_per_second.is_none() && evaluated.relative_curvature() > NEAR_GOUGING;
        // Imprints have no tooth marks: the spacing with marks shrinks as that without does.
        Some(widest * self.share_by_imprints(&imprints, without_marks.min(spaced.widest), range, widens))
    }

    /// The ends of a facet along the passes, from its middle.
    fn range_along(spaced: &Spaced, facet: usize) -> [f64; 2] {
        let along = spaced.workpiece.corners[facet].map(|[x, y, _]| spaced.sweep.heading.along(x, y));
        let middle = along.iter().sum::<f64>() / 3.0;
        let (low, high) = along.into_iter().fold((0.0, 0.0), |(low, high): (f64, f64), at| (low.min(at - middle), high.max(at - middle)));
        [low, high]
    }

    /// The share of a spacing at which imprints leave the tolerance on a facet with these ends along the passes. It is
    /// at most 1 unless it `widens`.
    fn share_by_imprints(&self, imprints: &Imprints, spacing: f64, range: [f64; 2], widens: bool) -> f64 {
        let (place, mut height) = imprints.highest(spacing, range);
        let (mut share, mut last, mut kept) = (1.0, None::<(f64, f64)>, None::<f64>);
        for _ in 0..IMPRINT_STEPS {
            let of_tolerance = height / self.tolerance;
            if of_tolerance <= OVER {
                kept = Some(share);
                if !widens || of_tolerance >= TIGHT || share >= WIDEST {
                    break;
                }
            }
            // Heights grow with the first power of the spacing beside a sharp edge, elsewhere with the second.
            let power = last.map_or(2.0, |(other, at_other)| (at_other / of_tolerance).ln() / (other / share).ln());
            let power = if power > 1.0 { power.min(2.0) } else { 1.0 };
            last = Some((share, of_tolerance));
            let factor = if of_tolerance.is_finite() { (AIM / of_tolerance.max(0.1)).powf(power.recip()) } else { 0.5 };
            share = (share * factor.clamp(0.3, 1.2)).min(WIDEST);
            if kept.is_some_and(|kept| share <= kept) {
                break;
            }
            height = imprints.height(share * spacing, place);
        }
        kept.unwrap_or(share)
    }
}

/// The index of the strip that contains a coordinate across the passes. Strip i begins at plane i; coordinates before
/// the first plane belong to strip 0.
fn strip_of(planes: &[Plane], at: f64) -> usize {
    planes.partition_point(|plane| plane.at <= at).saturating_sub(1)
}

fn figures(evaluated: &[Evaluated], drawn: usize, workpiece: &Workpiece, tolerance: f64) -> ScallopFigures {
    let by_area = &evaluated[..drawn];
    let mut heights: Vec<f64> = by_area.iter().filter_map(|place| place.height).filter(|height| height.is_finite()).collect();
    heights.sort_by(f64::total_cmp);
    #[expect(clippy::cast_precision_loss, reason = "at most 2,000")]
    let share = |count: usize| if drawn == 0 { 0.0 } else { count as f64 / drawn as f64 };
    let percentile = |hundredths: usize| {
        Length::computed(heights.get((heights.len() * hundredths / 100).min(heights.len().saturating_sub(1))).copied().unwrap_or(0.0))
    };
    let max = evaluated.iter().filter_map(|place| place.height).filter(|height| height.is_finite()).fold(0.0, f64::max);
    ScallopFigures {
        p50: percentile(50),
        p90: percentile(90),
        p99: percentile(99),
        max: Length::computed(max),
        over_tolerance_share: share_over(evaluated, drawn, workpiece, OVER * tolerance),
        far_over_share: share_over(evaluated, drawn, workpiece, FAR_OVER * tolerance),
        without_height_share: share(drawn - heights.len()),
        places: evaluated.len(),
    }
}

/// The share of the area whose height exceeds a limit. A chosen facet counts with its own area; the sampled facets
/// represent the rest.
fn share_over(evaluated: &[Evaluated], drawn: usize, workpiece: &Workpiece, limit: f64) -> f64 {
    let is_over = |place: &Evaluated| place.height.is_some_and(|height| height.is_finite() && height > limit);
    let (by_area, chosen) = evaluated.split_at(drawn);
    let mut chosen: Vec<(u32, bool)> = chosen.iter().map(|place| (place.facet, is_over(place))).collect();
    chosen.sort_unstable();
    let (mut area, mut over) = (0.0, 0.0);
    #[expect(clippy::cast_precision_loss, reason = "at most 2,000")]
    for of_facet in chosen.chunk_by(|a, b| a.0 == b.0) {
        let own = workpiece.areas[of_facet[0].0 as usize];
        area += own;
        over += own * of_facet.iter().filter(|(_, is_over)| *is_over).count() as f64 / of_facet.len() as f64;
    }
    let rest = by_area.iter().filter(|place| chosen.binary_search_by_key(&place.facet, |(facet, _)| *facet).is_err());
    let (count, over_of_rest) = rest.fold((0.0, 0.0), |(count, over), place| (count + 1.0, over + if is_over(place) { 1.0 } else { 0.0 }));
    let whole = workpiece.areas.iter().zip(&workpiece.tangents).filter(|(_, tangent)| !tangent.is_steep).map(|(area, _)| area).sum::<f64>();
    let of_rest = if count > 0.0 { (whole - area).max(0.0) * over_of_rest / count } else { 0.0 };
    if whole > 0.0 { ((over + of_rest) / whole).min(1.0) } else { 0.0 }
}

/// About `count` facets, each of which represents the same area, or all facets if they are fewer. Facets that are too
/// steep to set a spacing are left out.
fn drawn_by_area(workpiece: &Workpiece, count: usize) -> Vec<u32> {
    let facets = || (0_u32..).zip(workpiece.areas.iter().zip(&workpiece.tangents)).filter(|(_, (_, tangent))| !tangent.is_steep);
    let area: f64 = facets().map(|(_, (area, _))| area).sum();
    #[expect(clippy::cast_precision_loss, reason = "hundreds")]
    let share = area / count as f64;
    let mut due = 0.5 * share;
    let mut passed = 0.0;
    let mut drawn = Vec::with_capacity(count);
    for (index, (area, _)) in facets() {
        passed += area;
        // A facet larger than the represented area is drawn several times.
        while passed >= due && drawn.len() < count {
            drawn.push(index);
            due += share;
        }
    }
    drawn
}
