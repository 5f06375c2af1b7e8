//! Answers to requests that the server refuses before they reach a handler: under load, with status 503 and `Retry-After`; and request heads that
//! cannot be parsed because they are malformed, too large or too slow, which reach no route, but have a request id, a problem and a log line.

use super::codes::ServiceProblem;
use super::metrics::Metrics;
use super::problem::Problem;
use super::request_id::RequestId;
use crate::budget::NoMemory;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::fmt;
use std::sync::{Arc, LazyLock};
use std::time::Duration;

/// The value of `Retry-After`. Resources become free within milliseconds unless the load persists.
const RETRY_AFTER_S: u32 = 1;

/// The limit that a request would exceed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overload {
    /// The limit of requests in flight is reached.
    InFlight,
    /// The limit of requests that use the worker pool is reached.
    Workers,
    /// The memory budget is exhausted.
    Memory,
}

impl Overload {
    /// The limits whose refusals the metrics count; the memory budget counts its own.
    pub(crate) const ALL: [Self; 2] = [Self::InFlight, Self::Workers];

    /// The value of the label `reason` in the metrics.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::InFlight => "in_flight",
            Self::Workers => "workers",
            Self::Memory => "memory",
        }
    }
}

impl fmt::Display for Overload {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::InFlight => write!(f, "as many requests as are accepted at once are in flight"),
            Self::Memory => write!(f, "the memory for requests is in use"),
            Self::Workers => write!(f, "as many uploads and batches as are accepted at once are being worked on"),
        }
    }
}

impl std::error::Error for Overload {}

impl From<Overload> for Problem {
    fn from(overload: Overload) -> Self {
        Self::new(ServiceProblem::Overloaded, overload.to_string()).retry_after(RETRY_AFTER_S)
    }
}

impl From<NoMemory> for Problem {
    fn from(_: NoMemory) -> Self {
        Overload::Memory.into()
    }
}

impl IntoResponse for Overload {
    fn into_response(self) -> Response {
        Problem::from(self).into_response()
    }
}

/// The labels of method and route in log and metrics.
const UNREAD: &str = "unread";

/// The bytes of the answer to such a head. The connection is closed after it.
pub(super) fn refuse(status: StatusCode, metrics: &Metrics) -> Vec<u8> {
    static ROUTE: LazyLock<Arc<str>> = LazyLock::new(|| Arc::from(UNREAD));
    let id = RequestId::create();
    metrics.began();
    metrics.ended(UNREAD, &ROUTE, status.as_u16(), Duration::ZERO);
    let problem = Problem::of_status(status);
    let kind = problem.kind();
    let body = problem.written("", &id);
    // The memory for heads is used up at this moment only.
    let retry = if status == StatusCode::SERVICE_UNAVAILABLE { "retry-after: 1\r\n" } else { "" };
    let head = format!(
        "HTTP/1.1 {status}\r\ncontent-type: application/problem+json\r\ncontent-length: {}\r\nx-request-id: {}\r\n{retry}connection: close\r\n\r\n",
        body.len(),
        id.as_str()
    );
    tracing::info!(
        request_id = id.as_str(),
        method = UNREAD,
        route = UNREAD,
        status = status.as_u16(),
        response_bytes = body.len(),
        problem = kind,
        "request"
    );
    [head.into_bytes(), body].concat()
}
