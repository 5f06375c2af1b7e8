//! The job of the published method: two cutters to compare, the scallop height that they may leave, and the machine.

use crate::milling::{Contact, Cutter, CutterKind, EffectiveRadius, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use crate::motion::MachineLimits;
use crate::quantity::{Angle, Length};
use std::fmt;

/// A finishing job: a toroidal and a ball-end cutter, the scallop height sh that they may leave, and the machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterComparison {
    toroidal: Cutter,
    ball_end: Cutter,
    scallop_height: Length,
    machine: MachineLimits,
    model: Model,
    ball_end_step_over: Length,
}

/// The reason why cutters and scallop height do not make a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JobError {
    /// The first cutter is not toroidal.
    NotToroidal,
    /// The second cutter is not a ball-end.
    NotBallEnd,
    /// The scallop would be higher than the round of a cutter.
    ScallopTooHigh {
        /// The smaller of the toroidal cutter's corner radius and the ball's radius.
        largest: Length,
    },
    /// The ball-end cutter has no step-over at that height.
    BallEnd(NoAnswer),
}

impl fmt::Display for JobError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotToroidal => f.write_str("the first cutter must be toroidal, with 0 < corner radius < half the diameter"),
            Self::NotBallEnd => f.write_str("the second cutter must be a ball-end"),
            Self::ScallopTooHigh { largest } => write!(
                f,
                "the scallop height must be at most {} mm, the smaller of the toroidal cutter's corner radius and the ball's radius",
                largest.mm()
            ),
            Self::BallEnd(no_answer) => write!(f, "the ball-end cutter: {no_answer}"),
        }
    }
}

impl std::error::Error for JobError {}

impl CutterComparison {
    /// A job whose scallops are within the round of both cutters: sh <= r of the toroidal and R of the ball-end cutter.
    /// The cutters may have different diameters.
    ///
    /// # Errors
    /// [`JobError`]
    pub fn new(toroidal: Cutter, ball_end: Cutter, scallop_height: Length, machine: MachineLimits, model: Model) -> Result<Self, JobError> {
        if toroidal.kind() != CutterKind::Toroidal {
            return Err(JobError::NotToroidal);
        }
        if ball_end.kind() != CutterKind::BallEnd {
            return Err(JobError::NotBallEnd);
        }
        let (corner, ball) = (toroidal.corner_radius(), ball_end.outer_radius());
        let largest = if corner < ball { corner } else { ball };
        if scallop_height > largest {
            return Err(JobError::ScallopTooHigh { largest });
        }
        // A ball leaves the same height on every slope and in both models, so its step-over is computed once.
        let ball_end_step_over = step_over(Model::Analytic, ball_end, Angle::ZERO, scallop_height).map_err(JobError::BallEnd)?;
        Ok(Self { toroidal, ball_end, scallop_height, machine, model, ball_end_step_over })
    }

    /// sod1, the step-over of the toroidal cutter up and down a slope: chord((R - r)/sin(s) + r, sh) in the analytic
    /// model [Herraz et al. 2020, eq. 6 and 7], at most that of a floor, 2(R - r) + 2 sqrt(2 r sh - sh^2) [section 4.1.1].
    ///
    /// # Errors
    /// The cases in which the model has no step-over.
    pub fn toroidal_step_over(&self, slope: Angle) -> Result<Length, NoAnswer> {
        step_over(self.model, self.toroidal, slope, self.scallop_height)
    }

    /// sod2, the step-over of the ball-end cutter on any slope and in any direction: chord(R, sh).
    #[must_use]
    pub fn ball_end_step_over(&self) -> Length {
        self.ball_end_step_over
    }

    /// The toroidal cutter.
    #[must_use]
    pub fn toroidal(&self) -> Cutter {
        self.toroidal
    }

    /// The ball-end cutter.
    #[must_use]
    pub fn ball_end(&self) -> Cutter {
        self.ball_end
    }

    /// sh, the scallop height.
    #[must_use]
    pub fn scallop_height(&self) -> Length {
        self.scallop_height
    }

    /// The machine.
    #[must_use]
    pub fn machine(&self) -> MachineLimits {
        self.machine
    }

    /// The model that computes the step-over for the scallop height. The published method and its closed forms use the
    /// analytic one.
    #[must_use]
    pub fn model(&self) -> Model {
        self.model
    }
}

/// The largest step-over of a pass along the steepest slope of a plane.
///
/// In model `analytic` that is the published chord. Near a floor its circle is wider than the cutter; there the published
/// bound holds, the step-over on the floor itself.
fn step_over(model: Model, cutter: Cutter, slope: Angle, scallop_height: Length) -> Result<Length, NoAnswer> {
    let contact = Contact::up_the_slope(slope);
    if model == Model::Analytic {
        let on_floor = cutter.step_over_on_floor(scallop_height);
        let Some(radius) = EffectiveRadius::across_feed(cutter, contact).finite() else { return Ok(on_floor) };
        let (radius, height) = (radius.mm(), scallop_height.mm());
        if height >= radius {
            return Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: Length::computed(2.0 * radius) });
        }
        // The root of the product is taken factor by factor, because the product can overflow or underflow.
        let chord = Length::computed(2.0 * height.sqrt() * (2.0 * radius - height).sqrt());
        return Ok(if chord < on_floor { chord } else { on_floor });
    }
    let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    match EvaluatedPass::new(model, pass)?.max_step_over(scallop_height, None) {
        // The scallop is as high as the corner radius, up to rounding: the passes have their largest distance.
        Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over }) => Ok(largest_step_over),
        found => found,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::PRESETS;

    fn mm(value: f64) -> Length {
        Length::from_mm(value).unwrap()
    }

    fn job(toroidal: Cutter, ball_end: Cutter, scallop_height: f64) -> Result<CutterComparison, JobError> {
        CutterComparison::new(toroidal, ball_end, mm(scallop_height), PRESETS[0].limits, Model::Analytic)
    }

    #[test]
    fn cutters_must_be_of_their_kind_and_rounder_than_the_scallop() {
        let (toroidal, ball) = (Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::ball_end(mm(10.0)));
        assert_eq!(job(ball, ball, 0.01), Err(JobError::NotToroidal));
        assert_eq!(job(Cutter::flat_end(mm(10.0)), ball, 0.01), Err(JobError::NotToroidal));
        assert_eq!(job(toroidal, toroidal, 0.01), Err(JobError::NotBallEnd));
        assert_eq!(job(toroidal, ball, 2.1), Err(JobError::ScallopTooHigh { largest: mm(2.0) }));
        assert_eq!(job(toroidal, Cutter::ball_end(mm(1.0)), 1.0), Err(JobError::ScallopTooHigh { largest: mm(0.5) }));
        // With a scallop as high as the ball's radius, the grooves only touch, so that there is no largest step-over.
        assert!(matches!(
            job(toroidal, Cutter::ball_end(mm(1.0)), 0.5),
            Err(JobError::BallEnd(NoAnswer::ToleranceLimitsNoStepOver { .. }))
        ));
        assert!(job(toroidal, ball, 2.0).is_ok());
    }

    #[test]
    fn step_overs_are_the_chords_of_their_grooves() {
        let job = job(Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::ball_end(mm(12.0)), 0.01).unwrap();
        let chord = |radius: f64| 2.0 * (2.0 * radius * 0.01 - 0.01 * 0.01).sqrt();
        approx::assert_relative_eq!(job.ball_end_step_over().mm(), chord(6.0), max_relative = 1e-14);
        let slope = Angle::from_degrees(30.0).unwrap();
        // R_eff = 3/sin(30 deg) + 2 = 8
        approx::assert_relative_eq!(job.toroidal_step_over(slope).unwrap().mm(), chord(8.0), max_relative = 1e-14);
        // The paper's 6.4 mm on a floor, which the chord exceeds from 0.33 deg down.
        let on_floor = 6.0 + 2.0 * (0.04_f64 - 0.0001).sqrt();
        for slope in [0.0, 1e-300, 0.2, 0.33] {
            let step_over = job.toroidal_step_over(Angle::from_degrees(slope).unwrap()).unwrap();
            approx::assert_relative_eq!(step_over.mm(), on_floor, max_relative = 1e-14);
        }
    }

    #[test]
    fn both_models_agree_on_a_floor_and_nearly_on_a_slope() {
        let (toroidal, ball) = (Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::ball_end(mm(10.0)));
        let of = |model| CutterComparison::new(toroidal, ball, mm(0.01), PRESETS[0].limits, model).unwrap();
        let (circle, envelope) = (of(Model::Analytic), of(Model::Envelope));
        assert_eq!(circle.ball_end_step_over(), envelope.ball_end_step_over());
        // On a floor the corners leave it: 2 (R - r) of flat, and the chord of r, 2 sqrt(2 * 2 * 0.01 - 0.01^2).
        let on_floor = envelope.toroidal_step_over(Angle::ZERO).unwrap().mm();
        approx::assert_relative_eq!(on_floor, 6.0 + 2.0 * (0.04_f64 - 0.0001).sqrt(), max_relative = 1e-9);
        approx::assert_relative_eq!(on_floor, circle.toroidal_step_over(Angle::ZERO).unwrap().mm(), max_relative = 1e-9);
        // At 40 deg and a step of 0.73 mm the heights are 9.999 and 10.006 um: h grows with s^2, so s differs by half
        // of 7e-4.
        let slope = Angle::from_degrees(40.0).unwrap();
        let (one, other) = (circle.toroidal_step_over(slope).unwrap().mm(), envelope.toroidal_step_over(slope).unwrap().mm());
        assert!(other < one && other > one * (1.0 - 5e-4), "{one} {other}");
    }
}
