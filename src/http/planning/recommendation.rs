//! `POST /v1/cutter-recommendation`: the surface in the JSON body.

use super::answer::RecommendationAnswer;
use super::library::Libraries;
use super::memory::{Resources, bytes_of_machined_surface, bytes_to_read};
use super::parameters::{CUTTERS, ParameterMembers, Parameters};
use super::plan::Task;
use super::simulation::on_threads;
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::{Components, Faulted, ObjectSchema};
use crate::http::wire::SURFACE;
use crate::http::worker_pool::Work;
use crate::memory_budget::{BudgetExceeded, Reservation};
use crate::planning::memory::{bytes_of_mesh, bytes_prepared};
use std::time::Duration;
use utoipa::openapi::{RefOr, Schema};

described!(RecommendationRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let schema = ObjectSchema::new("A surface, the cutters to choose from, and the machine", components);
    schema.required(&SURFACE).with::<ParameterMembers>().required(&CUTTERS).build()
}

/// The cutter for a surface
///
/// Which of the cutters finishes a surface soonest, in which direction and with which step-over and feed, and how
/// reliable the recommendation is. By default zigzag passes are simulated on the surface itself; method `rectangle`
/// plans on the equivalent inclined rectangle of the surface.
#[utoipa::path(
    post, path = "/v1/cutter-recommendation", tag = "planning", operation_id = "cutter_recommendation",
    request_body = RecommendationRequest,
    responses((status = 200, description = "The recommendation, with all candidates", body = RecommendationAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    const LONGEST_WAIT: Duration = Work::LONGEST_WAIT_OF_PLAN;
    let resources = Resources::none(&work, LONGEST_WAIT);
    let bytes = bytes_to_read(body.json());
    let first = move |memory, cancelled: &CancelFlag| {
        let (task, memory) = read(&body, memory, cancelled)?;
        drop(body);
        attempt(task, resources.with(memory), cancelled)
    };
    match work.run_with_memory(work.budget().open(), bytes, LONGEST_WAIT, first).await?? {
        Attempt::Answered(answer) => Ok(answer),
        Attempt::NeedsMemory(task, mut resources, bytes) => {
            let memory = std::mem::replace(&mut resources.memory, work.budget().open());
            let again = move |mut memory: Reservation, cancelled: &CancelFlag| {
                memory.begin_work();
                answer_to(*task, resources.with(memory), cancelled)
            };
            work.run_with_memory(memory, bytes, LONGEST_WAIT, again).await?
        }
    }
}

/// The result of an attempt that does not wait for memory.
enum Attempt {
    Answered(WrittenJson),
    /// The recommendation needs this many bytes more than were free.
    NeedsMemory(Box<Task>, Resources, u64),
}

/// Computes the answer if the memory for it is free. Otherwise returns the reserved memory, except that of the task.
/// Only a few tasks may wait at the same time: many could together take so much memory that none gets the rest.
fn attempt(task: Task, mut resources: Resources, cancelled: &CancelFlag) -> Result<Attempt, Problem> {
    let (mesh, ranking) = task.size();
    resources.memory.shrink_to(resources.most(mesh, ranking));
    let least = resources.least(mesh, ranking);
    match resources.memory.try_grow(least.saturating_sub(resources.memory.bytes())) {
        Err(BudgetExceeded::Now) => {
            let held = (bytes_of_mesh(mesh) + bytes_prepared(mesh.facets)) as u64;
            resources.memory.shrink_to(held);
            resources.memory.begin_wait()?;
            let more = least.saturating_sub(resources.memory.bytes());
            Ok(Attempt::NeedsMemory(Box::new(task), resources, more))
        }
        _ => answer_to(task, resources, cancelled).map(Attempt::Answered),
    }
}

/// Reads a body and prepares the facets of the plan. `memory` grows with them.
fn read(body: &JsonBody, mut memory: Reservation, cancelled: &CancelFlag) -> Result<(Task, Reservation), Problem> {
    let mut exceeded = None;
    let task = body.read_until(cancelled, |object, faults| {
        let parameters = Parameters::read(object, Libraries::default(), faults);
        let surface = object.required(&SURFACE, faults);
        let (parameters, surface) = (parameters?, surface?);
        if let Err(error) = memory.grow(bytes_of_machined_surface(&surface.surface.mesh)) {
            exceeded = Some(error);
            return Err(Faulted);
        }
        Task::new(parameters, surface, &object.path().member(SURFACE.name), faults, &|| cancelled.is_cancelled())
    });
    match exceeded {
        Some(exceeded) => Err(exceeded.into()),
        None => Ok((task?, memory)),
    }
}

/// Computes the recommendation with `resources`, and writes the answer.
pub(super) fn answer_to(task: Task, mut resources: Resources, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
    let stop = || cancelled.is_cancelled();
    let (mesh, ranking) = task.size();
    resources.provide(mesh, ranking, &stop)?;
    let answer = on_threads(resources.parallelism.threads, || task.answer(&mut resources, &stop))??;
    WrittenJson::until(cancelled, &answer)?.holding(resources.memory)
}
