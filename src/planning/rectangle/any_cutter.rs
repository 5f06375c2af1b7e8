//! The zigzag of one cutter of any kind on the equivalent rectangle of a surface, for comparison with the simulation on
//! the surface.

use super::{InclinedRectangle, Zigzag};
use crate::milling::{Contact, Cutter, CutterKind, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use crate::motion::MachineLimits;
use crate::quantity::{Angle, Length, OutOfRange};
use crate::surface::Shape;

/// A zigzag on the rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectanglePlan {
    /// The direction of the passes: the principal direction for a ball-end cutter, the steepest for others; `None` if
    /// the surface has none.
    pub direction: Option<Angle>,
    /// Step-over, passes, length and time.
    pub zigzag: Zigzag,
}

/// The zigzag of a cutter on the equivalent rectangle of a surface: a ball-end cutter along the long side, a toroidal
/// or flat-end cutter up and down the slope [Herraz et al. 2020, section 6.1].
///
/// The step-over is at most the cutter's diameter. On a level surface, on which model `analytic` has no answer, it is
/// the diameter. `None` if the model has no step-over.
///
/// # Errors
/// [`OutOfRange`] with the bounds in mm, if a side of the rectangle is outside them.
pub fn plan_on_rectangle(
    cutter: Cutter,
    shape: &Shape,
    scallop_height: Length,
    machine: MachineLimits,
    model: Model,
) -> Result<Option<RectanglePlan>, OutOfRange> {
    let rectangle = InclinedRectangle::from_form(shape.form_factor, shape.characteristic_size)?;
    let slope = if shape.steepest_direction.is_some() { shape.slope } else { Angle::ZERO };
    let is_ball = cutter.kind() == CutterKind::BallEnd;
    let Some(step_over) = step_over(cutter, if is_ball { Angle::ZERO } else { slope }, scallop_height, model) else { return Ok(None) };
    Ok(Some(if is_ball {
        RectanglePlan { direction: shape.principal_direction, zigzag: rectangle.along_the_long_side(step_over, machine) }
    } else {
        RectanglePlan { direction: shape.steepest_direction, zigzag: rectangle.up_and_down(step_over, machine) }
    }))
}

/// The largest step-over along the steepest line of a plane, at most the cutter's diameter.
fn step_over(cutter: Cutter, slope: Angle, scallop_height: Length, model: Model) -> Option<Length> {
    let diameter = cutter.outer_radius() + cutter.outer_radius();
    let pass = Pass { cutter, contact: Contact::up_the_slope(slope), surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    let step_over = match EvaluatedPass::new(model, pass).and_then(|evaluated| evaluated.max_step_over(scallop_height, None)) {
        Ok(step_over) => step_over,
        Err(NoAnswer::FlatFloor) => diameter,
        Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over }) => largest_step_over,
        Err(_) => return None,
    };
    Some(if step_over < diameter { step_over } else { diameter })
}
