//! The check of a plan: its scallop heights over the area, by model `envelope` with the curvature of each facet.

use super::inspector::{Evaluated, Inspector, OVER};
use super::march::{Fit, NoPlanes, Plane};
use super::refine::{Risks, Tightest, refine, tightest};
use super::simulate::{Operation, Simulated, simulate};
use super::spaced::Spaced;
use super::workpiece::Workpiece;
use crate::quantity::Length;

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

/// The number of further points, about: those that determine the strips, without those that [`CLEAR`] leaves out.
const CHOSEN: usize = 1000;

/// Facets whose refined spacing is over this multiple of the strip's width are not evaluated: their heights are under
/// those of the facets that bind the strip.
const CLEAR: f64 = 1.0005;

/// A plan whose heights exceed this share of the tolerance on more than a thousandth of the area loses confidence.
const FAR_OVER: f64 = 1.03;

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
    let risks = Risks::new(&spaced, inspector.cutter, stop);
    let is_refined =
        if follows { refine(&mut spaced, &risks, &inspector, operation.room, stop)? } else { vec![false; spaced.allowed.len()] };
    let fit = |place: u32, at: f64, width: f64, limit: f64| inspector.fitted(&spaced, place, at, [width, limit]);
    let fit: Option<&Fit> = if follows { Some(&fit) } else { None };
    let simulated = simulate(&spaced, operation, fit, stop)?;
    let workpiece = spaced.workpiece;
    let drawn = workpiece.drawn(DRAWN, |facet| !workpiece.tangents[facet].is_steep);
    #[expect(clippy::cast_possible_truncation, reason = "facets are bounded")]
    let drawn: Vec<u32> = drawn.into_iter().flat_map(|(facet, times)| std::iter::repeat_n(facet as u32, times)).collect();
    // Without marks a facet that allows more than its strip has a lower height. With marks the feed uses what is left.
    let is_clear = |&Tightest { strip, place }: &Tightest| {
        let allowed = f64::from(spaced.allowed[place as usize]);
        inspector.teeth_per_second.is_none() && is_refined[place as usize] && allowed > CLEAR * simulated.planes[strip].after
    };
    let (clear, chosen): (Vec<_>, Vec<_>) = tightest(&spaced, &simulated.planes, &risks, CHOSEN, stop).into_iter().partition(is_clear);
    let mut evaluated = heights_of(&inspector, &spaced, &simulated.planes, &drawn, &chosen);
    let places = evaluated.len();
    evaluated.extend(clear.iter().map(|one| Evaluated { facet: spaced.sweep.covered[one.place as usize].facet, height: None }));
    let figures = ScallopFigures { places, ..figures(&evaluated, drawn.len(), spaced.workpiece, inspector.tolerance) };
    Ok((simulated, figures))
}

/// The heights at the sampled facets, followed by those at the facets that determine the strips.
fn heights_of(inspector: &Inspector, spaced: &Spaced, planes: &[Plane], drawn: &[u32], chosen: &[Tightest]) -> Vec<Evaluated> {
    let chosen = chosen.iter().map(|&Tightest { strip, place }| (strip, spaced.sweep.covered[place as usize].facet));
    let places: Vec<(usize, u32)> = Inspector::by_strip(spaced, planes, drawn).into_iter().chain(chosen).collect();
    inspector.evaluate(spaced, planes, &places)
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
