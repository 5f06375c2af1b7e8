//! `POST /v1/step-over` and its batch: the largest step-over that keeps a tolerance.

use super::column::{Column, Table};
use super::figures::{Check, Columns, Common, Failure, Figures, Summary, answers, model_name};
use super::terms::{Setup, Stated, TOLERANCE};
use super::{Calculation, Warning, batch, single};
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::{Faulted, Faults, Object, ObjectSchema};
use crate::http::worker_pool::Work;
use crate::milling::{JudgedPass, Model, NoAnswer};
use crate::quantity::Length;
use axum::Json;
use serde::Serialize;
use utoipa::ToSchema;

/// The largest step-over at a contact.
pub(crate) struct MaxStepOver {
    tolerance: Length,
}

pub(crate) struct StepOverFigures {
    common: Common,
}

impl StepOverFigures {
    fn found_mm(&self) -> f64 {
        self.common.step_over.mm()
    }
}

answers! { StepOverFigures => StepOverAnswer, StepOverBatchAnswer; }

impl Calculation for MaxStepOver {
    const STATES: Stated = Stated { step_over: false, feed_per_tooth: true };
    const SCHEMAS: [&'static str; 2] = ["StepOverRequest", "StepOverBatchRequest"];
    type Figures = StepOverFigures;

    fn read(object: &mut Object<'_, '_>, _: Result<&Setup, Faulted>, faults: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self { tolerance: object.required(&TOLERANCE, faults)? })
    }

    fn describe(schema: ObjectSchema) -> ObjectSchema {
        schema.required(&TOLERANCE)
    }

    fn work_out(&self, _: &Setup, pass: &JudgedPass, _: Option<Length>, feed: Option<Length>) -> Result<StepOverFigures, NoAnswer> {
        let step_over = pass.max_step_over(self.tolerance, feed)?;
        Ok(StepOverFigures { common: Common::at(pass, step_over, feed)? })
    }
}

described!(StepOverRequest, single::schemas::<MaxStepOver>());
described!(StepOverBatchRequest, batch::schemas::<MaxStepOver>());

/// The largest step-over at one contact
///
/// The largest step-over that keeps the scallop height within a tolerance, along the surface and seen from above, at a given feed per
/// tooth.
#[utoipa::path(
    post, path = "/v1/step-over", tag = "calculations", operation_id = "step_over",
    request_body = StepOverRequest,
    responses((status = 200, description = "The step-over, and the heights at it", body = StepOverAnswer), Problems),
)]
pub(crate) async fn answer(body: JsonBody) -> Result<Json<StepOverAnswer>, Problem> {
    single::answer::<MaxStepOver>(&body)
}

/// The largest step-overs of a tool path
///
/// The same at many contacts. A contact without an answer is null in every column and named in `failures`; the others are answered.
#[utoipa::path(
    post, path = "/v1/step-over/batch", tag = "calculations", operation_id = "step_over_batch",
    request_body = StepOverBatchRequest,
    responses((status = 200, description = "A column for each figure", body = StepOverBatchAnswer), Problems),
)]
pub(crate) async fn answer_batch(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    batch::answer::<MaxStepOver>(work, body).await
}
