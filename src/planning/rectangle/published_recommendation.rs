//! The recommendation of a cutter for a surface by method `rectangle`.

use super::{CutterComparison, InclinedRectangle, Plan, Weakness, plan};
use crate::milling::NoAnswer;
use crate::planning::Confidence;
use crate::quantity::{Angle, OutOfRange};
use crate::surface::Shape;
use std::fmt;

/// A plan for a surface, with its confidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Recommendation {
    /// Both candidates, with directions.
    pub plan: Plan,
    /// The confidence in the recommendation.
    pub confidence: Confidence<Weakness>,
}

/// The reason why there is no plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanError {
    /// A side of the surface's equivalent rectangle is outside these bounds, in mm.
    Size(OutOfRange),
    /// The toroidal cutter has no step-over; on a level surface the analytic model has none.
    Toroidal(NoAnswer),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size(bounds) => write!(f, "both sides of the surface's equivalent rectangle {bounds} mm"),
            Self::Toroidal(no_answer) => write!(f, "the toroidal cutter up the slope: {no_answer}"),
        }
    }
}

impl std::error::Error for PlanError {}

/// The recommendation for a surface, by the rectangle that has its form factor and characteristic size, at its slope
/// [Herraz et al. 2020, section 6.1].
///
/// A surface without a steepest direction counts as level: its slope is only a rounding error, with which the groove
/// would have a radius of kilometres.
///
/// # Errors
/// [`PlanError`]
pub fn recommend(job: &CutterComparison, shape: &Shape) -> Result<Recommendation, PlanError> {
    let rectangle = InclinedRectangle::from_form(shape.form_factor, shape.characteristic_size).map_err(PlanError::Size)?;
    let slope = if shape.steepest_direction.is_some() { shape.slope } else { Angle::ZERO };
    let mut plan = plan(job, rectangle, slope).map_err(PlanError::Toroidal)?;
    plan.toroidal.direction = shape.steepest_direction;
    plan.ball_end.direction = shape.principal_direction;
    let confidence = Confidence::in_plan(&plan, job, rectangle, shape);
    Ok(Recommendation { plan, confidence })
}
