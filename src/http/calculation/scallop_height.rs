//! `POST /v1/scallop-height` and its batch: the height that a step-over and a feed leave.

use super::column::{Column, Table};
use super::figures::{Check, Columns, Common, Failure, Figures, Summary, answers, model_name};
use super::terms::{Setup, Stated};
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

/// The height at a contact.
pub(crate) struct ScallopHeight;

pub(crate) struct HeightFigures {
    common: Common,
}

impl HeightFigures {
    fn found_mm(&self) -> f64 {
        self.common.height.total().mm()
    }
}

answers! { HeightFigures => ScallopHeightAnswer, ScallopHeightBatchAnswer; }

impl Calculation for ScallopHeight {
    const STATES: Stated = Stated { step_over: true, feed_per_tooth: true };
    const SCHEMAS: [&'static str; 2] = ["ScallopHeightRequest", "ScallopHeightBatchRequest"];
    type Figures = HeightFigures;

    fn read(_: &mut Object<'_, '_>, _: Result<&Setup, Faulted>, _: &mut Faults) -> Result<Self, Faulted> {
        Ok(Self)
    }

    fn describe(schema: ObjectSchema) -> ObjectSchema {
        schema
    }

    fn work_out(&self, _: &Setup, pass: &JudgedPass, step_over: Option<Length>, feed: Option<Length>) -> Result<HeightFigures, NoAnswer> {
        let step_over = step_over.unwrap_or_else(|| unreachable!("a request of this calculation states a step-over"));
        Ok(HeightFigures { common: Common::at(pass, step_over, feed)? })
    }
}

described!(ScallopHeightRequest, single::schemas::<ScallopHeight>());
described!(ScallopHeightBatchRequest, batch::schemas::<ScallopHeight>());

/// The scallop height at one contact
///
/// What a step-over and a feed per tooth leave on the surface: h1 from the step-over, and what the tooth marks along the feed add.
#[utoipa::path(
    post, path = "/v1/scallop-height", tag = "calculations", operation_id = "scallop_height",
    request_body = ScallopHeightRequest,
    responses((status = 200, description = "The height, its shares and radii", body = ScallopHeightAnswer), Problems),
)]
pub(crate) async fn answer(body: JsonBody) -> Result<Json<ScallopHeightAnswer>, Problem> {
    single::answer::<ScallopHeight>(&body)
}

/// The scallop heights of a tool path
///
/// The same at many contacts. A contact without an answer is null in every column and named in `failures`; the others are answered.
#[utoipa::path(
    post, path = "/v1/scallop-height/batch", tag = "calculations", operation_id = "scallop_height_batch",
    request_body = ScallopHeightBatchRequest,
    responses((status = 200, description = "A column for each figure", body = ScallopHeightBatchAnswer), Problems),
)]
pub(crate) async fn answer_batch(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    batch::answer::<ScallopHeight>(work, body).await
}
