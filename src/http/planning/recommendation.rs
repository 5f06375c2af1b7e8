//! `POST /v1/cutter-recommendation`: the surface in the JSON body.

use super::answer::RecommendationAnswer;
use super::parameters::Parameters;
use super::plan::Task;
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::{Components, ObjectSchema};
use crate::http::wire::{CUTTERS, SURFACE};
use crate::http::worker_pool::Work;
use utoipa::openapi::{RefOr, Schema};

/// The memory that a surface takes for each byte in which the body states it. A point of 24 bytes is `[0,0,0],` at least; beside it a welded point and its
/// place in the table take up to twice 34 bytes while they grow: (24 + 68) / 8 is under 12.
const MEMORY_OF_A_BYTE: u64 = 12;

/// The memory that planning takes for each facet: 128 bytes of the facet, 36 of the mesh, some 150 of the simulation and its order across a direction on each
/// of two threads.
const MEMORY_OF_A_FACET: u64 = 400;

/// What the facets of a body can take at most, as they are merged beyond their bound.
const MOST_MEMORY_OF_A_SURFACE: u64 = 128 << 20;

described!(RecommendationRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let schema = ObjectSchema::new("A surface, the cutters to choose from, and the machine", components);
    Parameters::describe(schema.required(&SURFACE)).required(&CUTTERS).build()
}

/// The cutter for a surface
///
/// Which of the cutters finishes a surface soonest, in which direction and with which step-over and feed, and how far to trust it. By default zigzag passes
/// are simulated on the surface itself; method `rectangle` compares the surface with an inclined rectangle that spreads as much.
#[utoipa::path(
    post, path = "/v1/cutter-recommendation", tag = "planning", operation_id = "cutter_recommendation",
    request_body = RecommendationRequest,
    responses((status = 200, description = "The recommendation, with all candidates", body = RecommendationAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let held = (MEMORY_OF_A_BYTE * body.len() as u64).min(MOST_MEMORY_OF_A_SURFACE + 6 * body.len() as u64);
    let memory = work.reserve(held)?;
    let planning = work.clone();
    let work_out = move |cancelled: &CancelFlag| {
        // Until the answer is ready.
        let _memory = memory;
        let task = body.read(|object, faults| {
            let parameters = Parameters::read(object, [], Ok(()), faults);
            let surface = object.required(&SURFACE, faults);
            Task::new(parameters?, surface?, &object.path().member(SURFACE.name), faults)
        })?;
        answer_to(task, &planning, cancelled)
    };
    work.run(work_out).await?
}

/// Plans within the memory budget, and writes the answer.
pub(super) fn answer_to(task: Task, work: &Work, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
    let _memory = work.reserve(MEMORY_OF_A_FACET * task.facets() as u64)?;
    WrittenJson::of(&task.answer(&|| cancelled.is_cancelled())?)
}
