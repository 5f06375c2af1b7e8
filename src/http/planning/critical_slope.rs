//! `POST /v1/critical-slope`: the inclined rectangle, on which slope decides between the cutters.

use super::bounded::Bounded;
use super::candidates::{CandidateAnswer, ComparedCutter, Recommended, always_faster, candidates};
use super::job;
use crate::http::body::JsonBody;
use crate::http::calculation::Warning;
use crate::http::codes::{RequestFault, WarningCode};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::member::StatedLength;
use crate::http::reading::{Faulted, Faults, Member, Object, ObjectSchema};
use crate::milling::NoAnswer;
use crate::planning::{CriticalSlope, InclinedRectangle, Job, Plan, critical_slope, plan};
use crate::quantity::{Angle, Area, FormFactor, OutOfRange};
use axum::Json;
use serde::Serialize;
use utoipa::ToSchema;
use utoipa::openapi::{RefOr, Schema};

const WIDTH: Member<StatedLength> = Member {
    name: "width_mm",
    about: "w, the rectangle's long side, which is level; with height_mm, or give form_factor and characteristic_size_mm2",
    kind: StatedLength { example: 56.0 },
};
const HEIGHT: Member<StatedLength> = Member {
    name: "height_mm",
    about: "h, the side up the slope, at most the width; with width_mm, or give form_factor and characteristic_size_mm2",
    kind: StatedLength { example: 28.0 },
};
const FORM_FACTOR: Member<Bounded<FormFactor>> = Member {
    name: "form_factor",
    about: "mu = w/h; with characteristic_size_mm2, or give width_mm and height_mm",
    kind: Bounded { minimum: 1.0, maximum: FormFactor::LARGEST, example: 2.0, of: FormFactor::new },
};
const CHARACTERISTIC_SIZE: Member<Bounded<Area>> = Member {
    name: "characteristic_size_mm2",
    about: "chi = w h; with form_factor, or give width_mm and height_mm",
    kind: Bounded { minimum: Area::SMALLEST, maximum: Area::LARGEST, example: 1568.0, of: Area::from_mm2 },
};
const SLOPE: Member<Bounded<Angle>> = Member {
    name: "slope_deg",
    about: "s, the rectangle's slope, 0 (floor) to 90 (wall); with it the answer has the candidates, too",
    kind: Bounded { minimum: 0.0, maximum: 90.0, example: 60.0, of: slope },
};

fn slope(degrees: f64) -> Result<Angle, OutOfRange> {
    Angle::from_degrees(OutOfRange::check(degrees, 0.0, 90.0)?)
}

/// The slope at which both cutters finish an inclined rectangle in the same time.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct CriticalSlopeAnswer {
    /// s_c: below it the toroidal cutter is faster, above it the ball-end cutter. 90 where the toroidal cutter is faster on every slope, 0
    /// where the ball-end cutter is; `always_faster` names it then.
    #[schema(minimum = 0, maximum = 90)]
    critical_slope_deg: f64,
    /// The cutter that is faster on every slope; absent where there is a critical slope.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    always_faster: Option<ComparedCutter>,
    /// mu_c, below which the toroidal cutter is faster at `slope_deg` on a rectangle of this size; 1 where the ball-end cutter is faster
    /// even on a square. Only with `slope_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = 1)]
    critical_form_factor: Option<f64>,
    /// The faster cutter at `slope_deg`. Only with `slope_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    recommended: Option<Recommended>,
    /// Both cutters at `slope_deg`, the toroidal cutter first. Only with `slope_deg`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, min_items = 2, max_items = 2)]
    candidates: Option<Vec<CandidateAnswer>>,
    /// What must be looked at.
    warnings: Vec<Warning>,
}

impl CriticalSlopeAnswer {
    fn without_slope(critical: CriticalSlope) -> Self {
        Self {
            critical_slope_deg: critical.angle().degrees(),
            always_faster: always_faster(critical),
            critical_form_factor: None,
            recommended: None,
            candidates: None,
            warnings: Vec::new(),
        }
    }

    fn at_slope(plan: &Plan, job: &Job) -> Self {
        Self {
            critical_form_factor: Some(plan.critical_form_factor.form_factor().ratio()),
            recommended: Some(plan.recommended().into()),
            candidates: Some(candidates(plan)),
            warnings: wide_step_over(plan, job).into_iter().collect(),
            ..Self::without_slope(plan.critical_slope)
        }
    }
}

/// The model's circle can be wider than the cutter.
fn wide_step_over(plan: &Plan, job: &Job) -> Option<Warning> {
    let (step_over, diameter) = (plan.toroidal.zigzag.step_over.mm(), 2.0 * job.toroidal().outer_radius().mm());
    (step_over > diameter).then(|| {
        Warning::new(
            WarningCode::StepOverExceedsCutter,
            format!(
                "the toroidal cutter's step-over, {step_over:.3} mm, exceeds its diameter, {diameter} mm: the model's circle is wider than the cutter; model \"envelope\" knows its width"
            ),
        )
    })
}

described!(CriticalSlopeRequest, schemas());

fn schemas() -> Vec<(String, RefOr<Schema>)> {
    let schema = job::describe(ObjectSchema::new("an inclined rectangle, by its sides or by its form, and the job"));
    let schema = schema.optional(&WIDTH).optional(&HEIGHT).optional(&FORM_FACTOR).optional(&CHARACTERISTIC_SIZE).optional(&SLOPE);
    vec![("CriticalSlopeRequest".to_owned(), schema.build())]
}

/// The critical slope of an inclined rectangle
///
/// The slope below which a toroidal cutter up and down the slope finishes a rectangle sooner than a ball-end cutter along its level
/// long side. Give the rectangle by `width_mm` and `height_mm`, or by `form_factor` and `characteristic_size_mm2`.
#[utoipa::path(
    post, path = "/v1/critical-slope", tag = "planning", operation_id = "critical_slope",
    request_body = CriticalSlopeRequest,
    responses((status = 200, description = "The critical slope, and with a slope both candidates", body = CriticalSlopeAnswer), Problems),
)]
pub(crate) async fn answer(body: JsonBody) -> Result<Json<CriticalSlopeAnswer>, Problem> {
    body.read(|object, faults| {
        let job = job::read(object, faults);
        let rectangle = rectangle(object, faults);
        let slope = object.optional(&SLOPE, faults);
        let (job, rectangle) = (job?, rectangle?);
        let answer = match slope? {
            None => critical_slope(&job, rectangle).map(CriticalSlopeAnswer::without_slope),
            Some(slope) => plan(&job, rectangle, slope).map(|plan| CriticalSlopeAnswer::at_slope(&plan, &job)),
        };
        answer.map_err(|cause| {
            let detail = format_args!("the toroidal cutter up the slope: {cause}");
            faults.push(job::no_answer(cause, detail, &object.place().member(to_blame(cause))))
        })
    })
    .map(Json)
}

/// The member that leaves the toroidal cutter without a step-over.
fn to_blame(cause: NoAnswer) -> &'static str {
    if cause == NoAnswer::FlatFloor { SLOPE.name } else { job::SCALLOP_HEIGHT.name }
}

/// Takes the rectangle, by its sides or by its form.
fn rectangle(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<InclinedRectangle, Faulted> {
    let by_sides = object.has(WIDTH.name) || object.has(HEIGHT.name);
    let by_form = object.has(FORM_FACTOR.name) || object.has(CHARACTERISTIC_SIZE.name);
    match (by_sides, by_form) {
        (true, false) => {
            let (width, height) = (object.required(&WIDTH, faults), object.required(&HEIGHT, faults));
            InclinedRectangle::from_sides(width?, height?)
                .map_err(|error| faults.add(&object.place().member(HEIGHT.name), RequestFault::HeightExceedsWidth, error))
        }
        (false, true) => {
            let (mu, chi) = (object.required(&FORM_FACTOR, faults), object.required(&CHARACTERISTIC_SIZE, faults));
            InclinedRectangle::from_form(mu?, chi?).map_err(|bounds| {
                let detail = format_args!("each side, sqrt(mu chi) and sqrt(chi/mu), {bounds} mm");
                faults.add(&object.place().member(CHARACTERISTIC_SIZE.name), RequestFault::OutOfRange, detail)
            })
        }
        (true, true) => {
            // Both forms are read for the faults in them.
            let _ = (object.optional(&WIDTH, faults), object.optional(&HEIGHT, faults));
            let _ = (object.optional(&FORM_FACTOR, faults), object.optional(&CHARACTERISTIC_SIZE, faults));
            let detail = "give width_mm and height_mm, or form_factor and characteristic_size_mm2, not both";
            Err(faults.add(&object.place(), RequestFault::ConflictingFields, detail))
        }
        (false, false) => Err(faults.add(
            &object.place(),
            RequestFault::MissingField,
            "give width_mm and height_mm, or form_factor and characteristic_size_mm2",
        )),
    }
}
