//! The rules for a request's body: the longest pause and the longest time of its arrival, the largest size after
//! decompression (`limit`), and the longest time from its last byte to the answer. A body that breaks a rule ends with
//! an error. The service then answers with the problem of that rule, whatever the handler returned.

mod gzip;
mod limit;
mod progress;

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use tokio::time::{Instant, timeout_at};
use tower_http::timeout::{DeadlineBody, TimeoutBody};

use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::http::routes::RouteClass;
use crate::settings::Settings;
use gzip::{decompressed, is_gzip};
use limit::{limited, too_large};
pub(super) use progress::{BodyProgress, RecordedBody};

/// How many times the longest pause a body's arrival may take in all: a trickle does not hold a connection for ever.
const MAX_PAUSES: u32 = 20;

/// The rules for requests to the routes of one class.
#[derive(Debug)]
pub(super) struct BodyRules {
    /// The largest body, in decompressed bytes.
    max_bytes: u64,
    pub(super) request_timeout: Duration,
    client_timeout: Duration,
}

impl BodyRules {
    pub(super) fn new(class: RouteClass, settings: &Settings) -> Self {
        Self {
            max_bytes: class.max_body_bytes(settings),
            request_timeout: settings.request_timeout_s,
            client_timeout: settings.client_timeout_s,
        }
    }

    /// Rejects a request whose head already shows that its body breaks a rule.
    #[expect(clippy::result_large_err, reason = "the response is returned as it is, once")]
    pub(super) fn check_head(&self, headers: &HeaderMap) -> Result<(), Response> {
        let max_bytes = self.max_bytes;
        match is_gzip(headers) {
            Some(false) if stated_length(headers).is_some_and(|length| length > max_bytes) => Err(too_large(max_bytes).into_response()),
            Some(_) => Ok(()),
            None => Err(unsupported_encoding()),
        }
    }

    /// Limits the body's arrival and its decompressed size, and decompresses it.
    pub(super) fn limit(&self, request: Request) -> Request {
        let progress = BodyProgress::of(&request);
        if !progress.is_unread() {
            return request;
        }
        let pause = self.client_timeout;
        let timed = request.map(|body| Body::new(DeadlineBody::new(MAX_PAUSES * pause, TimeoutBody::new(pause, body))));
        decompressed(timed).map(|body| limited(body, self.max_bytes, progress))
    }
}

/// Returns `answer` if it is ready within `longest` of the request's last byte and the body broke no rule; otherwise
/// the problem. The time of the upload does not count, because it depends on the client's connection.
pub(super) async fn answer_in_time(longest: Duration, progress: Arc<BodyProgress>, answer: impl Future<Output = Response>) -> Response {
    let mut answer = std::pin::pin!(answer);
    let answer = loop {
        let deadline = progress.last_byte() + longest;
        match timeout_at(deadline, answer.as_mut()).await {
            Ok(response) => break Some(response),
            Err(_) if progress.last_byte() + longest > Instant::now() => {}
            Err(_) => break None,
        }
    };
    match (progress.fault(), answer) {
        (Some(fault), _) => fault.clone().into_response(),
        (None, Some(response)) => response,
        (None, None) => took_too_long(longest),
    }
}

fn stated_length(headers: &HeaderMap) -> Option<u64> {
    headers.get(header::CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

fn unsupported_encoding() -> Response {
    let detail = "send the body plain or with the header content-encoding: gzip".to_owned();
    let mut response = Problem::new(ServiceProblem::UnsupportedEncoding, detail).into_response();
    response.headers_mut().insert(header::ACCEPT_ENCODING, HeaderValue::from_static("gzip"));
    response
}

fn took_too_long(longest: Duration) -> Response {
    let detail = format!("no answer within {} s of the request's last byte", longest.as_secs());
    Problem::new(ServiceProblem::Timeout, detail).into_response()
}
