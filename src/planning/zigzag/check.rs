//! The check of a plan against the envelope with the surface's own curvature, and the spacing that follows from it.

use super::contacts::{FacetContact, NoContact};
use super::march::{Plane, Spaced, TooManyPlanes};
use super::simulate::{Operation, Simulated, simulate};
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
    /// The share of the area whose height exceeds the scallop height by more than a thousandth.
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

/// Heights from this share of the tolerance on count as tight.
const TIGHT: f64 = 0.97;

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
struct Judged {
    strip: usize,
    height: Option<f64>,
}

/// Simulates with spacings as they come, or, where `follows` is set, with spacings that follow from the check of each strip.
///
/// In each round the heights at the facets that bind the strips, and at places drawn by area, give each strip's highest; its spacing is
/// multiplied by the square root of tolerance over height. In the first two rounds strips may widen as well, by a fifth at most; afterwards
/// they only narrow, so that the rounds end. A round is the last when no strip is over the tolerance by more than a hundredth and, in
/// the first two, none is under [`TIGHT`] of it.
///
/// # Errors
/// [`TooManyPlanes`]
pub(super) fn checked(
    mut spaced: Spaced,
    operation: Operation,
    inspector: Inspector,
    follows: bool,
) -> Result<(Simulated, ScallopFigures), TooManyPlanes> {
    let drawn = drawn_by_area(inspector.facets, DRAWN);
    let mut simulated = simulate(&spaced, operation)?;
    for round in 0..if follows { ROUNDS } else { 0 } {
        let judged = inspector.judge(&spaced, &simulated.planes, &drawn);
        let widens = round < 2;
        let Some(next) = corrected(&spaced, &simulated.planes, &judged, inspector.tolerance, widens) else { break };
        spaced.factors = next;
        simulated = simulate(&spaced, operation)?;
    }
    let judged = inspector.judge(&spaced, &simulated.planes, &drawn);
    let figures = figures(&judged, drawn.len(), inspector.tolerance);
    Ok((simulated, figures))
}

impl Inspector<'_> {
    /// The heights at the drawn facets and at those that bind the strips, in this order.
    fn judge(&self, spaced: &Spaced, planes: &[Plane], drawn: &[u32]) -> Vec<Judged> {
        let stride = planes.len().div_ceil(STRIPS).max(1);
        let heading = spaced.sweep.heading;
        let middle = |facet: u32| {
            let corners = spaced.workpiece.corners[facet as usize];
            corners.iter().map(|&[x, y, _]| heading.across(x, y)).sum::<f64>() / 3.0
        };
        let by_area = drawn.iter().map(|&facet| (strip_of(planes, middle(facet)), facet));
        let binding = planes.iter().enumerate().step_by(stride).flat_map(|(strip, plane)| plane.binding.into_iter().flatten().map(move |facet| (strip, facet)));
        let places: Vec<(usize, u32)> = by_area.chain(binding).collect();
        let judge = |&(strip, facet): &(usize, u32)| {
            let spacing = planes[strip].after;
            Judged { strip, height: self.height(spaced, facet, spacing) }
        };
        places.par_iter().with_min_len(64).map(judge).collect()
    }

    /// The height at a facet; `None` where there is none, and infinite where uncut material stands between the passes.
    fn height(&self, spaced: &Spaced, facet: u32, spacing: f64) -> Option<f64> {
        let index = facet as usize;
        let tangent = &spaced.workpiece.tangents[index];
        if tangent.is_steep {
            return None;
        }
        let e = spaced.sweep.heading.e;
        let feed = self.teeth_per_second.map(|teeth| {
            let taken = spacing * spacing / f64::from(spaced.squared[index]);
            self.feeds.rate(tangent, tangent.alpha(e).0, taken) / teeth
        });
        match FacetContact::new(&self.facets[index], e).and_then(|contact| contact.height(self.cutter, Model::Envelope, spacing, feed)) {
            Ok(height) => Some(height),
            Err(NoContact::Model(NoAnswer::PassesDoNotOverlap { .. } | NoAnswer::MarksDoNotOverlap { .. })) => Some(f64::INFINITY),
            Err(_) => None,
        }
    }
}

/// The strip in which a place across the passes lies: that after the last plane before it, the first one's before the first plane.
fn strip_of(planes: &[Plane], at: f64) -> usize {
    planes.partition_point(|plane| plane.at <= at).saturating_sub(1)
}

/// The factors of the next round; `None` when the spacing may stay.
fn corrected(spaced: &Spaced, planes: &[Plane], judged: &[Judged], tolerance: f64, widens: bool) -> Option<Vec<(f64, f64)>> {
    let mut highest = vec![0.0_f64; planes.len()];
    for place in judged {
        if let Some(height) = place.height {
            highest[place.strip] = highest[place.strip].max(height);
        }
    }
    let mut changes = false;
    let mut last: f64 = 1.0;
    let factors = planes.iter().zip(&highest).enumerate().map(|(strip, (plane, &height))| {
        let correction = if height > 1.01 * tolerance {
            changes = true;
            (tolerance / height).sqrt().max(0.5)
        } else if widens && height > 0.0 && height < TIGHT * tolerance {
            let correction = (0.99 * tolerance / height).sqrt().min(1.2);
            // The last strip of a band is as wide as the band leaves it.
            changes |= strip + 1 < planes.len();
            correction
        } else {
            1.0
        };
        // Strips without a height follow their neighbour.
        let factor = if height > 0.0 { spaced.factor(plane.at) * correction } else { last };
        last = factor;
        (plane.at, factor)
    });
    let factors: Vec<(f64, f64)> = factors.collect();
    changes.then_some(factors)
}

fn figures(judged: &[Judged], drawn: usize, tolerance: f64) -> ScallopFigures {
    let by_area = &judged[..drawn];
    let mut heights: Vec<f64> = by_area.iter().filter_map(|place| place.height).filter(|height| height.is_finite()).collect();
    heights.sort_by(f64::total_cmp);
    #[expect(clippy::cast_precision_loss, reason = "at most 2,000")]
    let share = |count: usize| if drawn == 0 { 0.0 } else { count as f64 / drawn as f64 };
    let percentile = |hundredths: usize| Length::computed(heights.get((heights.len() * hundredths / 100).min(heights.len().saturating_sub(1))).copied().unwrap_or(0.0));
    let max = judged.iter().filter_map(|place| place.height).filter(|height| height.is_finite()).fold(0.0, f64::max);
    ScallopFigures {
        p50: percentile(50),
        p90: percentile(90),
        p99: percentile(99),
        max: Length::computed(max),
        over_tolerance_share: share(heights.iter().filter(|&&height| height > 1.001 * tolerance).count()),
        without_height_share: share(drawn - heights.len()),
        places: judged.len(),
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
