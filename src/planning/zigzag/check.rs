//! The check of a plan: scallop heights at sampled facets by model `envelope` with the curvature of each facet, and the
//! correction of the spacing by these heights.

use super::contacts::{FacetContact, NoContact};
use super::march::{BINDING, NoPlanes, Plane, Spaced};
use super::prepared::Prepared;
use super::settings::ZigzagSettings;
use super::simulate::{Operation, Simulated, planes_of, simulate};
use super::spacing::FeedLaw;
use super::workpiece::Workpiece;
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

/// The number of further points chosen from all strips: those that bind the spacing of a strip, and those with the
/// largest error of the spacing.
const CHOSEN: usize = 1600;

/// The largest number of strips with chosen points. If there are more strips, this many are taken at even distances.
const STRIPS: usize = 400;

/// The largest number of points chosen from a strip. Half of them are those that bind it.
const MOST_OF_STRIP: usize = 6;

/// The largest number of rounds in which a check corrects the spacing.
const ROUNDS: usize = 4;

/// The number of facets and strips between two checks for cancellation.
const TURN: usize = 16_384;

/// Shares of the tolerance: heights of at least `TIGHT` use the tolerance fully, heights above `OVER` are too high, and
/// spacings are corrected so that the height is `AIM`.
const TIGHT: f64 = 0.97;
const AIM: f64 = 0.995;
const OVER: f64 = 1.0033;

/// A plan whose heights exceed this share of the tolerance on more than a thousandth of the area loses confidence.
const FAR_OVER: f64 = 1.03;

/// The upper limit of the curvature's factor in a facet's risk.
const LARGEST_CURVATURE: f64 = 10.0;

/// The data for the check of a plan.
#[derive(Clone, Copy)]
pub(super) struct Inspector<'a> {
    pub(super) facets: &'a [FinishFacet],
    pub(super) cutter: Cutter,
    pub(super) tolerance: f64,
    pub(super) feeds: &'a FeedLaw,
    pub(super) teeth_per_second: Option<f64>,
    /// Once it returns true, the check ends early with a result that has no meaning.
    stop: &'a (dyn Fn() -> bool + Sync),
}

/// A height at a point, and its strip.
#[derive(Debug, Clone, Copy)]
struct Evaluated {
    strip: usize,
    facet: u32,
    height: Option<f64>,
}

/// Simulates with the model's spacings. If `follows` is set, the spacing of each strip is then corrected by the check.
///
/// Each round evaluates the heights at three groups of facets: those that bind the strips, those where the spacing errs
/// most, and those sampled by area. If the highest of a strip exceeds the tolerance, the strip's spacing becomes the
/// one with [`AIM`] of the tolerance at that facet. In the first two rounds, strips below [`TIGHT`] of the tolerance
/// are widened in the same way, by a fifth at most; in later rounds strips only become narrower. There are at most
/// [`ROUNDS`] rounds.
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
    let drawn = drawn_by_area(spaced.workpiece, DRAWN);
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

    /// The heights at the sampled facets, followed by those at the facets chosen from the strips.
    fn evaluate(&self, spaced: &Spaced, planes: &[Plane], drawn: &[u32]) -> Vec<Evaluated> {
        let stride = planes.len().div_ceil(STRIPS).max(1);
        let of_strip = (CHOSEN * stride / planes.len().max(1)).clamp(2, MOST_OF_STRIP) / 2;
        // A ball's spacing is exact to second order at every slope.
        let is_ball = self.cutter.core_radius().mm() == 0.0;
        let risky = if is_ball { vec![[(0.0, 0); BINDING]; planes.len()] } else { self.riskiest(spaced, planes, stride) };
        let chosen = planes.iter().zip(&risky).enumerate().step_by(stride).flat_map(|(strip, (plane, risky))| {
            let binding = plane.binding.into_iter().flatten().take(of_strip);
            let risky = risky.iter().take(of_strip).filter(|(risk, _)| *risk > 0.0).map(|&(_, facet)| facet);
            let risky = risky.filter(move |facet| !plane.binding[..of_strip].contains(&Some(*facet)));
            binding.chain(risky).map(move |facet| (strip, facet))
        });
        let places: Vec<(usize, u32)> = Self::by_strip(spaced, planes, drawn).into_iter().chain(chosen).collect();
        self.evaluate_all(spaced, planes, &places)
    }

    /// The facets of each strip at which the height may exceed the tolerance most, in falling order of risk.
    ///
    /// Spacings come from second-order curvatures at the contact. Their error is large if the surface's curvature is
    /// not small compared with that of the cutter's body, 1/((R - r)/sin(S) + r), which is the case near a floor. A
    /// facet's risk is the share of its allowed height that the spacing uses, multiplied by one plus that ratio.
    fn riskiest(&self, spaced: &Spaced, planes: &[Plane], stride: usize) -> Vec<[(f64, u32); BINDING]> {
        let (core, corner) = (self.cutter.core_radius().mm(), self.cutter.corner_radius().mm());
        let mut riskiest = vec![[(0.0, 0_u32); BINDING]; planes.len()];
        let (mut first, mut examined) = (0, 0);
        for (covered, &allowed) in spaced.sweep.covered.iter().zip(&spaced.allowed) {
            examined += 1;
            if examined >= TURN {
                examined = 0;
                if (self.stop)() {
                    break;
                }
            }
            while planes.get(first + 1).is_some_and(|next| next.at <= covered.low) {
                first += 1;
            }
            let tangent = &spaced.workpiece.tangents[covered.facet as usize];
            if tangent.is_steep {
                continue;
            }
            let [steepest, twist, level] = tangent.curvature;
            let curvature = steepest.abs().max(level.abs()) + twist.abs();
            let ratio = if curvature > 0.0 { (curvature * (core / tangent.sin + corner)).min(LARGEST_CURVATURE) } else { 0.0 };
            let per_squared_spacing = (1.0 + ratio) / f64::from(allowed).powi(2);
            for (strip, plane) in
                planes.iter().enumerate().skip(first).take_while(|(strip, plane)| *strip == first || plane.at < covered.high)
            {
                examined += 1;
                if strip % stride != 0 {
                    continue;
                }
                let risk = per_squared_spacing * plane.after * plane.after;
                let found = &mut riskiest[strip];
                if risk > found[BINDING - 1].0 {
                    let place = found.iter().position(|&(other, _)| risk > other).unwrap_or(BINDING - 1);
                    found[place..].rotate_right(1);
                    found[place] = (risk, covered.facet);
                }
            }
        }
        riskiest
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
        let evaluate = |&(strip, facet): &(usize, u32)| {
            let spacing = planes[strip].after;
            let height = if (self.stop)() { None } else { self.height(spaced, facet, spacing) };
            Evaluated { strip, facet, height }
        };
        places.par_iter().with_min_len(64).map(evaluate).collect()
    }

    /// The height at a facet; `None` if the model has none, infinite if material stays uncut between the passes.
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

    /// The widest spacing at which a facet's height is [`AIM`] of the tolerance, at the feed that belongs to `spacing`.
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

/// The index of the strip that contains a coordinate across the passes. Strip i begins at plane i; coordinates before
/// the first plane belong to strip 0.
fn strip_of(planes: &[Plane], at: f64) -> usize {
    planes.partition_point(|plane| plane.at <= at).saturating_sub(1)
}

/// The factors of the next round; `None` if no strip needs a correction.
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
        if (inspector.stop)() {
            return None;
        }
        let is_over = height > OVER * tolerance;
        // The band's end determines the width of its last strip.
        let is_loose = widens && height < TIGHT * tolerance && strip + 1 < planes.len();
        if !is_over && !is_loose {
            return Some(1.0);
        }
        let spacing = planes[strip].after;
        let by_inverse = inspector.widest(spaced, facet, spacing).map(|widest| widest / spacing);
        // Heights are about proportional to the square of the spacing.
        let correction = by_inverse.unwrap_or_else(|| if height.is_finite() { (AIM * tolerance / height).sqrt() } else { 0.5 });
        // The factor is limited: with a spacing wider than the cutter, later corrections would have no effect.
        let widest = (spaced.widest / spacing).clamp(1.0, 1.2);
        Some(if is_over { correction.clamp(0.5, AIM) } else { correction.clamp(1.0, widest) })
    };
    let corrections: Vec<Option<f64>> = highest.par_iter().enumerate().with_min_len(8).map(correction).collect();
    #[expect(clippy::float_cmp, reason = "1 where nothing is corrected")]
    let changes = corrections.iter().flatten().any(|&correction| correction != 1.0);
    let mut last = None;
    let factors = planes.iter().zip(corrections).map(|(plane, correction)| {
        let own = spaced.factor(plane.at);
        // Strips without a height use their neighbour's factor.
        let factor = correction.map_or_else(|| last.unwrap_or(own), |correction| own * correction);
        last = Some(factor);
        (plane.at, factor)
    });
    let factors = factors.collect();
    changes.then_some(factors)
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
