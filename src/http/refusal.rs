//! Answers to request heads that cannot be parsed because they are malformed, too large or too slow. They reach no
//! route, but have a request id, a problem, a log line and a count like other requests.

use std::sync::{Arc, LazyLock};
use std::time::Duration;

use axum::http::StatusCode;

use super::metrics::Metrics;
use super::problem::Problem;
use super::request_id::RequestId;

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
