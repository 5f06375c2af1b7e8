//! `/v1/step-over`, by `POST` and `GET`, and its batch: the largest step-over that keeps the scallop height within a
//! tolerance.

use super::{Calculation, batch, single};
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems, QueryProblems};
use crate::http::query::query;
use crate::http::reading::{Faulted, Faults, JsonPath, Quantity, members};
use crate::http::wire::{COMMON_FIGURES, Figure, Figures, Heights, SharedParameters, StatedParameters, TOLERANCE};
use crate::http::worker_pool::Work;
use crate::milling::{EvaluatedPass, NoAnswer};
use crate::quantity::Length;
use axum::extract::RawQuery;

members! {
    /// The tolerance to keep.
    pub(crate) struct ToleranceMembers {
        tolerance: required TOLERANCE: Quantity<Length>,
    }
}

/// The largest step-over at a contact.
pub(crate) struct MaxStepOver {
    tolerance: Length,
}

impl Calculation for MaxStepOver {
    const STATED: StatedParameters = StatedParameters { step_over: false, feed_per_tooth: true };
    type Members = ToleranceMembers;
    const FIGURES: &'static [&'static [Figure]] = &[COMMON_FIGURES];

    fn new(members: ToleranceMembers, _: Result<&SharedParameters, Faulted>, _: &JsonPath<'_>, _: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self { tolerance: members.tolerance? })
    }

    fn compute(
        &self,
        _: &SharedParameters,
        pass: &EvaluatedPass,
        _: Option<Length>,
        feed: Option<Length>,
        heights: Heights,
    ) -> Result<Figures, NoAnswer> {
        Figures::at(pass, pass.max_step_over(self.tolerance, feed)?, feed, heights, None)
    }
}

query!(QUERY, StepOverQuery, single::describe_request::<MaxStepOver>);

described!(StepOverRequest, single::describe_request::<MaxStepOver>);
described!(StepOverAnswer, single::describe_answer::<MaxStepOver>);
described!(StepOverBatchRequest, batch::describe_request::<MaxStepOver>);
described!(StepOverBatchAnswer, batch::describe_answer::<MaxStepOver>);

/// The largest step-over at one contact
///
/// The largest step-over that keeps the scallop height within a tolerance, along the surface and seen from above, at a
/// given feed per tooth.
#[utoipa::path(
    post, path = "/v1/step-over", tag = "calculations", operation_id = "step_over",
    request_body = StepOverRequest,
    responses((status = 200, description = "The step-over, and the heights at this step-over", body = StepOverAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    single::answer::<MaxStepOver>(work, body).await
}

/// The largest step-over at one contact, by a query
///
/// The same as the POST, with the members as query parameters: the names of nested members are joined by an underscore,
/// members of `cutter` and `contact` keep their names, the cutter's type is `cutter`, and a vector is three numbers
/// separated by commas.
#[utoipa::path(
    get, path = "/v1/step-over", tag = "calculations", operation_id = "step_over_query", params(StepOverQuery),
    responses((status = 200, description = "The step-over, and the heights at this step-over", body = StepOverAnswer), QueryProblems),
)]
pub(crate) async fn answer_query(work: Work, RawQuery(text): RawQuery) -> Result<WrittenJson, Problem> {
    single::answer_query::<MaxStepOver>(work, &QUERY, text).await
}

/// The largest step-overs of a tool path
///
/// The same calculation at many contacts. A contact without an answer is null in every column and listed in `failures`;
/// it does not affect the others.
#[utoipa::path(
    post, path = "/v1/step-over/batch", tag = "calculations", operation_id = "step_over_batch",
    request_body = StepOverBatchRequest,
    responses((status = 200, description = "A column for each figure", body = StepOverBatchAnswer), Problems),
)]
pub(crate) async fn answer_batch(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    batch::answer::<MaxStepOver>(work, body).await
}
