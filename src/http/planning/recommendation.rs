//! `POST /v1/cutter-recommendation`: the surface in the JSON body. What the upload shares with it is here, too: the parameters beside the
//! surface, and the way from a surface to an answer.

use super::answer::RecommendationAnswer;
use super::job;
use super::source::Sourced;
use super::stated_surface::{self, SURFACE};
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::member::Choice;
use crate::http::reading::{Fault, Faulted, Faults, Member, Object, ObjectSchema, Place};
use crate::http::worker_pool::Work;
use crate::milling::NoAnswer;
use crate::planning::{Job, PlanError, recommend};
use crate::surface::{Facing, ShapeError, Unit};
use utoipa::openapi::{RefOr, Schema};

const UNIT: Member<Choice<Unit>> = Member {
    name: "unit",
    about: "the unit of the surface's coordinates; absent = mm",
    kind: Choice { words: &[("mm", Unit::Millimetre), ("cm", Unit::Centimetre), ("m", Unit::Metre), ("inch", Unit::Inch)] },
};
const FACING: Member<Choice<Facing>> = Member {
    name: "facing",
    about: "which facets count: up (default), those whose normal points up, which a cutter from above reaches; any, all of them. Points and patches have no sides",
    kind: Choice { words: &[("up", Facing::Up), ("any", Facing::Any)] },
};

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
        let (unit, facing) = (object.optional(&UNIT, faults), object.optional(&FACING, faults));
        Ok(Self { job: job?, unit: unit?.unwrap_or_default(), facing: facing?.unwrap_or_default() })
    }

    /// Adds these members to a request's schema.
    pub(super) fn describe(schema: ObjectSchema) -> ObjectSchema {
        job::describe(schema).optional(&UNIT).optional(&FACING)
    }

    /// The answer for a surface that was sent at `place`.
    pub(super) fn answer(&self, sourced: &Sourced, place: &Place<'_>, faults: &mut Faults) -> Result<RecommendationAnswer, Faulted> {
        let shape = sourced.surface.shape(self.unit, self.facing);
        let shape = shape.map_err(|error| faults.add(place, shape_code(error), error))?;
        let recommendation = recommend(&self.job, &shape).map_err(|error| faults.push(plan_fault(error, place)))?;
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

fn plan_fault(error: PlanError, place: &Place<'_>) -> Fault {
    match error {
        PlanError::Size(_) => Fault::new(place, RequestFault::SizeOutOfRange, error),
        PlanError::Toroidal(cause @ NoAnswer::FlatFloor) => job::no_answer(cause, error, place),
        PlanError::Toroidal(cause) => job::no_answer(cause, error, &Place::Root.member(job::SCALLOP_HEIGHT.name)),
    }
}

described!(RecommendationRequest, schemas());

fn schemas() -> Vec<(String, RefOr<Schema>)> {
    let schema = ObjectSchema::new("a surface, two cutters to compare on it, and the machine").required(&SURFACE);
    let mut schemas = vec![("RecommendationRequest".to_owned(), Parameters::describe(schema).build())];
    schemas.extend(stated_surface::schemas());
    schemas
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
    work.run(move |_| work_out(&body)).await?
}

fn work_out(body: &JsonBody) -> Result<WrittenJson, Problem> {
    let answer = body.read(|object, faults| {
        let parameters = Parameters::read(object, faults);
        let surface = object.required(&SURFACE, faults);
        parameters?.answer(&surface?, &object.place().member(SURFACE.name), faults)
    })?;
    WrittenJson::of(&answer)
}
