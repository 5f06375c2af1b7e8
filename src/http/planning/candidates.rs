//! Wire objects of the two candidates that the published method compares, and of the faster one.

use crate::http::codes::same_names;
use crate::http::wire::answer;
use crate::planning::{Candidate, CriticalSlope, CutterChoice};
use crate::quantity::Angle;
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
    pub(super) struct CandidateAnswer of (candidate: &Candidate) {
        /// The cutter.
        cutter: ComparedCutter = candidate.cutter.into(),
        /// The distance of the passes along the surface.
        step_over_mm: f64 [minimum = 0] = candidate.zigzag.step_over.mm(),
        /// The number of passes: the length of the side across them divided by the step-over, not rounded.
        passes: f64 [minimum = 0] = candidate.zigzag.passes,
        /// The length of all passes and the steps between them.
        path_length_mm: f64 [minimum = 0] = candidate.zigzag.path_length.mm(),
        /// The time of the zigzag, stops at all corners included.
        machining_time_s: f64 [minimum = 0] = candidate.zigzag.time.seconds(),
    }
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
