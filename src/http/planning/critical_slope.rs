//! `POST /v1/critical-slope`: the slope of an inclined rectangle at which both cutters take the same time.

use super::candidates::{CandidateAnswer, ComparedCutter, Recommended, always_faster, outside_range};
use super::parameters::unused_on_rectangle;
use crate::http::codes::RequestFault;
use crate::http::document::described;
use crate::http::json_body::JsonBody;
use crate::http::problem::Problem;
use crate::http::problem_schemas::Problems;
use crate::http::reading::{
    Choice, Components, Fault, Faulted, Faults, Form, JsonPath, Members, Object, ObjectSchema, Quantity, Renamed, members,
};
use crate::http::wire::{
    BallEndCutter, MACHINE, MODEL, MachineKind, ROUGHNESS, RoughnessKind, SCALLOP_HEIGHT, ToroidalCutter, Warning, answer, plan_tolerance,
};
use crate::milling::{Contact, EffectiveRadius, Model};
use crate::motion;
use crate::planning::{CriticalSlope, CutterComparison, InclinedRectangle, JobError, Plan, critical_slope, plan};
use crate::quantity::{Angle, Area, FormFactor, Length};
use axum::Json;
use utoipa::openapi::{RefOr, Schema};

members! {
    /// The members of a job.
    pub(super) struct JobMembers {
        toroidal: required TOROIDAL: ToroidalCutter = ("toroidal", ToroidalCutter, "the toroidal cutter to compare"),
        ball_end: required BALL_END: BallEndCutter = ("ball_end", BallEndCutter, "the ball-end cutter to compare"),
        roughness: optional ROUGHNESS: RoughnessKind,
        tolerance: optional TOLERANCE: Quantity<Length> = ("scallop_tolerance_mm", Quantity::length(0.01),
            "sh, the scallop height that either cutter may leave: at most the toroidal cutter's corner radius and under the ball's radius"),
        scallop_height: optional SCALLOP_HEIGHT: Renamed<Length>,
        machine: required MACHINE: MachineKind,
        model: optional MODEL: Choice<Model>,
    }
}

/// A job, the machine with what the job does not need, and the name of the member that states the scallop height.
pub(super) struct StatedJob {
    pub(super) job: CutterComparison,
    pub(super) machine: motion::Machine,
    pub(super) tolerance: &'static str,
}

/// Reads the members of a job from `object`, which may have others.
fn read_job(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<StatedJob, Faulted> {
    let JobMembers { toroidal, ball_end, roughness, tolerance, scallop_height, machine, model } = JobMembers::read(object, faults);
    let tolerance = plan_tolerance(tolerance, scallop_height, roughness, &TOLERANCE, &object.path(), faults);
    let (toroidal, ball_end, tolerance, machine) = (toroidal?, ball_end?, tolerance?, machine?);
    let job = CutterComparison::new(toroidal, ball_end, tolerance.height, machine.limits, model?.unwrap_or_default());
    let job = job.map_err(|error| faults.push(fault(error, &object.path().member(tolerance.name))))?;
    Ok(StatedJob { job, machine, tolerance: tolerance.name })
}

/// The fault of a job whose scallop height is at `tolerance`.
fn fault(error: JobError, tolerance: &JsonPath<'_>) -> Fault {
    match error {
        JobError::NotToroidal | JobError::NotBallEnd => unreachable!("each member is read as a cutter of its kind"),
        JobError::ScallopTooHigh { .. } => Fault::new(tolerance, RequestFault::ScallopTooHigh, error),
        JobError::BallEnd(cause) => Fault::no_answer(cause, tolerance, error),
    }
}

members! {
    /// A rectangle by its sides.
    struct Sides {
        width: required WIDTH: Quantity<Length> = ("width_mm", Quantity::length(56.0),
            "w, the rectangle's long side, which is level; with height_mm, or give form_factor and characteristic_size_mm2"),
        height: required HEIGHT: Quantity<Length> = ("height_mm", Quantity::length(28.0),
            "h, the side up the slope, at most the width; with width_mm, or give form_factor and characteristic_size_mm2"),
    }
}
members! {
    /// A rectangle by its form and size.
    struct FormAndSize {
        form_factor: required FORM_FACTOR: Quantity<FormFactor> = ("form_factor", Quantity::new(FormFactor::new, 2.0),
            "mu = w/h; with characteristic_size_mm2, or give width_mm and height_mm"),
        size: required CHARACTERISTIC_SIZE: Quantity<Area> = ("characteristic_size_mm2", Quantity::new(Area::from_mm2, 1568.0),
            "chi = w h; with form_factor, or give width_mm and height_mm"),
    }
}
members! {
    /// The slope at which the candidates are compared.
    struct SlopeMembers {
        slope: optional SLOPE: Quantity<Angle> = ("slope_deg", Quantity::slope(60.0),
            "s, the rectangle's slope, 0 (floor) to 90 (wall); with it, the answer includes the candidates"),
    }
}

answer! {
    /// The slope at which both cutters finish an inclined rectangle in the same time.
    pub(crate) struct CriticalSlopeAnswer of (critical: CriticalSlope, rectangle: InclinedRectangle, candidates: Option<[CandidateAnswer; 2]>, plan: Option<&Plan>, warnings: Vec<Warning>) {
        /// mu = w/h of the rectangle.
        form_factor: f64 [minimum = 1] = rectangle.form_factor().ratio(),
        /// chi = w h of the rectangle.
        characteristic_size_mm2: f64 [minimum = 0] = rectangle.characteristic_size().mm2(),
        /// s_c: below it the toroidal cutter is faster, above it the ball-end cutter. 90 if the toroidal cutter is faster
        /// on every slope, 0 if the ball-end cutter is; `always_faster` then names that cutter.
        critical_slope_deg: f64 [minimum = 0, maximum = 90] = critical.angle().degrees(),
        /// The cutter that is faster on every slope; absent if there is a critical slope.
        always_faster?: ComparedCutter = always_faster(critical),
        /// mu_c, below which the toroidal cutter is faster at `slope_deg` on a rectangle of this size; 1 if the ball-end
        /// cutter is faster even on a square. Only with `slope_deg`.
        critical_form_factor?: f64 [minimum = 1] = plan.map(|plan| plan.critical_form_factor.form_factor().ratio()),
        /// The faster cutter at `slope_deg`. Only with `slope_deg`.
        recommended?: Recommended = plan.map(|plan| Recommended::of(plan.recommended())),
        /// Both cutters at `slope_deg`, the toroidal cutter first. Only with `slope_deg`.
        candidates?: Vec<CandidateAnswer> [min_items = 2, max_items = 2]
            = candidates.map(Vec::from),
        /// Facts that need attention.
        warnings: Vec<Warning> = warnings,
    }
}

/// The warning that the toroidal cutter's analytic step-over leaves far more than the scallop height.
fn beyond_the_model(plan: &Plan, job: &CutterComparison, slope: Angle) -> Option<Warning> {
    let step_over = plan.toroidal.zigzag.step_over;
    let is_analytic = job.model() == Model::Analytic;
    is_analytic.then(|| outside_range("the toroidal cutter", job.toroidal(), slope, step_over, None, job.scallop_height()))?
}

described!(CriticalSlopeRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let schema = ObjectSchema::new("An inclined rectangle, by its sides or by its form, and the job", components).with::<JobMembers>();
    schema.with_form::<Sides>().with_form::<FormAndSize>().with::<SlopeMembers>().build()
}

/// The critical slope of an inclined rectangle
///
/// The slope below which a toroidal cutter up and down the slope finishes a rectangle sooner than a ball-end cutter
/// along its level long side. Give the rectangle by `width_mm` and `height_mm`, or by `form_factor` and
/// `characteristic_size_mm2`.
#[utoipa::path(
    post, path = "/v1/critical-slope", tag = "planning", operation_id = "critical_slope",
    request_body = CriticalSlopeRequest,
    responses((status = 200, description = "The critical slope; if slope_deg is given, also both candidates", body = CriticalSlopeAnswer), Problems),
)]
pub(crate) async fn answer(body: JsonBody) -> Result<Json<CriticalSlopeAnswer>, Problem> {
    body.read(|object, faults| {
        let job = read_job(object, faults);
        let rectangle = rectangle(object, faults);
        let SlopeMembers { slope } = SlopeMembers::read(object, faults);
        let (StatedJob { job, machine, tolerance }, rectangle) = (job?, rectangle?);
        let mut warnings = unused_on_rectangle(&machine);
        let answer = match slope? {
            None => critical_slope(&job, rectangle).map(|critical| CriticalSlopeAnswer::of(critical, rectangle, None, None, warnings)),
            Some(slope) => plan(&job, rectangle, slope).map(|plan| {
                let plan = plan.slowed(machine.time_factor);
                warnings.extend(beyond_the_model(&plan, &job, slope));
                let candidates =
                    [(&plan.toroidal, job.toroidal(), rectangle.height()), (&plan.ball_end, job.ball_end(), rectangle.width())];
                let candidates = candidates.map(|(candidate, cutter, pass)| {
                    let radius = EffectiveRadius::across_feed(cutter, Contact::up_the_slope(slope)).finite();
                    CandidateAnswer::of(candidate, radius, pass, job.machine())
                });
                CriticalSlopeAnswer::of(plan.critical_slope, rectangle, Some(candidates), Some(&plan), warnings)
            }),
        };
        answer.map_err(|cause| {
            let detail = format_args!("the toroidal cutter up the slope: {cause}");
            faults.push(Fault::no_answer(cause, &object.path().member(tolerance), detail))
        })
    })
    .map(Json)
}

/// Reads the rectangle from `object`, by its sides or by its form.
fn rectangle(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<InclinedRectangle, Faulted> {
    let path = object.path();
    match object.one_of("give width_mm and height_mm, or form_factor and characteristic_size_mm2", faults)? {
        Form::First(Sides { width, height }) => InclinedRectangle::from_sides(width?, height?)
            .map_err(|error| faults.add(&path.member(HEIGHT.name), RequestFault::HeightExceedsWidth, error)),
        Form::Second(FormAndSize { form_factor, size }) => InclinedRectangle::from_form(form_factor?, size?).map_err(|bounds| {
            let detail = format_args!("each side, sqrt(mu chi) and sqrt(chi/mu), {bounds} mm");
            faults.add(&path.member(CHARACTERISTIC_SIZE.name), RequestFault::OutOfRange, detail)
        }),
    }
}
