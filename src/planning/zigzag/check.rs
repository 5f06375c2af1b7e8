//! The check of a plan against the envelope with the surface's own curvature, and the spacing that follows from it.

use super::contacts::{FacetContact, NoContact};
use super::march::{NoPlanes, Plane, Spaced};
use super::prepared::Prepared;
use super::settings::ZigzagSettings;
use super::simulate::{Operation, Simulated, planes_of, simulate};
use super::spacing::FeedLaw;
use crate::milling::{Cutter, Model, NoAnswer};
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
    /// The share of the area whose height exceeds the scallop height by more than a third of a per cent, to which spacings are found.
    pub over_tolerance_share: f64,
    /// The share of the area where the cutter gouges the surface beside the contact, or leaves uncut material between the passes: it has no
    /// height and is not in the percentiles.
    pub without_height_share: f64,
    /// At how many places the height was calculated.
    pub places: usize,
}

/// How many places are drawn by area; those that bind the strips come beside them. Together at most 2,000.
const DRAWN: usize = 400;

/// How many strips at most have the facets that bind them checked one by one; more are checked at even distances.
const STRIPS: usize = 400;

/// How often the spacing follows from a check.
const ROUNDS: usize = 4;

/// Heights from this share of the tolerance on count as tight, and over this one as too high; spacings are set to `AIM` of it.
const TIGHT: f64 = 0.97;
const AIM: f64 = 0.995;
const OVER: f64 = 1.0033;

/// What to check a plan with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inspector<'a> {
    pub(super) facets: &'a [FinishFacet],
    pub(super) cutter: Cutter,
    pub(super) tolerance: f64,
    pub(super) feeds: &'a FeedLaw,
    pub(super) teeth_per_second: Option<f64>,
}

/// A height at a place, and which strip it is in.
#[derive(Debug, Clone, Copy)]
struct Evaluated {
    strip: usize,
    facet: u32,
    height: Option<f64>,
}

/// Simulates with spacings as they come, or, where `follows` is set, with spacings that follow from the check of each strip.
///
/// In each round the heights at the facets that bind the strips, and at places drawn by area, give each strip's highest; where that is over
/// the tolerance, the strip's spacing becomes the one that keeps [`AIM`] of the tolerance at that place. In the first two rounds strips under [`TIGHT`] of it widen
/// in the same way, by a fifth at most; afterwards they only narrow. There are [`ROUNDS`] rounds at most.
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
    let drawn = drawn_by_area(inspector.facets, DRAWN);
    let mut kept = None;
    for round in 0..if follows { ROUNDS } else { 0 } {
        let planes = planes_of(&spaced, operation.room, stop)?;
        let evaluated = inspector.evaluate(&spaced, &planes, &drawn);
        let widens = round < 2;
        let Some(next) = corrected(&spaced, &planes, &evaluated, &inspector, widens) else {
            kept = Some(evaluated);
            break;
        };
        spaced.factors = next;
    }
    let simulated = simulate(&spaced, operation, stop)?;
    let evaluated = kept.unwrap_or_else(|| inspector.evaluate(&spaced, &simulated.planes, &drawn));
    let figures = figures(&evaluated, drawn.len(), inspector.tolerance);
    Ok((simulated, figures))
}

impl<'a> Inspector<'a> {
    pub(super) fn new(facets: &'a [FinishFacet], prepared: &'a Prepared, settings: &ZigzagSettings) -> Self {
        Self {
            facets,
            cutter: prepared.candidate.cutter,
            tolerance: settings.scallop_height.mm(),
            feeds: &prepared.feeds,
            teeth_per_second: prepared.range.map(|range| range.teeth_per_second),
        }
    }

    /// The heights at these facets, in their order.
    pub(super) fn heights(&self, spaced: &Spaced, planes: &[Plane], facets: &[u32]) -> Vec<Option<f64>> {
        self.evaluate_all(spaced, planes, &Self::by_strip(spaced, planes, facets)).into_iter().map(|evaluated| evaluated.height).collect()
    }

    /// The heights at the drawn facets and at those that bind the strips, in this order.
    fn evaluate(&self, spaced: &Spaced, planes: &[Plane], drawn: &[u32]) -> Vec<Evaluated> {
        let stride = planes.len().div_ceil(STRIPS).max(1);
        let by_area = Self::by_strip(spaced, planes, drawn);
        let binding = planes
            .iter()
            .enumerate()
            .step_by(stride)
            .flat_map(|(strip, plane)| plane.binding.into_iter().flatten().map(move |facet| (strip, facet)));
        let places: Vec<(usize, u32)> = by_area.into_iter().chain(binding).collect();
        self.evaluate_all(spaced, planes, &places)
    }

    /// Each facet with the strip in which its middle lies.
    fn by_strip(spaced: &Spaced, planes: &[Plane], facets: &[u32]) -> Vec<(usize, u32)> {
        let heading = spaced.sweep.heading;
        let middle = |facet: u32| {
            let corners = spaced.workpiece.corners[facet as usize];
            corners.iter().map(|&[x, y, _]| heading.across(x, y)).sum::<f64>() / 3.0
        };
        facets.iter().map(|&facet| (strip_of(planes, middle(facet)), facet)).collect()
    }

    fn evaluate_all(&self, spaced: &Spaced, planes: &[Plane], places: &[(usize, u32)]) -> Vec<Evaluated> {
        let evaluate = |&(strip, facet): &(usize, u32)| {
            let spacing = planes[strip].after;
            Evaluated { strip, facet, height: self.height(spaced, facet, spacing) }
        };
        places.par_iter().with_min_len(64).map(evaluate).collect()
    }

    /// The height at a facet; `None` where there is none, and infinite where uncut material stands between the passes.
    fn height(&self, spaced: &Spaced, facet: u32, spacing: f64) -> Option<f64> {
        let index = facet as usize;
        let tangent = &spaced.workpiece.tangents[index];
        if tangent.is_steep {
            return None;
        }
        let feed = self.feed(spaced, index, spacing);
        match FacetContact::new(&self.facets[index], spaced.sweep.heading.e)
            .and_then(|contact| contact.height(self.cutter, Model::Envelope, spacing, feed))
        {
            Ok(height) => Some(height),
            Err(NoContact::Model(NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::MarksDoNotOverlap { .. })) => Some(f64::INFINITY),
            Err(_) => None,
        }
    }

    /// The feed per tooth of the plan at a facet; `None` without a drive.
    fn feed(&self, spaced: &Spaced, index: usize, spacing: f64) -> Option<f64> {
        let tangent = &spaced.workpiece.tangents[index];
        let (cos_alpha, _) = tangent.alpha(spaced.sweep.heading.e);
        let taken = spacing * spacing / spaced.squared(index);
        self.teeth_per_second.map(|teeth| self.feeds.rate(tangent, cos_alpha, taken) / teeth)
    }

    /// The widest spacing that keeps [`AIM`] of the tolerance at a facet, with the feed that belongs to `spacing`.
    fn widest(&self, spaced: &Spaced, facet: u32, spacing: f64) -> Option<f64> {
        let index = facet as usize;
        let contact = FacetContact::new(&self.facets[index], spaced.sweep.heading.e).ok()?;
        let evaluated = contact.evaluated(self.cutter, Model::Envelope).ok()?;
        let feed = self.feed(spaced, index, spacing).map(Length::computed);
        match evaluated.max_step_over(Length::computed(AIM * self.tolerance), feed) {
            Ok(step_over) | Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: step_over }) => {
                Some(step_over.mm() * contact.contact.spacing_ratio())
            }
            Err(_) => None,
        }
    }
}

/// The strip in which a place across the passes lies: that after the last plane before it, the first one's before the first plane.
fn strip_of(planes: &[Plane], at: f64) -> usize {
    planes.partition_point(|plane| plane.at <= at).saturating_sub(1)
}

/// The factors of the next round; `None` when the spacing may stay.
fn corrected(spaced: &Spaced, planes: &[Plane], evaluated: &[Evaluated], inspector: &Inspector, widens: bool) -> Option<Vec<(f64, f64)>> {
    let tolerance = inspector.tolerance;
    let mut highest: Vec<Option<(f64, u32)>> = vec![None; planes.len()];
    for place in evaluated {
        if let Some(height) = place.height
            && highest[place.strip].is_none_or(|(other, _)| height > other)
        {
            highest[place.strip] = Some((height, place.facet));
        }
    }
    let correction = |(strip, highest): (usize, &Option<(f64, u32)>)| {
        let &(height, facet) = highest.as_ref()?;
        let is_over = height > OVER * tolerance;
        // The last strip of a band is as wide as the band leaves it.
        let is_loose = widens && height < TIGHT * tolerance && strip + 1 < planes.len();
        if !is_over && !is_loose {
            return Some(1.0);
        }
        let spacing = planes[strip].after;
        let by_inverse = inspector.widest(spaced, facet, spacing).map(|widest| widest / spacing);
        // Heights go about with the square of the spacing.
        let correction = by_inverse.unwrap_or_else(|| if height.is_finite() { (AIM * tolerance / height).sqrt() } else { 0.5 });
        Some(if is_over { correction.clamp(0.5, AIM) } else { correction.clamp(1.0, 1.2) })
    };
    let corrections: Vec<Option<f64>> = highest.par_iter().enumerate().with_min_len(8).map(correction).collect();
    #[expect(clippy::float_cmp, reason = "1 where nothing is corrected")]
    let changes = corrections.iter().flatten().any(|&correction| correction != 1.0);
    let mut last = None;
    let factors = planes.iter().zip(corrections).map(|(plane, correction)| {
        let own = spaced.factor(plane.at);
        // Strips without a height follow their neighbour.
        let factor = correction.map_or_else(|| last.unwrap_or(own), |correction| own * correction);
        last = Some(factor);
        (plane.at, factor)
    });
    let factors = factors.collect();
    changes.then_some(factors)
}

fn figures(evaluated: &[Evaluated], drawn: usize, tolerance: f64) -> ScallopFigures {
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
        over_tolerance_share: share(heights.iter().filter(|&&height| height > OVER * tolerance).count()),
        without_height_share: share(drawn - heights.len()),
        places: evaluated.len(),
    }
}

/// About `count` facets, each of which stands for the same area, or all of them where they are fewer.
fn drawn_by_area(facets: &[FinishFacet], count: usize) -> Vec<u32> {
    let area: f64 = facets.iter().map(|facet| facet.area).sum();
    #[expect(clippy::cast_precision_loss, reason = "hundreds")]
    let share = area / count as f64;
    let mut due = 0.5 * share;
    let mut passed = 0.0;
    let mut drawn = Vec::with_capacity(count);
    for (index, facet) in (0_u32..).zip(facets) {
        passed += facet.area;
        // A large facet is drawn as often as its area is due.
        while passed >= due && drawn.len() < count {
            drawn.push(index);
            due += share;
        }
    }
    drawn
}
