//! `POST /v1/max-feed` and its batch: the largest feed that keeps a tolerance.

use super::column::{Column, Table};
use super::figures::{Check, Columns, Common, Failure, Figures, Summary, answers, model_name};
use super::terms::{Setup, Stated, TOLERANCE};
use super::{Calculation, Warning, batch, single};
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::member::{Number, StatedLength};
use crate::http::reading::{Faulted, Faults, Member, Object, ObjectSchema};
use crate::http::worker_pool::Work;
use crate::milling::{JudgedPass, Model, NoAnswer};
use crate::quantity::Length;
use axum::Json;
use serde::Serialize;
use utoipa::ToSchema;

const SPINDLE_SPEED: Member<Number> = Member {
    name: "spindle_speed_rpm",
    about: "spindle speed n; with the cutter's teeth it gives the feed rate",
    kind: Number { minimum: 1.0, maximum: 1e6, example: 10_000.0 },
};
const MAX_FEED_PER_TOOTH: Member<StatedLength> = Member {
    name: "max_feed_per_tooth_mm",
    about: "the largest feed per tooth that the cutter's maker allows",
    kind: StatedLength { example: 0.35 },
};
const MAX_FEED_RATE: Member<Number> = Member {
    name: "max_feed_rate_mm_min",
    about: "the largest feed rate of the machine; needs spindle_speed_rpm and the cutter's teeth",
    kind: Number { minimum: 1e-3, maximum: 1e7, example: 15_000.0 },
};

/// The largest feed at a contact.
pub(crate) struct MaxFeed {
    tolerance: Length,
    spindle_speed_rpm: Option<f64>,
    per_tooth_limit: Option<Length>,
    rate_limit_mm_min: Option<f64>,
}

/// What keeps the feed from being larger.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
enum LimitedBy {
    /// The scallop height reaches its tolerance.
    ScallopTolerance,
    /// The cutter's maker allows no more.
    MaxFeedPerTooth,
    /// The machine is not faster.
    MaxFeedRate,
}

pub(crate) struct FeedFigures {
    feed_per_tooth: Length,
    feed_rate_mm_min: Option<f64>,
    limited_by: LimitedBy,
    common: Common,
}

impl FeedFigures {
    fn found_mm(&self) -> f64 {
        self.feed_per_tooth.mm()
    }
}

answers! {
    FeedFigures => MaxFeedAnswer, MaxFeedBatchAnswer;
    required {
        /// The largest feed per tooth.
        feed_per_tooth_mm: f64 = |figures: &FeedFigures| figures.feed_per_tooth.mm(),
        /// What keeps the feed from being larger.
        limited_by: LimitedBy = |figures: &FeedFigures| figures.limited_by,
    }
    optional {
        /// The feed rate f_z z n; where the cutter's teeth and the spindle speed are given.
        feed_rate_mm_min: f64 = |figures: &FeedFigures| figures.feed_rate_mm_min,
    }
}

impl Calculation for MaxFeed {
    const STATES: Stated = Stated { step_over: true, feed_per_tooth: false };
    const SCHEMAS: [&'static str; 2] = ["MaxFeedRequest", "MaxFeedBatchRequest"];
    type Figures = FeedFigures;

    fn read(object: &mut Object<'_, '_>, setup: Result<&Setup, Faulted>, faults: &mut Faults) -> Result<Self, Faulted> {
        let tolerance = object.required(&TOLERANCE, faults);
        let spindle_speed = object.optional(&SPINDLE_SPEED, faults);
        let per_tooth_limit = object.optional(&MAX_FEED_PER_TOOTH, faults);
        let rate_limit = object.optional(&MAX_FEED_RATE, faults);
        if let (Ok(Some(_)), Ok(speed), Ok(setup)) = (rate_limit, spindle_speed, setup) {
            let place = object.place();
            if speed.is_none() {
                faults.add(
                    &place.member(SPINDLE_SPEED.name),
                    RequestFault::MissingField,
                    "a largest feed rate limits the feed per tooth only with a spindle speed",
                );
            }
            if setup.tool.teeth.is_none() {
                let cutter = place.member("cutter");
                faults.add(
                    &cutter.member("teeth"),
                    RequestFault::MissingField,
                    "a largest feed rate limits the feed per tooth only with a number of teeth",
                );
            }
        }
        Ok(Self {
            tolerance: tolerance?,
            spindle_speed_rpm: spindle_speed?,
            per_tooth_limit: per_tooth_limit?,
            rate_limit_mm_min: rate_limit?,
        })
    }

    fn describe(schema: ObjectSchema) -> ObjectSchema {
        schema.required(&TOLERANCE).optional(&SPINDLE_SPEED).optional(&MAX_FEED_PER_TOOTH).optional(&MAX_FEED_RATE)
    }

    fn work_out(&self, setup: &Setup, pass: &JudgedPass, step_over: Option<Length>, _: Option<Length>) -> Result<FeedFigures, NoAnswer> {
        let step_over = step_over.unwrap_or_else(|| unreachable!("a request of this calculation states a step-over"));
        // A feed rate is f_z z n, so z n is a feed rate for each mm of feed per tooth.
        let teeth_per_min = setup.tool.teeth.zip(self.spindle_speed_rpm).map(|(teeth, speed)| f64::from(teeth) * speed);
        let by_machine = self.rate_limit_mm_min.zip(teeth_per_min).map(|(rate, teeth_per_min)| Length::computed(rate / teeth_per_min));
        let stated = [(self.per_tooth_limit, LimitedBy::MaxFeedPerTooth), (by_machine, LimitedBy::MaxFeedRate)];
        let stated = stated.into_iter().filter_map(|(limit, by)| Some((limit?, by))).reduce(|a, b| if b.0 < a.0 { b } else { a });
        let (feed_per_tooth, limited_by) = match (pass.max_feed_per_tooth(self.tolerance, step_over), stated) {
            (Ok(by_tolerance), Some(stated)) if stated.0 < by_tolerance => stated,
            (Ok(by_tolerance), _) => (by_tolerance, LimitedBy::ScallopTolerance),
            // The tolerance sets no limit as long as marks overlap; a stated limit within that is then the only one.
            (Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth }), Some(stated)) if stated.0 <= largest_feed_per_tooth => stated,
            (Err(cause), _) => return Err(cause),
        };
        let common = Common::at(pass, step_over, Some(feed_per_tooth))?;
        let feed_rate_mm_min = teeth_per_min.map(|teeth_per_min| feed_per_tooth.mm() * teeth_per_min);
        Ok(FeedFigures { feed_per_tooth, feed_rate_mm_min, limited_by, common })
    }
}

described!(MaxFeedRequest, single::schemas::<MaxFeed>());
described!(MaxFeedBatchRequest, batch::schemas::<MaxFeed>());

/// The largest feed at one contact
///
/// The largest feed per tooth, and feed rate, that keep the scallop height within a tolerance at a given step-over, and within the limits
/// of cutter and machine where these are stated.
#[utoipa::path(
    post, path = "/v1/max-feed", tag = "calculations", operation_id = "max_feed",
    request_body = MaxFeedRequest,
    responses((status = 200, description = "The feed, what limits it, and the heights at it", body = MaxFeedAnswer), Problems),
)]
pub(crate) async fn answer(body: JsonBody) -> Result<Json<MaxFeedAnswer>, Problem> {
    single::answer::<MaxFeed>(&body)
}

/// The largest feeds of a tool path
///
/// The same at many contacts. A contact without an answer is null in every column and named in `failures`; the others are answered.
#[utoipa::path(
    post, path = "/v1/max-feed/batch", tag = "calculations", operation_id = "max_feed_batch",
    request_body = MaxFeedBatchRequest,
    responses((status = 200, description = "A column for each figure", body = MaxFeedBatchAnswer), Problems),
)]
pub(crate) async fn answer_batch(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    batch::answer::<MaxFeed>(work, body).await
}
