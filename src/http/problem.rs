//! Answers to requests that fail: problem details (RFC 9457), the same for every route and every layer.
//!
//! A handler or layer that fails returns a [`Problem`], or any response with an error status and no body that matters;
//! [`describe_error`] turns both into `application/problem+json` on the way out, where path and request id are known.

use super::reading::{Fault, Faults};
use super::request_id::RequestId;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde_json::{Map, Value};
use std::borrow::Cow;
use std::collections::BTreeMap;
use utoipa::openapi::{self, Ref, RefOr, ResponseBuilder};
use utoipa::{IntoResponses, ToSchema};

const INVALID: &str = "invalid-request";
const INVALID_TITLE: &str = "The request cannot be answered";

/// A request that failed, before it is written. Boxed, because results carry it that nearly always succeed.
#[derive(Debug, Clone)]
pub(crate) struct Problem(Box<Content>);

#[derive(Debug, Clone)]
struct Content {
    status: StatusCode,
    kind: &'static str,
    title: &'static str,
    detail: Cow<'static, str>,
    errors: Vec<Fault>,
    members: Map<String, Value>,
    retry_after_s: Option<u32>,
}

impl Problem {
    pub(crate) fn new(status: StatusCode, kind: &'static str, title: &'static str, detail: impl Into<Cow<'static, str>>) -> Self {
        Self(Box::new(Content { status, kind, title, detail: detail.into(), errors: Vec::new(), members: Map::new(), retry_after_s: None }))
    }

    /// The request is well-formed and cannot be answered, for all the reasons in `faults`. A single reason that has a title of its own
    /// gives the problem its name.
    pub(crate) fn faulty_request(faults: Faults) -> Self {
        let errors = faults.into_listed();
        let (kind, title, detail) = match errors.as_slice() {
            [only] => (only.title.map_or(INVALID, |_| only.code), only.title.unwrap_or(INVALID_TITLE), only.detail.clone()),
            several => (INVALID, INVALID_TITLE, format!("{} faults, listed in errors", several.len())),
        };
        let members =
            errors.iter().flat_map(|fault| fault.figures.iter().map(|(name, value)| ((*name).to_owned(), (*value).into()))).collect();
        let mut problem = Self::new(StatusCode::UNPROCESSABLE_ENTITY, kind, title, detail);
        (problem.0.errors, problem.0.members) = (errors, members);
        problem
    }

    /// The same under another status.
    pub(crate) fn with_status(mut self, status: StatusCode) -> Self {
        self.0.status = status;
        self
    }

    /// The same, for the client to try again after `seconds`.
    pub(crate) fn retry_after(mut self, seconds: u32) -> Self {
        self.0.retry_after_s = Some(seconds);
        self
    }

    /// The problem that a bare status stands for.
    pub(crate) fn of_status(status: StatusCode) -> Self {
        let (kind, title, detail) = match status {
            StatusCode::BAD_REQUEST => ("malformed-request", "The request is malformed", "the request could not be read"),
            StatusCode::NOT_FOUND => ("not-found", "There is nothing here", "no such path; /docs lists what there is"),
            StatusCode::METHOD_NOT_ALLOWED => {
                ("method-not-allowed", "The method is not allowed here", "the header Allow lists the methods of this path")
            }
            StatusCode::REQUEST_TIMEOUT => ("timeout", "The request took too long", "the request was not complete in time"),
            StatusCode::PAYLOAD_TOO_LARGE => {
                ("too-large", "The body is too large", "the body, counted decompressed, exceeds the limit of this server")
            }
            StatusCode::UNSUPPORTED_MEDIA_TYPE => {
                ("unsupported-media-type", "The media type is not supported", "send application/json, plain or with content-encoding gzip")
            }
            StatusCode::SERVICE_UNAVAILABLE => {
                ("overloaded", "The server is busy", "the server is at its limit; try again after the seconds in Retry-After")
            }
            StatusCode::INTERNAL_SERVER_ERROR => {
                ("internal", "The server failed", "the fault is the server's; its log holds the cause under the request id")
            }
            _ => ("failed", status.canonical_reason().unwrap_or("The request failed"), "the request failed"),
        };
        Self::new(status, kind, title, detail)
    }
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = self.0.status.into_response();
        if let Some(seconds) = self.0.retry_after_s {
            response.headers_mut().insert(header::RETRY_AFTER, seconds.into());
        }
        response.extensions_mut().insert(self);
        response
    }
}

const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");

/// Writes an error response as a problem; others stay. Client errors keep what the framework said in its body only as a status, because
/// its texts are not this API's; server errors tell nothing but the request id.
pub(crate) fn describe_error(mut response: Response, instance: &str, request_id: &RequestId) -> Response {
    let status = response.status();
    if !status.is_client_error() && !status.is_server_error() {
        return response;
    }
    let Problem(problem) = response.extensions_mut().remove::<Problem>().unwrap_or_else(|| Problem::of_status(status));
    let body = ProblemBody {
        kind: problem.kind.into(),
        title: problem.title.into(),
        status: status.as_u16(),
        detail: problem.detail.into_owned(),
        instance: instance.to_owned(),
        request_id: Some(request_id.as_str().to_owned()),
        errors: problem.errors.into_iter().map(FaultBody::from).collect(),
        members: problem.members,
    };
    let (mut parts, _) = response.into_parts();
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.remove(header::CONTENT_ENCODING);
    parts.headers.insert(header::CONTENT_TYPE, PROBLEM_JSON);
    match serde_json::to_vec(&body) {
        Ok(json) => Response::from_parts(parts, json.into()),
        Err(error) => {
            tracing::error!(%error, "a problem could not be written");
            StatusCode::INTERNAL_SERVER_ERROR.into_response()
        }
    }
}

/// Why a request failed (RFC 9457).
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Problem)]
pub(crate) struct ProblemBody {
    /// Which problem: a stable name to decide by.
    #[serde(rename = "type")]
    #[schema(example = "invalid-request")]
    kind: Cow<'static, str>,
    /// The problem in a few words, the same for every occurrence.
    title: Cow<'static, str>,
    /// The HTTP status.
    #[schema(minimum = 400, maximum = 599)]
    status: u16,
    /// What went wrong here and what would be right, for a person.
    detail: String,
    /// The path of the request.
    instance: String,
    /// The request's id, which the server's log lines carry.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    request_id: Option<String>,
    /// All faults of an invalid request.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    errors: Vec<FaultBody>,
    /// Figures of some problems: `step_over_height_mm` and `max_step_over_mm` of `tolerance-exceeded`.
    #[serde(flatten)]
    #[schema(ignore)]
    members: Map<String, Value>,
}

/// One fault of an invalid request.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Fault)]
struct FaultBody {
    /// Where: a JSON pointer (RFC 6901) into the request; for an uploaded file the line or byte is in `detail`.
    #[schema(example = "/cutter/corner_radius_mm")]
    pointer: String,
    /// Which: a stable name to decide by.
    #[schema(example = "out-of-range")]
    code: Cow<'static, str>,
    /// What is wrong and what would be right, for a person.
    detail: String,
}

impl From<Fault> for FaultBody {
    fn from(fault: Fault) -> Self {
        Self { pointer: fault.pointer, code: fault.code.into(), detail: fault.detail }
    }
}

/// The problems that any operation with a JSON body can answer with, for the API document.
pub(crate) struct Problems;

impl IntoResponses for Problems {
    fn responses() -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
        responses("The body is not JSON", "The body's media type or encoding is not supported")
    }
}

/// The problems that an operation with an uploaded file can answer with, for the API document.
pub(crate) struct UploadProblems;

impl IntoResponses for UploadProblems {
    fn responses() -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
        responses(
            "The form, its parameters or the file is malformed; of the file, `errors` names the line or byte",
            "The body is no form, or the file is in no format that is read",
        )
    }
}

fn responses(malformed: &str, unsupported: &str) -> BTreeMap<String, RefOr<utoipa::openapi::Response>> {
    [
        ("400", malformed),
        ("408", "The request was not complete in time"),
        ("413", "The body, counted decompressed, exceeds the server's limit"),
        ("415", unsupported),
        ("422", "The request is well-formed and cannot be answered; `errors` lists every fault with its place"),
        ("500", "The server failed; its log holds the cause under the request id"),
        ("503", "The server is busy; try again after the seconds in Retry-After"),
    ]
    .into_iter()
    .map(|(status, description)| (status.to_owned(), problem_response(description)))
    .collect()
}

fn problem_response(description: &str) -> RefOr<utoipa::openapi::Response> {
    let content = openapi::Content::new(Some(RefOr::Ref(Ref::from_schema_name("Problem"))));
    ResponseBuilder::new().description(description).content("application/problem+json", content).build().into()
}
