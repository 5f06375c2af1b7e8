//! Wire objects of the two candidates that the published method compares, and of the faster one.

use crate::http::codes::{WarningCode, same_names};
use crate::http::wire::{Warning, answer};
use crate::milling::{Contact, Cutter, CutterKind, Envelope, Pass, Runout, SurfaceCurvature};
use crate::motion::{MachineLimits, TravelCase};
use crate::planning::{Candidate, CriticalSlope, CutterChoice};
use crate::quantity::{Angle, Length};
use serde::Serialize;
use utoipa::ToSchema;

/// A cutter of the comparison, with its direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(super) enum ComparedCutter {
    /// The toroidal cutter, up and down the slope.
    Toroidal,
    /// The ball-end cutter, along the long side.
    BallEnd,
}

/// The limits of the machine that a straight move from rest to rest reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = TravelCase)]
pub(super) enum TravelCaseName {
    /// Neither the feed rate nor the acceleration; the jerk alone limits the move.
    JerkOnly,
    /// The feed rate, but not the acceleration.
    FeedRate,
    /// The feed rate and the acceleration.
    FeedRateAndAcceleration,
    /// The acceleration, but not the feed rate.
    Acceleration,
}

same_names!(TravelCase => TravelCaseName: JerkOnly, FeedRate, FeedRateAndAcceleration, Acceleration);

same_names!(CutterChoice => ComparedCutter: Toroidal, BallEnd);

answer! {
    /// The faster cutter and its passes.
    #[derive(Clone)]
    pub(super) struct Recommended of (candidate: &Candidate) {
        /// The cutter.
        cutter: ComparedCutter = candidate.cutter.into(),
        /// The distance of the passes along the surface.
        step_over_mm: f64 [minimum = 0] = candidate.zigzag.step_over.mm(),
        /// The time of the zigzag, stops at all corners included.
        machining_time_s: f64 [minimum = 0] = candidate.zigzag.time.seconds(),
    }

    /// A cutter with the figures of its passes.
    #[derive(Clone)]
    pub(super) struct CandidateAnswer of (candidate: &Candidate, effective_radius: Option<Length>, pass: Length, machine: MachineLimits) {
        /// The cutter.
        cutter: ComparedCutter = candidate.cutter.into(),
        /// R_eff, the effective radius across the feed; absent on a floor, where that of a toroidal cutter is infinite.
        effective_radius_mm?: f64 [minimum = 0] = effective_radius.map(Length::mm),
        /// The distance of the passes along the surface.
        step_over_mm: f64 [minimum = 0] = candidate.zigzag.step_over.mm(),
        /// The length of a pass: the height of the rectangle for the toroidal cutter, its width for the ball-end cutter.
        pass_length_mm: f64 [minimum = 0] = pass.mm(),
        /// Which limits a pass reaches.
        pass_case: TravelCaseName = TravelCase::of(pass, machine).into(),
        /// Which limits a step from pass to pass reaches.
        step_case: TravelCaseName = TravelCase::of(candidate.zigzag.step_over, machine).into(),
        /// The number of passes: the length of the side across them divided by the step-over, not rounded.
        passes: f64 [minimum = 0] = candidate.zigzag.passes,
        /// The length of all passes and the steps between them.
        path_length_mm: f64 [minimum = 0] = candidate.zigzag.path_length.mm(),
        /// The time of the zigzag, stops at all corners included.
        machining_time_s: f64 [minimum = 0] = candidate.zigzag.time.seconds(),
    }
}

/// The share over the scallop height from which an analytic step-over is outside the model's range: the height is then 5 %
/// under what the cutter leaves.
const OUTSIDE_RANGE: f64 = 1.0 / 0.95;

/// The warning that an analytic step-over up the slope of a plane leaves far more than the scallop height by the cutter's
/// exact shape. A ball-end cutter leaves what the model says.
pub(super) fn outside_range(
    named: &str,
    cutter: Cutter,
    slope: Angle,
    step_over: Length,
    feed_per_tooth: Option<Length>,
    height: Length,
) -> Option<Warning> {
    if cutter.kind() == CutterKind::BallEnd {
        return None;
    }
    let pass = Pass { cutter, contact: Contact::up_the_slope(slope), surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    let left = Envelope::new(pass).and_then(|envelope| envelope.scallop_height(step_over, feed_per_tooth));
    let detail = match left {
        Ok(left) if left.total().mm() <= OUTSIDE_RANGE * height.mm() => return None,
        Ok(left) => format!(
            "the step-over of {named}, {:.3} mm, leaves {:.6} mm by the cutter's exact shape, {:.1} times the scallop height; model \"envelope\" keeps it",
            step_over.mm(),
            left.total().mm(),
            left.total().mm() / height.mm()
        ),
        Err(cause) => format!("the step-over of {named}, {:.3} mm, leaves no scallop by the cutter's exact shape: {cause}", step_over.mm()),
    };
    Some(Warning::new(WarningCode::OutsideAnalyticRange, detail))
}

/// The direction of a line in degrees, in [0, 180). It is rounded to 1e-9 deg, because the conversion to radians and
/// back has a rounding error; a line that rounds to 180 is 0.
pub(super) fn line_degrees(line: Angle) -> f64 {
    let degrees = (line.degrees() * 1e9).round() / 1e9;
    if degrees < 180.0 { degrees } else { 0.0 }
}

/// The cutter that is faster on every slope; `None` if there is a critical slope.
pub(super) fn always_faster(critical: CriticalSlope) -> Option<ComparedCutter> {
    match critical {
        CriticalSlope::At(_) => None,
        CriticalSlope::ToroidalAlways => Some(ComparedCutter::Toroidal),
        CriticalSlope::BallEndAlways => Some(ComparedCutter::BallEnd),
    }
}
