//! The plan by method `rectangle`: the passes of both cutters, and the faster of them.

use super::{CriticalFormFactor, CriticalSlope, CutterComparison, InclinedRectangle, Zigzag, critical_form_factor, critical_slope};
use crate::milling::NoAnswer;
use crate::quantity::Angle;

/// One of a job's two cutters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CutterChoice {
    /// The toroidal cutter, up and down the slope.
    Toroidal,
    /// The ball-end cutter, along the long side.
    BallEnd,
}

/// A cutter with the figures of its passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The cutter.
    pub cutter: CutterChoice,
    /// The direction of its passes seen from above, a line in [0, pi) from X: the steepest direction for the toroidal
    /// cutter, the principal direction for the ball-end cutter. `None` if the surface has no such direction, or its
    /// position in XY is not known.
    pub direction: Option<Angle>,
    /// Step-over, passes, length and time.
    pub zigzag: Zigzag,
}

/// Both candidates on an inclined rectangle, and the faster one.
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
    /// The toroidal cutter below the critical slope, otherwise the ball-end cutter [Herraz et al. 2020, section 6.1].
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

    /// The same passes in `factor` times the time, which leaves the critical values as they are.
    #[must_use]
    pub fn slowed(self, factor: f64) -> Self {
        let slowed = |candidate: Candidate| Candidate { zigzag: candidate.zigzag.slowed(factor), ..candidate };
        Self { toroidal: slowed(self.toroidal), ball_end: slowed(self.ball_end), ..self }
    }
}

/// Both candidates on a rectangle at a slope from 0 to pi/2, without directions.
///
/// # Errors
/// [`NoAnswer`] if the toroidal cutter has no step-over.
pub fn plan(job: &CutterComparison, rectangle: InclinedRectangle, slope: Angle) -> Result<Plan, NoAnswer> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::{Cutter, Model};
    use crate::motion::MachineLimits;
    use crate::quantity::{Acceleration, Area, FormFactor, Jerk, Length, Speed};
    use proptest::prelude::*;

    /// All valid values, decade by decade.
    fn decades(smallest: f64, largest: f64) -> impl Strategy<Value = f64> {
        (smallest.log10()..=largest.log10()).prop_map(move |exponent| 10.0_f64.powf(exponent).clamp(smallest, largest))
    }

    fn machines() -> impl Strategy<Value = MachineLimits> {
        let limits = (
            decades(Speed::SMALLEST, Speed::LARGEST),
            decades(Acceleration::SMALLEST, Acceleration::LARGEST),
            decades(Jerk::SMALLEST, Jerk::LARGEST),
        );
        limits.prop_map(|(v, a, j)| MachineLimits {
            feed_rate: Speed::from_mm_min(v).unwrap(),
            acceleration: Acceleration::from_m_s2(a).unwrap(),
            jerk: Jerk::from_m_s3(j).unwrap(),
        })
    }

    fn lengths() -> impl Strategy<Value = Length> {
        decades(Length::SMALLEST, Length::LARGEST).prop_map(|mm| Length::from_mm(mm).unwrap())
    }

    proptest! {
        #![proptest_config(ProptestConfig { max_global_rejects: 1_000_000, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn all_valid_jobs_have_a_consistent_plan(
            (diameter, corner, ball, scallop) in (lengths(), lengths(), lengths(), lengths()),
            machine in machines(),
            mu in decades(1.0, FormFactor::LARGEST),
            chi in decades(Area::SMALLEST, Area::LARGEST),
            slope in prop_oneof![0.0..=90.0_f64, decades(1e-300, 90.0)],
            model in prop_oneof![3 => Just(Model::Analytic), 1 => Just(Model::Envelope)],
        ) {
            let Ok(toroidal) = Cutter::toroidal(diameter, corner) else { return Err(TestCaseError::reject("corner")) };
            let job = CutterComparison::new(toroidal, Cutter::ball_end(ball), scallop, machine, model);
            let Ok(job) = job else { return Err(TestCaseError::reject("scallop")) };
            let rectangle = InclinedRectangle::from_form(FormFactor::new(mu).unwrap(), Area::from_mm2(chi).unwrap());
            let Ok(rectangle) = rectangle else { return Err(TestCaseError::reject("sides")) };
            let slope = Angle::from_degrees(slope).unwrap();
            // In debug builds, the constructors of quantities check that these are finite.
            let plan = plan(&job, rectangle, slope).unwrap();
            let (one, other) = (plan.toroidal.zigzag.time.seconds(), plan.ball_end.zigzag.time.seconds());
            // Where the times differ by more than rounding, the faster cutter is recommended; flatter slopes than
            // 1e-6 deg count as equal.
            if slope.degrees() > 1e-6 && (one - other).abs() > 1e-9 * one.max(other) {
                let faster = if one < other { CutterChoice::Toroidal } else { CutterChoice::BallEnd };
                prop_assert_eq!(plan.recommended, faster, "{:?}", plan);
            }
            prop_assert!(plan.toroidal.zigzag.passes.is_finite() && plan.ball_end.zigzag.passes.is_finite());
        }
    }
}
