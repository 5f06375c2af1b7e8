//! The rules for a request's body: the lowest rate of arrival (`wire`), the largest size after decompression (`limit`),
//! and the longest time from its last byte to the answer. A body that breaks a rule ends with an error. The service
//! then answers with the problem of that rule, whatever the handler returned.

mod gzip;
mod limit;
mod progress;
mod wire;

use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use tokio::time::{Instant, timeout_at};

use crate::http::codes::ServiceProblem;
use crate::http::problem::Problem;
use crate::http::routes::RouteClass;
use crate::settings::HttpSettings;
use gzip::{decompressed, is_gzip};
use limit::{LimitedBody, too_large};
pub(super) use progress::BodyProgress;
pub(super) use wire::{Pace, WireBody};

/// The rules for requests to the routes of one class.
#[derive(Debug)]
pub(super) struct BodyRules {
    /// The largest body, in decompressed bytes.
    max_bytes: u64,
    pub(super) request_timeout: Duration,
    pub(super) pace: Pace,
}

impl BodyRules {
    pub(super) fn new(class: RouteClass, settings: &HttpSettings) -> Self {
        Self {
            max_bytes: class.max_body_bytes(settings),
            request_timeout: settings.request_timeout,
            pace: Pace { longest_stall: settings.body_idle_timeout, min_bytes_s: settings.min_body_rate },
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

    /// Decompresses the body, and limits its decompressed size.
    pub(super) fn decompress(&self, request: Request) -> Request {
        let progress = BodyProgress::of(&request);
        decompressed(request).map(|body| Body::new(LimitedBody::new(body, self.max_bytes, progress)))
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
