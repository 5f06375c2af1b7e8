//! A lower bound of the time of any zigzag: the time to finish every point with the widest step-over of any direction,
//! without stops.

use super::prepared::Prepared;
use super::workpiece::{Tangent, Workpiece};

/// The number of directions at each facet. Step-overs squared are nearly linear in cos^2(alpha). The widest lies within
/// 2.5 deg of one of these directions and exceeds its step-over by at most 0.2 %, which [`SLACK`] covers.
const DIRECTIONS: u32 = 36;
const SLACK: f64 = 0.998;

/// Facets beyond this number are sampled.
const MOST_FACETS: usize = 600;

/// The integral of dA / (v s) over the surface, in s. v s is the largest product of feed rate and step-over of any
/// direction at the facet. Facets that set no spacing add no time.
pub(super) fn least_seconds(workpiece: &Workpiece, prepared: &Prepared) -> f64 {
    let sampled;
    let workpiece = if workpiece.len() > MOST_FACETS {
        sampled = workpiece.sampled(MOST_FACETS, None);
        &sampled
    } else {
        workpiece
    };
    let directions: Vec<[f64; 2]> = (0..DIRECTIONS)
        .map(|step| {
            let (sin, cos) = (f64::from(step) * std::f64::consts::PI / f64::from(DIRECTIONS)).sin_cos();
            [cos, sin]
        })
        .collect();
    let time = |(tangent, area): (&Tangent, &f64)| {
        if tangent.is_steep {
            return 0.0;
        }
        let rate = directions.iter().map(|&e| {
            let (cos_alpha, sin_alpha) = tangent.alpha(e);
            let squared = prepared.spacing.squared(tangent, cos_alpha, sin_alpha);
            (squared / tangent.ratio_squared(cos_alpha)).sqrt() * prepared.feeds.rate(tangent, cos_alpha, 1.0)
        });
        let widest = rate.fold(0.0, f64::max);
        if widest > 0.0 { area / widest } else { 0.0 }
    };
    SLACK * workpiece.tangents.iter().zip(&workpiece.areas).map(time).sum::<f64>()
}
