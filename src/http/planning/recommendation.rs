//! `POST /v1/cutter-recommendation`: the surface in the JSON body.

use super::answer::RecommendationAnswer;
use super::memory::{Means, Needs, bytes_of_workpiece, bytes_to_read};
use super::parameters::Parameters;
use super::plan::Task;
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::{Components, Faulted, ObjectSchema};
use crate::http::wire::{CUTTERS, SURFACE};
use crate::http::worker_pool::Work;
use crate::memory_budget::Reservation;
use axum::http::StatusCode;
use utoipa::openapi::{RefOr, Schema};

described!(RecommendationRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let schema = ObjectSchema::new("A surface, the cutters to choose from, and the machine", components);
    Parameters::describe(schema.required(&SURFACE)).required(&CUTTERS).build()
}

/// The cutter for a surface
///
/// Which of the cutters finishes a surface soonest, in which direction and with which step-over and feed, and how
/// reliable the recommendation is. By default zigzag passes are simulated on the surface itself; method `rectangle`
/// compares the surface with an inclined rectangle that spreads as much.
#[utoipa::path(
    post, path = "/v1/cutter-recommendation", tag = "planning", operation_id = "cutter_recommendation",
    request_body = RecommendationRequest,
    responses((status = 200, description = "The recommendation, with all candidates", body = RecommendationAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let mut memory = work.reserve(0)?;
    work.grow(&mut memory, bytes_to_read(body.json())).await?;
    let read = move |cancelled: &CancelFlag| read(&body, memory, cancelled);
    let (task, mut memory) = work.run(read).await??;
    let Needs { bytes, parallelism } = Needs::of_plan(task.size(), task.candidates(), &work);
    memory.shrink_to(bytes);
    let more = bytes - memory.bytes();
    work.grow(&mut memory, more).await?;
    work.run(move |cancelled| answer_to(task, Means { memory, parallelism }, cancelled)).await?
}

/// Reads a body and prepares the facets of the plan. `memory` grows with them.
fn read(body: &JsonBody, mut memory: Reservation, cancelled: &CancelFlag) -> Result<(Task, Reservation), Problem> {
    let mut exceeded = None;
    let task = body.read_until(cancelled, |object, faults| {
        let parameters = Parameters::read(object, [], Ok(None), faults);
        let surface = object.required(&SURFACE, faults);
        let (parameters, surface) = (parameters?, surface?);
        if let Err(error) = memory.grow(bytes_of_workpiece(&surface.surface.mesh)) {
            exceeded = Some(error);
            return Err(Faulted);
        }
        Task::new(parameters, surface, &object.path().member(SURFACE.name), faults)
    });
    match exceeded {
        Some(exceeded) => Err(exceeded.into()),
        None => Ok((task?, memory)),
    }
}

/// Plans within `means`, and writes the answer.
pub(super) fn answer_to(task: Task, mut means: Means, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
    let threads = means.parallelism.threads;
    let answer = Work::on_threads(threads, || task.answer(&mut means, &|| cancelled.is_cancelled())).map_err(|error| {
        tracing::error!(%error, "no threads for a recommendation");
        Problem::of_status(StatusCode::INTERNAL_SERVER_ERROR)
    })??;
    WrittenJson::of(&answer)?.holding(means.memory)
}
