//! Which cutter, in which direction, by how much.

use super::{Confidence, CriticalFormFactor, CriticalSlope, InclinedRectangle, Job, Zigzag, critical_form_factor, critical_slope};
use crate::milling::NoAnswer;
use crate::quantity::{Angle, OutOfRange};
use crate::surface::Shape;
use std::fmt;

/// One of a job's two cutters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutterChoice {
    /// The toroidal cutter, up and down the slope.
    Toroidal,
    /// The ball-end cutter, along the long side.
    BallEnd,
}

/// One way to finish a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The cutter.
    pub cutter: CutterChoice,
    /// The line along which it runs, seen from above, in [0, pi) from X: the steepest direction for the toroidal cutter, the principal
    /// direction for the ball-end cutter. `None` where the surface has no such direction, or was given without its place in XY.
    pub direction: Option<Angle>,
    /// Step-over, passes, length and time.
    pub zigzag: Zigzag,
}

/// Both ways to finish an inclined rectangle, and which is faster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The slope below which the toroidal cutter is faster on this rectangle.
    pub critical_slope: CriticalSlope,
    /// The form factor below which the toroidal cutter is faster on this slope.
    pub critical_form_factor: CriticalFormFactor,
    /// The toroidal cutter up and down the slope.
    pub toroidal: Candidate,
    /// The ball-end cutter along the long side.
    pub ball_end: Candidate,
    /// The toroidal cutter below the critical slope, else the ball-end cutter [Herraz et al. 2020, section 6.1].
    pub recommended: CutterChoice,
}

impl Plan {
    /// The candidate that is recommended.
    #[must_use]
    pub fn recommended(&self) -> &Candidate {
        match self.recommended {
            CutterChoice::Toroidal => &self.toroidal,
            CutterChoice::BallEnd => &self.ball_end,
        }
    }
}

/// A plan for a surface, and how far to trust it.
#[derive(Debug, Clone, PartialEq)]
pub struct Recommendation {
    /// Both candidates, with directions.
    pub plan: Plan,
    /// The weaknesses that the answer has.
    pub confidence: Confidence,
}

/// Why there is no plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanError {
    /// A side of the rectangle that stands for the surface is outside these bounds, in mm.
    Size(OutOfRange),
    /// The toroidal cutter has no step-over; on a level surface the analytic model has none.
    Toroidal(NoAnswer),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size(bounds) => write!(f, "both sides of the rectangle that stands for the surface {bounds} mm"),
            Self::Toroidal(no_answer) => write!(f, "the toroidal cutter up the slope: {no_answer}"),
        }
    }
}

impl std::error::Error for PlanError {}

/// Both ways to finish a rectangle at a slope from 0 to pi/2, without directions.
///
/// # Errors
/// [`NoAnswer`], when the toroidal cutter has no step-over: at slope 0 in the analytic model.
pub fn plan(job: &Job, rectangle: InclinedRectangle, slope: Angle) -> Result<Plan, NoAnswer> {
    let critical_slope = critical_slope(job, rectangle)?;
    let up_and_down = rectangle.up_and_down(job.toroidal_step_over(slope)?, job.machine());
    let along = rectangle.along_the_long_side(job.ball_end_step_over(), job.machine());
    let recommended = if critical_slope.favours_toroidal(slope) { CutterChoice::Toroidal } else { CutterChoice::BallEnd };
    Ok(Plan {
        critical_slope,
        critical_form_factor: critical_form_factor(job, rectangle.characteristic_size(), slope)?,
        toroidal: Candidate { cutter: CutterChoice::Toroidal, direction: None, zigzag: up_and_down },
        ball_end: Candidate { cutter: CutterChoice::BallEnd, direction: None, zigzag: along },
        recommended,
    })
}

/// The recommendation for a surface, by the rectangle that has its form factor and characteristic size, at its slope
/// [Herraz et al. 2020, section 6.1].
///
/// A surface without steepest direction is level: what is left of its slope is rounding, and would be taken for a groove of
/// kilometres' radius.
///
/// # Errors
/// [`PlanError`]
pub fn recommend(job: &Job, shape: &Shape) -> Result<Recommendation, PlanError> {
    let rectangle = InclinedRectangle::from_form(shape.form_factor, shape.characteristic_size).map_err(PlanError::Size)?;
    let slope = if shape.steepest_direction.is_some() { shape.slope } else { Angle::ZERO };
    let mut plan = plan(job, rectangle, slope).map_err(PlanError::Toroidal)?;
    plan.toroidal.direction = shape.steepest_direction;
    plan.ball_end.direction = shape.principal_direction;
    let confidence = Confidence::in_plan(&plan, job, rectangle, shape);
    Ok(Recommendation { plan, confidence })
}
