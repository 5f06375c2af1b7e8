//! `/v1/scallop-height`, by `POST` and `GET`, and its batch: the height left by a step-over and a feed.

use super::{Calculation, batch, single};
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems, QueryProblems};
use crate::http::query::query;
use crate::http::reading::{Faulted, Faults, JsonPath, members};
use crate::http::wire::{COMMON_FIGURES, Figure, Figures, Heights, SharedParameters, StatedParameters};
use crate::http::worker_pool::Work;
use crate::milling::{EvaluatedPass, NoAnswer};
use crate::quantity::Length;
use axum::extract::RawQuery;

members! {
    /// This calculation has only the members that all calculations share.
    pub(crate) struct NoMembers {}
}

/// The height at a contact.
pub(crate) struct ScallopHeight;

impl Calculation for ScallopHeight {
    const STATED: StatedParameters = StatedParameters { step_over: true, feed_per_tooth: true };
    type Members = NoMembers;
    const FIGURES: &'static [&'static [Figure]] = &[COMMON_FIGURES];

    fn new(_: NoMembers, _: Result<&SharedParameters, Faulted>, _: &JsonPath<'_>, _: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self)
    }

    fn compute(
        &self,
        _: &SharedParameters,
        pass: &EvaluatedPass,
        step_over: Option<Length>,
        feed: Option<Length>,
        heights: Heights,
    ) -> Result<Figures, NoAnswer> {
        let step_over = step_over.unwrap_or_else(|| unreachable!("a request of this calculation states a step-over"));
        // A contact without a height has no answer, whichever figures are named.
        Figures::at(pass, step_over, feed, heights.max(Heights::Total), None)
    }
}

query!(QUERY, ScallopHeightQuery, single::describe_request::<ScallopHeight>);

described!(ScallopHeightRequest, single::describe_request::<ScallopHeight>);
described!(ScallopHeightAnswer, single::describe_answer::<ScallopHeight>);
described!(ScallopHeightBatchRequest, batch::describe_request::<ScallopHeight>);
described!(ScallopHeightBatchAnswer, batch::describe_answer::<ScallopHeight>);

/// The scallop height at one contact
///
/// The height that a step-over and a feed per tooth leave on the surface: h1 from the step-over, and the part that the
/// tooth marks along the feed add.
#[utoipa::path(
    post, path = "/v1/scallop-height", tag = "calculations", operation_id = "scallop_height",
    request_body = ScallopHeightRequest,
    responses((status = 200, description = "The height, its parts, and the effective radii", body = ScallopHeightAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    single::answer::<ScallopHeight>(work, body).await
}

/// The scallop height at one contact, by a query
///
/// The same as the POST, with the members as query parameters: the names of nested members are joined by an underscore,
/// members of `cutter` and `contact` keep their names, the cutter's type is `cutter`, and a vector is three numbers
/// separated by commas.
#[utoipa::path(
    get, path = "/v1/scallop-height", tag = "calculations", operation_id = "scallop_height_query", params(ScallopHeightQuery),
    responses((status = 200, description = "The height, its parts, and the effective radii", body = ScallopHeightAnswer), QueryProblems),
)]
pub(crate) async fn answer_query(work: Work, RawQuery(text): RawQuery) -> Result<WrittenJson, Problem> {
    single::answer_query::<ScallopHeight>(work, &QUERY, text).await
}

/// The scallop heights of a tool path
///
/// The same calculation at many contacts. A contact without an answer is null in every column and listed in `failures`;
/// it does not affect the others.
#[utoipa::path(
    post, path = "/v1/scallop-height/batch", tag = "calculations", operation_id = "scallop_height_batch",
    request_body = ScallopHeightBatchRequest,
    responses((status = 200, description = "A column for each figure", body = ScallopHeightBatchAnswer), Problems),
)]
pub(crate) async fn answer_batch(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    batch::answer::<ScallopHeight>(work, body).await
}
