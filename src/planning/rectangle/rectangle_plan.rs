//! The plan by method `rectangle`: the passes of both cutters and the faster of them, and the passes of one cutter of any kind on
//! the equivalent rectangle of a surface.

use super::{CriticalFormFactor, CriticalSlope, CutterComparison, InclinedRectangle, Zigzag, critical_form_factor, critical_slope};
use crate::milling::{Contact, Cutter, CutterKind, CuttingLimits, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use crate::motion::{Machine, MachineLimits, travel_time};
use crate::planning::plan::{CandidateCutter, FeedRange, Pattern, PlanSettings};
use crate::quantity::{Angle, Length, OutOfRange, Speed, Time};
use crate::surface::Shape;

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

/// The passes on the rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RectanglePlan {
    /// The direction of the passes: the principal direction for a ball-end cutter, the steepest for others; `None` if
    /// the surface has none.
    pub direction: Option<Angle>,
    /// Step-over, passes, length and time, returns included.
    pub zigzag: Zigzag,
    /// The feed rate of the passes.
    pub feed_rate: Speed,
    /// The feed per tooth; `None` for a cutter without a drive.
    pub feed_per_tooth: Option<Length>,
}

/// The passes of a cutter on the equivalent rectangle of a surface: a ball-end cutter along the long side, all others
/// up and down the slope [Herraz et al. 2020, section 6.1].
///
/// A cutter without a drive takes the step-over that leaves the scallop height, at the machine's feed rate, as
/// published. A cutter with a drive takes the step-over and feed that finish the most area per time, its tooth marks
/// within the scallop height, and the feed within the limits of cutter and machine. The step-over is at most the cutter's
/// diameter, and in model `analytic` at most that of a floor. `None` if the model has no step-over.
///
/// # Errors
/// [`OutOfRange`] with the bounds in mm, if a side of the rectangle is outside them.
pub fn plan_on_rectangle(
    candidate: &CandidateCutter,
    shape: &Shape,
    settings: &PlanSettings,
    model: Model,
) -> Result<Option<RectanglePlan>, OutOfRange> {
    let rectangle = InclinedRectangle::from_form(shape.form_factor, shape.characteristic_size)?;
    let slope = if shape.steepest_direction.is_some() { shape.slope } else { Angle::ZERO };
    let is_ball = candidate.cutter.kind() == CutterKind::BallEnd;
    let feeds = candidate.drive.map(|drive| FeedRange::of(drive, &settings.machine));
    // A ball-end cutter leaves the same height on every slope.
    let at = if is_ball { Angle::ZERO } else { slope };
    let Some(parameters) = parameters(candidate.cutter, at, settings.scallop_height, model, feeds) else { return Ok(None) };
    let limits = settings.machine.limits;
    let feed_rate = match (feeds, parameters.feed_per_tooth) {
        (Some(feeds), Some(feed)) => Speed::computed(feeds.rate(feed.mm())),
        _ => limits.feed_rate,
    };
    let limits = MachineLimits { feed_rate, ..limits };
    let (direction, zigzag) = if is_ball {
        (shape.principal_direction, rectangle.along_the_long_side(parameters.step_over, limits))
    } else {
        (shape.steepest_direction, rectangle.up_and_down(parameters.step_over, limits))
    };
    let zigzag = match settings.pattern {
        Pattern::Zigzag => zigzag,
        Pattern::OneWay => one_way(zigzag, rectangle, slope, is_ball, limits, &settings.machine),
    };
    let zigzag = zigzag.slowed(settings.machine.time_factor);
    Ok(Some(RectanglePlan { direction, zigzag, feed_rate, feed_per_tooth: parameters.feed_per_tooth }))
}

/// These passes in one direction. After each, the cutter rises to the clearance height over the highest edge, returns
/// and comes down, at the rapid rate: three moves from rest to rest. Level passes are timed from the middle of the slope.
fn one_way(zigzag: Zigzag, rectangle: InclinedRectangle, slope: Angle, is_level: bool, limits: MachineLimits, machine: &Machine) -> Zigzag {
    let (clearance, rise, step) = (machine.clearance_height.mm(), rectangle.height().mm() * slope.sin(), zigzag.step_over.mm());
    let (pass, lift, back, down) = if is_level {
        let lift = clearance + rise / 2.0;
        (rectangle.width(), lift, rectangle.width().mm().hypot(step * slope.cos()), lift)
    } else {
        (rectangle.height(), clearance, (rectangle.height().mm() * slope.cos()).hypot(step), clearance + rise)
    };
    let rapid = machine.rapid_limits();
    let returns: f64 = [lift, back, down].map(|length| travel_time(Length::computed(length), rapid).seconds()).iter().sum();
    Zigzag {
        path_length: Length::computed(zigzag.passes * (pass.mm() + lift + back + down)),
        time: Time::computed(zigzag.passes * (travel_time(pass, limits).seconds() + returns)),
        ..zigzag
    }
}

/// The step-over and feed of passes on a plane.
struct Parameters {
    step_over: Length,
    feed_per_tooth: Option<Length>,
}

/// The slope in degrees that stands for a floor in model `analytic`, which has no answer on the floor itself: 17 nm over a
/// metre.
const FLATTEST: f64 = 1e-6;

/// The step-over and feed along the steepest line of a plane.
fn parameters(cutter: Cutter, slope: Angle, height: Length, model: Model, feeds: Option<FeedRange>) -> Option<Parameters> {
    let diameter = cutter.outer_radius() + cutter.outer_radius();
    let is_analytic = model == Model::Analytic;
    let slope = if is_analytic && slope.degrees() < FLATTEST { Angle::from_radians(FLATTEST.to_radians()) } else { slope };
    let widest = |height: Length| if is_analytic { cutter.step_over_on_floor(height) } else { diameter };
    let pass = Pass { cutter, contact: Contact::up_the_slope(slope), surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    let evaluated = EvaluatedPass::new(model, pass).ok()?;
    let Some(feeds) = feeds else {
        let step_over = match evaluated.max_step_over(height, None) {
            Ok(step_over) => step_over,
            Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over }) => largest_step_over,
            Err(_) => return None,
        };
        return Some(Parameters { step_over: smaller(step_over, widest(height)), feed_per_tooth: None });
    };
    let limits = CuttingLimits::new(Some(Length::computed(feeds.largest)), None, Some(widest(height))).ok()?;
    let fastest = evaluated.fastest(height, &limits).ok()?;
    // What the tooth marks leave of the height bounds the step-over near a floor.
    let marks = evaluated.scallop_height(fastest.step_over, Some(fastest.feed_per_tooth)).ok()?.feed;
    let left = Length::computed((height.mm() - marks.mm()).max(0.0));
    Some(Parameters { step_over: smaller(fastest.step_over, widest(left)), feed_per_tooth: Some(fastest.feed_per_tooth) })
}

fn smaller(one: Length, other: Length) -> Length {
    if one < other { one } else { other }
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
