//! `POST /v1/cutter-recommendation`: the surface in the JSON body.

use super::answer::RecommendationAnswer;
use super::library::Libraries;
use super::parameters::{CUTTERS, ParameterMembers, Parameters};
use super::plan_task::Task;
use crate::budget::Job;
use crate::cancellation::CancelFlag;
use crate::http::document::described;
use crate::http::json_body::{JsonBody, WrittenJson};
use crate::http::problem::Problem;
use crate::http::problem_schemas::Problems;
use crate::http::reading::{Components, ObjectSchema};
use crate::http::wire::{MOST_CUTTERS, SURFACE};
use crate::http::work::Work;
use crate::surface::MOST_FACETS;
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
    let json = body.json();
    let cutters = memchr::memmem::find_iter(json, "diameter_mm").count().min(MOST_CUTTERS);
    let job = Job::Plan { json: json.len(), facets: likely_facets(json), cutters, threads: work.threads() };
    work.answer(job, move |cancelled| {
        let task = read(&body, cancelled)?;
        drop(body);
        answer_to(task, cancelled)
    })
    .await
}

/// The bytes of JSON for each facet or point: between the shortest notation and numbers with digits.
pub(super) const BYTES_OF_JSON: usize = 20;

/// The number of facets of the surface in a body, before it is read: one for each [`BYTES_OF_JSON`], or two for each cell
/// of the samples of a patch, unless they are written in an unusual way.
pub(super) fn likely_facets(json: &[u8]) -> usize {
    const NAME: &[u8] = b"\"samples\"";
    let samples = memchr::memmem::find_iter(json, NAME).map(|place| {
        let digits = json[place + NAME.len()..].iter().skip_while(|byte| byte.is_ascii_whitespace() || **byte == b':');
        digits.take(4).take_while(|byte| byte.is_ascii_digit()).fold(0, |number, digit| 10 * number + usize::from(digit - b'0'))
    });
    let of_patch = samples.max().map_or(0, |samples| 2 * samples * samples);
    (json.len() / BYTES_OF_JSON).max(of_patch).min(MOST_FACETS)
}

/// Reads a body and prepares the facets of the plan.
fn read(body: &JsonBody, cancelled: &CancelFlag) -> Result<Task, Problem> {
    body.read_until(cancelled, |object, faults| {
        let parameters = Parameters::read(object, Libraries::default(), faults);
        let surface = object.required(&SURFACE, faults);
        Task::new(parameters?, surface?, &object.path().member(SURFACE.name), faults, &|| cancelled.is_cancelled())
    })
}

/// Computes the recommendation, and writes the answer.
pub(super) fn answer_to(task: Task, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
    let answer = task.answer(&|| cancelled.is_cancelled())?;
    WrittenJson::until(cancelled, &answer)
}
