//! The passes of one cutter of any kind on the equivalent rectangle of a surface.

use super::{InclinedRectangle, Zigzag};
use crate::milling::{Contact, Cutter, CutterKind, CuttingLimits, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use crate::motion::{Machine, MachineLimits, travel_time};
use crate::planning::plan::{CandidateCutter, FeedRange, Pattern, PlanSettings};
use crate::quantity::{Angle, Length, OutOfRange, Speed, Time};
use crate::surface::Shape;

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
