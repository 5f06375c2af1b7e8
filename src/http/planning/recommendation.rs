//! `POST /v1/cutter-recommendation`: the surface in the JSON body. What the upload shares with it is here, too: the parameters beside the
//! surface, and the way from a surface to an answer.

use super::answer::RecommendationAnswer;
use super::job::{self, JobMembers};
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::{Choice, Components, Fault, Faulted, Faults, JsonPath, Members, Object, ObjectSchema, members};
use crate::http::wire::{SURFACE, Sourced};
use crate::http::worker_pool::Work;
use crate::milling::NoAnswer;
use crate::planning::{Job, PlanError, recommend};
use crate::surface::{Facing, ShapeError, Unit};
use utoipa::openapi::{RefOr, Schema};

members! {
    /// How the surface is taken.
    struct SurfaceOptions {
        unit: optional UNIT: Choice<Unit> = ("unit", Choice { name: Some("Unit"), words: &[("mm", Unit::Millimetre), ("cm", Unit::Centimetre), ("m", Unit::Metre), ("inch", Unit::Inch)] },
            "the unit of the surface's coordinates; absent = mm"),
        facing: optional FACING: Choice<Facing> = ("facing", Choice { name: Some("Facing"), words: &[("up", Facing::Up), ("any", Facing::Any)] },
            "which facets count: up (default), those whose normal points up, which a cutter from above reaches; any, all of them. Points and patches have no sides"),
    }
}

/// The memory that a surface takes for each byte in which the body states it: a point of 24 bytes is `[0,0,0],` at least.
const MEMORY_OF_A_BYTE: u64 = 3;

/// What is asked beside the surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Parameters {
    job: Job,
    unit: Unit,
    facing: Facing,
}

impl Parameters {
    /// Takes the parameters out of `object`, which may have the surface, too.
    pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let job = job::read(object, faults);
        let SurfaceOptions { unit, facing } = SurfaceOptions::read(object, faults);
        Ok(Self { job: job?, unit: unit?.unwrap_or_default(), facing: facing?.unwrap_or_default() })
    }

    /// Adds these members to a request's schema.
    pub(super) fn describe(schema: ObjectSchema<'_>) -> ObjectSchema<'_> {
        schema.with::<JobMembers>().with::<SurfaceOptions>()
    }

    /// The answer for a surface that was sent at `path`.
    pub(super) fn answer(&self, sourced: &Sourced, path: &JsonPath<'_>, faults: &mut Faults) -> Result<RecommendationAnswer, Faulted> {
        let shape = sourced.surface.shape(self.unit, self.facing);
        let shape = shape.map_err(|error| faults.add(path, shape_code(error), error))?;
        let recommendation = recommend(&self.job, &shape).map_err(|error| faults.push(plan_fault(error, path)))?;
        Ok(RecommendationAnswer::new(&recommendation, &shape, sourced))
    }
}

fn shape_code(error: ShapeError) -> RequestFault {
    match error {
        ShapeError::TooFewPoints { .. } => RequestFault::TooFewPoints,
        ShapeError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        ShapeError::AllPointsEqual => RequestFault::AllPointsEqual,
        ShapeError::Collinear => RequestFault::Collinear,
        ShapeError::CoordinateOutOfRange => RequestFault::OutOfRange,
    }
}

fn plan_fault(error: PlanError, path: &JsonPath<'_>) -> Fault {
    match error {
        PlanError::Size(_) => Fault::new(path, RequestFault::SizeOutOfRange, error),
        PlanError::Toroidal(cause @ NoAnswer::FlatFloor) => job::no_answer(cause, error, path),
        PlanError::Toroidal(cause) => job::no_answer(cause, error, &JsonPath::Root.member(job::SCALLOP_HEIGHT.name)),
    }
}

described!(RecommendationRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let schema = ObjectSchema::new("A surface, two cutters to compare on it, and the machine", components);
    Parameters::describe(schema.required(&SURFACE)).build()
}

/// The cutter for a surface
///
/// Which of two cutters finishes a surface sooner, in which direction and with which step-over, and how far to trust it. The surface is
/// compared with an inclined rectangle that spreads as much as its points or facets do.
#[utoipa::path(
    post, path = "/v1/cutter-recommendation", tag = "planning", operation_id = "cutter_recommendation",
    request_body = RecommendationRequest,
    responses((status = 200, description = "The recommendation, with both candidates", body = RecommendationAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let memory = work.reserve(MEMORY_OF_A_BYTE * body.len() as u64)?;
    let work_out = move |_: &CancelFlag| {
        // Until the answer is ready.
        let _memory = memory;
        work_out(&body)
    };
    work.run(work_out).await?
}

fn work_out(body: &JsonBody) -> Result<WrittenJson, Problem> {
    let answer = body.read(|object, faults| {
        let parameters = Parameters::read(object, faults);
        let surface = object.required(&SURFACE, faults);
        parameters?.answer(&surface?, &object.path().member(SURFACE.name), faults)
    })?;
    WrittenJson::of(&answer)
}
