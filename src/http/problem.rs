//! Answers to requests that fail: problem details (RFC 9457), in the same form for every route and layer.
//!
//! A handler or layer that fails returns a [`Problem`], or a response with an error status and any body. The outermost
//! layer, in which path and request id are known, turns both into `application/problem+json` by [`describe_error`].

use super::codes::{Code, FaultCode, ProblemFigure, ProblemType, ServiceProblem};
use super::reading::{Fault, Faults};
use super::request_id::RequestId;
use super::wire::NotRanked;
use crate::quantity::Length;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt;
use utoipa::ToSchema;

pub(super) const NEEDED_SHARE: ProblemFigure = ProblemFigure {
    name: "needed_max_uncut_share",
    about: "The `max_uncut_share` with which the cutter that comes closest would be ranked.",
};
pub(super) const HOLLOW: ProblemFigure = ProblemFigure {
    name: "smallest_concave_radius_mm",
    about: "The smallest concave radius of what is to be machined, estimated from its facets; 0 for a sharp inner edge. Absent without hollows.",
};

/// The problem of a failed request. Its content is boxed to keep `Result`s small.
#[derive(Debug, Clone)]
pub(crate) struct Problem(Box<ProblemBody>);

impl Problem {
    pub(crate) fn new(kind: ServiceProblem, detail: impl Into<String>) -> Self {
        Self::under(kind.entry().status.unwrap_or(StatusCode::INTERNAL_SERVER_ERROR), kind.into(), detail)
    }

    fn under(status: StatusCode, kind: ProblemType, detail: impl Into<String>) -> Self {
        Self(Box::new(ProblemBody {
            kind,
            title: kind.entry().meaning,
            status: status.as_u16(),
            detail: detail.into(),
            instance: String::new(),
            request_id: String::new(),
            errors: Vec::new(),
            not_ranked: Vec::new(),
            figures: Map::new(),
            answer: None,
            retry_after_s: None,
        }))
    }

    /// The name of its type.
    pub(crate) fn kind(&self) -> &'static str {
        self.0.kind.name()
    }

    /// The problem as JSON, in the answer to the request with this path and id.
    pub(crate) fn written(self, instance: &str, request_id: &RequestId) -> Vec<u8> {
        let body = ProblemBody { instance: instance.to_owned(), request_id: request_id.as_str().to_owned(), ..*self.0 };
        let mut text = serde_json::to_vec(&body).unwrap_or_else(|error| unreachable!("a problem can be written: {error}"));
        if let Some(answer) = &body.answer {
            // The answer of a large batch is written once, as text.
            text.pop();
            text.extend_from_slice(b",\"answer\":");
            text.extend_from_slice(answer);
            text.push(b'}');
        }
        text
    }

    /// A well-formed request that cannot be answered because of `faults`. If there is one fault and its code is a
    /// problem type, the problem has that type and the fault's figures. The fault of a file determines the status.
    pub(crate) fn faulty_request(faults: Faults) -> Self {
        let count = faults.count();
        let mut errors = faults.into_listed();
        let (kind, detail, figures) = match errors.as_mut_slice() {
            [only] if count == 1 => (type_of(only.code), only.detail.clone(), std::mem::take(&mut only.figures)),
            listed => {
                let which = if count > listed.len() { "the first of them" } else { "listed" };
                (ServiceProblem::InvalidRequest.into(), format!("{count} faults, {which} in errors"), Vec::new())
            }
        };
        // A request with a faulty file is not calculated: faults of files and missing answers do not occur together.
        let own = errors.iter().find_map(|fault| fault.code.entry().status);
        let mut problem = Self::under(own.unwrap_or(StatusCode::UNPROCESSABLE_ENTITY), kind, detail);
        problem.0.errors = errors;
        problem.0.figures = figures.into_iter().map(|(figure, value)| (figure.name.to_owned(), value.into())).collect();
        problem
    }

    /// The problem that none of the cutters can be ranked, with the reason for each.
    pub(crate) fn no_cutter_fits(not_ranked: Vec<NotRanked>) -> Self {
        let detail = format!("none of the {} cutters can be ranked; not_ranked has the reasons", not_ranked.len());
        let mut problem = Self::new(ServiceProblem::NoCutterFits, detail);
        problem.0.not_ranked = not_ranked;
        problem
    }

    /// Adds a batch's answer, a JSON object, as the member `answer`.
    pub(crate) fn with_answer(mut self, answer: Vec<u8>) -> Self {
        self.0.answer = Some(answer.into());
        self
    }

    /// Adds what would help where no cutter fits: the tightest hollow, and the cutter that comes closest to the limit.
    pub(crate) fn with_hollow(mut self, radius: Option<Length>, max_uncut_share: f64) -> Self {
        let mut details = vec![std::mem::take(&mut self.0.detail)];
        // No limit ranks a cutter that reaches nothing.
        let closest = self.0.not_ranked.iter().filter_map(|cutter| Some((cutter, cutter.uncut_share.filter(|share| *share < 1.0)?)));
        if let Some((cutter, share)) = closest.min_by(|a, b| a.1.total_cmp(&b.1)) {
            // Rounded up, so that the limit does what it says.
            let needed = (share * 1e4).ceil() / 1e4;
            let name = cutter.name.as_ref().map_or_else(|| format!("cutter {}", cutter.cutter), |name| format!("{name:?}"));
            details.push(format!("max_uncut_share is {max_uncut_share}, and {name} would be ranked with {needed}"));
            self.0.figures.insert(NEEDED_SHARE.name.to_owned(), needed.into());
        }
        if let Some(radius) = radius.map(Length::mm) {
            details.push(if radius > 0.0 {
                format!("the smallest concave radius of the surface is about {radius:.3} mm")
            } else {
                "the surface has sharp inner edges, which no round cutter reaches".to_owned()
            });
            self.0.figures.insert(HOLLOW.name.to_owned(), radius.into());
        }
        self.0.detail = details.join("; ");
        self
    }

    /// Adds the header `Retry-After`.
    pub(crate) fn retry_after(mut self, seconds: u32) -> Self {
        self.0.retry_after_s = Some(seconds);
        self
    }

    /// The problem for an error response that has only a status.
    pub(crate) fn of_status(status: StatusCode) -> Self {
        let (kind, detail) = match status {
            StatusCode::BAD_REQUEST => (ServiceProblem::MalformedRequest, "the request could not be read as HTTP/1.1"),
            StatusCode::NOT_FOUND => (ServiceProblem::NotFound, "no such path; /docs lists all paths"),
            StatusCode::METHOD_NOT_ALLOWED => (ServiceProblem::MethodNotAllowed, "the header Allow lists the methods of this path"),
            StatusCode::REQUEST_TIMEOUT => (ServiceProblem::Timeout, "the request was not complete in time"),
            StatusCode::PAYLOAD_TOO_LARGE => (ServiceProblem::TooLarge, "the body, counted decompressed, exceeds the limit of this server"),
            StatusCode::UNSUPPORTED_MEDIA_TYPE => {
                (ServiceProblem::UnsupportedMediaType, "send application/json, plain or with content-encoding gzip")
            }
            StatusCode::SERVICE_UNAVAILABLE => {
                (ServiceProblem::Overloaded, "the server is at its limit; try again after the time in Retry-After")
            }
            StatusCode::INTERNAL_SERVER_ERROR => {
                (ServiceProblem::Internal, "the server failed; its log has the cause under the request id")
            }
            StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE => (
                ServiceProblem::Failed,
                "the request line and the headers are longer than this server reads; send parameters as JSON by POST",
            ),
            _ => (ServiceProblem::Failed, "the request failed"),
        };
        Self::under(status, kind.into(), detail)
    }
}

/// The type of a problem with a single fault.
fn type_of(code: FaultCode) -> ProblemType {
    match code {
        FaultCode::RequestFault(_) => ServiceProblem::InvalidRequest.into(),
        FaultCode::FileFaultCode(code) => code.into(),
        FaultCode::NoAnswerCode(code) => code.into(),
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.detail)
    }
}

impl std::error::Error for Problem {}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = StatusCode::from_u16(self.0.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR).into_response();
        if let Some(seconds) = self.0.retry_after_s {
            response.headers_mut().insert(header::RETRY_AFTER, seconds.into());
        }
        response.extensions_mut().insert(self);
        response
    }
}

/// What the log states of a problem; an extension of the answer.
#[derive(Debug, Clone)]
pub(crate) struct Refusal {
    /// The problem's type.
    pub(crate) problem: &'static str,
    /// The code of the first fault, and its pointer.
    pub(crate) fault: Option<(&'static str, String)>,
}

impl Refusal {
    fn of(problem: &Problem) -> Self {
        let fault = problem.0.errors.first().map(|fault| (fault.code.name(), fault.pointer.clone()));
        Self { problem: problem.kind(), fault }
    }
}

const PROBLEM_JSON: HeaderValue = HeaderValue::from_static("application/problem+json");

/// Writes an error response as a problem, and returns other responses unchanged. Only the status of the framework's own
/// errors is kept: their texts are not part of this API.
pub(crate) fn describe_error(mut response: Response, instance: &str, request_id: &RequestId) -> Response {
    let status = response.status();
    if !status.is_client_error() && !status.is_server_error() {
        return response;
    }
    let problem = response.extensions_mut().remove::<Problem>().unwrap_or_else(|| Problem::of_status(status));
    let (mut parts, _) = response.into_parts();
    parts.extensions.insert(Refusal::of(&problem));
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.remove(header::CONTENT_ENCODING);
    parts.headers.insert(header::CONTENT_TYPE, PROBLEM_JSON);
    Response::from_parts(parts, problem.written(instance, request_id).into())
}

/// A problem (RFC 9457): the reason why a request failed.
#[derive(Debug, Clone, Serialize, ToSchema)]
#[schema(as = Problem)]
pub(crate) struct ProblemBody {
    #[serde(rename = "type")]
    kind: ProblemType,
    /// The problem in a few words, the same for every occurrence.
    title: &'static str,
    /// The HTTP status.
    #[schema(minimum = 400, maximum = 599)]
    status: u16,
    /// What went wrong and what is expected, for people.
    detail: String,
    /// The path of the request.
    instance: String,
    /// The request's id, which is in the server's log lines.
    #[schema(required = false)]
    request_id: String,
    /// All faults of an invalid request.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(required = false)]
    errors: Vec<Fault>,
    /// The cutters that cannot be ranked, for the type `no-cutter-fits`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schema(ignore)]
    not_ranked: Vec<NotRanked>,
    /// The figures of the problem's type, described by the schema of the type.
    #[serde(flatten)]
    #[schema(ignore)]
    figures: Map<String, Value>,
    /// A batch's answer as JSON, if no contact has an answer.
    #[serde(skip)]
    #[schema(ignore)]
    answer: Option<Bytes>,
    /// The value of the header `Retry-After`.
    #[serde(skip)]
    #[schema(ignore)]
    retry_after_s: Option<u32>,
}
