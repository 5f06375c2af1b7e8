//! Heights and widest spacings at single facets, by model `envelope` with the curvature of each.

use super::contacts::{FacetContact, NoContact};
use super::imprint::Imprints;
use super::march::Plane;
use super::prepared::Prepared;
use super::settings::ZigzagSettings;
use super::spaced::Spaced;
use super::spacing::FeedLaw;
use crate::milling::{Cutter, CutterKind, Model, NoAnswer};
use crate::quantity::Length;
use crate::surface::FinishFacet;
use rayon::prelude::*;

/// Shares of the tolerance: spacings are set to `AIM`, with tooth marks to `AIM_WITH_MARKS`, because the feed of a
/// spacing under the largest one exceeds the tolerance by up to 1.4 %.
const AIM: f64 = 0.99;
const AIM_WITH_MARKS: f64 = 0.975;

/// Heights above this share of the tolerance are too high: the accuracy of the spacing.
pub(super) const OVER: f64 = 1.0033;

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

/// The data from which heights and spacings are computed.
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
pub(super) struct Evaluated {
    pub(super) facet: u32,
    pub(super) height: Option<f64>,
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
        self.evaluate(spaced, planes, &Self::by_strip(spaced, planes, facets)).into_iter().map(|evaluated| evaluated.height).collect()
    }

    /// Pairs each facet with the strip that contains its centroid.
    pub(super) fn by_strip(spaced: &Spaced, planes: &[Plane], facets: &[u32]) -> Vec<(usize, u32)> {
        let heading = spaced.sweep.heading;
        let middle = |facet: u32| {
            let corners = spaced.workpiece.corners[facet as usize];
            corners.iter().map(|&[x, y, _]| heading.across(x, y)).sum::<f64>() / 3.0
        };
        facets.iter().map(|&facet| (strip_of(planes, middle(facet)), facet)).collect()
    }

    /// The heights at facets, each with the number of its strip.
    pub(super) fn evaluate(&self, spaced: &Spaced, planes: &[Plane], places: &[(usize, u32)]) -> Vec<Evaluated> {
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
